//! Carrying out a spatial split: straddling references are cut in two or, where that is cheaper, put wholly to one side.

use super::bins::SpatialPlane;
use crate::build::binned::scaled_half_area;
use crate::build::cost::Sah;
use crate::build::lanes::LaneBox;
use crate::build::prim_ref::PrimRef;
use crate::build::recipe::options::Clip;
use crate::build::top_down::strategy::Child;
use crate::geom::Aabb;
use crate::geom::clip;
use crate::scene::Mesh;

/// What the cutter needs beside the plane.
#[derive(Clone, Copy)]
pub(super) struct Cutter<'a> {
    pub mesh: &'a Mesh,
    pub clip: Clip,
    pub unsplit: bool,
    /// The factor of [`crate::build::binned::area_scale`].
    pub scale: f32,
}

/// Where a straddling reference goes.
enum Fate {
    Left,
    Right,
    Both,
}

impl Cutter<'_> {
    /// Partition the references `slots[..live]` into those left of the plane, at the front of the slots, and those right of it, returned; both
    /// in the old order with the straddling ones last. Together they are no more than there are slots.
    ///
    /// `None` if the plane does not separate anything; the same references then stand in another order, to which no split found
    /// before applies.
    pub fn partition(&self, plane: &SpatialPlane, slots: &mut [PrimRef], live: usize) -> Option<Parts> {
        let (axis, at) = (plane.axis, plane.position);
        let mut parts =
            Parts { left: Side::EMPTY, right: Side::EMPTY, right_refs: Vec::with_capacity(plane.counts[1]) };
        let mut straddling = Vec::with_capacity((plane.counts[0] + plane.counts[1]).saturating_sub(live));

        // Move what lies on one side. The bins only estimated who straddles; this is exact.
        for i in 0..live {
            let r = slots[i];
            if r.min[axis] >= at {
                parts.put_right(r);
            } else if r.max[axis] <= at {
                parts.put_left(r, slots);
            } else {
                straddling.push(r);
            }
        }

        let mut spare = slots.len() - live;
        let counts = [parts.left.live + straddling.len(), parts.right.live + straddling.len()];
        let mut balance = Balance::new(plane, counts, self.scale);
        for r in straddling {
            match balance.choose(&r.bounds(), self.unsplit, spare > 0) {
                Fate::Left => parts.put_left(r, slots),
                Fate::Right => parts.put_right(r),
                Fate::Both => {
                    let (below, above) = self.cut(&r, axis, at);
                    let part = |bounds: &Aabb| PrimRef { min: bounds.min, max: bounds.max, ..r };
                    // Where the triangle misses one side of its box, the reference stays as it is: one that is not divided must not change,
                    // or the object split found before would no longer fit it.
                    match (below.is_empty(), above.is_empty()) {
                        (false, false) => {
                            parts.put_left(part(&below), slots);
                            parts.put_right(part(&above));
                            spare -= 1;
                        }
                        (true, false) => parts.put_right(r),
                        (_, true) => parts.put_left(r, slots),
                    }
                }
            }
        }

        if parts.left.live == 0 || parts.right.live == 0 {
            slots[parts.left.live..][..parts.right.live].copy_from_slice(&parts.right_refs);
            return None;
        }
        Some(parts)
    }

    fn cut(&self, r: &PrimRef, axis: usize, at: f32) -> (Aabb, Aabb) {
        let bounds = r.bounds();
        match self.clip {
            Clip::Box => clip::split_box(&bounds, axis, at),
            Clip::Exact => clip::split(&self.mesh.corners(r.prim as usize), axis, at, &bounds),
        }
    }
}

/// Both sides of a split while they fill.
pub(super) struct Parts {
    pub left: Side,
    pub right: Side,
    pub right_refs: Vec<PrimRef>,
}

impl Parts {
    /// Never overtakes the reading of the slots: at any time fewer references have been put than read, or copies than there are spare slots.
    #[inline(always)]
    fn put_left(&mut self, r: PrimRef, slots: &mut [PrimRef]) {
        slots[self.left.live] = r;
        self.left.add(&r);
    }

    #[inline(always)]
    fn put_right(&mut self, r: PrimRef) {
        self.right_refs.push(r);
        self.right.add(&r);
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
    /// `counts`: references on each side, every straddling one on both.
    fn new(plane: &SpatialPlane, counts: [usize; 2], scale: f32) -> Balance {
        Balance { bounds: plane.bounds, areas: plane.bounds.map(|b| scaled_half_area(&b, scale)), counts, scale }
    }

    /// `unsplit`: whether a reference may go to one side although it could be cut; `spare`: whether it may be cut.
    fn choose(&mut self, reference: &Aabb, unsplit: bool, spare: bool) -> Fate {
        if spare && !unsplit {
            return Fate::Both;
        }
        let grown = self.bounds.map(|b| b.union(*reference));
        let grown_areas = grown.map(|b| scaled_half_area(&b, self.scale));
        let [left, right] = self.counts.map(|c| c as f32);
        let only_left = Sah::weight(grown_areas[0], left, self.areas[1], right - 1.0);
        let only_right = Sah::weight(self.areas[0], left - 1.0, grown_areas[1], right);
        let both = if spare { Sah::weight(self.areas[0], left, self.areas[1], right) } else { f32::INFINITY };

        // Neither side may lose its last reference: a split that separates nothing is none.
        let allowed = [self.counts[1] > 1 && only_left < both, self.counts[0] > 1 && only_right < both];
        let side = match allowed {
            [false, false] if spare => return Fate::Both,
            [true, true] => usize::from(only_right < only_left),
            [_, right] => usize::from(right),
        };
        self.bounds[side] = grown[side];
        self.areas[side] = grown_areas[side];
        self.counts[1 - side] -= 1;
        if side == 0 { Fate::Left } else { Fate::Right }
    }
}
