// Brute force: every triangle slot of every instance, no tree. The same triangle test, so the same bits where the tree
// loses nothing.

// Test all rays against the slots from (first_place, first_slot) up to (last_place, last_slot), which does not count. A
// place is an instance, or the only BLAS of a one-level file. Hits and distances stay in their buffers from one launch
// to the next.
__kernel void brute(SCENE_PARAMETERS, __global const Ray *rays, __global Hit *hits, __global ulong *distances,
                    uint ray_count, uint fresh, uint first_place, uint first_slot, uint last_place, uint last_slot) {
    size_t id = get_global_id(0);
    if (id >= ray_count)
        return;
    Scene scene = SCENE;
    Ray ray = rays[id];
    Best best;
    float t_max = fmin(ray.t_max, FARTHEST);
    best.t = fresh ? widen(t_max) : real_of(distances[id]);
    best.hit = no_hit();
    if (!fresh)
        best.hit = hits[id];
    best.limit = t_max; // Boxes are not tested.
    for (uint place = first_place; place <= last_place && usable(ray); place++) {
        Real3 origin = widen3((float3)(ray.ox, ray.oy, ray.oz)), direction = widen3((float3)(ray.dx, ray.dy, ray.dz));
        uint number = 0, instance = NONE;
        if (scene.top_count != 0) {
            if (place >= scene.instance_count)
                break;
            uint4 names = scene.instances[8 * (ulong)place + 6];
            number = names.x;
            instance = names.y;
            to_object(&scene, place, &origin, &direction);
        }
        Blas blas;
        if (!load_blas(&scene, number, &blas))
            break;
        EdgeRay edges = edge_ray(origin, direction);
        uint from = place == first_place ? first_slot : 0;
        uint to = place == last_place ? min(last_slot, blas.ref_count) : blas.ref_count;
        for (uint slot = from; slot < to; slot++)
            triangle(&scene, &edges, blas.ref_offset + slot, instance, ray.t_min, &best);
    }
    distances[id] = bits_of(best.t);
    hits[id] = best.hit;
}
