//! The box test: slabs that never reject a box which the exact ray meets.
//!
//! Write `u = 2⁻²⁴`. Each slab distance `(plane − origin) · inverse` suffers three relative errors of at most `u`, so a computed entry
//! may exceed a computed exit by a factor `(1 + u)³ / (1 − u)³ < 1 + 7u`; the exit is therefore widened by `8u` of itself (Ize, "Robust BVH
//! Ray Traversal", 2013). What is not relative is put into the origin: each axis has two of them, moved apart so that the box
//! looks larger, by
//! - the rounding of a mapped ray's `f64` origin to `f32`,
//! - `2⁻⁴⁸` of the largest coordinate in play: sixteen times what the triangle test's `f64` arithmetic may be off,
//! - `2⁻¹⁴⁶·|direction|` and at least `2⁻¹⁰⁰`: products that underflow.
//!
//! For all but the tiniest coordinates these moves come to one unit in the last place of the origin.

use crate::geom::{Aabb, round_down, round_up};
use crate::tree::Node;

/// `8u`: how much of itself the exit distance is widened by.
const WIDEN: f32 = 8.0 * (f32::EPSILON / 2.0);

/// A ray made ready for box tests.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slabs {
    /// Per axis the origin that makes the entry distance smallest, and the one that makes the exit distance largest.
    near_origin: [f32; 4],
    far_origin: [f32; 4],
    /// `1 / direction`. Infinite where the ray is parallel to the slab: then an origin inside gives −∞ and +∞, one on a face gives
    /// NaN, which the comparisons below ignore. NaN where the reciprocal is not a normal number: the axis is not used.
    inverse: [f32; 4],
    /// All ones where the box's minimum is entered first, and where its maximum is; the fourth lane, which the node uses for something
    /// else, in neither.
    enters_low: [u32; 4],
    enters_high: [u32; 4],
    t_min: f32,
}

impl Slabs {
    /// `bounds` contains everything that will be tested.
    pub fn new(origin: [f64; 3], direction: [f64; 3], bounds: &Aabb, t_min: f32) -> Slabs {
        let largest = |values: &[f64]| values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let planes: [f64; 6] =
            std::array::from_fn(|i| f64::from(if i < 3 { bounds.min[i] } else { bounds.max[i - 3] }));
        let arithmetic = 2f64.powi(-48) * (largest(&planes) + largest(&origin));
        let mut slabs = Slabs {
            near_origin: [0.0; 4],
            far_origin: [0.0; 4],
            inverse: [0.0; 4],
            enters_low: [0; 4],
            enters_high: [0; 4],
            t_min,
        };
        for axis in 0..3 {
            let (o, d) = (origin[axis], direction[axis]);
            let pad = arithmetic.max(d.abs() * 2f64.powi(-146)).max(2f64.powi(-100));
            let (low, high) = (round_down(o - pad), round_up(o + pad));
            let flipped = d < 0.0;
            (slabs.enters_low[axis], slabs.enters_high[axis]) = if flipped { (0, u32::MAX) } else { (u32::MAX, 0) };
            (slabs.near_origin[axis], slabs.far_origin[axis]) = if flipped { (low, high) } else { (high, low) };
            let inverse = (1.0 / d) as f32;
            slabs.inverse[axis] = if d == 0.0 {
                f32::INFINITY
            } else if inverse.is_normal() {
                inverse
            } else {
                f32::NAN
            };
        }
        slabs
    }

    /// Entry distances of two boxes, and whether the ray meets them between `t_min` and `limit`.
    #[inline(always)]
    pub fn pair(&self, nodes: &[Node; 2], limit: f32) -> ([f32; 2], [bool; 2]) {
        #[cfg(target_arch = "x86_64")]
        {
            sse2::pair(self, nodes, limit)
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            self.pair_plain(nodes, limit)
        }
    }

    /// What [`Slabs::pair`] computes, bit for bit, on any machine.
    #[cfg(any(test, not(target_arch = "x86_64")))]
    pub fn pair_plain(&self, nodes: &[Node; 2], limit: f32) -> ([f32; 2], [bool; 2]) {
        let [a, b] = [self.one(&nodes[0], limit), self.one(&nodes[1], limit)];
        ([a.0, b.0], [a.1, b.1])
    }

    #[inline]
    pub fn one(&self, node: &Node, limit: f32) -> (f32, bool) {
        let (mut near, mut far) = (self.t_min, limit);
        for axis in 0..3 {
            let (enter, leave) = if self.enters_high[axis] != 0 {
                (node.max[axis], node.min[axis])
            } else {
                (node.min[axis], node.max[axis])
            };
            let t_enter = (enter - self.near_origin[axis]) * self.inverse[axis];
            let t_leave = (leave - self.far_origin[axis]) * self.inverse[axis];
            near = if t_enter > near { t_enter } else { near };
            far = if t_leave < far { t_leave } else { far };
        }
        (near, near <= widened(far))
    }
}

/// The largest distance that may still be meant by a computed `t`.
#[inline]
pub(super) fn widened(t: f32) -> f32 {
    t + t.abs() * WIDEN
}

/// Two boxes at once in SSE2 registers, which every x86-64 processor has.
#[cfg(target_arch = "x86_64")]
mod sse2 {
    use super::{Node, Slabs, WIDEN};
    use std::arch::x86_64::*;

    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn pair(slabs: &Slabs, nodes: &[Node; 2], limit: f32) -> ([f32; 2], [bool; 2]) {
        // SAFETY: SSE2 is part of the x86-64 baseline, so the processor has it; the function takes and returns plain values
        // and references and is unsafe to call for no other reason.
        unsafe { pair_sse2(slabs, nodes, limit) }
    }

    #[inline]
    #[target_feature(enable = "sse2")]
    fn pair_sse2(slabs: &Slabs, nodes: &[Node; 2], limit: f32) -> ([f32; 2], [bool; 2]) {
        let load = |v: [f32; 4]| _mm_set_ps(v[3], v[2], v[1], v[0]);
        let mask = |v: [u32; 4]| load(v.map(f32::from_bits));
        let (low, high) = (mask(slabs.enters_low), mask(slabs.enters_high));
        let (near_origin, far_origin, inverse) = (load(slabs.near_origin), load(slabs.far_origin), load(slabs.inverse));
        let distances = |node: &Node| {
            let [min, max]: [[f32; 4]; 2] = bytemuck::cast(*node);
            let (min, max) = (load(min), load(max));
            let enter = _mm_or_ps(_mm_and_ps(min, low), _mm_and_ps(max, high));
            let leave = _mm_or_ps(_mm_and_ps(max, low), _mm_and_ps(min, high));
            (_mm_mul_ps(_mm_sub_ps(enter, near_origin), inverse), _mm_mul_ps(_mm_sub_ps(leave, far_origin), inverse))
        };
        let (a, b) = (distances(&nodes[0]), distances(&nodes[1]));

        // Lanes: a.x b.x a.y b.y, then a.z b.z. A comparison with NaN keeps the second operand, which never is one.
        let enter = _mm_max_ps(_mm_unpacklo_ps(a.0, b.0), _mm_set1_ps(slabs.t_min));
        let near = _mm_max_ps(_mm_unpackhi_ps(a.0, b.0), _mm_max_ps(_mm_movehl_ps(enter, enter), enter));
        let leave = _mm_min_ps(_mm_unpacklo_ps(a.1, b.1), _mm_set1_ps(limit));
        let far = _mm_min_ps(_mm_unpackhi_ps(a.1, b.1), _mm_min_ps(_mm_movehl_ps(leave, leave), leave));
        let size = _mm_and_ps(far, _mm_set1_ps(f32::from_bits(0x7FFF_FFFF)));
        let widened = _mm_add_ps(far, _mm_mul_ps(size, _mm_set1_ps(WIDEN)));
        let hit = _mm_movemask_ps(_mm_cmple_ps(near, widened));
        ([_mm_cvtss_f32(near), _mm_cvtss_f32(_mm_shuffle_ps::<1>(near, near))], [hit & 1 != 0, hit & 2 != 0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::rays::Random;

    fn special(random: &mut Random) -> f32 {
        match random.below(8) {
            0 => 0.0,
            1 => -0.0,
            2 => 1.0,
            3 => 0.25 * random.below(8) as f32 - 1.0,
            4 => 1e30 * (random.unit() as f32 - 0.5),
            5 => 1e-30 * (random.unit() as f32 - 0.5),
            _ => 2.0 * random.unit() as f32 - 1.0,
        }
    }

    /// A box around points, some of them equal, so that many boxes are flat.
    fn some_box(random: &mut Random) -> Node {
        let points = [0; 2].map(|_| [0; 3].map(|_| special(random)));
        Node::leaf(Aabb::from_points(&points), random.bits() as u32, random.bits() as u32)
    }

    #[test]
    fn the_vector_form_gives_the_bits_of_the_plain_one() {
        let mut random = Random::new(1);
        for _ in 0..200_000 {
            let nodes = [some_box(&mut random), some_box(&mut random)];
            let [origin, direction] = [0; 2].map(|_| [0; 3].map(|_| f64::from(special(&mut random))));
            let slabs = Slabs::new(origin, direction, &nodes[0].bounds(), special(&mut random));
            let limit = [special(&mut random), 1e38, 2.0][random.below(3) as usize];
            let ((near, hit), (near_plain, hit_plain)) = (slabs.pair(&nodes, limit), slabs.pair_plain(&nodes, limit));
            assert_eq!(hit, hit_plain, "{slabs:?} {nodes:?} {limit}");
            for i in 0..2 {
                // Which zero a maximum of two zeros is depends on the order of the operands, and matters to no comparison.
                assert!(!hit[i] || near[i] == near_plain[i], "{slabs:?} {nodes:?} {limit}");
            }
        }
    }

    #[test]
    fn a_ray_aimed_at_a_point_of_a_box_meets_the_box() {
        let mut random = Random::new(2);
        for _ in 0..200_000 {
            let node = some_box(&mut random);
            let origin = [0; 3].map(|_| special(&mut random));
            let on = |lo: f32, hi: f32, random: &mut Random| {
                [lo, hi, lo + (hi - lo) * random.unit() as f32][random.below(3) as usize]
            };
            let target = [0, 1, 2].map(|a| on(node.min[a], node.max[a], &mut random));

            // The direction in f64 is exact up to 2⁻⁵³ of the coordinates, far less than the origin's pad.
            let direction = [0, 1, 2].map(|a| f64::from(target[a]) - f64::from(origin[a]));
            let bounds = node.bounds().grow(target);
            let slabs = Slabs::new(origin.map(f64::from), direction, &bounds, 0.0);
            assert!(slabs.one(&node, 1.0).1, "{origin:?} to {target:?} in {node:?}");
            assert!(slabs.pair(&[node, node], 1.0).1 == [true, true]);
        }
    }

    #[test]
    fn a_parallel_ray_on_a_face_meets_the_box_and_one_beside_it_does_not() {
        let node = Node::leaf(Aabb { min: [0.0, 0.0, 2.0], max: [1.0, 1.0, 3.0] }, 0, 1);
        for zero in [0.0, -0.0] {
            for (x, meets) in [(0.0, true), (1.0, true), (0.5, true), (-1e-3, false), (1.0 + 1e-6, false)] {
                let slabs = Slabs::new([x, 0.0, 0.0], [zero, zero, 1.0], &node.bounds(), 0.0);
                assert_eq!(slabs.one(&node, f32::MAX / 4.0).1, meets, "x = {x}, zero = {zero}");
            }
        }
    }
}
