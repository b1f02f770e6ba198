//! The triangle test: a filter in `f32` that proves most misses, and the decision in `f64`.
//!
//! Both look along the ray (Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", 2013): corners are taken relative to
//! the origin and sheared so that the ray becomes an axis; the ray hits if the origin of the remaining plane lies on the same
//! side of all three edges. The side is the sign of an edge function `p × q`, which is exactly antisymmetric in floating point, so the two
//! triangles of a shared edge never both lose a ray.
//!
//! The `f64` decision shears by multiplication, `a·d_z − a_z·d`: for the rays of a one-level file (whose numbers are `f32`) differences and
//! products are exact in `f64` unless exponents lie far apart, so its signs are those of true geometry but for rays closer to an
//! edge than about 2⁻⁵⁰ of the coordinates in play. `f32` alone would move edges by 2⁻²² of the distance, enough to hand a hit to
//! a neighbour whose box the ray misses.

use super::test::{Crossing, TriangleTest, dominant, others};
use crate::cache::{InstanceRecord, TriangleRecord};
use crate::geom::vector::{cross, dot, sub};
use crate::simd::Register;

/// A ray made ready for triangle tests. The axis of the direction's largest component is a constant of the test functions; this
/// says which to call.
#[derive(Clone, Copy, Debug)]
pub struct EdgeRay {
    dominant: usize,
    origin: [f64; 3],
    direction: [f64; 3],
    /// The origin and the two shears rounded to `f32`.
    filter_origin: Register,
    shear: [Register; 2],
    /// What rounding the origin moved it by, times 3.
    slack: Register,
}

/// The numbers of [`EdgeRay`]'s filter for many triangles at once: see `surely_misses`.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    /// The axes that are sheared, and the one they are sheared along.
    pub axes: [usize; 3],
    /// The origin on these axes, rounded to `f32`.
    pub origin: [f32; 3],
    /// The two shears.
    pub shear: [f32; 2],
    /// What rounding the origin moved it by, times 3.
    pub slack: f32,
}

impl Filter {
    /// `8u`.
    pub const RELATIVE: f32 = 4.0 * f32::EPSILON;
    /// 2⁻¹²⁰.
    pub const UNDERFLOW: f32 = f32::from_bits((127 - 120) << 23);
}

/// What an origin that was moved so far adds to the error of a corner.
#[inline(always)]
fn slack(moved: f64) -> f32 {
    crate::geom::round_up(3.0 * moved)
}

impl TriangleTest for EdgeRay {
    /// In `f64`: the stored matrix is taken as it is, and nothing is added to its rounding.
    fn to_object(instance: &InstanceRecord, origin: [f64; 3], direction: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let m = instance.world_to_object.map(f64::from);
        let linear = |v: [f64; 3], r: usize| m[4 * r] * v[0] + m[4 * r + 1] * v[1] + m[4 * r + 2] * v[2];
        ([0, 1, 2].map(|r| linear(origin, r) + m[4 * r + 3]), [0, 1, 2].map(|r| linear(direction, r)))
    }

    #[inline(always)]
    fn new(origin: [f64; 3], direction: [f64; 3]) -> EdgeRay {
        EdgeRay::new(origin, direction)
    }

    fn axis(&self) -> usize {
        self.dominant
    }

    #[inline(always)]
    fn crossing<const AXIS: usize>(&self, triangle: &TriangleRecord) -> Option<Crossing> {
        if self.surely_misses::<AXIS>(triangle) {
            return None;
        }
        self.decide::<AXIS>(triangle)
    }
}

impl EdgeRay {
    /// The direction is finite and not zero.
    #[inline(always)]
    fn new(origin: [f64; 3], direction: [f64; 3]) -> EdgeRay {
        let dominant = dominant(direction);
        let (kx, ky) = others(dominant);
        let filter_origin = origin.map(|v| v as f32);
        let moved = (0..3).map(|a| (origin[a] - f64::from(filter_origin[a])).abs()).fold(0.0, f64::max);
        EdgeRay {
            dominant,
            origin,
            direction,
            filter_origin: Register::of([filter_origin[0], filter_origin[1], filter_origin[2], 0.0]),
            shear: [kx, ky].map(|k| Register::splat((direction[k] / direction[dominant]) as f32)),
            slack: Register::splat(slack(moved)),
        }
    }

    /// True only if the exact ray's line misses the triangle.
    ///
    /// Let `u = 2⁻²⁴` and let `a` be a corner relative to the origin, with sheared coordinates `A`. The three roundings of the origin, the
    /// shear and its product, and the one of the difference give `|error of A_x| ≤ u(2|a_x| + 4.1|a_z|) + 2.1·moved ≤ u(2r + 6.1|a_z|) +
    /// 2.1·moved` with `r = |A_x| + |A_y|`. An edge function `C_x·B_y − C_y·B_x` is therefore off by at most `g_C·e_B + g_B·e_C`, where
    /// `e = 8u(r + |a_z|) + 3·moved` covers the error of a corner and its share `u·r` of the edge function's own roundings, and `g = r + e`. The
    /// constant 2⁻¹²⁰ stands for underflow. Where one of the two products of an edge function may overflow, so does `g_C·g_B`, and its product with 0
    /// makes the bound no number, so that both comparisons are false.
    ///
    /// The lanes are the three corners, and the third once more.
    #[inline(always)]
    pub fn surely_misses<const AXIS: usize>(&self, triangle: &TriangleRecord) -> bool {
        let (kx, ky) = others(AXIS);
        let rows: [[f32; 4]; 3] = bytemuck::cast(*triangle);
        let corners = Register::transpose_three(rows.map(|row| Register::of(row) - self.filter_origin));
        let z = corners[AXIS];
        let x = corners[kx] - self.shear[0] * z;
        let y = corners[ky] - self.shear[1] * z;
        let reach = x.abs() + y.abs();
        let error = (reach + z.abs()) * Register::splat(Filter::RELATIVE) + self.slack;
        let reach = reach + error;

        // The edge functions of each corner and the one before it.
        let [qx, qy, q_reach, q_error] = [x, y, reach, error].map(Register::previous);
        let overflow = reach * q_reach * Register::splat(0.0);
        let bound = reach * q_error + q_reach * error + Register::splat(Filter::UNDERFLOW) + overflow;
        let side = x * qy - y * qx;
        let (left, right) = (bound.less(side), side.less(bound.negated()));
        (left != 0) & (right != 0)
    }

    /// The numbers for many triangles at once.
    #[inline(always)]
    pub fn filter(&self) -> Filter {
        let EdgeRay { dominant, origin, direction, .. } = self;
        let (kx, ky) = others(*dominant);
        let [x, y, z] = [origin[kx] as f32, origin[ky] as f32, origin[*dominant] as f32];
        let moved = |rounded: f32, exact: f64| (exact - f64::from(rounded)).abs();
        let [a, b, c] = [moved(x, origin[kx]), moved(y, origin[ky]), moved(z, origin[*dominant])];
        let along = direction[*dominant];
        Filter {
            axes: [kx, ky, *dominant],
            origin: [x, y, z],
            shear: [(direction[kx] / along) as f32, (direction[ky] / along) as f32],
            slack: slack(larger(larger(a, b), c)),
        }
    }

    /// A ray for [`EdgeRay::decide`] and [`EdgeRay::filter`]: its own filter has no numbers and proves no miss.
    #[inline(always)]
    pub fn unfiltered(origin: [f64; 3], direction: [f64; 3]) -> EdgeRay {
        let none = Register::splat(f32::NAN);
        EdgeRay { dominant: dominant(direction), origin, direction, filter_origin: none, shear: [none; 2], slack: none }
    }

    /// Where the ray's line crosses the triangle, edges and corners included. A triangle seen edge-on has no crossing.
    ///
    /// Two conditions are asked. The origin of the sheared plane lies on one side of the three edges. And it lies within the rectangle around
    /// the sheared corners, up to a margin of 2⁻⁵⁰ of the coordinates in play: a shear and its difference round by less than 2⁻⁵¹ of them, so
    /// no ray that meets the triangle is lost by the second one. It is needed where a triangle is so thin that the products of an edge
    /// function are rounded by more than the triangle is wide. All three signs are chance there, along the whole line of the
    /// triangle, and only the rectangle ends it.
    ///
    /// The distance is that of the triangle's plane: its normal is a difference of products that are exact in `f64`, so the distance
    /// is good for slivers too, where the ratio of the edge functions is not. Kept within the corners' depths, it stays
    /// sensible for planes that the ray nearly lies in. A distance of zero is always positive: which of two zeros a minimum is
    /// differs between processors.
    #[inline(never)]
    pub fn decide<const AXIS: usize>(&self, triangle: &TriangleRecord) -> Option<Crossing> {
        let (kx, ky) = others(AXIS);
        let (o, d) = (&self.origin, &self.direction);
        let sheared = |p: &[f32; 3]| {
            let relative = |k: usize| f64::from(p[k]) - o[k];
            let (x, y, z) = (relative(kx), relative(ky), relative(AXIS));
            (x * d[AXIS] - z * d[kx], y * d[AXIS] - z * d[ky], z)
        };
        let (a, b, c) = (sheared(&triangle.v0), sheared(&triangle.v1), sheared(&triangle.v2));
        let edge = |p: (f64, f64, f64), q: (f64, f64, f64)| p.0 * q.1 - p.1 * q.0;
        let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));

        // One question instead of six, since no processor guesses signs. A triangle of no number has no crossing.
        let sum = u + v + w;
        if ((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0)) | !(sum.abs() > 0.0) {
            return None;
        }

        // The signs of a triangle that is thinner than their rounding say nothing of how far along it the ray passes.
        let size = |p: &[f32; 3]| {
            let distance = |k: usize| (f64::from(p[k]) - o[k]).abs();
            distance(kx) + distance(ky) + distance(AXIS)
        };
        let largest = larger(larger(size(&triangle.v0), size(&triangle.v1)), size(&triangle.v2));
        let margin = largest * d[AXIS].abs() * OUTLINE_MARGIN;
        let outside = |a: f64, b: f64, c: f64| smaller(smaller(a, b), c) > margin || larger(larger(a, b), c) < -margin;
        if outside(a.0, b.0, c.0) || outside(a.1, b.1, c.1) {
            return None;
        }

        // The plane's distance, between those of the nearest and the farthest corner. Of three quotients by one number the smallest is
        // that of the smallest or the largest, so two are enough.
        let wide = |p: &[f32; 3]| [f64::from(p[0]), f64::from(p[1]), f64::from(p[2])];
        let (p, q, r) = (wide(&triangle.v0), wide(&triangle.v1), wide(&triangle.v2));
        let (e, f) = (sub(q, p), sub(r, p));
        let n = cross(e, f);
        let ahead = dot(n, sub(p, *o));
        let (low, high) = (smaller(smaller(a.2, b.2), c.2), larger(larger(a.2, b.2), c.2));
        let (near, far) = if d[AXIS] < 0.0 { (high, low) } else { (low, high) };
        let t = smaller(larger(ahead / dot(n, *d), near / d[AXIS]), far / d[AXIS]);
        Some(Crossing { t: t + 0.0, u: v, v: w, sum })
    }
}

/// The second where the first is NaN.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The second where the first is NaN.
#[inline(always)]
pub fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// 2⁻⁵⁰.
const OUTLINE_MARGIN: f64 = f64::from_bits((1023 - 50) << 52);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Triangles around the z axis, 2⁻⁹⁰ of their length wide and all as good as one line to `f64`, and rays that cross the axis: before the
    /// triangle, within it, or behind it. All three signs are chance.
    #[test]
    fn a_needle_is_hit_between_its_ends_alone() {
        let mut random = Random::new(1);
        let (mut within, mut beside) = (0, 0);
        for _ in 0..40_000 {
            let mut near = || (random.unit() * 2.0 - 1.0) as f32;
            let depths = [near(), near(), near()];
            let corners = depths.map(|z| [near() * 1e-27, near() * 1e-27, z]);
            let mut triangle: TriangleRecord = bytemuck::Zeroable::zeroed();
            [triangle.v0, triangle.v1, triangle.v2] = corners;
            let (x, y, start, slope) = (near() * 0.1, near() * 0.1, near(), near());
            let ray = EdgeRay::new([x, y, start].map(f64::from), [-x, -y, slope].map(f64::from));
            let crossing = match ray.dominant {
                0 => ray.crossing::<0>(&triangle),
                1 => ray.crossing::<1>(&triangle),
                _ => ray.crossing::<2>(&triangle),
            };
            let at = f64::from(start) + f64::from(slope);
            let [low, high] = [f32::min, f32::max].map(|f| f64::from(depths.into_iter().reduce(f).unwrap()));
            if low - 1e-12 <= at && at <= high + 1e-12 {
                within += u32::from(crossing.is_some());
            } else {
                beside += 1;
                assert!(crossing.is_none(), "{triangle:?} ends before {at}, {ray:?}");
            }
        }
        assert!(within > 100 && beside > 1000, "{within} hits, {beside} rays past the ends");
    }

    /// Products beyond the range of `f32` prove nothing: rays at points of triangles whose coordinates are about the root of the largest number.
    #[test]
    fn a_product_that_overflows_rejects_nothing() {
        let mut random = Random::new(7);
        let mut crossed = 0;
        for _ in 0..40_000 {
            let mut point = || [0; 3].map(|_| (2.5e19 * (2.0 * random.unit() - 1.0)) as f32);
            let corners = [point(), point(), point()];
            let mut triangle: TriangleRecord = bytemuck::Zeroable::zeroed();
            [triangle.v0, triangle.v1, triangle.v2] = corners;
            let (a, b) = (random.unit(), random.unit());
            let weights = [1.0 - a.max(b), a.min(b), (a - b).abs()];
            let target = [0, 1, 2].map(|k| (0..3).map(|c| weights[c] * f64::from(corners[c][k])).sum::<f64>());
            let ray = EdgeRay::new([0.0; 3], target.map(|v| f64::from((v * 1e-19) as f32)));
            let (filtered, exact) = match ray.dominant {
                0 => (ray.crossing::<0>(&triangle), ray.decide::<0>(&triangle)),
                1 => (ray.crossing::<1>(&triangle), ray.decide::<1>(&triangle)),
                _ => (ray.crossing::<2>(&triangle), ray.decide::<2>(&triangle)),
            };
            crossed += u32::from(exact.is_some());
            assert_eq!(filtered.is_some(), exact.is_some(), "{triangle:?} {ray:?}");
        }
        assert!(crossed > 30_000, "{crossed}");
    }
}
