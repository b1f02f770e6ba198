//! The top-down recursion: asks the strategy where to split, guarantees depth and leaf size, makes the leaves and lays
//! the nodes out in canonical order.
//!
//! Depth is designed, not hoped for. `d + levels(n) <= 64` holds at every node of depth `d` with `n` references, where
//! `levels(n)` is the height of a balanced subtree with full leaves. A strategy is asked only while a child as large as
//! its parent would still satisfy this; from there on the driver halves.

use super::output::{Branch, Piece};
use super::partition::halve;
use super::strategy::{Child, Decision, NodeTask, Strategy};
use crate::build::error::BuildError;
use crate::build::exec::Executor;
use crate::build::prim_ref::{PrimRef, PrimRefs};
use crate::build::progress::Progress;
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
    let driver = Driver {
        strategy,
        max_leaf: max_leaf.clamp(1, 255) as usize,
        exec,
        progress,
        cancelled: AtomicBool::new(false),
    };
    let task = NodeTask { bounds: input.bounds, centroids: input.centroids, live, depth: 0 };
    if exec.is_sequential() {
        let mut piece = Piece::for_refs(live);
        let pair = piece.reserve_pair();
        let root = driver.grow(task, &mut input.refs, &mut piece, share);
        return if driver.cancelled.into_inner() {
            Err(BuildError::Cancelled)
        } else {
            Ok(piece.into_tree(pair, root))
        };
    }
    let branch = exec.run(|| driver.fork(task, &mut input.refs, share));
    drop(input);
    if driver.cancelled.load(Ordering::Relaxed) {
        return Err(BuildError::Cancelled);
    }
    Ok(exec.run(|| branch.assemble(exec)))
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
        help: "Keep instances apart with --levels two, or allow fewer duplicates with --split-budget 1.",
    })
}

struct Driver<'a, S> {
    strategy: &'a S,
    max_leaf: usize,
    exec: &'a Executor,
    progress: &'a dyn Progress,
    /// Set once, never read back into the output: a cancelled build returns no tree.
    cancelled: AtomicBool,
}

impl<S: Strategy> Driver<'_, S> {
    /// The upper part of the tree, where the two sides are separate tasks.
    fn fork(&self, task: NodeTask, slots: &mut [PrimRef], share: u64) -> Branch {
        if task.live <= TASK {
            let mut piece = Piece::for_refs(task.live);
            let root = self.grow(task, slots, &mut piece, share);
            return Branch::Piece { root, piece };
        }
        let Some((left, right)) = self.split(&task, slots) else {
            let mut piece = Piece::default();
            let root = piece.leaf(task.bounds, &slots[..task.live]);
            self.progress.advance(share);
            return Branch::Piece { root, piece };
        };
        if self.is_cancelled() {
            return Branch::Piece { root: Node::leaf(task.bounds, 0, 1), piece: Piece::default() };
        }
        let (left_slots, right_slots) = slots.split_at_mut(left.slots);
        let left_share = part_of(share, &left, &right);
        let children = self.exec.join(
            || self.fork(child_task(&task, &left), left_slots, left_share),
            || self.fork(child_task(&task, &right), right_slots, share - left_share),
        );
        Branch::Fork { bounds: task.bounds, children: Box::new(children) }
    }

    /// A whole subtree, appended to `piece`; returns its root's record.
    fn grow(&self, task: NodeTask, slots: &mut [PrimRef], piece: &mut Piece, share: u64) -> Node {
        let large = task.live > TICK;
        if large && self.is_cancelled() {
            return Node::leaf(task.bounds, 0, 1);
        }
        let Some((left, right)) = self.split(&task, slots) else {
            let leaf = piece.leaf(task.bounds, &slots[..task.live]);
            if share > 0 {
                self.progress.advance(share);
            }
            return leaf;
        };
        let (left_slots, right_slots) = slots.split_at_mut(left.slots);
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
    fn split(&self, task: &NodeTask, slots: &mut [PrimRef]) -> Option<(Child, Child)> {
        if task.live == 1 {
            return None;
        }
        let may_ask = task.depth + 1 + self.levels(task.live) <= MAX_DEPTH;
        if may_ask && let Decision::Split { left, right } = self.strategy.split(task, slots, self.exec) {
            debug_assert!((1..=task.live).contains(&left.live) && (1..=task.live).contains(&right.live));
            debug_assert!(left.live <= left.slots && right.live <= right.slots);
            debug_assert_eq!(left.slots + right.slots, slots.len());
            return Some((left, right));
        }
        (task.live > self.max_leaf).then(|| halve(task, slots))
    }

    /// Height of a balanced subtree with full leaves: a leaf has 0.
    fn levels(&self, live: usize) -> u32 {
        live.div_ceil(self.max_leaf).next_power_of_two().trailing_zeros()
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
