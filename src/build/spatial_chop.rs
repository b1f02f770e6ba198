//! Chopping a reference into slabs, to price planes by.
//!
//! These boxes are estimates, a rounding error too small or too large: they choose a plane and are thrown away. Boxes that
//! survive are made by [`crate::geom::clip`], which rounds outward.

use super::lanes::{LaneBox, Lanes};
use crate::geom::Point;

/// A triangle's corners, loaded once for all axes.
#[derive(Clone, Copy)]
pub(super) struct Chopper {
    corners: [Lanes; 3],
}

/// The equidistant planes of one axis: plane `i` lies at `low + i·step`, slab `i` between the planes `i` and `i + 1`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub low: f32,
    pub step: f32,
}

impl Grid {
    #[inline(always)]
    pub fn plane(&self, i: usize) -> f32 {
        self.low + self.step * i as f32
    }
}

impl Chopper {
    pub fn new(corners: &[Point; 3]) -> Chopper {
        Chopper { corners: corners.map(Lanes::of_point) }
    }

    /// Hand `put` a box for each of the slabs `first ..= last`, `first < last`, which the reference's box `within` spans.
    ///
    /// A triangle meets a plane in a segment from its longest edge (along the axis) to one of the other two. The part in a slab is bounded by
    /// the segments of its two planes and by the middle corner if that lies between them.
    #[inline(always)]
    pub fn chop<const AXIS: usize>(
        &self,
        grid: &Grid,
        first: usize,
        last: usize,
        within: LaneBox,
        mut put: impl FnMut(usize, LaneBox),
    ) {
        let [low, middle, high] = self.sorted::<AXIS>();
        let at = |v: Lanes| v.0[AXIS];
        let (long, lower, upper) = (high.minus(low), middle.minus(low), high.minus(middle));
        let (per_long, per_lower, per_upper) = (1.0 / at(long), 1.0 / at(lower), 1.0 / at(upper));
        let section = |plane: f32| {
            let a = low.plus(long.times(Lanes::splat((plane - at(low)) * per_long)));
            let b = if plane < at(middle) {
                low.plus(lower.times(Lanes::splat((plane - at(low)) * per_lower)))
            } else {
                middle.plus(upper.times(Lanes::splat((plane - at(middle)) * per_upper)))
            };
            LaneBox { min: a.min(b), max: a.max(b) }
        };
        let clamp = |v: Lanes| v.max(within.min).min(within.max);

        let mut before = at(within.min);
        let mut lower_end = if before <= at(low) { LaneBox { min: low, max: low } } else { section(before) };
        for slab in first..=last {
            let (after, upper_end) = if slab < last {
                let plane = grid.plane(slab + 1);
                (plane, section(plane))
            } else {
                let end = at(within.max);
                (end, if end >= at(high) { LaneBox { min: high, max: high } } else { section(end) })
            };
            let mut piece = lower_end.union(upper_end);
            if before <= at(middle) && at(middle) <= after {
                piece = piece.grow(middle);
            }
            put(slab, LaneBox { min: clamp(piece.min), max: clamp(piece.max) });
            (before, lower_end) = (after, upper_end);
        }
    }

    /// Corners in ascending order along an axis.
    #[inline(always)]
    fn sorted<const AXIS: usize>(&self) -> [Lanes; 3] {
        let order = |a: Lanes, b: Lanes| if a.0[AXIS] <= b.0[AXIS] { (a, b) } else { (b, a) };
        let [a, b, c] = self.corners;
        let (a, b) = order(a, b);
        let (b, c) = order(b, c);
        let (a, b) = order(a, b);
        [a, b, c]
    }
}
