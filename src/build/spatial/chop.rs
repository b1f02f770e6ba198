//! Chopping a reference into slabs, to price planes by.
//!
//! These boxes are estimates, a rounding error too small or too large: they choose a plane and are thrown away. Boxes that
//! survive are made by [`crate::geom::clip`], which rounds outward.

use crate::scene::Mesh;
use crate::simd::{LaneBox, Lanes};

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
    pub per_step: f32,
}

impl Grid {
    #[inline(always)]
    pub fn plane(&self, i: usize) -> f32 {
        self.low + self.step * i as f32
    }
}

impl Chopper {
    #[inline]
    pub fn new(mesh: &Mesh, triangle: u32) -> Chopper {
        let [a, b, c] = mesh.triangles[triangle as usize];
        let corner = |i: u32| Lanes::of_point(mesh.positions[i as usize]);
        Chopper { corners: [corner(a), corner(b), corner(c)] }
    }

    /// Hand `put` a box for each of the slabs `first ..= last`, `first < last`, which the reference's box `within` spans.
    ///
    /// A triangle meets a plane in a segment from its longest edge (along the axis) to one of the other two. The part in a slab is bounded by
    /// the segments of its two planes and by the middle corner if that lies between them. Choices are made by index, since no
    /// branch predictor knows triangles.
    #[inline(always)]
    pub fn chop<const AXIS: usize>(
        &self,
        grid: &Grid,
        (first, last): (usize, usize),
        within: LaneBox,
        mut put: impl FnMut(usize, LaneBox),
    ) {
        let at = |v: Lanes| v.0[AXIS];
        let [low, middle, high] = self.sorted::<AXIS>();
        let long = Edge::new::<AXIS>(low, high);
        let short = [Edge::new::<AXIS>(low, middle), Edge::new::<AXIS>(middle, high)];
        let section = |plane: f32| {
            let a = long.at::<AXIS>(plane);
            let b = short[usize::from(plane >= at(middle))].at::<AXIS>(plane);
            LaneBox { min: a.min(b), max: a.max(b) }
        };
        let clamp = |b: LaneBox| LaneBox {
            min: b.min.max(within.min).min(within.max),
            max: b.max.max(within.min).min(within.max),
        };
        let point = |p: Lanes| LaneBox { min: p, max: p };

        let (start, end) = (at(within.min), at(within.max));
        let mut before = if start <= at(low) { point(low) } else { section(start) };
        for slab in first..last {
            let after = section(grid.plane(slab + 1));
            put(slab, clamp(before.union(after)));
            before = after;
        }
        let after = if end >= at(high) { point(high) } else { section(end) };
        put(last, clamp(before.union(after)));

        if start <= at(middle) && at(middle) <= end {
            let slab = ((at(middle) - grid.low) * grid.per_step) as usize;
            put(slab.clamp(first, last), clamp(point(middle)));
        }
    }

    /// Corners in ascending order along an axis.
    #[inline(always)]
    fn sorted<const AXIS: usize>(&self) -> [Lanes; 3] {
        let [a, b, c] = [0, 1, 2].map(|i: usize| self.corners[i].0[AXIS]);
        // Ties: the first of the lowest and the last of the highest, so that the two differ.
        let low = if a <= b {
            if a <= c { 0 } else { 2 }
        } else if b <= c {
            1
        } else {
            2
        };
        let high = if c >= b {
            if c >= a { 2 } else { 0 }
        } else if b >= a {
            1
        } else {
            0
        };
        [self.corners[low], self.corners[(3 - low - high) % 3], self.corners[high]]
    }
}

/// An edge, ready to be met with planes.
#[derive(Clone, Copy)]
struct Edge {
    start: Lanes,
    direction: Lanes,
    /// 1 over the edge's extent along the axis.
    inverse: f32,
}

impl Edge {
    #[inline(always)]
    fn new<const AXIS: usize>(start: Lanes, end: Lanes) -> Edge {
        let direction = end.minus(start);
        Edge { start, direction, inverse: 1.0 / direction.0[AXIS] }
    }

    #[inline(always)]
    fn at<const AXIS: usize>(&self, plane: f32) -> Lanes {
        self.start.plus(self.direction.times(Lanes::splat((plane - self.start.0[AXIS]) * self.inverse)))
    }
}
