// The file's records, the ray, and the triangle test: what traversal and brute force share.
//
// All of it mirrors bvhc's own traversal (src/trace) operation by operation, so that the answers are equal bit for bit:
// f32 and f64 operations that IEEE 754 defines, in the same order, never contracted. Why the bounds in here hold is
// written there.

#define NONE 0xFFFFFFFFu
#define FARTHEST as_float(0x7E800000u) /* 2^126: no hit counts beyond */

// What HitRecord.status says. After a failure the fields t, u and v hold the numbers named here.
#define DONE 0u
#define CHILD_OUT_OF_RANGE 1u /* first, nodes */
#define LEAF_OUT_OF_RANGE 2u  /* first, count, references */
#define BLAS_OUT_OF_RANGE 3u  /* instance, BLAS */
#define TOO_DEEP 4u
#define NOT_A_TREE 5u         /* nodes */

// Records as the host lays them out (RayRecord, HitRecord), and as the file does.
typedef struct { float ox, oy, oz, t_min, dx, dy, dz, t_max; } Ray;
typedef struct { uint t, u, v, prim, geom, instance, triangle, status; } Hit;
typedef struct { float3 low; uint first; float3 high; uint count; } Node;
typedef struct { ulong node_offset, ref_offset; uint node_count, ref_count; } Blas;

// A view of the file. NODE and TRIS are cut into PARTS buffers of 2^NODE_SHIFT and 2^TRIS_SHIFT records where one is
// more than the device allocates.
typedef struct {
    __global const uint4 *nodes[PARTS], *triangles[PARTS];
    __global const uint4 *blases, *top_nodes, *instances;
    ulong node_count, triangle_count;
    uint blas_count, top_count, instance_count;
} Scene;

#if PARTS == 1
#define SCENE_PARAMETERS                                                                                               \
    __global const uint4 *n0, __global const uint4 *t0, __global const uint4 *blases, __global const uint4 *top_nodes, \
        __global const uint4 *instances, ulong node_count, ulong triangle_count, uint blas_count, uint top_count,      \
        uint instance_count
#define SCENE                                                                                                          \
    { { n0 }, { t0 }, blases, top_nodes, instances, node_count, triangle_count, blas_count, top_count, instance_count }
#else
#define SCENE_PARAMETERS                                                                                               \
    __global const uint4 *n0, __global const uint4 *n1, __global const uint4 *n2, __global const uint4 *n3,            \
        __global const uint4 *n4, __global const uint4 *n5, __global const uint4 *n6, __global const uint4 *n7,        \
        __global const uint4 *t0, __global const uint4 *t1, __global const uint4 *t2, __global const uint4 *t3,        \
        __global const uint4 *t4, __global const uint4 *t5, __global const uint4 *t6, __global const uint4 *t7,        \
        __global const uint4 *blases, __global const uint4 *top_nodes, __global const uint4 *instances,                \
        ulong node_count, ulong triangle_count, uint blas_count, uint top_count, uint instance_count
#define SCENE                                                                                                          \
    { { n0, n1, n2, n3, n4, n5, n6, n7 }, { t0, t1, t2, t3, t4, t5, t6, t7 }, blases, top_nodes, instances,            \
      node_count, triangle_count, blas_count, top_count, instance_count }
#endif

// The record of BLAS `index`; false where the index or the record's ranges lie outside the sections.
static bool load_blas(const Scene *scene, uint index, Blas *blas) {
    if (index >= scene->blas_count)
        return false;
    __global const uint4 *words = scene->blases + 4 * (ulong)index;
    uint4 offsets = words[2];
    blas->node_count = words[0].w;
    blas->ref_count = words[1].w;
    blas->node_offset = (ulong)offsets.y << 32 | offsets.x;
    blas->ref_offset = (ulong)offsets.w << 32 | offsets.z;
    return blas->node_count <= scene->node_count && blas->node_offset <= scene->node_count - blas->node_count &&
           blas->ref_count <= scene->triangle_count && blas->ref_offset <= scene->triangle_count - blas->ref_count;
}

static __global const uint4 *triangle_words(const Scene *scene, ulong record) {
#if PARTS == 1
    return scene->triangles[0] + 3 * record;
#else
    return scene->triangles[record >> TRIS_SHIFT] + 3 * (record & ((1UL << TRIS_SHIFT) - 1));
#endif
}

// f32 helpers whose NaN and zero rules are those of the Rust twins.
static float bigger(float a, float b) { return a > b ? a : b; }
static bool is_finite(float a) { return (as_uint(a) & 0x7F800000u) != 0x7F800000u; }
static float widened(float t) { return t + fabs(t) * 0x5p-23f; }

static float next_up(float f) {
    uint bits = as_uint(f), size = bits & 0x7FFFFFFFu;
    if (size > 0x7F800000u || bits == 0x7F800000u)
        return f;
    return as_float(size == 0 ? 1 : bits == size ? bits + 1 : bits - 1);
}
static float next_down(float f) { return -next_up(-f); }

// f64 helpers: the second where the first is no number.
static real larger(real a, real b) { return less(b, a) ? a : b; }
static real smaller(real a, real b) { return less(a, b) ? a : b; }
static float round_down(real v) {
    float f = narrow(v);
    return (less(v, widen(f)) ? next_down(f) : f) + 0.0f;
}
static float round_up(real v) {
    float f = narrow(v);
    return (less(widen(f), v) ? next_up(f) : f) + 0.0f;
}

typedef struct { real x, y, z; } Real3;

static Real3 widen3(float3 v) { Real3 r = { widen(v.x), widen(v.y), widen(v.z) }; return r; }
static Real3 minus3(Real3 a, Real3 b) { Real3 r = { minus(a.x, b.x), minus(a.y, b.y), minus(a.z, b.z) }; return r; }
static real dot3(Real3 a, Real3 b) { return plus(plus(times(a.x, b.x), times(a.y, b.y)), times(a.z, b.z)); }

// (x, y, z) with the axis last and the two after it, cyclically, before: the ray looks along z.
static float3 turned(float3 v, uint axis) { return axis == 0 ? v.yzx : axis == 1 ? v.zxy : v; }
static Real3 turned3(Real3 v, uint axis) {
    Real3 r = { axis == 0 ? v.y : axis == 1 ? v.z : v.x, axis == 0 ? v.z : axis == 1 ? v.x : v.y,
                axis == 0 ? v.x : axis == 1 ? v.y : v.z };
    return r;
}

// A ray made ready for triangle tests.
typedef struct {
    Real3 origin, direction;
    Real3 forward;       // The direction, turned.
    uint axis;           // Of the direction's largest component.
    float3 near_origin;  // The origin and the two shears, rounded to f32.
    float shear_x, shear_y;
    float slack;         // What rounding the origin moved it by, times 3.
} EdgeRay;

static EdgeRay edge_ray(Real3 origin, Real3 direction) {
    EdgeRay ray;
    ray.origin = origin;
    ray.direction = direction;
    real x = magnitude(direction.x), y = magnitude(direction.y), z = magnitude(direction.z);
    ray.axis = at_most(y, x) && at_most(z, x) ? 0 : at_most(z, y) ? 1 : 2;
    ray.forward = turned3(direction, ray.axis);
    ray.near_origin = (float3)(narrow(origin.x), narrow(origin.y), narrow(origin.z));
    ray.shear_x = narrow(over(ray.forward.x, ray.forward.z));
    ray.shear_y = narrow(over(ray.forward.y, ray.forward.z));
    Real3 moved = minus3(origin, widen3(ray.near_origin));
    real most = larger(magnitude(moved.z), larger(magnitude(moved.y), larger(magnitude(moved.x), real_of(0))));
    ray.slack = round_up(times(real_of(0x4008000000000000UL), most)); // 3
    return ray;
}

// The ray in an instance's own space.
static void to_object(const Scene *scene, ulong instance, Real3 *origin, Real3 *direction) {
    __global const uint4 *rows = scene->instances + 8 * instance + 3;
    Real3 row[3];
    real last[3];
    for (int r = 0; r < 3; r++) {
        float4 m = as_float4(rows[r]);
        row[r] = widen3(m.xyz);
        last[r] = widen(m.w);
    }
    Real3 o = { plus(dot3(row[0], *origin), last[0]), plus(dot3(row[1], *origin), last[1]),
                plus(dot3(row[2], *origin), last[2]) };
    Real3 d = { dot3(row[0], *direction), dot3(row[1], *direction), dot3(row[2], *direction) };
    *origin = o;
    *direction = d;
}

// A corner as the f32 filter sees it: sheared so that the ray is the z axis, with the bound of its error.
typedef struct { float x, y, reach, error; } Corner;

static Corner corner(const EdgeRay *ray, float3 position) {
    float3 p = turned(position - ray->near_origin, ray->axis);
    Corner c;
    c.x = p.x - ray->shear_x * p.z;
    c.y = p.y - ray->shear_y * p.z;
    float reach = fabs(c.x) + fabs(c.y);
    c.error = (reach + fabs(p.z)) * 0x1p-21f + ray->slack;
    c.reach = reach + c.error;
    return c;
}

// The side of the edge that the ray passes on: 1 or -1 where f32 is sure of it, else 0.
static int side(Corner p, Corner q) {
    float bound = ((p.reach * q.error + q.reach * p.error) + 0x1p-120f) + p.reach * q.reach * 0.0f;
    float edge = p.x * q.y - p.y * q.x;
    return bound < edge ? 1 : edge < -bound ? -1 : 0;
}

// The best hit so far: smaller t first, among equal ones the smaller (instance, geometry, primitive, slot).
typedef struct {
    real t;
    float limit; // t rounded up: boxes are culled by it.
    Hit hit;
} Best;

static Hit no_hit(void) {
    Hit hit = { 0, 0, 0, 0, 0, NONE, NONE, DONE };
    return hit;
}

static bool comes_first(Hit a, Hit b) {
    if (a.instance != b.instance)
        return a.instance < b.instance;
    if (a.geom != b.geom)
        return a.geom < b.geom;
    if (a.prim != b.prim)
        return a.prim < b.prim;
    return a.triangle < b.triangle;
}

// Twice the area that the edge q p spans with the ray, seen along it.
static real edge(Real3 p, Real3 q) { return minus(times(p.x, q.y), times(p.y, q.x)); }

static real size(Real3 a) { return plus(plus(magnitude(a.x), magnitude(a.y)), magnitude(a.z)); }

// Whether zero lies farther than the margin from the span of three numbers.
static bool outside(real a, real b, real c, real margin) {
    return less(margin, smaller(smaller(a, b), c)) || less(larger(larger(a, b), c), minus(real_of(0), margin));
}

// Test one triangle; true if the ray meets it within t_min and the best hit, which it then becomes where it comes
// first.
static bool triangle(const Scene *scene, const EdgeRay *ray, ulong slot, uint instance, float t_min, Best *best) {
    __global const uint4 *words = triangle_words(scene, slot);
    uint4 w0 = words[0], w1 = words[1], w2 = words[2];
    float3 v0 = as_float4(w0).xyz, v1 = as_float4(w1).xyz, v2 = as_float4(w2).xyz;

    // The filter: a miss that f32 proves, with two edges passed on different sides.
    Corner c0 = corner(ray, v0), c1 = corner(ray, v1), c2 = corner(ray, v2);
    int s0 = side(c0, c2), s1 = side(c1, c0), s2 = side(c2, c1);
    if ((s0 > 0 || s1 > 0 || s2 > 0) && (s0 < 0 || s1 < 0 || s2 < 0))
        return false;

    // The decision: the sides in f64. A ray through an edge or a corner meets the triangle, one in its plane does not.
    Real3 d = ray->forward;
    Real3 p = widen3(v0), q = widen3(v1), r = widen3(v2);
    Real3 a = turned3(minus3(p, ray->origin), ray->axis);
    Real3 b = turned3(minus3(q, ray->origin), ray->axis);
    Real3 c = turned3(minus3(r, ray->origin), ray->axis);
    Real3 sa = { minus(times(a.x, d.z), times(a.z, d.x)), minus(times(a.y, d.z), times(a.z, d.y)), a.z };
    Real3 sb = { minus(times(b.x, d.z), times(b.z, d.x)), minus(times(b.y, d.z), times(b.z, d.y)), b.z };
    Real3 sc = { minus(times(c.x, d.z), times(c.z, d.x)), minus(times(c.y, d.z), times(c.z, d.y)), c.z };
    real zero = real_of(0);
    real u = edge(sc, sb), v = edge(sa, sc), w = edge(sb, sa);
    if ((less(u, zero) || less(v, zero) || less(w, zero)) && (less(zero, u) || less(zero, v) || less(zero, w)))
        return false;
    real sum = plus(plus(u, v), w);
    if (!less(zero, magnitude(sum))) // Seen edge-on, or of no number.
        return false;

    // Thin triangles end where the rectangle around their corners ends.
    real largest = larger(larger(size(a), size(b)), size(c));
    real margin = times(times(largest, magnitude(d.z)), real_of(0x3CD0000000000000UL)); // 2^-50
    if (outside(sa.x, sb.x, sc.x, margin) || outside(sa.y, sb.y, sc.y, margin))
        return false;

    // The distance of the triangle's plane, kept within the depths of its corners.
    Real3 e = minus3(q, p), f = minus3(r, p);
    Real3 n = { minus(times(e.y, f.z), times(e.z, f.y)), minus(times(e.z, f.x), times(e.x, f.z)),
                minus(times(e.x, f.y), times(e.y, f.x)) };
    real ahead = dot3(n, minus3(p, ray->origin));
    real low = smaller(smaller(a.z, b.z), c.z), high = larger(larger(a.z, b.z), c.z);
    bool back = less(d.z, zero);
    real near = over(back ? high : low, d.z), far = over(back ? low : high, d.z);
    real t = plus(smaller(larger(over(ahead, dot3(n, ray->direction)), near), far), zero);
    if (!(at_most(widen(t_min), t) && at_most(t, best->t)))
        return false;

    Hit hit = { as_uint(narrow(t)), as_uint(narrow(over(v, sum))), as_uint(narrow(over(w, sum))), w0.w, w1.w, instance,
                (uint)slot, DONE };
    if (best->hit.triangle == NONE || less(t, best->t) || comes_first(hit, best->hit)) {
        best->t = t;
        best->limit = round_up(t);
        best->hit = hit;
    }
    return true;
}

// Whether the ray can meet anything.
static bool usable(Ray ray) {
    return is_finite(ray.ox) && is_finite(ray.oy) && is_finite(ray.oz) && is_finite(ray.dx) && is_finite(ray.dy) &&
           is_finite(ray.dz) && (ray.dx != 0 || ray.dy != 0 || ray.dz != 0) && ray.t_min <= ray.t_max;
}
