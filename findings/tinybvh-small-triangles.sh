#!/usr/bin/env bash
# tinybvh 1.6.8 (the header in the package tinybvh-rs 0.1.0-beta.3): its binary trees lose every hit on triangles whose sides are below a thousandth.
#
# Expected: a ray that meets the middle of a triangle hits it, whatever the model's unit. Its own 8-wide trees answer so.
# Seen: the triangle test of BVH::Intersect takes a ray for parallel where the determinant is below a constant, 0.000001. The determinant is twice the
# triangle's area times the cosine of the ray to its normal, so it is a matter of the unit: on a floor of 32 x 32 squares no hit is lost where it is 1 wide,
# all 400 are where it is 0.03 wide, and BuildHQ loses the same. BVH8_CPU loses none at these sizes and at 0.001.
# Hurts: scans in metres, small parts, dense meshes, rays that graze larger triangles; hits change with the layout that is traced.
# bvhc: the triangle test has no length of its own; offsets_and_scales_lose_no_hits of tests/accuracy.rs scales whole scenes.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/src"
cat > "$work/Cargo.toml" <<'TOML'
[package]
name = "small"
version = "0.0.0"
edition = "2021"
[dependencies]
tinybvh-rs = "=0.1.0-beta.3"
[workspace]
TOML
echo 'fn main() {}' > "$work/src/main.rs"
header=$(cargo metadata --format-version 1 --manifest-path "$work/Cargo.toml" 2> /dev/null |
    tr '"' '\n' | grep 'tinybvh-rs-0.1.0-beta.3/Cargo.toml$' | head -n 1)
cat > "$work/small.cpp" <<'CPP'
#define TINYBVH_IMPLEMENTATION
#include "tiny_bvh.h"
#include <cstdio>
#include <vector>

using namespace tinybvh;

// A floor of 2 * 32 * 32 triangles, `size` wide, and 400 rays that fall on it from `size` above.
static void study(float size) {
    const int n = 32;
    auto p = [&](int x, int y) { return bvhvec4(x * size / n, y * size / n, 0, 0); };
    std::vector<bvhvec4> floor;
    for (int y = 0; y < n; y++) for (int x = 0; x < n; x++)
        for (auto v : {p(x, y), p(x + 1, y), p(x + 1, y + 1), p(x, y), p(x + 1, y + 1), p(x, y + 1)}) floor.push_back(v);
    BVH plain, high;
    BVH8_CPU wide;
    plain.Build(floor.data(), 2 * n * n);
    high.BuildHQ(floor.data(), 2 * n * n);
    wide.Build(floor.data(), 2 * n * n);
    int lost[3] = {};
    for (int i = 0; i < 400; i++) {
        auto at = [&](int k) { return (k + 0.3f) * size / 21; };
        Ray rays[3];
        for (auto& ray : rays) ray = Ray(bvhvec3(at(i % 20), at(i / 20), size), bvhvec3(0, 0, -1));
        plain.Intersect(rays[0]), high.Intersect(rays[1]), wide.Intersect(rays[2]);
        for (int k = 0; k < 3; k++) lost[k] += rays[k].hit.t >= BVH_FAR;
    }
    printf("%g wide: lost of 400 by Build %d, by BuildHQ %d, by BVH8_CPU %d\n", size, lost[0], lost[1], lost[2]);
}

int main() {
    study(1);
    study(0.03f);
    study(0.001f);
}
CPP
c++ -std=c++20 -O2 -mavx2 -mfma -w -pthread -I "$(dirname "$header")/ffi/tinybvh" "$work/small.cpp" -o "$work/small"
"$work/small" | tee "$work/out"
expected='1 wide: lost of 400 by Build 0, by BuildHQ 0, by BVH8_CPU 0
0.03 wide: lost of 400 by Build 400, by BuildHQ 400, by BVH8_CPU 0
0.001 wide: lost of 400 by Build 400, by BuildHQ 400, by BVH8_CPU 0'
if [ "$(cat "$work/out")" != "$expected" ]; then
    printf 'CHANGED: tinybvh 1.6.8 no longer loses just the small triangles of binary trees. Seen before:\n%s\n' "$expected" >&2
    exit 1
fi
echo "as described: the binary trees of tinybvh 1.6.8 lose every hit on triangles of sides below a thousandth, its 8-wide trees none"
