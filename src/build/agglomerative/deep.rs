//! A tree of bounded depth from a forest that goes too deep.

use super::forest::{Forest, Merge};
use crate::build::binned::Binned;
use crate::build::prim_ref::{PrimRef, bounds_of};
use crate::build::progress::NoProgress;
use crate::build::recipe::options::{Axes, BuildOptions};
use crate::build::top_down::driver::{Driver, Limits};
use crate::build::top_down::output::Piece;
use crate::build::top_down::strategy::NodeTask;
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::tree::{MAX_DEPTH, Node, Tree};

/// Write the tree. Clustering is kept where it fits; what is below is built from the top down.
pub(super) fn emit(forest: &Forest, options: &BuildOptions, exec: &Executor) -> Tree {
    // The options of this method say nothing of bins.
    let strategy = Binned::new(&BuildOptions { axes: Axes::All, bins: 16, ..options.clone() });
    let limits = Limits { max_leaf: options.max_leaf, max_depth: MAX_DEPTH };
    let driver = Driver::new(&strategy, limits, exec, &NoProgress);
    let piece = Piece::for_refs(forest.refs.len());
    let below = survey(forest);
    let mut writer = Writer { forest, below, driver, limits, piece, open: Vec::new() };
    let pair = writer.piece.reserve_pair();
    let root = writer.grow(forest.root.number, 0);
    writer.piece.into_tree(pair, root)
}

/// What is below a merge.
#[derive(Clone, Copy)]
struct Below {
    bounds: Aabb,
    /// Longest way down to a leaf.
    height: u32,
}

/// What is below each merge, in their order.
fn survey(forest: &Forest) -> Vec<Below> {
    let mut below: Vec<Below> = Vec::with_capacity(forest.merges.len());
    for merge in &forest.merges {
        // Children stand before their parents.
        let of = |child: u32| match forest.refs.get(child as usize) {
            Some(r) => Below { bounds: r.bounds(), height: 0 },
            None => below[child as usize - forest.refs.len()],
        };
        let [a, b] = merge.children.map(of);
        let height = if merge.inner == 0 { 0 } else { a.height.max(b.height) + 1 };
        below.push(Below { bounds: a.bounds.union(b.bounds), height });
    }
    below
}

struct Writer<'a> {
    forest: &'a Forest<'a>,
    below: Vec<Below>,
    driver: Driver<'a, Binned>,
    limits: Limits,
    piece: Piece,
    /// Scratch: clusters that are still to be opened.
    open: Vec<u32>,
}

impl Writer<'_> {
    /// Append a whole subtree; returns its root's record. As deep as the tree, which [`MAX_DEPTH`] bounds.
    fn grow(&mut self, cluster: u32, depth: u32) -> Node {
        let Some((merge, below)) = self.merge(cluster) else {
            let r = &self.forest.refs[cluster as usize];
            return self.piece.leaf(r.bounds(), std::iter::once(r.prim));
        };
        if merge.inner == 0 {
            let refs = self.refs_below(cluster, merge);
            return self.piece.leaf(below.bounds, refs.iter().map(|r| r.prim));
        }
        if !self.children_fit(merge, depth) {
            return self.rebuild(cluster, merge, depth);
        }
        let pair = self.piece.reserve_pair();
        let [first, second] = merge.children.map(|child| self.grow(child, depth + 1));
        self.piece.fill_pair(pair, first, second);
        Node::inner(below.bounds, pair)
    }

    fn merge(&self, cluster: u32) -> Option<(Merge, Below)> {
        Some((*self.forest.merge(cluster)?, self.below[cluster as usize - self.forest.refs.len()]))
    }

    /// Clustering is kept as long as what lies below still fits, at worst as a balanced tree with full leaves. So
    /// `depth + min(height, levels(count)) <= MAX_DEPTH` holds at every cluster that is asked about.
    fn children_fit(&self, merge: Merge, depth: u32) -> bool {
        let height = |child: u32| {
            self.merge(child).map_or(0, |(merge, below)| below.height.min(self.limits.levels(merge.count as usize)))
        };
        merge.children.into_iter().all(|child| depth + 1 + height(child) <= MAX_DEPTH)
    }

    /// Build what is below from the top down, by a driver that keeps to the depth.
    fn rebuild(&mut self, cluster: u32, merge: Merge, depth: u32) -> Node {
        let mut refs = self.refs_below(cluster, merge);
        let (bounds, centroids) = bounds_of(&refs);
        let task = NodeTask { bounds, centroids, live: refs.len(), depth };
        self.driver.grow(task, refs.as_mut_slice(), &mut self.piece, 0)
    }

    /// The first child's before the second's.
    fn refs_below(&mut self, cluster: u32, merge: Merge) -> Vec<PrimRef> {
        let mut refs = Vec::with_capacity(merge.count as usize);
        self.open.push(cluster);
        while let Some(cluster) = self.open.pop() {
            match self.forest.merge(cluster) {
                Some(merge) => self.open.extend(merge.children.into_iter().rev()),
                None => refs.push(self.forest.refs[cluster as usize]),
            }
        }
        refs
    }
}
