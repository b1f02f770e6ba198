//! Brute force between two frames: every triangle of every instance, moved to the time of the ray. Without trees, boxes or a top level.
//!
//! Twice: by the triangle test of traversal over the very numbers that it sees, which must agree to the bit; and in `f64` and world space, by
//! another formula that shares nothing with the library, which must agree but for rays that pass an edge closely.

use bvhc::cache::{Between, TriangleRecord};
use bvhc::geom::{Mix, Ray};
use bvhc::random::Random;
use bvhc::trace::{FARTHEST, Hit};
use bvhc_core::trace::arithmetic::{Crossing, EdgeRay, TriangleTest};

/// The scene at one moment.
pub struct Moved<'b> {
    pub between: &'b Between<'b>,
    pub mix: Mix,
    pub fraction: f32,
    /// For each instance its triangles, as the library interpolates them, in the tree's space.
    triangles: Vec<Vec<TriangleRecord>>,
    /// For each instance its triangles in world space, interpolated in `f64` from the ends.
    world: Vec<Vec<[[f64; 3]; 3]>>,
}

impl<'b> Moved<'b> {
    pub fn new(between: &'b Between<'b>, fraction: f32) -> Moved<'b> {
        let mix = Mix::new(fraction).unwrap();
        let (mut triangles, mut world) = (Vec::new(), Vec::new());
        for instance in between.instances() {
            let tree = between.tree(instance.tree as usize).unwrap();
            triangles.push(tree.triangles.iter().map(|t| tree.at(t, &mix)).collect());
            let f = f64::from(fraction);
            let lerp = |a: f32, b: f32| f64::from(a) * (1.0 - f) + f64::from(b) * f;
            let [m, n] = instance.ends.map(|end| end.object_to_world);
            let placed = |v: u32| {
                let p = [0, 1, 2].map(|k| lerp(tree.vertices[0][v as usize][k], tree.vertices[1][v as usize][k]));
                [0, 4, 8].map(|r| {
                    let at = |c: usize| lerp(m[r + c], n[r + c]);
                    at(0) * p[0] + at(1) * p[1] + at(2) * p[2] + at(3)
                })
            };
            world.push(tree.triangles.iter().map(|t| t.corners.map(placed)).collect());
        }
        Moved { between, mix, fraction, triangles, world }
    }

    /// The hit by the library's own arithmetic over all triangles.
    pub fn exactly(&self, ray: &Ray) -> Option<Hit> {
        let mut best: Option<(f64, Hit)> = None;
        for (instance, triangles) in self.between.instances().iter().zip(&self.triangles) {
            let (origin, direction) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
            let Some((origin, direction)) = instance.to_object(&self.mix, origin, direction) else { continue };
            let test = <EdgeRay as TriangleTest>::new(origin, direction);
            let first = self.between.tree(instance.tree as usize).unwrap().first_triangle;
            for (slot, triangle) in triangles.iter().enumerate() {
                let crossing = match test.axis() {
                    0 => test.crossing::<0>(triangle),
                    1 => test.crossing::<1>(triangle),
                    _ => test.crossing::<2>(triangle),
                };
                let Some(Crossing { t, u, v, sum }) = crossing else { continue };
                if !(t >= f64::from(ray.t_min) && t <= f64::from(ray.t_max.min(FARTHEST))) {
                    continue;
                }
                let hit = Hit {
                    t: t as f32,
                    u: (u / sum) as f32,
                    v: (v / sum) as f32,
                    prim: triangle.prim,
                    geom: triangle.geom,
                    instance: Some(instance.ends[0].id),
                    triangle: first + slot,
                };
                let key = |h: &Hit| (h.instance, h.geom, h.prim);
                if best.is_none_or(|(old_t, old)| t < old_t || t == old_t && key(&hit) < key(&old)) {
                    best = Some((t, hit));
                }
            }
        }
        best.map(|(_, hit)| hit)
    }

    /// The nearest distance in world space, by Möller and Trumbore's formula, of triangles that are grown by this part of themselves, or shrunk.
    pub fn nearest(&self, ray: &Ray, grown: f64) -> Option<f64> {
        let (o, d) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
        let sub = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k] - b[k]);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let distance = |[a, b, c]: &[[f64; 3]; 3]| {
            let (e, f) = (sub(*b, *a), sub(*c, *a));
            let p = cross(d, f);
            let determinant = dot(e, p);
            // Seen nearly edge-on: what rounding makes of it, nobody can say.
            let length = |v: [f64; 3]| dot(v, v).sqrt();
            if !(determinant.abs() > 1e-3 * length(e) * length(p)) {
                return None;
            }
            let s = sub(o, *a);
            let q = cross(s, e);
            let (u, v, t) = (dot(s, p) / determinant, dot(d, q) / determinant, dot(f, q) / determinant);
            let inside = u >= -grown && v >= -grown && u + v <= 1.0 + grown;
            (inside && t >= f64::from(ray.t_min) && t <= f64::from(ray.t_max)).then_some(t)
        };
        self.world.iter().flatten().filter_map(distance).reduce(f64::min)
    }

    /// A ray at a point of some triangle, often of its edge or a corner, from somewhere around; seldom past everything.
    pub fn some_ray(&self, random: &mut Random) -> Ray {
        let shown: Vec<_> = self.world.iter().filter(|triangles| !triangles.is_empty()).collect();
        let Some(triangles) = shown.get(random.below(shown.len().max(1) as u64) as usize) else {
            return Ray::new([0.0; 3], [1.0, 0.0, 0.0]);
        };
        let [a, b, c] = triangles[random.below(triangles.len() as u64) as usize];
        let (mut u, mut v) = (random.unit(), random.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        match random.below(8) {
            0 => u = 0.0,
            1 => v = 0.0,
            2 => u = 1.0 - v,
            3 => (u, v) = (0.0, 0.0),
            _ => {}
        }
        let target = [0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
        let size = target.iter().chain(&b).chain(&a).fold(0.0f64, |m, v| m.max(v.abs()));
        let away = random.direction().map(|k| k * size * (0.1 + 2.0 * random.unit()));
        let origin = [0, 1, 2].map(|k| (target[k] + away[k]) as f32);
        let along = random.below(16) as usize;
        let direction = [0, 1, 2].map(|k| {
            let straight = (target[k] - f64::from(origin[k])) as f32;
            if along > 2 || along == k { straight } else { 0.0 }
        });
        if direction == [0.0; 3] { Ray::new(origin, [0.0, 1.0, 0.0]) } else { Ray::new(origin, direction) }
    }
}

/// What rays found.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    pub rays: usize,
    pub hits: usize,
    /// Rays that `f64` in world space is sure to hit.
    pub sure: usize,
}

/// So many rays at this moment: each must find what brute force finds.
pub fn compare(moved: &Moved<'_>, rays: usize, random: &mut Random, tally: &mut Tally) {
    for _ in 0..rays {
        let ray = moved.some_ray(random);
        let fraction = moved.fraction;
        let hit = moved.between.closest_hit(&ray, fraction).unwrap();
        let want = moved.exactly(&ray);
        // Copies of a triangle that stands in several leaves are one triangle, and any of them may be named.
        let named = |h: Hit| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.prim, h.geom, h.instance);
        assert_eq!(hit.map(named), want.map(named), "{ray:?} at {fraction}: {hit:?}, brute force {want:?}");
        assert_eq!(moved.between.any_hit(&ray, fraction).unwrap(), hit.is_some(), "{ray:?} at {fraction}");

        let near = 1e-3;
        if let Some(sure) = moved.nearest(&ray, -near) {
            let t = hit.unwrap_or_else(|| panic!("missed: {ray:?} at {fraction}, at {sure}")).t;
            assert!(f64::from(t) <= sure * (1.0 + near) + near, "{ray:?} at {fraction}: {t} for {sure}");
            tally.sure += 1;
        }
        tally.rays += 1;
        tally.hits += usize::from(hit.is_some());
    }
}
