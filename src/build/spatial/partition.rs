//! Carrying out a spatial split: straddling references are cut in two or, where that is cheaper, put wholly to one side.

use super::CHUNK;
use super::bins::SpatialPlane;
use crate::build::binned::scaled_half_area;
use crate::build::cost::Sah;
use crate::build::prim_ref::PrimRef;
use crate::build::recipe::options::Clip;
use crate::build::top_down::strategy::Child;
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::geom::clip;
use crate::scene::Mesh;
use crate::simd::LaneBox;

/// From so many references on, a node is divided in chunks, which copies each reference once more than a single pass does.
const CHUNKED: usize = 1 << 16;
/// References that a task cuts at once.
const CUTS: usize = 1 << 8;

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
    pub fn partition(
        &self,
        plane: &SpatialPlane,
        slots: &mut [PrimRef],
        live: usize,
        exec: &Executor,
    ) -> Option<Parts> {
        let many = live >= CHUNKED;
        let (mut parts, straddling) =
            if many { deal_chunks(plane, slots, live, exec) } else { deal(plane, slots, live) };

        // Cut side by side what the decisions below, each of which depends on those before it, may ask for.
        let cut = |r: &PrimRef| self.cut(r, plane.axis, plane.position);
        let ready: Vec<(Aabb, Aabb)> = if many {
            exec.map_chunks(&straddling, CUTS, |_, refs| refs.iter().map(cut).collect::<Vec<_>>()).concat()
        } else {
            Vec::new()
        };
        let mut spare = slots.len() - live;
        let counts = [parts.left.live + straddling.len(), parts.right.live + straddling.len()];
        let mut balance = Balance::new(plane, counts, self.scale);
        for (i, r) in straddling.into_iter().enumerate() {
            match balance.choose(&r.bounds(), self.unsplit, spare > 0) {
                Fate::Left => parts.put_left(r, slots),
                Fate::Right => parts.put_right(r),
                Fate::Both => {
                    let (below, above) = ready.get(i).copied().unwrap_or_else(|| cut(&r));
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

/// Move what lies on one side of the plane to it; returns what straddles. The bins only estimated that; this is exact.
fn deal(plane: &SpatialPlane, slots: &mut [PrimRef], live: usize) -> (Parts, Vec<PrimRef>) {
    let right_refs = Vec::with_capacity(plane.counts[1].min(live));
    let mut parts = Parts { left: Side::EMPTY, right: Side::EMPTY, right_refs };
    let mut straddling = Vec::new();
    for i in 0..live {
        let r = slots[i];
        if r.min[plane.axis] >= plane.position {
            parts.put_right(r);
        } else if r.max[plane.axis] <= plane.position {
            parts.put_left(r, slots);
        } else {
            straddling.push(r);
        }
    }
    (parts, straddling)
}

/// [`deal`] with the same result, chunks side by side.
fn deal_chunks(plane: &SpatialPlane, slots: &mut [PrimRef], live: usize, exec: &Executor) -> (Parts, Vec<PrimRef>) {
    let dealt = exec.map_chunks_mut(&mut slots[..live], CHUNK, |_, chunk| {
        let (parts, straddling) = deal(plane, chunk, chunk.len());
        let left_refs = chunk[..parts.left.live].to_vec();
        (parts, left_refs, straddling)
    });
    let left = Side::joined(dealt.iter().map(|(parts, ..)| &parts.left));
    let right = Side::joined(dealt.iter().map(|(parts, ..)| &parts.right));
    concatenate(dealt.iter().map(|(_, left_refs, _)| left_refs), &mut slots[..left.live], exec);
    let mut right_refs = bytemuck::zeroed_vec(right.live);
    concatenate(dealt.iter().map(|(parts, ..)| &parts.right_refs), &mut right_refs, exec);
    let straddling = dealt.iter().flat_map(|(_, _, straddling)| straddling).copied().collect();
    (Parts { left, right, right_refs }, straddling)
}

/// Copy runs of references one behind the other.
fn concatenate<'a>(runs: impl Iterator<Item = &'a Vec<PrimRef>>, mut to: &mut [PrimRef], exec: &Executor) {
    let mut jobs = Vec::new();
    for run in runs {
        let (place, rest) = to.split_at_mut(run.len());
        jobs.push((run, place));
        to = rest;
    }
    exec.map(jobs, |_, (run, place)| place.copy_from_slice(run));
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

    fn joined<'a>(sides: impl Iterator<Item = &'a Side>) -> Side {
        sides.fold(Side::EMPTY, |a, b| Side {
            bounds: a.bounds.union(b.bounds),
            centroids: a.centroids.union(b.centroids),
            live: a.live + b.live,
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_dealt_as_the_whole() {
        let mut refs: Vec<PrimRef> = (0..3 * CHUNK as u32 + 77)
            .map(|i| {
                let at = (i.wrapping_mul(2_654_435_761) >> 12) as f32 * 1e-5;
                PrimRef::new(&Aabb { min: [at, 0.0, -at], max: [at + 0.3, 1.0, 1.0] }, i)
            })
            .collect();
        let (bounds, live) = ([Aabb::EMPTY; 2], refs.len());
        let plane = SpatialPlane { axis: 0, position: 4.0, weight: 0.0, bounds, counts: [live; 2] };
        let mut whole = refs.clone();
        let (expected, expected_straddling) = deal(&plane, &mut whole, live);
        assert!(expected.left.live > CHUNK && expected.right.live > CHUNK && expected_straddling.len() > 100);

        let (parts, straddling) = deal_chunks(&plane, &mut refs, live, &Executor::new(2).unwrap());
        assert!(refs[..parts.left.live] == whole[..expected.left.live]);
        assert!(parts.right_refs == expected.right_refs && straddling == expected_straddling);
        for (side, expected) in [(parts.left, expected.left), (parts.right, expected.right)] {
            let child = |side: Side| (side.child(0).bounds, side.child(0).centroids, side.live);
            assert_eq!(child(side), child(expected));
        }
    }
}
