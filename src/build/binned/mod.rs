//! Object splits by binned SAH (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007):
//! references are counted into equal bins over the box of their *centres*, and the planes between bins compete on all
//! three axes.

mod bins;
mod subsets;

use self::bins::{AxisMap, BinMap, Bins};
use self::subsets::partition_subset;
pub(super) use self::subsets::{EXHAUSTIVE, Subset, best_subset};
use crate::build::cost::Sah;
use crate::build::prim_ref::{PrimRef, bounds_of};
use crate::build::recipe::options::{Axes, BuildOptions};
use crate::build::top_down::partition::partition;
use crate::build::top_down::strategy::{Child, Decision, NodeTask, Strategy};
use crate::exec::Executor;
use crate::geom::Aabb;

/// From so many references on, bins are filled in chunks of [`CHUNK`].
const CHUNKED: usize = 1 << 15;
const CHUNK: usize = 1 << 13;

/// The method `binned`; also the object half of the spatial strategy.
#[derive(Clone, Copy, Debug)]
pub struct Binned {
    sah: Sah,
    axes: Axes,
    bins: usize,
    max_leaf: usize,
}

/// The best object split of a node, not yet carried out.
#[derive(Clone, Copy, Debug)]
pub struct ObjectSplit {
    how: How,
    /// `A_L·N_L + A_R·N_R`, with areas scaled as by [`area_scale`].
    pub weight: f32,
    /// Exact boxes of the two sides.
    pub bounds: [Aabb; 2],
}

/// Which references go left.
#[derive(Clone, Copy, Debug)]
enum How {
    Plane(AxisMap, u32),
    Subset(Subset),
}

/// A factor for edges that brings a box's longest edge to about 1. Areas of the scaled box and of all boxes in it
/// neither overflow nor vanish.
pub fn area_scale(bounds: &Aabb) -> f32 {
    let [x, y, z] = bounds.extent();
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    1.0 / larger(larger(x, y), z)
}

/// Half the area of a box whose edges are multiplied by `scale` first.
pub fn scaled_half_area(bounds: &Aabb, scale: f32) -> f32 {
    let [x, y, z] = bounds.extent().map(|e| e * scale);
    x * y + y * z + z * x
}

impl Binned {
    pub fn new(options: &BuildOptions) -> Binned {
        Binned {
            sah: Sah { traversal: options.traversal_cost, intersection: options.intersection_cost },
            axes: options.axes,
            bins: options.bins.clamp(2, 256) as usize,
            max_leaf: options.max_leaf as usize,
        }
    }

    /// The cheapest object split, or `None` where all centres coincide or areas are no numbers.
    pub fn find(&self, node: &NodeTask, refs: &[PrimRef], exec: &Executor) -> Option<ObjectSplit> {
        if refs.len() <= EXHAUSTIVE && self.axes == Axes::All {
            let (subset, weight, bounds) = best_subset(refs, area_scale(&node.bounds))?;
            return Some(ObjectSplit { how: How::Subset(subset), weight, bounds });
        }
        // Small nodes cannot tell many planes apart.
        let bins = self.bins.min(8 + node.live / 20);
        match bins {
            0..=8 => self.find_in::<8>(node, refs, bins, exec),
            9..=16 => self.find_in::<16>(node, refs, bins, exec),
            17..=32 => self.find_in::<32>(node, refs, bins, exec),
            _ => self.find_in::<256>(node, refs, bins, exec),
        }
    }

    #[inline(never)]
    fn find_in<const CAP: usize>(
        &self,
        node: &NodeTask,
        refs: &[PrimRef],
        bins: usize,
        exec: &Executor,
    ) -> Option<ObjectSplit> {
        let map = BinMap::new(&node.centroids, bins);
        let mut filled = Bins::<CAP>::EMPTY;
        if refs.len() < CHUNKED {
            filled.fill(&map, refs);
        } else {
            let parts = exec.map_chunks(refs, CHUNK, |_, chunk| {
                let mut part = Box::new(Bins::<CAP>::EMPTY);
                part.fill(&map, chunk);
                part
            });
            parts.iter().for_each(|part| filled.merge(part));
        }
        let plane = filled.best_plane(&map, self.axes_of(node), bins, area_scale(&node.bounds))?;
        let how = How::Plane(map.on_axis(plane.axis), plane.bin);
        Some(ObjectSplit { how, weight: plane.weight, bounds: filled.sides(&plane, bins) })
    }

    fn axes_of(&self, node: &NodeTask) -> std::ops::Range<usize> {
        match self.axes {
            Axes::All => 0..3,
            Axes::Longest => {
                let extent = node.centroids.extent();
                let longest = (1..3).fold(0, |best, a| if extent[a] > extent[best] { a } else { best });
                longest..longest + 1
            }
        }
    }

    /// Carry out a split on the live references. Both children get no more slots than they have references.
    pub fn apply(split: &ObjectSplit, refs: &mut [PrimRef], exec: &Executor) -> (Child, Child) {
        let total = refs.len();
        let (left, centroids) = match split.how {
            How::Plane(map, last) => partition(refs, exec, |r| map.bin_of(r) <= last),
            How::Subset(subset) => {
                let left = partition_subset(refs, subset);
                (left, [bounds_of(&refs[..left]).1, bounds_of(&refs[left..]).1])
            }
        };
        let child = |side: usize, live: usize| Child {
            bounds: split.bounds[side],
            centroids: centroids[side],
            live,
            slots: live,
        };
        (child(0, left), child(1, total - left))
    }
}

impl Strategy for Binned {
    fn split(&self, node: &NodeTask, slots: &mut [PrimRef], exec: &Executor) -> Decision {
        if node.live <= self.max_leaf && self.sah.needs_no_split(node.live) {
            return Decision::Leaf;
        }
        let refs = &mut slots[..node.live];
        let Some(split) = self.find(node, refs, exec) else { return Decision::Leaf };
        let area = scaled_half_area(&node.bounds, area_scale(&node.bounds));
        // Where areas vanish all splits weigh the same: none is useful.
        if split.weight == 0.0 && area == 0.0 {
            return Decision::Leaf;
        }
        if node.live <= self.max_leaf && self.sah.prefers_leaf(node.live, split.weight, area) {
            return Decision::Leaf;
        }
        let (left, right) = Binned::apply(&split, refs, exec);
        Decision::Split { left, right }
    }
}
