//! What clustering finds: which clusters became one, and what is below.

use crate::build::cost::Sah;
use crate::build::prim_ref::PrimRef;
use crate::build::recipe::options::{BuildOptions, MAX_RADIUS};
use crate::geom::Aabb;

/// How clusters are merged and valued.
#[derive(Clone, Copy, Debug)]
pub(in crate::build) struct Rules {
    pub sah: Sah,
    pub max_leaf: u32,
    /// Neighbours to either side that a cluster looks at.
    pub radius: usize,
    /// Edges are multiplied by it before they are to areas.
    pub scale: f32,
}

impl Rules {
    /// What the options ask, for references in this box.
    pub fn new(options: &BuildOptions, bounds: &Aabb) -> Rules {
        Rules {
            sah: Sah { traversal: options.traversal_cost, intersection: options.intersection_cost },
            max_leaf: options.max_leaf.clamp(1, 255),
            radius: options.radius.clamp(1, MAX_RADIUS) as usize,
            scale: scale_of(bounds),
        }
    }

    /// Half the box's area, in the scale of all of them.
    #[inline(always)]
    pub fn area(&self, bounds: &Aabb) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|a| (bounds.max[a] - bounds.min[a]) * self.scale);
        x * y + y * z + z * x
    }
}

/// A power of two that brings the longest side to between 1 and 2, so that no area over- or underflows.
fn scale_of(bounds: &Aabb) -> f32 {
    let longest = (0..3).map(|a| f64::from(bounds.max[a]) - f64::from(bounds.min[a])).fold(0.0, f64::max);
    let exponent = if longest > 0.0 { longest.log2().floor() as i32 } else { 0 };
    2f32.powi((-exponent).clamp(-126, 126))
}

/// What a cluster weighs in the comparison of its parent with a leaf, and how much room it takes.
#[derive(Clone, Copy, Debug, Default, bytemuck::Zeroable)]
#[repr(C, align(16))]
pub(in crate::build) struct Weight {
    /// References below.
    pub count: u32,
    /// Inner nodes from this one on down; 0 where the subtree is cheaper as a leaf.
    pub inner: u32,
    /// Longest way down to a leaf.
    pub height: u32,
    /// SAH of the subtree times the area of the root.
    pub cost: f32,
}

impl Weight {
    /// A cluster of one reference of this area.
    pub fn of_one(area: f32, sah: Sah) -> Weight {
        Weight { count: 1, inner: 0, height: 0, cost: sah.intersection * area }
    }

    /// What two clusters are together, in a box of this area: a leaf or an inner node.
    #[inline(always)]
    pub fn joined(a: Weight, b: Weight, area: f32, rules: &Rules) -> Weight {
        let (count, Sah { traversal, intersection }) = (a.count + b.count, rules.sah);
        let split = traversal * area + (a.cost + b.cost);
        let leaf = intersection * count as f32 * area;
        if count <= rules.max_leaf && leaf <= split {
            Weight { count, inner: 0, height: 0, cost: leaf }
        } else {
            Weight { count, inner: a.inner + b.inner + 1, height: a.height.max(b.height) + 1, cost: split }
        }
    }
}

/// What is still to be merged.
#[derive(Clone, Copy, Debug, bytemuck::Zeroable)]
#[repr(C)]
pub(in crate::build) struct Cluster {
    pub weight: Weight,
    pub bounds: Aabb,
    /// Below the number of references that of a reference, otherwise of a merge.
    pub number: u32,
}

/// Two clusters that became one.
#[derive(Clone, Copy, Debug, bytemuck::Zeroable)]
#[repr(C)]
pub(in crate::build) struct Merge {
    pub children: [u32; 2],
    /// References below.
    pub count: u32,
    /// Inner nodes from this one on down; 0 for a leaf.
    pub inner: u32,
}

/// The merges of all references into one cluster.
pub(in crate::build) struct Forest<'a> {
    /// In the order in which clusters number them.
    pub refs: &'a [PrimRef],
    /// Children stand before their parents. Not every place is in use.
    pub merges: Vec<Merge>,
    pub root: Cluster,
}

impl Forest<'_> {
    /// `None` for a reference.
    #[inline(always)]
    pub fn merge(&self, cluster: u32) -> Option<&Merge> {
        self.merges.get((cluster as usize).checked_sub(self.refs.len())?)
    }
}
