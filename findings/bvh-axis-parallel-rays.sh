#!/usr/bin/env bash
# Crate bvh 0.13.0 (svenstaro/bvh): a vertical ray over a grid line of a height field hits nothing.
#
# Expected: the candidates of Bvh::traverse are a superset of what the ray hits. Box tests must see to 0 * inf for that (Ize 2013, Robust BVH
# Ray Traversal), so that a ray in the plane of a face counts for the box.
# Seen: where a direction is 0 in x and the origin has the x of a face, 0 * inf is NaN, and the box counts as missed. That is so on
# both sides of a face, so both neighbours are passed over, although the ray hits their triangles. The crate's change log has the rule
# for one box, not that whole rows of hits are lost. 225 of 225 rays over nodes are lost, and 225 of 225 over edges; beside them none.
# Hurts: terrain heights and picking at whole coordinates, images whose pixel centres lie on a grid of the model.
# bvhc: a slab that is NaN never culls; grid_scenes_are_exact of tests/accuracy.rs shoots such rays.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/src"
cat > "$work/Cargo.toml" <<'TOML'
[package]
name = "axis"
version = "0.0.0"
edition = "2021"
[dependencies]
bvh = "=0.13.0"
nalgebra = "=0.35.0"
[workspace]
TOML
cat > "$work/src/main.rs" <<'RUST'
use bvh::{aabb::{Aabb, Bounded}, bounding_hierarchy::BHShape, bvh::Bvh, ray::Ray};
use nalgebra::{Point3, Vector3};

struct Triangle { corners: [Point3<f32>; 3], node: usize }
impl Bounded<f32, 3> for Triangle {
    fn aabb(&self) -> Aabb<f32, 3> {
        self.corners.iter().fold(Aabb::empty(), |b, p| b.grow(p))
    }
}
impl BHShape<f32, 3> for Triangle {
    fn set_bh_node_index(&mut self, node: usize) { self.node = node; }
    fn bh_node_index(&self) -> usize { self.node }
}

/// Whether the vertical line through (x, y) meets the triangle, border included: exact for the small multiples of 1/4 used here.
fn below(t: &Triangle, x: f32, y: f32) -> bool {
    let side = |i: usize| {
        let (a, b) = (t.corners[i], t.corners[(i + 1) % 3]);
        (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)
    };
    (0..3).all(|i| side(i) >= 0.0)
}

fn main() {
    const N: usize = 16;
    let p = |x: usize, y: usize| Point3::new(x as f32, y as f32, ((x * 7 + y * 13) % 5) as f32 * 0.25);
    let mut field = Vec::new();
    for y in 0..N {
        for x in 0..N {
            field.push(Triangle { corners: [p(x, y), p(x + 1, y), p(x + 1, y + 1)], node: 0 });
            field.push(Triangle { corners: [p(x, y), p(x + 1, y + 1), p(x, y + 1)], node: 0 });
        }
    }
    let tree = Bvh::build(&mut field);
    for (name, dx, dy) in [("nodes", 0.0, 0.0), ("edges", 0.5, 0.0), ("beside", 0.25, 0.5)] {
        let (mut hit, mut lost) = (0, 0);
        for i in 0..(N - 1) * (N - 1) {
            let (x, y) = ((i % (N - 1) + 1) as f32 + dx, (i / (N - 1) + 1) as f32 + dy);
            let ray = Ray::new(Point3::new(x, y, 10.0), Vector3::new(0.0, 0.0, -1.0));
            let all = field.iter().any(|t| below(t, x, y));
            let tree = tree.traverse(&ray, &field).into_iter().any(|t| below(t, x, y));
            hit += usize::from(all);
            lost += usize::from(all && !tree);
        }
        println!("{name} hit {hit} lost {lost}");
    }
}
RUST
CARGO_TARGET_DIR="$work/target" cargo run --quiet --manifest-path "$work/Cargo.toml" | tee "$work/out"
expected='nodes hit 225 lost 225
edges hit 225 lost 225
beside hit 225 lost 0'
if [ "$(cat "$work/out")" != "$expected" ]; then
    printf 'CHANGED: bvh 0.13.0 no longer loses just the rays on grid lines. Seen before:\n%s\n' "$expected" >&2
    exit 1
fi
echo "as described: bvh 0.13.0 loses every vertical ray over a grid line, and none beside"
