//! What stands in the slots of a tree under change: one box each, or one for each of several poses.
//!
//! Search and refit ask for areas alone, and so do not see which of the two it is.

use super::slot::Slot;
use crate::simd::LaneBox;

/// The boxes of all slots. What is said of a slot depends on its link alone or on what it holds, never on where it stands, since moves carry
/// what slots hold from one to another.
pub trait Volumes: Sync {
    /// What one node takes up, apart from the tree.
    type Held: Copy + Send;

    /// What a slot takes up.
    fn held(&self, slot: &Slot) -> Self::Held;

    /// The area of a slot together with something.
    fn area_with(&self, slot: &Slot, held: &Self::Held) -> f32;

    /// Add what a slot takes up, and return the area of all.
    fn join(&self, slot: &Slot, held: &mut Self::Held) -> f32;

    /// Whether a slot takes up just this.
    fn is(&self, slot: &Slot, held: &Self::Held) -> bool;

    /// Let an inner node's slot take up what its children do, and return the area of that.
    fn enclose(&mut self, slots: &mut [Slot], at: u32) -> f32;
}

/// One box in each slot, and it stands there itself.
pub struct OneBox {
    /// As [`WorkTree::scale`](super::work_tree::WorkTree::scale).
    pub scale: f32,
}

impl Volumes for OneBox {
    type Held = LaneBox;

    #[inline(always)]
    fn held(&self, slot: &Slot) -> LaneBox {
        slot.lanes()
    }

    #[inline(always)]
    fn area_with(&self, slot: &Slot, held: &LaneBox) -> f32 {
        slot.lanes().union(*held).scaled_half_area(self.scale)
    }

    #[inline(always)]
    fn join(&self, slot: &Slot, held: &mut LaneBox) -> f32 {
        *held = held.union(slot.lanes());
        held.scaled_half_area(self.scale)
    }

    #[inline(always)]
    fn is(&self, slot: &Slot, held: &LaneBox) -> bool {
        (slot.min, slot.max) == (held.min.point(), held.max.point())
    }

    #[inline(always)]
    fn enclose(&mut self, slots: &mut [Slot], at: u32) -> f32 {
        let [first, second] = slots[at as usize].children().map(|child| slots[child as usize].lanes());
        let both = first.union(second);
        slots[at as usize].set_box(both);
        both.scaled_half_area(self.scale)
    }
}
