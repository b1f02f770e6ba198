// tinybvh as a handful of C functions: a tree of some setting, its nodes, and rays through it or through the 8-wide form of it.
#define TINYBVH_IMPLEMENTATION
#include "tiny_bvh.h"
#include <chrono>
#include <cmath>

using namespace tinybvh;

namespace {

struct Tree {
    BVH binary;
    BVH8_CPU wide;
};

// What a setting means before the build; the library's own costs and leaves.
void prepare(BVH& bvh, uint32_t setting) {
    bvh.useFullSweep = setting == 1;
    bvh.hqbvhbins = setting >= 3 ? 32 : 8;
}

} // namespace

extern "C" {

// Vertices are three of four floats a triangle, and outlive the tree. `wide` is 1 for the 8-wide form.
Tree* tree_build(const float* vertices, uint32_t triangles, uint32_t setting, uint32_t wide, double* milliseconds) {
    auto* corners = reinterpret_cast<const bvhvec4*>(vertices);
    bvhvec4slice slice(corners, 3 * triangles, sizeof(bvhvec4));
    Tree* tree = new Tree();
    const bool hq = setting >= 2, optimized = setting >= 4;
    const uint32_t iterations = setting == 4 ? 25 : 50;
    auto start = std::chrono::steady_clock::now();
    if (wide) {
        prepare(tree->wide.bvh8.bvh, setting);
        if (hq) tree->wide.BuildHQ(slice); else tree->wide.Build(slice);
        if (optimized) tree->wide.Optimize(iterations, setting == 5);
    } else {
        prepare(tree->binary, setting);
        if (hq) tree->binary.BuildHQ(slice);
#ifdef BVH_USEAVX
        else if (setting == 0) tree->binary.BuildAVX(slice);
#endif
        else tree->binary.Build(slice);
        if (optimized) tree->binary.Optimize(iterations, setting == 5, false);
    }
    *milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return tree;
}

uint32_t tree_nodes(const Tree* tree, const void** nodes) {
    *nodes = tree->binary.bvhNode;
    return tree->binary.usedNodes;
}

uint32_t tree_indices(const Tree* tree, const uint32_t** indices) {
    *indices = tree->binary.primIdx;
    return tree->binary.idxCount;
}

uint32_t tree_wide_nodes(const Tree* tree, double* bytes) {
    *bytes = 64.0 * tree->wide.usedBlocks;
    return tree->wide.bvh8.usedNodes;
}

// A ray is its origin and its direction as they are, without the normalisation of the constructor. 1 where something is hit.
uint32_t tree_trace(const Tree* tree, uint32_t wide, const float* ray, float* t, uint32_t* triangle) {
    Ray asked(bvhvec3(ray[0], ray[1], ray[2]), bvhvec3(ray[4], ray[5], ray[6]));
    asked.D = bvhvec3(ray[4], ray[5], ray[6]);
    asked.rD = tinybvh_rcp(asked.D);
    if (wide) tree->wide.Intersect(asked); else tree->binary.Intersect(asked);
    *t = asked.hit.t, *triangle = asked.hit.prim;
    return asked.hit.t < BVH_FAR;
}

void tree_free(Tree* tree) { delete tree; }

uint32_t has_wide() {
#ifdef BVH_USEAVX2
    return 1;
#else
    return 0;
#endif
}
}
