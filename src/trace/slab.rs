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
//! For all but the tiniest coordinates these moves vanish in the rounding of the origin itself.

use crate::geom::{Aabb, round_down, round_up};
use crate::tree::Node;

/// `8u`: how much of itself the exit distance is widened by.
const WIDEN: f32 = 8.0 * (f32::EPSILON / 2.0);

/// A ray made ready for box tests.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slabs {
    /// Per axis the origin that makes the entry distance smallest, and the one that makes the exit distance largest.
    near_origin: [f32; 3],
    far_origin: [f32; 3],
    /// `1 / direction`. Infinite where the ray is parallel to the slab: then an origin inside gives −∞ and +∞, one on a face gives
    /// NaN, which the comparisons below ignore. NaN where the reciprocal is not a normal number: the axis is not used.
    inverse: [f32; 3],
    /// Whether the box's maximum is entered first.
    flipped: [bool; 3],
    t_min: f32,
}

impl Slabs {
    /// `bounds` contains everything that will be tested.
    pub fn new(origin: [f64; 3], direction: [f64; 3], bounds: &Aabb, t_min: f32) -> Slabs {
        let largest = |values: &[f64]| values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let planes: [f64; 6] =
            std::array::from_fn(|i| f64::from(if i < 3 { bounds.min[i] } else { bounds.max[i - 3] }));
        let arithmetic = 2f64.powi(-48) * (largest(&planes) + largest(&origin));
        let mut slabs =
            Slabs { near_origin: [0.0; 3], far_origin: [0.0; 3], inverse: [0.0; 3], flipped: [false; 3], t_min };
        for axis in 0..3 {
            let (o, d) = (origin[axis], direction[axis]);
            let pad = arithmetic.max(d.abs() * 2f64.powi(-146)).max(2f64.powi(-100));
            let (low, high) = (round_down(o - pad), round_up(o + pad));
            let flipped = d < 0.0;
            slabs.flipped[axis] = flipped;
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
    #[inline]
    pub fn pair(&self, nodes: &[Node; 2], limit: f32) -> ([f32; 2], [bool; 2]) {
        let [a, b] = [self.one(&nodes[0], limit), self.one(&nodes[1], limit)];
        ([a.0, b.0], [a.1, b.1])
    }

    #[inline]
    pub fn one(&self, node: &Node, limit: f32) -> (f32, bool) {
        let (mut near, mut far) = (self.t_min, limit);
        for axis in 0..3 {
            let (enter, leave) =
                if self.flipped[axis] { (node.max[axis], node.min[axis]) } else { (node.min[axis], node.max[axis]) };
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
