use crate::build::prim_ref::PrimRef;
use crate::exec::Executor;
use crate::geom::Aabb;

/// What the driver asks a strategy about: one node with at least two references.
#[derive(Clone, Copy, Debug)]
pub struct NodeTask {
    /// Union of the live references' boxes.
    pub bounds: Aabb,
    /// Box of the live references' doubled centres ([`PrimRef::center2`]).
    pub centroids: Aabb,
    /// References in the node: the first `live` of its slots. The slots behind them are free for duplicates.
    pub live: usize,
    /// 0 for the root.
    pub depth: u32,
}

/// One side of a split.
#[derive(Clone, Copy, Debug)]
pub struct Child {
    pub bounds: Aabb,
    pub centroids: Aabb,
    /// At least 1, at most the parent's `live`.
    pub live: usize,
    /// Slots that the child gets, `live` at least. Both children together get all of the parent's.
    pub slots: usize,
}

/// A strategy's answer.
#[derive(Clone, Copy, Debug)]
pub enum Decision {
    /// A leaf is cheaper than any split, or no split separates the references. The driver makes a leaf where the node
    /// fits one, and splits in the middle where it does not.
    Leaf,
    /// The references stand partitioned: the left child's in `slots[..left.live]`, the right child's in
    /// `slots[left.slots..left.slots + right.live]`.
    Split { left: Child, right: Child },
}

/// Answers one question: where to split this node. Leaves, depth, recursion and output are the
/// [driver](super::driver)'s.
pub trait Strategy: Sync {
    /// Choose a split and carry it out on `slots`, or leave `slots[..node.live]` a permutation of what it was.
    ///
    /// The answer may depend on nothing but the arguments: not on time, threads or earlier calls.
    fn split(&self, node: &NodeTask, slots: &mut [PrimRef], exec: &Executor) -> Decision;
}
