//! Object and spatial splits in competition: the method `sbvh` (Stich, Friedrich and Dietrich, "Spatial Splits in Bounding Volume
//! Hierarchies", 2009).
//!
//! A node's best object split is found first. Where its children overlap by more than α of the *root's* area, space itself is
//! tried: slabs on every axis, references chopped into them, and the cheapest plane taken if it beats the object split. A
//! reference that straddles the plane becomes two, which costs a slot; slots are a budget that every split divides between its
//! children, so that the answer depends on the node alone and not on who asked first.

mod bins;
mod chop;
mod partition;
mod small_sweep;

use self::bins::{Grids, SpatialBins, SpatialPlane};
use self::partition::{Cutter, Parts};
use self::small_sweep::SmallSplit;
use crate::build::binned::{Binned, ObjectSplit, area_scale, scaled_half_area};
use crate::build::cost::Sah;
use crate::build::exec::Executor;
use crate::build::lanes::LaneBox;
use crate::build::prim_ref::PrimRef;
use crate::build::recipe::options::{Axes, BuildOptions, Clip};
use crate::build::top_down::strategy::{Child, Decision, NodeTask, Strategy};
use crate::geom::Aabb;
use crate::scene::Mesh;

/// From so many references on, bins are filled in chunks of [`CHUNK`]: constants, so that nothing depends on the number of threads.
const CHUNKED: usize = 1 << 14;
const CHUNK: usize = 1 << 12;

/// A spatial split must beat the object split by a hundredth: its duplicates cost memory, and its price is an estimate.
const MARGIN: f32 = 0.99;

/// The method `sbvh`.
pub struct Spatial<'a> {
    mesh: &'a Mesh,
    objects: Binned,
    axes: Axes,
    sah: Sah,
    bins: usize,
    max_leaf: usize,
    clip: Clip,
    unsplit: bool,
    /// Half the area that children must overlap by: α times the root's.
    overlap: f64,
    /// α = 1: never, whatever rounding makes of the areas.
    never: bool,
}

/// Slots for a mesh of so many triangles: its references and the duplicates that the budget allows.
pub fn budgeted_slots(triangles: usize, split_budget: f32) -> usize {
    triangles.saturating_add((triangles as f64 * (f64::from(split_budget) - 1.0).max(0.0)) as usize)
}

impl<'a> Spatial<'a> {
    pub fn new(mesh: &'a Mesh, root: &Aabb, options: &BuildOptions) -> Spatial<'a> {
        Spatial {
            mesh,
            objects: Binned::new(options),
            axes: options.axes,
            sah: Sah { traversal: options.traversal_cost, intersection: options.intersection_cost },
            bins: options.spatial_bins.clamp(2, 256) as usize,
            max_leaf: options.max_leaf as usize,
            clip: options.clip,
            unsplit: options.unsplit,
            overlap: f64::from(options.split_alpha) * half_area(root),
            never: options.split_alpha >= 1.0,
        }
    }

    /// Whether the children of the best object split leave anything to gain.
    fn is_worth_a_try(&self, node: &NodeTask, split: Option<&Object>, slack: usize) -> bool {
        if self.never || slack == 0 {
            return false;
        }
        // Where all centres coincide no object split separates anything, which is as bad as full overlap.
        let overlap = split.map_or(node.bounds, Object::overlap);
        // Boxes that only touch, as on a regular grid, share a face but no ray is tested twice for it.
        let (shared, whole) = (overlap.extent(), node.bounds.extent());
        let touch = (0..3).any(|a| shared[a] <= 0.0 && whole[a] > 0.0);
        !overlap.is_empty() && !touch && half_area(&overlap) > self.overlap
    }

    /// Few references are swept, more are binned.
    fn find_object(&self, node: &NodeTask, refs: &[PrimRef], exec: &Executor) -> Option<Object> {
        if self.axes == Axes::All && refs.len() <= small_sweep::MAX {
            small_sweep::find(refs, area_scale(&node.bounds)).map(Object::Swept)
        } else {
            self.objects.find(node, refs, exec).map(Object::Binned)
        }
    }

    fn find_plane(&self, node: &NodeTask, refs: &[PrimRef], slack: usize, exec: &Executor) -> Option<SpatialPlane> {
        let bins = self.bins.min(4 + refs.len() / 8);
        match bins {
            0..=8 => self.find_in::<8>(node, refs, bins, slack, exec),
            9..=16 => self.find_in::<16>(node, refs, bins, slack, exec),
            17..=32 => self.find_in::<32>(node, refs, bins, slack, exec),
            _ => self.find_in::<256>(node, refs, bins, slack, exec),
        }
    }

    #[inline(never)]
    fn find_in<const CAP: usize>(
        &self,
        node: &NodeTask,
        refs: &[PrimRef],
        bins: usize,
        slack: usize,
        exec: &Executor,
    ) -> Option<SpatialPlane> {
        let grids = Grids::new(&node.bounds, bins);
        let mut filled = SpatialBins::<CAP>::empty();
        if refs.len() < CHUNKED {
            filled.fill(&grids, refs, self.mesh, self.clip);
        } else {
            let parts = exec.map_chunks(refs, CHUNK, |_, chunk| {
                let mut part = Box::new(SpatialBins::<CAP>::empty());
                part.fill(&grids, chunk, self.mesh, self.clip);
                part
            });
            filled = parts.iter().fold(filled, |all, part| all.merge(part));
        }
        filled.best_plane(&grids, node.live, slack, area_scale(&node.bounds))
    }
}

impl Strategy for Spatial<'_> {
    fn split(&self, node: &NodeTask, slots: &mut [PrimRef], exec: &Executor) -> Decision {
        let (live, slack, scale) = (node.live, slots.len() - node.live, area_scale(&node.bounds));
        let mut object = self.find_object(node, &slots[..live], exec);
        let spatial = if self.is_worth_a_try(node, object.as_ref(), slack) {
            self.find_plane(node, &slots[..live], slack, exec)
        } else {
            None
        };
        let object_weight = object.as_ref().map_or(f32::INFINITY, |s| s.weight());
        let spatial = spatial.filter(|s| s.weight < object_weight * MARGIN);

        // Compare the winner with a leaf.
        let weight = spatial.map_or(object_weight, |s| s.weight);
        let area = scaled_half_area(&node.bounds, scale);
        let is_leaf = |weight: f32| {
            (live <= self.max_leaf && self.sah.prefers_leaf(live, weight, area)) || area == 0.0 || weight == 0.0
        };
        if is_leaf(weight) {
            return Decision::Leaf;
        }

        if let Some(plane) = spatial {
            let cutter = Cutter { mesh: self.mesh, clip: self.clip, unsplit: self.unsplit, scale };
            if let Some(Parts { left, right, right_refs }) = cutter.partition(&plane, slots, live) {
                let spare = slots.len() - left.live - right.live;
                let left_slots = left.live + share_of(spare, &slots[..left.live], &right_refs);
                slots[left_slots..left_slots + right.live].copy_from_slice(&right_refs);
                return Decision::Split { left: left.child(left_slots), right: right.child(slots.len() - left_slots) };
            }

            // The plane divided nothing, and the object split goes by the places of references that stand elsewhere now.
            object = self.find_object(node, &slots[..live], exec);
            if object.as_ref().is_some_and(|s| is_leaf(s.weight())) {
                return Decision::Leaf;
            }
        }
        let Some(split) = object else { return Decision::Leaf };
        let (left, right) = split.apply(&mut slots[..live], exec);
        divide(left, right, slots)
    }
}

/// Move the right child's references behind the left child's share of the free slots.
fn divide(left: Child, right: Child, slots: &mut [PrimRef]) -> Decision {
    let (total, live) = (slots.len(), left.live + right.live);
    if total == live {
        return Decision::Split { left, right };
    }
    let (left_refs, right_refs) = slots[..live].split_at(left.live);
    let left_slots = left.live + share_of(total - live, left_refs, right_refs);
    slots.copy_within(left.live..live, left_slots);
    Decision::Split { left: Child { slots: left_slots, ..left }, right: Child { slots: total - left_slots, ..right } }
}

/// The left side's share of the free slots: in proportion to the surface of the references' boxes, since it is large boxes that are
/// worth cutting.
fn share_of(spare: usize, left: &[PrimRef], right: &[PrimRef]) -> usize {
    let sum = |refs: &[PrimRef]| refs.iter().map(|r| half_area(&r.bounds())).sum::<f64>();
    let (left, right) = (sum(left), sum(right));
    if left + right > 0.0 { ((spare as f64) * (left / (left + right))) as usize } else { spare / 2 }
}

/// The best object split of a node, however it was found.
enum Object {
    Binned(ObjectSplit),
    Swept(SmallSplit),
}

impl Object {
    fn weight(&self) -> f32 {
        match self {
            Object::Binned(split) => split.weight,
            Object::Swept(split) => split.weight,
        }
    }

    /// What both children's boxes share.
    fn overlap(&self) -> Aabb {
        let [left, right] = match self {
            Object::Binned(split) => split.bounds,
            Object::Swept(split) => split.bounds.map(LaneBox::aabb),
        };
        left.intersection(right)
    }

    fn apply(&self, refs: &mut [PrimRef], exec: &Executor) -> (Child, Child) {
        match self {
            Object::Binned(split) => Binned::apply(split, refs, exec),
            Object::Swept(split) => split.apply(refs),
        }
    }
}

/// Half the area in `f64`, which no finite box overflows; 0 for an empty box.
fn half_area(b: &Aabb) -> f64 {
    let edge = |a: usize| f64::from(b.max[a]) - f64::from(b.min[a]);
    let (x, y, z) = (edge(0), edge(1), edge(2));
    if x < 0.0 || y < 0.0 || z < 0.0 { 0.0 } else { x * y + y * z + z * x }
}

#[cfg(test)]
mod tests;
