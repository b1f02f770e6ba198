//! Spatial bins: every reference is chopped into each slab of space that it overlaps, and the planes between slabs compete.

use super::cost::Sah;
use super::lanes::{LaneBox, Lanes};
use super::options::Clip;
use super::prim_ref::PrimRef;
use crate::geom::Aabb;
use crate::geom::clip::{Planes, Polygon, Slabs};
use crate::scene::Mesh;

/// The planes of the three axes; `None` where the node is too thin to be cut.
pub(super) type PlanesOf = [Option<Planes>; 3];

/// Equidistant planes over a node's box.
pub(super) fn planes_of(bounds: &Aabb, bins: usize) -> PlanesOf {
    [0, 1, 2].map(|axis| Planes::new(bounds.min[axis], bounds.max[axis], bins))
}

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
    pub fn empty() -> Self {
        SpatialBins { boxes: [[LaneBox::EMPTY; 3]; CAP], enter: [[0; 3]; CAP], leave: [[0; 3]; CAP] }
    }

    pub fn fill(&mut self, planes: &PlanesOf, refs: &[PrimRef], mesh: &Mesh, clip: Clip) {
        let mut slabs = Slabs::<CAP>::default();
        for r in refs {
            let (lanes, mut polygon) = (r.lanes(), None);
            for axis in 0..3 {
                let Some(planes) = &planes[axis] else { continue };
                let (first, last) = planes.span(r.min[axis], r.max[axis]);
                self.enter[first][axis] += 1;
                self.leave[last][axis] += 1;
                // Most references fall wholly into one slab.
                if first == last {
                    self.boxes[first][axis] = self.boxes[first][axis].union(lanes);
                    continue;
                }
                let bounds = r.bounds();
                match clip {
                    Clip::Box => {
                        for s in first..=last {
                            self.put(s, axis, &planes.cut_box(&bounds, axis, s));
                        }
                    }
                    Clip::Exact => {
                        let polygon: &Polygon =
                            polygon.get_or_insert_with(|| Polygon::inside(&mesh.corners(r.prim as usize), &bounds));
                        polygon.chop(axis, planes, (first, last), &bounds, &mut slabs);
                        for (s, b) in (first..=last).zip(slabs.boxes()) {
                            self.put(s, axis, b);
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn put(&mut self, slab: usize, axis: usize, b: &Aabb) {
        let b = LaneBox { min: Lanes::of_point(b.min), max: Lanes::of_point(b.max) };
        self.boxes[slab][axis] = self.boxes[slab][axis].union(b);
    }

    #[must_use]
    pub fn merge(mut self, other: &Self) -> Self {
        for slab in 0..CAP {
            for axis in 0..3 {
                self.boxes[slab][axis] = self.boxes[slab][axis].union(other.boxes[slab][axis]);
                self.enter[slab][axis] += other.enter[slab][axis];
                self.leave[slab][axis] += other.leave[slab][axis];
            }
        }
        self
    }

    /// The plane of least weight that makes at most `slack` duplicates of `live` references; of equal ones the first. `None` where no
    /// plane has references on both sides and a finite weight.
    pub fn best_plane(&self, planes: &PlanesOf, live: usize, slack: usize, scale: f32) -> Option<SpatialPlane> {
        let mut best: Option<SpatialPlane> = None;
        let mut right = [(LaneBox::EMPTY, 0.0, 0u32); CAP];
        for (axis, planes) in planes.iter().enumerate() {
            let Some(planes) = planes else { continue };
            let (mut side, mut count) = (LaneBox::EMPTY, 0);
            for slab in (1..planes.count()).rev() {
                side = side.union(self.boxes[slab][axis]);
                count += self.leave[slab][axis];
                right[slab] = (side, side.scaled_half_area(scale), count);
            }
            let (mut side, mut count) = (LaneBox::EMPTY, 0);
            for slab in 1..planes.count() {
                side = side.union(self.boxes[slab - 1][axis]);
                count += self.enter[slab - 1][axis];
                let (right_side, right_area, right_count) = right[slab];
                let weight = Sah::weight(side.scaled_half_area(scale), count as f32, right_area, right_count as f32);
                let duplicates = (count as usize + right_count as usize).saturating_sub(live);
                let allowed = count > 0 && right_count > 0 && duplicates <= slack;
                if allowed && best.is_none_or(|b| weight < b.weight) && weight < f32::INFINITY {
                    best = Some(SpatialPlane {
                        axis,
                        position: planes.position(slab),
                        weight,
                        bounds: [side.aabb(), right_side.aabb()],
                        counts: [count as usize, right_count as usize],
                    });
                }
            }
        }
        best
    }
}
