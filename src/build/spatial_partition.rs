//! Carrying out a spatial split: straddling references are cut in two or, where that is cheaper, put wholly to one side.

use super::cost::Sah;
use super::lanes::LaneBox;
use super::options::Clip;
use super::prim_ref::PrimRef;
use super::spatial_bins::SpatialPlane;
use super::strategy::Child;
use crate::geom::Aabb;
use crate::geom::clip::{Polygon, split_box};
use crate::scene::Mesh;

/// What the cutter needs beside the plane.
#[derive(Clone, Copy)]
pub(super) struct Cutter<'a> {
    pub mesh: &'a Mesh,
    pub clip: Clip,
    pub unsplit: bool,
    /// The factor of [`super::area_scale`].
    pub scale: f32,
}

/// Where a straddling reference goes.
enum Fate {
    Left,
    Right,
    Both,
}

impl Cutter<'_> {
    /// Partition the references `slots[..live]`. On return the left references stand at the front and the right ones are returned, each side in
    /// the old order with the straddling ones last. The free slots suffice if those did that [`SpatialPlane::counts`] ask for.
    pub fn partition(&self, plane: &SpatialPlane, slots: &mut [PrimRef], live: usize) -> (Side, Side, Vec<PrimRef>) {
        let (axis, at) = (plane.axis, plane.position);
        let mut right_refs = Vec::with_capacity(plane.counts[1]);
        let mut straddling = Vec::with_capacity((plane.counts[0] + plane.counts[1]).saturating_sub(live));

        // Move what lies on one side; the same comparisons as `Planes::span` makes.
        let (mut left, mut right) = (Side::EMPTY, Side::EMPTY);
        for i in 0..live {
            let r = slots[i];
            if r.min[axis] >= at {
                right.add(&r);
                right_refs.push(r);
            } else if r.max[axis] <= at {
                left.add(&r);
                slots[left.live - 1] = r;
            } else {
                straddling.push(r);
            }
        }

        let mut put_left = |r: PrimRef| {
            left.add(&r);
            slots[left.live - 1] = r;
        };
        let mut put_right = |r: PrimRef| {
            right.add(&r);
            right_refs.push(r);
        };
        let mut balance = Balance::new(plane, self.scale);
        for r in straddling {
            let fate = if self.unsplit { balance.choose(&r.bounds()) } else { Fate::Both };
            match fate {
                Fate::Left => put_left(r),
                Fate::Right => put_right(r),
                Fate::Both => {
                    let (below, above) = self.cut(&r, axis, at);
                    let part = |bounds: &Aabb| PrimRef { min: bounds.min, max: bounds.max, ..r };
                    // The conservative answer where rounding left a part without a point: nobody is lost.
                    match (below.is_empty(), above.is_empty()) {
                        (false, false) => {
                            put_left(part(&below));
                            put_right(part(&above));
                        }
                        (false, true) => put_left(part(&below)),
                        (true, false) => put_right(part(&above)),
                        (true, true) => put_left(r),
                    }
                }
            }
        }
        (left, right, right_refs)
    }

    fn cut(&self, r: &PrimRef, axis: usize, at: f32) -> (Aabb, Aabb) {
        let bounds = r.bounds();
        match self.clip {
            Clip::Box => split_box(&bounds, axis, at),
            Clip::Exact => Polygon::inside(&self.mesh.corners(r.prim as usize), &bounds).split(axis, at, &bounds),
        }
    }
}

/// One side while it fills.
#[derive(Clone, Copy)]
pub(super) struct Side {
    bounds: LaneBox,
    centroids: LaneBox,
    pub live: usize,
}

impl Side {
    const EMPTY: Side = Side { bounds: LaneBox::EMPTY, centroids: LaneBox::EMPTY, live: 0 };

    #[inline(always)]
    fn add(&mut self, r: &PrimRef) {
        let lanes = r.lanes();
        self.bounds = self.bounds.union(lanes);
        self.centroids = self.centroids.grow(lanes.min.plus(lanes.max));
        self.live += 1;
    }

    pub fn child(&self, slots: usize) -> Child {
        Child { bounds: self.bounds.aabb(), centroids: self.centroids.aabb(), live: self.live, slots }
    }
}

/// Reference unsplitting (Stich et al., section 4.4): three costs for each straddling reference, with the sides as they stand after the
/// references before it.
struct Balance {
    bounds: [Aabb; 2],
    areas: [f32; 2],
    counts: [usize; 2],
    scale: f32,
}

impl Balance {
    fn new(plane: &SpatialPlane, scale: f32) -> Balance {
        let areas = plane.bounds.map(|b| super::scaled_half_area(&b, scale));
        Balance { bounds: plane.bounds, areas, counts: plane.counts, scale }
    }

    fn choose(&mut self, reference: &Aabb) -> Fate {
        let grown = self.bounds.map(|b| b.union(*reference));
        let grown_areas = grown.map(|b| super::scaled_half_area(&b, self.scale));
        let [left, right] = self.counts.map(|c| c as f32);
        let both = Sah::weight(self.areas[0], left, self.areas[1], right);
        let only_left = Sah::weight(grown_areas[0], left, self.areas[1], right - 1.0);
        let only_right = Sah::weight(self.areas[0], left - 1.0, grown_areas[1], right);

        // Neither side may lose its last reference: a split that separates nothing is none.
        let left_allowed = self.counts[1] > 1 && only_left < both;
        let right_allowed = self.counts[0] > 1 && only_right < both;
        let side = match (left_allowed, right_allowed) {
            (false, false) => return Fate::Both,
            (true, true) => usize::from(only_right < only_left),
            (true, false) => 0,
            (false, true) => 1,
        };
        self.bounds[side] = grown[side];
        self.areas[side] = grown_areas[side];
        self.counts[1 - side] -= 1;
        if side == 0 { Fate::Left } else { Fate::Right }
    }
}
