//! Spatial bins: every reference is chopped into each slab of space that it overlaps, and the planes between slabs compete.

use super::chop::{Chopper, Grid};
use crate::build::cost::Sah;
use crate::build::prim_ref::PrimRef;
use crate::build::recipe::options::Clip;
use crate::geom::Aabb;
use crate::scene::Mesh;
use crate::simd::{LaneBox, Lanes};

/// Equidistant planes over a node's box, on all three axes, and the way from a coordinate to a slab.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grids {
    axes: [Grid; 3],
    bins: usize,
    origin: Lanes,
    /// Slabs per unit; 0 on an axis that is too thin to be cut.
    scale: Lanes,
    last: f32,
}

/// An overlap of less than this share of a slab is none: coordinates on a plane, a rounding error beside it, stay on their side.
const TOUCH: f32 = 1e-4;

/// Adding 1.5·2²³ to a small float rounds it to an integer, which then stands in the low bits.
const ROUND: f32 = 12_582_912.0;

impl Grids {
    pub fn new(bounds: &Aabb, bins: usize) -> Grids {
        let extent = bounds.extent();
        let axes = [0, 1, 2].map(|a| Grid {
            low: bounds.min[a],
            step: extent[a] / bins as f32,
            per_step: bins as f32 / extent[a],
        });
        let scale = [0, 1, 2].map(|a| {
            // Planes must stand several roundings apart.
            let coarse = bounds.min[a].abs().max(bounds.max[a].abs()) * (16.0 * f32::EPSILON);
            let scale = bins as f32 / extent[a];
            if axes[a].step > coarse && extent[a].is_finite() && scale.is_finite() { scale } else { 0.0 }
        });
        Grids {
            axes,
            bins,
            origin: Lanes::of_point(bounds.min),
            scale: Lanes::of_point(scale),
            last: (bins - 1) as f32,
        }
    }

    /// First and last slab on each axis; `last` may be one less than `first` where a box has no thickness.
    #[inline(always)]
    fn span(&self, b: &LaneBox) -> ([u32; 3], [u32; 3]) {
        let slab = |v: Lanes, touch: f32| {
            let position = v.minus(self.origin).times(self.scale).plus(Lanes::splat(touch - 0.5));
            let [x, y, z, _] = position.max(Lanes::splat(0.0)).min(Lanes::splat(self.last)).plus(Lanes::splat(ROUND)).0;
            [x.to_bits() & 0xff, y.to_bits() & 0xff, z.to_bits() & 0xff]
        };
        (slab(b.min, TOUCH), slab(b.max, -TOUCH))
    }

    /// The axes that are thick enough to be cut.
    pub fn cuts(&self) -> [bool; 3] {
        [0, 1, 2].map(|axis| self.scale.0[axis] > 0.0)
    }
}

/// From so many references a slab on, two sets of slabs are filled in turn; below, that costs more than it saves.
const TWO_SETS: usize = 8;

/// Slabs of the three axes, at most `CAP` an axis. The order in which references are put in, or bins merged, makes no difference.
#[derive(Clone)]
pub(super) struct SpatialBins<const CAP: usize> {
    boxes: [[LaneBox; 3]; CAP],
    /// References whose first slab this is.
    enter: [[u32; 3]; CAP],
    /// References whose last slab this is.
    leave: [[u32; 3]; CAP],
}

/// A spatial split that is not yet carried out.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpatialPlane {
    pub axis: usize,
    pub position: f32,
    /// [`Sah::weight`] with areas scaled, every straddling reference counted on both sides.
    pub weight: f32,
    pub bounds: [Aabb; 2],
    pub counts: [usize; 2],
}

impl<const CAP: usize> SpatialBins<CAP> {
    pub const EMPTY: Self =
        SpatialBins { boxes: [[LaneBox::EMPTY; 3]; CAP], enter: [[0; 3]; CAP], leave: [[0; 3]; CAP] };

    pub fn fill<'r>(
        &mut self,
        grids: &Grids,
        axes: [bool; 3],
        refs: impl ExactSizeIterator<Item = &'r PrimRef>,
        mesh: &Mesh,
        clip: Clip,
    ) {
        // As object bins do, and for the same reason, many references fill two sets in turn.
        if refs.len() < TWO_SETS * CAP {
            refs.for_each(|r| self.put(grids, axes, r, mesh, clip));
            return;
        }
        let mut other = Self::EMPTY;
        for (i, r) in refs.enumerate() {
            let set = if i % 2 == 0 { &mut *self } else { &mut other };
            set.put(grids, axes, r, mesh, clip);
        }
        self.merge(&other);
    }

    #[inline(always)]
    fn put(&mut self, grids: &Grids, axes: [bool; 3], r: &PrimRef, mesh: &Mesh, clip: Clip) {
        let bounds = r.lanes();
        let (first, last) = grids.span(&bounds);
        let mut chopper = None;
        if axes[0] {
            self.fill_axis::<0>(grids, r, bounds, first[0], last[0], mesh, clip, &mut chopper);
        }
        if axes[1] {
            self.fill_axis::<1>(grids, r, bounds, first[1], last[1], mesh, clip, &mut chopper);
        }
        if axes[2] {
            self.fill_axis::<2>(grids, r, bounds, first[2], last[2], mesh, clip, &mut chopper);
        }
    }

    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "one loop body, three times")]
    fn fill_axis<const AXIS: usize>(
        &mut self,
        grids: &Grids,
        r: &PrimRef,
        bounds: LaneBox,
        first: u32,
        last: u32,
        mesh: &Mesh,
        clip: Clip,
        chopper: &mut Option<Chopper>,
    ) {
        let (first, last) = (first as usize % CAP, last.max(first) as usize % CAP);
        self.enter[first][AXIS] += 1;
        self.leave[last][AXIS] += 1;
        let boxes = &mut self.boxes;
        // Most references fall wholly into one slab.
        if first == last {
            boxes[first][AXIS] = boxes[first][AXIS].union(bounds);
            return;
        }
        let grid = &grids.axes[AXIS];
        match clip {
            Clip::Box => {
                for (slab, at) in boxes.iter_mut().enumerate().take(last + 1).skip(first) {
                    let mut piece = bounds;
                    if slab > first {
                        piece.min.0[AXIS] = grid.plane(slab);
                    }
                    if slab < last {
                        piece.max.0[AXIS] = grid.plane(slab + 1);
                    }
                    at[AXIS] = at[AXIS].union(piece);
                }
            }
            Clip::Exact => {
                let chopper = chopper.get_or_insert_with(|| Chopper::new(mesh, r.prim));
                chopper.chop::<AXIS>(grid, (first, last), bounds, |slab, piece| {
                    let slab = slab % CAP;
                    boxes[slab][AXIS] = boxes[slab][AXIS].union(piece);
                });
            }
        }
    }

    pub fn merge(&mut self, other: &Self) {
        for slab in 0..CAP {
            for axis in 0..3 {
                self.boxes[slab][axis] = self.boxes[slab][axis].union(other.boxes[slab][axis]);
                self.enter[slab][axis] += other.enter[slab][axis];
                self.leave[slab][axis] += other.leave[slab][axis];
            }
        }
    }

    /// The plane across `axis` of least weight that makes at most `slack` duplicates of `live` references; of equal ones the first. `None`
    /// where no plane has references on both sides and a finite weight.
    pub fn best_plane(
        &self,
        grids: &Grids,
        axis: usize,
        live: usize,
        slack: usize,
        scale: f32,
    ) -> Option<SpatialPlane> {
        let mut right = [(LaneBox::EMPTY, 0.0, 0u32); CAP];
        let (mut side, mut count) = (LaneBox::EMPTY, 0);
        for slab in (1..grids.bins).rev() {
            side = side.union(self.boxes[slab][axis]);
            count += self.leave[slab][axis];
            right[slab] = (side, side.scaled_half_area(scale), count);
        }
        let mut best: Option<SpatialPlane> = None;
        let (mut side, mut count) = (LaneBox::EMPTY, 0);
        for (slab, &(right_side, right_area, right_count)) in right.iter().enumerate().take(grids.bins).skip(1) {
            side = side.union(self.boxes[slab - 1][axis]);
            count += self.enter[slab - 1][axis];
            let weight = Sah::weight(side.scaled_half_area(scale), count as f32, right_area, right_count as f32);
            let duplicates = (count as usize + right_count as usize).saturating_sub(live);
            let allowed = count > 0 && right_count > 0 && duplicates <= slack;
            if allowed && best.is_none_or(|b| weight < b.weight) && weight < f32::INFINITY {
                best = Some(SpatialPlane {
                    axis,
                    position: grids.axes[axis].plane(slab),
                    weight,
                    bounds: [side.aabb(), right_side.aabb()],
                    counts: [count as usize, right_count as usize],
                });
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::prim_ref::PrimRefs;
    use crate::exec::Executor;

    #[test]
    fn sets_filled_in_turn_hold_what_one_holds() {
        for count in [8 * TWO_SETS - 1, 8 * TWO_SETS, 8 * TWO_SETS + 3] {
            let corner = |i: usize| [i * 7919 % 101, i * 104_729 % 37, i % 5].map(|v| v as f32);
            let positions: Vec<_> = (0..3 * count).map(corner).collect();
            let triangles: Vec<_> = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            let mesh = Mesh { positions, triangles, ..Mesh::default() };
            let refs = PrimRefs::of_mesh(&mesh, 0, &Executor::sequential());
            let grids = Grids::new(&refs.bounds, 8);
            let (mut in_turn, mut one_by_one) = (SpatialBins::<8>::EMPTY, SpatialBins::<8>::EMPTY);
            in_turn.fill(&grids, [true; 3], refs.refs.iter(), &mesh, Clip::Exact);
            refs.refs.iter().for_each(|r| one_by_one.put(&grids, [true; 3], r, &mesh, Clip::Exact));
            let corners = |bins: &SpatialBins<8>| bins.boxes.map(|slab| slab.map(LaneBox::aabb));
            assert_eq!(corners(&in_turn), corners(&one_by_one), "{count}");
            assert_eq!((in_turn.enter, in_turn.leave), (one_by_one.enter, one_by_one.leave), "{count}");
        }
    }
}
