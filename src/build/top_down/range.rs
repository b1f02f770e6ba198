//! The references of one node, in whatever form a builder keeps them.

use super::partition;
use super::strategy::{Child, Decision, NodeTask, Strategy};
use crate::build::prim_ref::PrimRef;
use crate::exec::Executor;

/// A node's slots: all that the recursion hands down.
pub(in crate::build) trait Range: Send + Sized {
    /// Divide the slots between the children, the first `left_slots` to the left one.
    fn cut(self, left_slots: usize) -> (Self, Self);

    /// The primitives of the first `live` slots, in any order.
    fn prims(&self, live: usize) -> impl Iterator<Item = u32> + '_;

    /// The split where no strategy has one: in the order of the centres along the longest side of the centroid box,
    /// equal centres in the order of their numbers, cut in the middle.
    fn halve(&mut self, node: &NodeTask) -> (Child, Child);
}

/// [`Strategy`] for any form of range.
pub(in crate::build) trait Splitter<R: Range>: Sync {
    fn split(&self, node: &NodeTask, range: &mut R, exec: &Executor) -> Decision;
}

impl Range for &mut [PrimRef] {
    #[inline]
    fn cut(self, left_slots: usize) -> (Self, Self) {
        self.split_at_mut(left_slots)
    }

    #[inline]
    fn prims(&self, live: usize) -> impl Iterator<Item = u32> + '_ {
        self[..live].iter().map(|r| r.prim)
    }

    fn halve(&mut self, node: &NodeTask) -> (Child, Child) {
        partition::halve(node, self)
    }
}

impl<S: Strategy> Splitter<&mut [PrimRef]> for S {
    #[inline]
    fn split(&self, node: &NodeTask, range: &mut &mut [PrimRef], exec: &Executor) -> Decision {
        Strategy::split(self, node, range, exec)
    }
}
