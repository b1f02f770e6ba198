//! The surface area heuristic, and nothing else knows it.
//!
//! SAH = Σ_inner C_T·A(n)/A(root) + Σ_leaf C_I·N(n)·A(n)/A(root) (Goldsmith and Salmon, "Automatic Creation of Object
//! Hierarchies for Ray Tracing", 1987; MacDonald and Booth, "Heuristics for Ray Tracing Using Space Subdivision",
//! 1990). A top-down builder compares, at one node, a leaf `C_I·N` with a split `C_T + C_I·(A_L·N_L + A_R·N_R)/A`. What
//! differs between two splits of the same node is only `A_L·N_L + A_R·N_R`, here called the split's *weight*.

use crate::simd::Lanes;

/// The two constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sah {
    /// C_T: cost of an inner node.
    pub traversal: f32,
    /// C_I: cost of a triangle test.
    pub intersection: f32,
}

impl Sah {
    /// `A_L·N_L + A_R·N_R`: the less, the better the split. Areas may carry any common factor.
    #[inline(always)]
    pub fn weight(left_area: f32, left_count: f32, right_area: f32, right_count: f32) -> f32 {
        left_area * left_count + right_area * right_count
    }

    /// One side's `A·N` on four planes at once. Left and right added up give [`Sah::weight`], to the bit.
    #[inline(always)]
    pub(super) fn side_weights(areas: Lanes, counts: Lanes) -> Lanes {
        areas.times(counts)
    }

    /// Whether a leaf of `count` references is no dearer than a split of the given weight, in a node of the given area.
    #[inline]
    pub fn prefers_leaf(&self, count: usize, weight: f32, area: f32) -> bool {
        self.intersection * count as f32 * area <= self.traversal * area + self.intersection * weight
    }
}

impl Sah {
    /// Whether a leaf of `count` references is no dearer than any split at all: one node costs as much as they do.
    #[inline]
    pub(super) fn needs_no_split(&self, count: usize) -> bool {
        self.intersection * count as f32 <= self.traversal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_far_triangles_are_split_and_two_equal_ones_are_not() {
        let sah = Sah { traversal: 1.2, intersection: 1.0 };
        assert!(!sah.prefers_leaf(2, Sah::weight(0.01, 1.0, 0.01, 1.0), 1.0));
        assert!(sah.prefers_leaf(2, Sah::weight(1.0, 1.0, 1.0, 1.0), 1.0));
        assert!(sah.prefers_leaf(2, Sah::weight(0.4, 1.0, 0.4, 1.0), 1.0), "a tie is a leaf: 2 = 1.2 + 0.8");
    }
}
