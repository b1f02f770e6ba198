//! The best plane of a node.
//!
//! Chopping every reference on every axis is what spatial splits cost, and most nodes then keep their object split. So a large node is
//! first judged by a sample of its references: their boxes are parts of all references' boxes, and a plane that does not
//! promise to win even for them is not looked for. Where one does, only its axis is filled with all references.

use super::bins::{Grids, SpatialBins, SpatialPlane};
use super::{CHUNK, CHUNKED};
use crate::build::binned::area_scale;
use crate::build::prim_ref::PrimRef;
use crate::build::recipe::options::Clip;
use crate::build::top_down::strategy::NodeTask;
use crate::exec::Executor;
use crate::scene::Mesh;

/// From so many references on, a sample is asked first.
const SAMPLED: usize = 1 << 11;
/// About so many references are a sample: chopping them costs little beside what it may save.
const SAMPLE: usize = 1 << 10;
/// A sample errs. It must promise a weight of this many times the limit or less, and an axis this many times the best one's.
const LENIENT: f32 = 1.02;
const NEAR: f32 = 1.1;

/// What planes are looked for with.
#[derive(Clone, Copy)]
pub(super) struct PlaneSearch<'a> {
    pub mesh: &'a Mesh,
    pub clip: Clip,
    pub bins: usize,
}

impl PlaneSearch<'_> {
    /// The plane of least weight that makes at most `slack` duplicates, if it seems to weigh less than `limit`.
    pub fn best(
        &self,
        node: &NodeTask,
        refs: &[PrimRef],
        slack: usize,
        limit: f32,
        exec: &Executor,
    ) -> Option<SpatialPlane> {
        let bins = self.bins.min(4 + refs.len() / 8);
        match bins {
            0..=8 => self.find_in::<8>(node, refs, bins, slack, limit, exec),
            9..=16 => self.find_in::<16>(node, refs, bins, slack, limit, exec),
            17..=32 => self.find_in::<32>(node, refs, bins, slack, limit, exec),
            _ => self.find_in::<256>(node, refs, bins, slack, limit, exec),
        }
    }

    #[inline(never)]
    fn find_in<const CAP: usize>(
        &self,
        node: &NodeTask,
        refs: &[PrimRef],
        bins: usize,
        slack: usize,
        limit: f32,
        exec: &Executor,
    ) -> Option<SpatialPlane> {
        let grids = Grids::new(&node.bounds, bins);
        let scale = area_scale(&node.bounds);
        let axes = if refs.len() < SAMPLED { grids.cuts() } else { self.promising::<CAP>(&grids, refs, limit, scale)? };
        let mut filled = SpatialBins::<CAP>::EMPTY;
        if refs.len() < CHUNKED {
            filled.fill(&grids, axes, refs.iter(), self.mesh, self.clip);
        } else {
            let parts = exec.map_chunks(refs, CHUNK, |_, chunk| {
                let mut part = Box::new(SpatialBins::<CAP>::EMPTY);
                part.fill(&grids, axes, chunk.iter(), self.mesh, self.clip);
                part
            });
            parts.iter().for_each(|part| filled.merge(part));
        }
        let planes = (0..3).filter(|&axis| axes[axis]);
        let planes = planes.filter_map(|axis| filled.best_plane(&grids, axis, refs.len(), slack, scale));
        planes.reduce(|best, plane| if plane.weight < best.weight { plane } else { best })
    }

    /// The axes on which a sample of the references has a plane that weighs less than `limit` and hardly more than the best of the sample's.
    fn promising<const CAP: usize>(
        &self,
        grids: &Grids,
        refs: &[PrimRef],
        limit: f32,
        scale: f32,
    ) -> Option<[bool; 3]> {
        let stride = refs.len() / SAMPLE;
        let mut filled = SpatialBins::<CAP>::EMPTY;
        let sample = refs.iter().step_by(stride);
        let share = refs.len() as f32 / sample.len() as f32;
        let cuts = grids.cuts();
        filled.fill(grids, cuts, sample, self.mesh, self.clip);
        let weights = [0, 1, 2].map(|axis| {
            let plane = if cuts[axis] { filled.best_plane(grids, axis, 0, usize::MAX, scale) } else { None };
            plane.map_or(f32::INFINITY, |plane| plane.weight * share)
        });
        let least = weights.into_iter().fold(f32::INFINITY, f32::min);
        let limit = limit * LENIENT;
        (least < limit).then(|| weights.map(|weight| weight < limit && weight <= least * NEAR))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::prim_ref::PrimRefs;

    /// Long thin triangles that cross the middle of the x axis, each in its own layer of the z axis.
    fn sticks(count: u32) -> Mesh {
        let at = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as f32 * 1e-6;
        let corners = (0..count).flat_map(|i| {
            let (y, z) = (at(i), at(i + count));
            [[0.0, y, z], [100.0, y, z], [100.0, y + 0.01, z]]
        });
        let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh { positions: corners.collect(), triangles, ..Mesh::default() }
    }

    fn node(refs: &PrimRefs) -> NodeTask {
        NodeTask { bounds: refs.bounds, centroids: refs.centroids, live: refs.refs.len(), depth: 0 }
    }

    #[test]
    fn a_sample_finds_the_axis_and_leaves_the_plane_to_all_references() {
        for count in [SAMPLED as u32 - 1, SAMPLED as u32, 40_000] {
            let mesh = sticks(count);
            for jobs in [1, 2] {
                let exec = Executor::new(jobs).unwrap();
                let refs = PrimRefs::of_mesh(&mesh, 0, &exec);
                let (node, search) = (node(&refs), PlaneSearch { mesh: &mesh, clip: Clip::Exact, bins: 16 });
                let plane = search.best(&node, &refs.refs, count as usize, f32::INFINITY, &exec).unwrap();

                let grids = Grids::new(&node.bounds, 16);
                let mut all = SpatialBins::<16>::EMPTY;
                all.fill(&grids, [true; 3], refs.refs.iter(), &mesh, Clip::Exact);
                let scale = area_scale(&node.bounds);
                let expected = (0..3).filter_map(|a| all.best_plane(&grids, a, refs.refs.len(), count as usize, scale));
                let expected = expected.reduce(|a, b| if b.weight < a.weight { b } else { a }).unwrap();
                assert_eq!((plane.axis, plane.position), (expected.axis, expected.position), "{count}");
                assert_eq!((plane.weight, plane.counts), (expected.weight, expected.counts), "{count}");
            }
        }
    }

    #[test]
    fn what_a_sample_does_not_promise_is_not_looked_for() {
        let mesh = sticks(40_000);
        let exec = Executor::sequential();
        let refs = PrimRefs::of_mesh(&mesh, 0, &exec);
        let search = PlaneSearch { mesh: &mesh, clip: Clip::Exact, bins: 16 };
        let best = |limit: f32| search.best(&node(&refs), &refs.refs, 40_000, limit, &exec);
        let weight = best(f32::INFINITY).unwrap().weight;
        assert!(best(weight * 1.01).is_some_and(|plane| plane.weight == weight));
        assert!(best(weight * 0.9).is_none());
    }
}
