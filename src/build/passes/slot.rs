//! What stands in a place of a tree under change.

use crate::simd::LaneBox;

/// A node of a [`WorkTree`](super::work_tree::WorkTree).
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Slot {
    pub min: [f32; 3],
    /// An inner node's pair of children by its number, half the index of its first slot; of a leaf [`LEAF`] and the place of
    /// its first reference.
    pub link: u32,
    pub max: [f32; 3],
    /// Half the area of the box, whose edges are multiplied by [`WorkTree::scale`](super::work_tree::WorkTree::scale) first; over several
    /// poses the weighted sum of those areas.
    pub area: f32,
}

/// The bit of [`Slot::link`] that marks a leaf: a tree has fewer than 2³¹ references and fewer pairs than that.
pub const LEAF: u32 = 1 << 31;

impl Slot {
    #[inline(always)]
    pub fn is_leaf(&self) -> bool {
        self.link & LEAF != 0
    }

    /// The slots of an inner node's children.
    #[inline(always)]
    pub fn children(&self) -> [u32; 2] {
        [2 * self.link, 2 * self.link + 1]
    }

    /// The box, with link and area in the fourth lanes.
    #[inline(always)]
    pub fn lanes(&self) -> LaneBox {
        *bytemuck::cast_ref(self)
    }

    /// Another box; the area stays.
    pub fn set_box(&mut self, bounds: LaneBox) {
        (self.min, self.max) = (bounds.min.point(), bounds.max.point());
    }
}
