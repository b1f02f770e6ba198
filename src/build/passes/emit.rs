//! From the tree under change back to records in canonical order, with leaves in the place of subtrees where that is
//! cheaper.
//!
//! What is cheapest at a node follows from what is cheapest at its children, so one pass from the leaves upward finds the
//! best of all ways to cut the tree short (dynamic programming over the SAH, as in Wald, "On fast Construction of SAH-based
//! Bounding Volume Hierarchies", 2007, applied to a finished tree). Leaves that are joined hold a triangle once that
//! spatial splits had put into several of them.

use super::work_tree::WorkTree;
use crate::build::cost::Sah;
use crate::build::top_down::output::{Branch, Piece};
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::tree::{Node, Tree};

/// Levels from the root that are separate tasks, and the least height of a subtree that is. Constants, so that nothing
/// depends on the number of threads.
const FORKS: u32 = 10;
const FORK_HEIGHT: u8 = 8;

/// When subtrees become leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collapse {
    pub sah: Sah,
    /// Most references in a leaf.
    pub max_leaf: usize,
}

/// Lay the tree out; `refs` are those of the tree it was made from.
pub fn emit(tree: &WorkTree, refs: &[u32], collapse: Option<Collapse>, exec: &Executor) -> Tree {
    let emitter = Emitter { tree, refs, collapse, exec };
    exec.run(|| emitter.fork(0, 0).0.assemble(exec))
}

struct Emitter<'a> {
    tree: &'a WorkTree,
    refs: &'a [u32],
    collapse: Option<Collapse>,
    exec: &'a Executor,
}

impl Emitter<'_> {
    /// The subtree at a slot, and its cost; without collapse nobody asks for that.
    fn fork(&self, slot: u32, depth: u32) -> (Branch, f64) {
        let node = &self.tree.slots[slot as usize];
        if node.is_leaf() || depth >= FORKS || self.tree.height(slot) < FORK_HEIGHT {
            let mut piece = Piece::default();
            let (root, cost) = self.grow(slot, &mut piece, &mut Vec::new());
            return (Branch::Piece { root, piece }, cost);
        }
        let [left, right] = node.children();
        let ((left, a), (right, b)) = self.exec.join(|| self.fork(left, depth + 1), || self.fork(right, depth + 1));
        let bounds = node.lanes().aabb();
        let cost = self.collapse.map_or(0.0, |c| c.inner_cost(node.area)) + a + b;

        // A high subtree may yet have few references, and could be a leaf.
        match (left, right, &self.collapse) {
            (Branch::Piece { root: left, piece: a }, Branch::Piece { root: right, piece: b }, Some(collapse))
                if a.refs.len() + b.refs.len() <= collapse.most_refs() =>
            {
                let mut piece = Piece::default();
                let pair = piece.reserve_pair();
                let (left, right) = (piece.append(left, &a), piece.append(right, &b));
                piece.fill_pair(pair, left, right);
                let (root, cost) = collapse.cheaper((bounds, node.area), pair, 0, cost, &mut piece, &mut Vec::new());
                (Branch::Piece { root, piece }, cost)
            }
            (left, right, _) => (Branch::Fork { bounds, children: Box::new((left, right)) }, cost),
        }
    }

    /// Append what is below a slot, in canonical order; returns its record and cost. As deep as the tree, which
    /// [`MAX_DEPTH`](crate::tree::MAX_DEPTH) bounds.
    fn grow(&self, slot: u32, piece: &mut Piece, scratch: &mut Vec<u32>) -> (Node, f64) {
        let node = &self.tree.slots[slot as usize];
        let bounds = node.lanes().aabb();
        let first = piece.refs.len();
        if node.is_leaf() {
            let refs = &self.refs[self.tree.leaf_range(node)];
            piece.refs.extend_from_slice(refs);
            let cost = self.collapse.map_or(0.0, |c| c.leaf_cost(refs.len(), node.area));
            return (Node::leaf(bounds, first as u32, refs.len() as u32), cost);
        }
        let [left, right] = node.children();
        let pair = piece.reserve_pair();
        let (left, a) = self.grow(left, piece, scratch);
        let (right, b) = self.grow(right, piece, scratch);
        piece.fill_pair(pair, left, right);
        match &self.collapse {
            None => (Node::inner(bounds, pair), 0.0),
            Some(collapse) => {
                let cost = collapse.inner_cost(node.area) + a + b;
                collapse.cheaper((bounds, node.area), pair, first, cost, piece, scratch)
            }
        }
    }
}

impl Collapse {
    fn inner_cost(&self, area: f32) -> f64 {
        f64::from(self.sah.traversal) * f64::from(area)
    }

    fn leaf_cost(&self, count: usize, area: f32) -> f64 {
        f64::from(self.sah.intersection) * count as f64 * f64::from(area)
    }

    /// Of more references than this, too few would be duplicates.
    fn most_refs(&self) -> usize {
        4 * self.max_leaf
    }

    /// The subtree that ends the piece, its pairs from `pair` and its references from `first` on: one leaf in its place if
    /// that is no dearer, and as it is otherwise. Returns its record and cost.
    fn cheaper(
        &self,
        (bounds, area): (Aabb, f32),
        pair: u32,
        first: usize,
        cost: f64,
        piece: &mut Piece,
        scratch: &mut Vec<u32>,
    ) -> (Node, f64) {
        let as_it_is = (Node::inner(bounds, pair), cost);
        let refs = &piece.refs[first..];
        if refs.len() > self.most_refs() {
            return as_it_is;
        }
        scratch.clear();
        scratch.extend_from_slice(refs);
        scratch.sort_unstable();
        scratch.dedup();
        let leaf_cost = self.leaf_cost(scratch.len(), area);
        if scratch.len() > self.max_leaf || leaf_cost > cost {
            return as_it_is;
        }
        piece.nodes.truncate(pair as usize);
        piece.refs.truncate(first);
        piece.refs.extend_from_slice(scratch);
        (Node::leaf(bounds, first as u32, scratch.len() as u32), leaf_cost)
    }
}
