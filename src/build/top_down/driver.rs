//! The top-down recursion: asks the strategy where to split, guarantees depth and leaf size, makes the leaves and lays
//! the nodes out in canonical order.
//!
//! Depth is designed, not hoped for. `d + levels(n) <= limit` (64 for a whole tree) holds at every node of depth `d` with
//! `n` references, where `levels(n)` is the height of a balanced subtree with full leaves. A strategy is asked only while a child as large as
//! its parent would still satisfy this; from there on the driver halves.

use super::output::{Branch, Grown, Piece};
use super::range::{Range, Splitter};
use super::strategy::{Child, Decision, NodeTask, Strategy};
use crate::build::error::{BuildError, Remedy};
use crate::build::prim_ref::PrimRefs;
use crate::build::progress::Progress;
use crate::exec::Executor;
use crate::tree::{MAX_DEPTH, Node, Tree};
use std::sync::atomic::{AtomicBool, Ordering};

/// Below this many references a subtree is one task. A constant, so that the output does not depend on the number of
/// threads.
const TASK: usize = 1 << 11;
/// Subtrees of at most so many references are reported, and cancellation is looked for, as a whole.
const TICK: usize = 1 << 12;
/// References of one tree: with a node fewer than twice that, node indices fit 32 bits.
pub const MAX_REFS: u64 = (1 << 31) - 1;

/// Build the tree over the references `input.refs[..live]`; the slots behind them are the strategy's budget for
/// duplicates.
///
/// `share` is what the tree counts for in [`Progress::advance`].
pub fn build(
    mut input: PrimRefs,
    live: usize,
    strategy: &impl Strategy,
    max_leaf: u32,
    exec: &Executor,
    progress: &dyn Progress,
    share: u64,
) -> Result<Tree, BuildError> {
    check_slots(input.refs.len())?;
    if live == 0 {
        return Ok(Tree::default());
    }
    let task = NodeTask { bounds: input.bounds, centroids: input.centroids, live, depth: 0 };
    let driver = Driver::new(strategy, Limits { max_leaf, max_depth: MAX_DEPTH }, exec, progress);
    progress.phase("split");
    let grown = driver.grow_all(task, input.refs.as_mut_slice(), share)?;
    progress.phase("put together");
    drop(input);
    Ok(grown.into_tree(exec))
}

/// Refuse more references than a tree can have; best asked before they are made.
pub fn check_slots(slots: usize) -> Result<(), BuildError> {
    if slots as u64 <= MAX_REFS {
        return Ok(());
    }
    Err(BuildError::TooLarge {
        what: "one tree (references)",
        needed: slots as u64,
        limit: MAX_REFS,
        remedy: Remedy::TwoLevelsOrFewerDuplicates,
    })
}

/// What no leaf of a tree may exceed.
#[derive(Clone, Copy, Debug)]
pub(in crate::build) struct Limits {
    /// References in a leaf, 1..=255.
    pub max_leaf: u32,
    /// Depth of a leaf: at least the height of a balanced tree with full leaves.
    pub max_depth: u32,
}

impl Limits {
    /// Height of a balanced subtree with full leaves: a leaf has 0.
    pub fn levels(&self, live: usize) -> u32 {
        live.div_ceil(self.max_leaf.max(1) as usize).next_power_of_two().trailing_zeros()
    }
}

/// The recursion over one kind of range.
pub(in crate::build) struct Driver<'a, S> {
    splitter: &'a S,
    limits: Limits,
    exec: &'a Executor,
    progress: &'a dyn Progress,
    /// Set once, never read back into the output: a cancelled build returns no tree.
    cancelled: AtomicBool,
}

impl<'a, S> Driver<'a, S> {
    pub fn new(splitter: &'a S, limits: Limits, exec: &'a Executor, progress: &'a dyn Progress) -> Self {
        let limits = Limits { max_leaf: limits.max_leaf.clamp(1, 255), ..limits };
        Driver { splitter, limits, exec, progress, cancelled: AtomicBool::new(false) }
    }

    /// The whole tree below a root with at least one reference, not yet assembled: the references can be freed before.
    pub fn grow_all<R: Range>(&self, root: NodeTask, range: R, share: u64) -> Result<Grown, BuildError>
    where
        S: Splitter<R>,
    {
        let grown = if self.exec.is_sequential() {
            let mut piece = Piece::for_refs(root.live);
            let pair = piece.reserve_pair();
            let root = self.grow(root, range, &mut piece, share);
            Grown::Whole { pair, root, piece }
        } else {
            Grown::Parts(self.exec.run(|| self.fork(root, range, share)))
        };
        self.finish(grown)
    }

    /// What was grown, unless that was cut short.
    pub fn finish<T>(&self, grown: T) -> Result<T, BuildError> {
        if self.cancelled.load(Ordering::Relaxed) { Err(BuildError::Cancelled) } else { Ok(grown) }
    }

    /// The upper part of the tree, where the two sides are separate tasks.
    fn fork<R: Range>(&self, task: NodeTask, mut range: R, share: u64) -> Branch
    where
        S: Splitter<R>,
    {
        if task.live <= TASK {
            let mut piece = Piece::for_refs(task.live);
            let root = self.grow(task, range, &mut piece, share);
            return Branch::Piece { root, piece };
        }
        let Some((left, right)) = self.split(&task, &mut range) else {
            let mut piece = Piece::default();
            let root = piece.leaf(task.bounds, range.prims(task.live));
            self.progress.advance(share);
            return Branch::Piece { root, piece };
        };
        if self.is_cancelled() {
            return Branch::Piece { root: Node::leaf(task.bounds, 0, 1), piece: Piece::default() };
        }
        let (left_slots, right_slots) = range.cut(left.slots);
        let left_share = part_of(share, &left, &right);
        let children = self.exec.join(
            || self.fork(child_task(&task, &left), left_slots, left_share),
            || self.fork(child_task(&task, &right), right_slots, share - left_share),
        );
        Branch::Fork { bounds: task.bounds, children: Box::new(children) }
    }

    /// A whole subtree, appended to `piece`; returns its root's record.
    pub fn grow<R: Range>(&self, task: NodeTask, mut range: R, piece: &mut Piece, share: u64) -> Node
    where
        S: Splitter<R>,
    {
        let large = task.live > TICK;
        if large && self.is_cancelled() {
            return Node::leaf(task.bounds, 0, 1);
        }
        let Some((left, right)) = self.split(&task, &mut range) else {
            let leaf = piece.leaf(task.bounds, range.prims(task.live));
            if share > 0 {
                self.progress.advance(share);
            }
            return leaf;
        };
        let (left_slots, right_slots) = range.cut(left.slots);
        let left_share = if large { part_of(share, &left, &right) } else { 0 };
        let pair = piece.reserve_pair();
        let first = self.grow(child_task(&task, &left), left_slots, piece, left_share);
        let second =
            self.grow(child_task(&task, &right), right_slots, piece, if large { share - left_share } else { 0 });
        if !large && share > 0 {
            self.progress.advance(share);
        }
        piece.fill_pair(pair, first, second);
        Node::inner(task.bounds, pair)
    }

    /// `None`: a leaf.
    #[inline]
    fn split<R: Range>(&self, task: &NodeTask, range: &mut R) -> Option<(Child, Child)>
    where
        S: Splitter<R>,
    {
        if task.live == 1 {
            return None;
        }
        let may_ask = task.depth + 1 + self.limits.levels(task.live) <= self.limits.max_depth;
        if may_ask && let Decision::Split { left, right } = self.splitter.split(task, range, self.exec) {
            debug_assert!((1..=task.live).contains(&left.live) && (1..=task.live).contains(&right.live));
            debug_assert!(left.live <= left.slots && right.live <= right.slots);
            return Some((left, right));
        }
        (task.live > self.limits.max_leaf as usize).then(|| range.halve(task))
    }

    fn is_cancelled(&self) -> bool {
        let cancelled = self.progress.is_cancelled();
        if cancelled {
            self.cancelled.store(true, Ordering::Relaxed);
        }
        cancelled
    }
}

fn child_task(parent: &NodeTask, child: &Child) -> NodeTask {
    NodeTask { bounds: child.bounds, centroids: child.centroids, live: child.live, depth: parent.depth + 1 }
}

/// The left child's part of the parent's progress; the right child gets the rest, so that the sum is exact.
fn part_of(share: u64, left: &Child, right: &Child) -> u64 {
    (u128::from(share) * left.live as u128 / (left.live + right.live) as u128) as u64
}
