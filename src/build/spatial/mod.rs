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
mod planes;
mod small_sweep;

use self::partition::{Cutter, Parts};
use self::planes::PlaneSearch;
use self::small_sweep::SmallSplit;
use crate::build::binned::{Binned, EXHAUSTIVE, ObjectSplit, area_scale, scaled_half_area};
use crate::build::cost::Sah;
use crate::build::prim_ref::PrimRef;
use crate::build::recipe::options::{Axes, BuildOptions, Clip};
use crate::build::top_down::strategy::{Child, Decision, NodeTask, Strategy};
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::scene::Mesh;
use crate::simd::{LaneBox, Lanes};

/// From so many references on, they are binned, copied and summed in chunks of [`CHUNK`]: constants, so that nothing depends on the number of
/// threads.
const CHUNKED: usize = 1 << 14;
const CHUNK: usize = 1 << 12;

/// Where an object split's children share nothing, a spatial split must beat it by a hundredth: its duplicates cost memory, and its price
/// is an estimate.
const MARGIN: f32 = 0.99;

/// What an object split is charged for each reference and unit of the area that its children share. The SAH charges a ray for the boxes on
/// its way as if it met nothing. Most rays end, and one that hits something in the near child is done, but for what the far child
/// shares with it: where that is much, dividing space is worth more than the SAH says. A choice by rays: half or twice as much
/// does nearly as well.
const SHARED: f32 = 0.1;

/// Space is not divided where cutting the overlap of the object split's children would save less than this share of a child's area.
const LEAST_GAIN: f64 = 0.005;

/// The method `sbvh`.
pub struct Spatial<'a> {
    mesh: &'a Mesh,
    objects: Binned,
    axes: Axes,
    sah: Sah,
    planes: PlaneSearch<'a>,
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
            planes: PlaneSearch { mesh, clip: options.clip, bins: options.spatial_bins.clamp(2, 256) as usize },
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
        let sides = split.map(Object::bounds);
        let can_gain = sides.is_none_or(|sides| most_saved(&node.bounds, &overlap, sides) > LEAST_GAIN);
        !overlap.is_empty() && !touch && half_area(&overlap) > self.overlap && can_gain
    }

    /// Very few references are split in every way, few are swept, more are binned.
    fn find_object(&self, node: &NodeTask, refs: &[PrimRef], exec: &Executor) -> Option<Object> {
        if self.axes == Axes::All && (EXHAUSTIVE + 1..=small_sweep::MAX).contains(&refs.len()) {
            small_sweep::find(refs, area_scale(&node.bounds)).map(Object::Swept)
        } else {
            self.objects.find(node, refs, exec).map(Object::Binned)
        }
    }
}

impl Strategy for Spatial<'_> {
    fn split(&self, node: &NodeTask, slots: &mut [PrimRef], exec: &Executor) -> Decision {
        let (live, slack, scale) = (node.live, slots.len() - node.live, area_scale(&node.bounds));
        let mut object = self.find_object(node, &slots[..live], exec);
        let object_weight = object.as_ref().map_or(f32::INFINITY, |s| s.weight());
        let shared = object.as_ref().map_or(0.0, |s| shared_area(s, scale));
        let limit = object_weight * MARGIN + SHARED * shared * live as f32;
        let spatial = if self.is_worth_a_try(node, object.as_ref(), slack) {
            self.planes.best(node, &slots[..live], slack, limit, exec)
        } else {
            None
        };
        let spatial = spatial.filter(|s| s.weight < limit);

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
            if let Some(Parts { left, right, right_refs }) = cutter.partition(&plane, slots, live, exec) {
                let spare = slots.len() - left.live - right.live;
                let left_slots = left.live + share_of(spare, &slots[..left.live], &right_refs, scale, exec);
                copy(&right_refs, &mut slots[left_slots..left_slots + right.live], exec);
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
        divide(left, right, slots, scale, exec)
    }
}

/// Move the right child's references behind the left child's share of the free slots.
fn divide(left: Child, right: Child, slots: &mut [PrimRef], scale: f32, exec: &Executor) -> Decision {
    let (total, live) = (slots.len(), left.live + right.live);
    if total == live {
        return Decision::Split { left, right };
    }
    let (left_refs, right_refs) = slots[..live].split_at(left.live);
    let left_slots = left.live + share_of(total - live, left_refs, right_refs, scale, exec);

    // Where old and new place overlap, only what stands before the new place moves, to its end: the order is nobody's concern.
    let moved = right.live.min(left_slots - left.live);
    let (from, to) = slots[left.live..left_slots + right.live].split_at_mut(left_slots.max(live) - left.live);
    let end = to.len() - moved;
    copy(&from[..moved], &mut to[end..], exec);
    Decision::Split { left: Child { slots: left_slots, ..left }, right: Child { slots: total - left_slots, ..right } }
}

/// Copy references to a place of as many.
fn copy(from: &[PrimRef], to: &mut [PrimRef], exec: &Executor) {
    if from.len() < CHUNKED {
        return to.copy_from_slice(from);
    }
    exec.map_chunks_mut(to, CHUNK, |i, chunk| chunk.copy_from_slice(&from[i * CHUNK..][..chunk.len()]));
}

/// The left side's share of the free slots: in proportion to the surface of the references' boxes, since it is large boxes that are
/// worth cutting.
fn share_of(spare: usize, left: &[PrimRef], right: &[PrimRef], scale: f32, exec: &Executor) -> usize {
    let sum = |refs: &[PrimRef]| match refs.len() {
        0..CHUNKED => area_of(refs, scale),
        _ => exec.map_chunks(refs, CHUNK, |_, chunk| area_of(chunk, scale)).iter().sum::<f64>(),
    };
    let (left, right) = (sum(left), sum(right));
    if left + right > 0.0 { ((spare as f64) * (left / (left + right))) as usize } else { spare / 2 }
}

/// The sum of the areas of the references' boxes, edges scaled: of runs of four in `f32`, of those in `f64`.
fn area_of(refs: &[PrimRef], scale: f32) -> f64 {
    let fours = refs.chunks_exact(4);
    let rest: f32 = fours.remainder().iter().map(|r| r.lanes().scaled_half_area(scale)).sum();
    let scale = Lanes::splat(scale);
    let sum = |areas: Lanes| (areas.0[0] + areas.0[1]) + (areas.0[2] + areas.0[3]);
    let four = |r: &[PrimRef]| {
        sum(LaneBox::scaled_half_areas([r[0].lanes(), r[1].lanes(), r[2].lanes(), r[3].lanes()], scale))
    };
    f64::from(rest) + fours.map(|r| f64::from(four(r))).sum::<f64>()
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

    fn bounds(&self) -> [Aabb; 2] {
        match self {
            Object::Binned(split) => split.bounds,
            Object::Swept(split) => split.bounds.map(LaneBox::aabb),
        }
    }

    /// What both children's boxes share.
    fn overlap(&self) -> Aabb {
        let [left, right] = self.bounds();
        left.intersection(right)
    }

    fn apply(&self, refs: &mut [PrimRef], exec: &Executor) -> (Child, Child) {
        match self {
            Object::Binned(split) => Binned::apply(split, refs, exec),
            Object::Swept(split) => split.apply(refs),
        }
    }
}

/// Half the area, scaled, of what the children of an object split share.
fn shared_area(split: &Object, scale: f32) -> f32 {
    let overlap = split.overlap();
    if overlap.is_empty() { 0.0 } else { scaled_half_area(&overlap, scale) }
}

/// The most that either child's box could lose of its area, as a share of it, if a plane across the axis on which they overlap least
/// gave all of the overlap to the other. A thin overlap has a large face, but next to nothing is saved by cutting it.
fn most_saved(node: &Aabb, overlap: &Aabb, sides: [Aabb; 2]) -> f64 {
    let edges = |b: &Aabb| [0, 1, 2].map(|a| f64::from(b.max[a]) - f64::from(b.min[a]));
    let (whole, shared) = (edges(node), edges(overlap));
    let thinness = |a: usize| if whole[a] > 0.0 { shared[a] / whole[a] } else { f64::INFINITY };
    let axis = (1..3).fold(0, |best, a| if thinness(a) < thinness(best) { a } else { best });
    let lost = |side: &Aabb| {
        let (edges, area) = (edges(side), half_area(side));
        let around = edges[(axis + 1) % 3] + edges[(axis + 2) % 3];
        // Nothing is known of what has no area.
        if area > 0.0 { shared[axis] * around / area } else { f64::INFINITY }
    };
    lost(&sides[0]).max(lost(&sides[1]))
}

/// Half the area in `f64`, which no finite box overflows; 0 for an empty box.
fn half_area(b: &Aabb) -> f64 {
    let edge = |a: usize| f64::from(b.max[a]) - f64::from(b.min[a]);
    let (x, y, z) = (edge(0), edge(1), edge(2));
    if x < 0.0 || y < 0.0 || z < 0.0 { 0.0 } else { x * y + y * z + z * x }
}

#[cfg(test)]
mod tests;
