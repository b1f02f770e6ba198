// Closest and any hit over the file's own records: one or two levels, an explicit stack, near child first, nodes behind
// the closest hit dropped.
//
// It is as careful as the Rust twin (src/trace/traverse.rs): on a malformed tree it ends with a status, and reads
// nothing out of bounds.

// Rays that lie side by side take different ways. A compiler that puts them into the lanes of one vector has all of them wait for the longest way, and do both
// sides of each branch. Intel's driver for processors does that unless it is told not to.
#ifdef cl_intel_vec_len_hint
#define ONE_RAY_AT_A_TIME __attribute__((intel_vec_len_hint(1)))
#else
#define ONE_RAY_AT_A_TIME
#endif

#define MAX_DEPTH 64
#define MAX_LEAF 255u

// A ray made ready for box tests (src/trace/slab.rs).
typedef struct {
    float3 near_origin, far_origin; // Moved apart, so that the box looks larger.
    float3 inverse, leaving;        // 1 / direction; negated and larger, so that the earliest exit is a maximum, too.
    uint3 downward;                 // All ones for an axis where a box's maximum is entered first.
    float t_min;
} Slabs;

static void slab(real o, real d, real arithmetic, real back, float *near, float *far, float *inverse, uint *downward) {
    real length = magnitude(d);
    real pad = larger(arithmetic, times(length, real_of(0x36D0000000000000UL))); // 2^-146
    pad = larger(pad, real_of(0x39B0000000000000UL));                            // 2^-100
    real far_pad = larger(pad, plus(pad, times(length, back)));
    bool down = less(d, real_of(0));
    *near = down ? round_down(minus(o, pad)) : round_up(plus(o, pad));
    *far = down ? round_up(plus(o, far_pad)) : round_down(minus(o, far_pad));
    *downward = down ? 0xFFFFFFFFu : 0;
#ifdef WRONG_OCTANT // A mistake that tests plant.
    *downward = ~*downward;
#endif
    float i = narrow(over(real_of(0x3FF0000000000000UL), d));
    uint exponent = as_uint(i) >> 23 & 0xFF;
    bool normal = exponent != 0 && exponent != 0xFF;
    *inverse = equal(d, real_of(0)) ? INFINITY : normal ? i : NAN;
}

static Slabs slabs(Real3 origin, Real3 direction, Node root, float t_min) {
    float plane = 0;
    plane = bigger(fabs(root.low.x), plane);
    plane = bigger(fabs(root.low.y), plane);
    plane = bigger(fabs(root.low.z), plane);
    plane = bigger(fabs(root.high.x), plane);
    plane = bigger(fabs(root.high.y), plane);
    plane = bigger(fabs(root.high.z), plane);
    real zero = real_of(0);
    real coordinate = larger(magnitude(origin.z), larger(magnitude(origin.y), larger(magnitude(origin.x), zero)));
    real arithmetic = times(real_of(0x3CF0000000000000UL), plus(widen(plane), coordinate)); // 2^-48
    real back = times(widen(t_min < 0 ? -t_min : 0.0f), real_of(0x3EC0000000000000UL));      // 2^-19
    Slabs s;
    float near[3], far[3], inverse[3];
    uint downward[3];
    slab(origin.x, direction.x, arithmetic, back, &near[0], &far[0], &inverse[0], &downward[0]);
    slab(origin.y, direction.y, arithmetic, back, &near[1], &far[1], &inverse[1], &downward[1]);
    slab(origin.z, direction.z, arithmetic, back, &near[2], &far[2], &inverse[2], &downward[2]);
    s.near_origin = (float3)(near[0], near[1], near[2]);
    s.far_origin = (float3)(far[0], far[1], far[2]);
    s.inverse = (float3)(inverse[0], inverse[1], inverse[2]);
    s.leaving = -s.inverse * 0x1.00000Ap+0f; // 1 + 10 · 2^-24
    s.downward = (uint3)(downward[0], downward[1], downward[2]);
    s.t_min = t_min;
    return s;
}

// Whether the ray meets the box before the end, which is given negated, and where it enters.
static bool meets(const Slabs *s, Node node, float minus_end, float *near) {
    uint3 low = as_uint3(node.low), high = as_uint3(node.high), other = (low ^ high) & s->downward;
    float3 enter = (as_float3(low ^ other) - s->near_origin) * s->inverse;
    float3 leave = (as_float3(high ^ other) - s->far_origin) * s->leaving;
    *near = bigger(enter.z, bigger(enter.y, bigger(enter.x, s->t_min)));
    return *near <= -bigger(leave.z, bigger(leave.y, bigger(leave.x, minus_end)));
}

// A walk through one tree, of the top level or of a BLAS.
typedef struct {
    bool top;
    ulong base;         // Its first record in NODE or TNOD.
    uint nodes, items;  // Records, and what its leaves refer to: TRIS slots or INST records.
    uint pairs_left, items_left;
    bool ready;         // first and count name a node to go on with; else one is taken from the stack.
    uint first, count;
    uint depth;
    float near[MAX_DEPTH];
    uint node[MAX_DEPTH];
} Walk;

static Node load_node(const Scene *scene, const Walk *walk, uint index) {
    ulong record = walk->base + index;
    __global const uint4 *words;
    if (walk->top)
        words = scene->top_nodes + 2 * record;
    else
#if PARTS == 1
        words = scene->nodes[0] + 2 * record;
#else
        words = scene->nodes[record >> NODE_SHIFT] + 2 * (record & ((1UL << NODE_SHIFT) - 1));
#endif
    uint4 a = words[0], b = words[1];
    Node node = { as_float4(a).xyz, a.w, as_float4(b).xyz, b.w };
    return node;
}

// Begin at the root, which is there.
static Slabs begin(const Scene *scene, Walk *walk, Real3 origin, Real3 direction, float t_min, float limit) {
    Node root = load_node(scene, walk, 0);
    Slabs s = slabs(origin, direction, root, t_min);
    float near;
    walk->ready = meets(&s, root, -widened(limit), &near);
    walk->first = root.first;
    walk->count = root.count;
    walk->depth = 0;
    walk->pairs_left = walk->nodes / 2;
    walk->items_left = walk->items;
    return s;
}

static bool failed(Hit *hit, uint status, uint a, uint b, uint c) {
    Hit failure = { a, b, c, 0, 0, NONE, NONE, status };
    *hit = failure;
    return false;
}

// Go on to the next leaf that the ray meets before `limit`, and leave its items in first and count. False at the end,
// or with a status in `failure`.
static bool next_leaf(const Scene *scene, Walk *walk, const Slabs *s, float limit, Hit *failure) {
    float end = widened(limit);
    for (;;) {
        // Take up the next node that is not behind the best hit.
        while (!walk->ready) {
            if (walk->depth == 0)
                return false;
            walk->depth--;
            if (walk->near[walk->depth] <= end) {
                Node node = load_node(scene, walk, walk->node[walk->depth]);
                walk->first = node.first;
                walk->count = node.count;
                walk->ready = true;
            }
        }
        uint first = walk->first, count = walk->count;
        if (count != 0) {
            walk->ready = false;
            if (count > MAX_LEAF || count > walk->items || first > walk->items - count)
                return failed(failure, LEAF_OUT_OF_RANGE, first, count, walk->items);
            if (count > walk->items_left)
                return failed(failure, NOT_A_TREE, walk->nodes, 0, 0);
            walk->items_left -= count;
            return true;
        }

        // Enter an inner node: test both children, go on with the nearer and put the other off.
        if (first >= walk->nodes || walk->nodes - first < 2)
            return failed(failure, CHILD_OUT_OF_RANGE, first, walk->nodes, 0);
        if (walk->pairs_left == 0)
            return failed(failure, NOT_A_TREE, walk->nodes, 0, 0);
        walk->pairs_left--;
        Node a = load_node(scene, walk, first), b = load_node(scene, walk, first + 1);
        float near_a, near_b;
        bool hits_a = meets(s, a, -end, &near_a), hits_b = meets(s, b, -end, &near_b);
        if (hits_a && hits_b) {
            if (walk->depth >= MAX_DEPTH)
                return failed(failure, TOO_DEEP, 0, 0, 0);
            bool swap = near_b < near_a;
            walk->near[walk->depth] = swap ? near_a : near_b;
            walk->node[walk->depth] = swap ? first : first + 1;
#ifndef DROPPED_CHILD // Another.
            walk->depth++;
#endif
            hits_a = !swap;
        }
        walk->ready = hits_a || hits_b;
        walk->first = hits_a ? a.first : b.first;
        walk->count = hits_a ? a.count : b.count;
    }
}

// Improve `best` by the triangles of one BLAS; with `any`, true as soon as one is hit. `stop` gets the status of a
// failure.
static bool trace_blas(const Scene *scene, Blas blas, uint instance, Real3 origin, Real3 direction, float t_min,
                       uint any, Best *best, Hit *stop) {
    if (blas.node_count == 0)
        return false;
    Walk walk;
    walk.top = false;
    walk.base = blas.node_offset;
    walk.nodes = blas.node_count;
    walk.items = blas.ref_count;
    EdgeRay ray = edge_ray(origin, direction);
    Slabs s = begin(scene, &walk, origin, direction, t_min, best->limit);
    while (next_leaf(scene, &walk, &s, best->limit, stop))
        for (uint i = 0; i < walk.count; i++)
            if (triangle(scene, &ray, blas.ref_offset + walk.first + i, instance, t_min, best) && any)
                return true;
    return false;
}

// Trace ray by ray. With `any` the answer is whether there is a hit, and the walk ends at the first.
__kernel ONE_RAY_AT_A_TIME void traverse(SCENE_PARAMETERS, __global const Ray *rays, __global Hit *hits, uint ray_count, uint any) {
    size_t id = get_global_id(0);
    if (id >= ray_count)
        return;
    Scene scene = SCENE;
    Ray ray = rays[id];
    Hit stop = no_hit();
    Best best = { widen(fmin(ray.t_max, FARTHEST)), fmin(ray.t_max, FARTHEST), no_hit() };
    Real3 origin = widen3((float3)(ray.ox, ray.oy, ray.oz)), direction = widen3((float3)(ray.dx, ray.dy, ray.dz));
    Blas blas;
    if (!usable(ray)) {
        // Meets nothing.
    } else if (scene.top_count == 0) {
        if (scene.blas_count != 0) {
            if (load_blas(&scene, 0, &blas))
                trace_blas(&scene, blas, NONE, origin, direction, ray.t_min, any, &best, &stop);
            else
                failed(&stop, BLAS_OUT_OF_RANGE, 0, 0, 0);
        }
    } else {
        Walk walk;
        walk.top = true;
        walk.base = 0;
        walk.nodes = scene.top_count;
        walk.items = scene.instance_count;
        Slabs s = begin(&scene, &walk, origin, direction, ray.t_min, best.limit);
        bool over_now = false;
        while (!over_now && next_leaf(&scene, &walk, &s, best.limit, &stop)) {
            for (uint i = 0; i < walk.count && !over_now; i++) {
                uint record = walk.first + i;
                uint4 names = scene.instances[8 * (ulong)record + 6];
                if (load_blas(&scene, names.x, &blas)) {
                    Real3 o = origin, d = direction;
                    to_object(&scene, record, &o, &d);
                    over_now = trace_blas(&scene, blas, names.y, o, d, ray.t_min, any, &best, &stop);
                } else {
                    failed(&stop, BLAS_OUT_OF_RANGE, record, names.x, 0);
                }
                over_now = over_now || stop.status != DONE;
            }
        }
    }
    Hit answer = stop.status != DONE ? stop : best.hit;
    if (any && stop.status == DONE) {
        answer = no_hit();
        answer.triangle = best.hit.triangle == NONE ? NONE : 0;
    }
    hits[id] = answer;
}
