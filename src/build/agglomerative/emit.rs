//! From merges to a tree in canonical order, of bounded depth.

use super::rounds::{Forest, Merge};
use crate::build::binned::Binned;
use crate::build::error::BuildError;
use crate::build::exec::Executor;
use crate::build::prim_ref::PrimRef;
use crate::build::progress::NoProgress;
use crate::build::recipe::options::{Axes, BuildOptions};
use crate::build::top_down::driver::{Driver, Limits};
use crate::build::top_down::output::{Branch, Grown, Piece};
use crate::build::top_down::partition::bounds_of;
use crate::build::top_down::strategy::NodeTask;
use crate::tree::{MAX_DEPTH, Node, Tree};

/// Below this many references a subtree is one task. A constant, so that nothing depends on the number of threads.
const TASK: u32 = 1 << 11;

/// Write the tree. `refs` are the references in the order that the forest numbers them in.
pub(super) fn emit(
    refs: &[PrimRef],
    forest: &Forest,
    options: &BuildOptions,
    exec: &Executor,
) -> Result<Tree, BuildError> {
    // Only where clustering goes too deep: the options of this method say nothing of bins.
    let strategy = Binned::new(&BuildOptions { axes: Axes::All, bins: 16, ..options.clone() });
    let limits = Limits { max_leaf: options.max_leaf, max_depth: MAX_DEPTH };
    let emitter = Emitter { refs, forest, exec, driver: Driver::new(&strategy, limits, exec, &NoProgress), limits };
    let root = (refs.len() + forest.merges.len() - 1) as u32;
    let grown = if exec.is_sequential() {
        let mut writer = Writer { piece: Piece::for_refs(refs.len()), ..Writer::default() };
        let pair = writer.piece.reserve_pair();
        let root = emitter.grow(root, 0, &mut writer);
        Grown::Whole { pair, root, piece: writer.piece }
    } else {
        Grown::Parts(exec.run(|| emitter.fork(root, 0)))
    };
    Ok(grown.into_tree(exec))
}

struct Emitter<'a> {
    refs: &'a [PrimRef],
    forest: &'a Forest,
    exec: &'a Executor,
    driver: Driver<'a, Binned>,
    limits: Limits,
}

/// A part of the tree while it grows.
#[derive(Default)]
struct Writer {
    piece: Piece,
    /// Scratch: clusters of a leaf that are still to be opened.
    open: Vec<u32>,
    prims: Vec<u32>,
}

impl Emitter<'_> {
    /// `None` for a reference.
    fn merge(&self, cluster: u32) -> Option<&Merge> {
        self.forest.merges.get((cluster as usize).checked_sub(self.refs.len())?)
    }

    /// The upper part of the tree, where the two sides are separate tasks.
    fn fork(&self, cluster: u32, depth: u32) -> Branch {
        match self.merge(cluster) {
            Some(merge) if merge.count > TASK && merge.height > 0 && self.children_fit(merge, depth) => {
                let [a, b] = merge.children;
                let children = self.exec.join(|| self.fork(a, depth + 1), || self.fork(b, depth + 1));
                Branch::Fork { bounds: merge.bounds, children: Box::new(children) }
            }
            _ => {
                let mut writer = Writer::default();
                let root = self.grow(cluster, depth, &mut writer);
                Branch::Piece { root, piece: writer.piece }
            }
        }
    }

    /// Append a whole subtree; returns its root's record. As deep as the tree, which [`MAX_DEPTH`] bounds.
    fn grow(&self, cluster: u32, depth: u32, writer: &mut Writer) -> Node {
        let Some(merge) = self.merge(cluster) else {
            let r = &self.refs[cluster as usize];
            return writer.piece.leaf(r.bounds(), std::iter::once(r.prim));
        };
        if merge.height == 0 {
            writer.prims.clear();
            let Writer { open, prims, .. } = writer;
            self.for_each_below(cluster, open, |r| prims.push(r.prim));
            return writer.piece.leaf(merge.bounds, writer.prims.drain(..));
        }
        if !self.children_fit(merge, depth) {
            return self.rebuild(cluster, merge, depth, writer);
        }
        let pair = writer.piece.reserve_pair();
        let [first, second] = merge.children.map(|child| self.grow(child, depth + 1, writer));
        writer.piece.fill_pair(pair, first, second);
        Node::inner(merge.bounds, pair)
    }

    /// Clustering is kept as long as what lies below still fits, at worst as a balanced tree with full leaves. So
    /// `depth + min(height, levels(count)) <= MAX_DEPTH` holds at every cluster that is asked about.
    fn children_fit(&self, merge: &Merge, depth: u32) -> bool {
        let height = |child: u32| self.merge(child).map_or(0, |m| m.height.min(self.limits.levels(m.count as usize)));
        merge.children.into_iter().all(|child| depth + 1 + height(child) <= MAX_DEPTH)
    }

    /// Build what is below from the top down, by a driver that keeps to the depth.
    fn rebuild(&self, cluster: u32, merge: &Merge, depth: u32, writer: &mut Writer) -> Node {
        let mut refs = Vec::with_capacity(merge.count as usize);
        self.for_each_below(cluster, &mut writer.open, |r| refs.push(*r));
        let (bounds, centroids) = bounds_of(&refs);
        let task = NodeTask { bounds, centroids, live: refs.len(), depth };
        self.driver.grow(task, refs.as_mut_slice(), &mut writer.piece, 0)
    }

    fn for_each_below(&self, cluster: u32, open: &mut Vec<u32>, mut f: impl FnMut(&PrimRef)) {
        open.clear();
        open.push(cluster);
        while let Some(cluster) = open.pop() {
            match self.merge(cluster) {
                Some(merge) => open.extend(merge.children.into_iter().rev()),
                None => f(&self.refs[cluster as usize]),
            }
        }
    }
}
