//! A walk over the nodes of one tree, for queries that are no rays: boxes, spheres, nearest points.

use super::bounds::Bounds;
use super::hit::Malformed;
use crate::layout::{BlasView, MAX_DEPTH, Node, TriangleRecord, View};

/// A node as a walk comes to it.
#[derive(Clone, Copy, Debug)]
pub struct Visit<'a> {
    /// Number of the node's record, counted from the tree's own start.
    pub index: usize,
    /// The record: its box, and what it is.
    pub node: &'a Node,
    /// The root has depth 0.
    pub depth: u32,
    /// The triangles of a leaf; empty for an inner node. The first is number `ref_offset + node.first` in the file's `TRIS`, with `ref_offset`
    /// of the tree's row in `BLAS`: so are its vertices in `VERT`.
    pub triangles: &'a [TriangleRecord],
}

/// How a walk goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Step {
    /// To the children, if the node has any.
    Descend,
    /// Past everything below this node.
    Skip,
    /// Nowhere: the walk ends.
    Stop,
}

impl<'a> BlasView<'a> {
    /// Walk the tree from its root, a parent before its children and the first child before the second. `see` decides after each node how
    /// the walk goes on.
    ///
    /// Returns whether `see` stopped the walk. An empty tree has no node to visit. Memory is constant and the walk ends on every input, by
    /// the bounds that hold for rays: each pair of children is entered once, each triangle seen once, and `depth` is at most 64.
    ///
    /// ```
    /// use bvhc_core::layout::View;
    /// use bvhc_core::trace::Step;
    ///
    /// /// How many triangles lie in leaves that a box meets.
    /// fn near(view: &View<'_>, query: &bvhc_core::geom::Aabb) -> Result<usize, bvhc_core::trace::Malformed> {
    ///     let mut count = 0;
    ///     for tree in view.trees() {
    ///         tree?.visit(|at| {
    ///             count += at.triangles.len();
    ///             if at.node.bounds().overlaps(query) { Step::Descend } else { Step::Skip }
    ///         })?;
    ///     }
    ///     Ok(count)
    /// }
    /// ```
    ///
    /// # Errors
    /// Where the records are no tree. A file that was opened at [`Validation::Tree`](crate::cache::Validation::Tree) has none such.
    pub fn visit(&self, mut see: impl FnMut(Visit<'a>) -> Step) -> Result<bool, Malformed> {
        walk(self.nodes, self.triangles, |index, node, depth, triangles| {
            Ok(see(Visit { index, node, depth, triangles }))
        })
    }
}

/// Walk any tree from its root: `see` gets each node's number, the node, its depth, and a leaf's items.
pub(super) fn walk<'a, T>(
    nodes: &'a [Node],
    items: &'a [T],
    mut see: impl FnMut(usize, &'a Node, u32, &'a [T]) -> Result<Step, Malformed>,
) -> Result<bool, Malformed> {
    let Some(mut node) = nodes.first() else { return Ok(false) };
    // A second child waits for each level that the walk is below the root.
    let mut waiting = [(0u32, 0u32); MAX_DEPTH as usize + 1];
    let mut bounds = Bounds::new(nodes, items);
    let mut count = 0;
    let (mut index, mut depth) = (0u32, 0u32);
    loop {
        let found = if node.is_leaf() { bounds.leaf(node.first, node.count)? } else { &[] };
        match see(index as usize, node, depth, found)? {
            Step::Stop => return Ok(true),
            Step::Descend if !node.is_leaf() => {
                let pair = bounds.enter(node.first)?;
                if depth >= MAX_DEPTH {
                    return Err(Malformed::TooDeep);
                }
                depth += 1;
                waiting[count] = (node.first + 1, depth);
                count += 1;
                (index, node) = (node.first, &pair[0]);
                continue;
            }
            Step::Descend | Step::Skip => {}
        }
        if count == 0 {
            return Ok(false);
        }
        count -= 1;
        (index, depth) = waiting[count];
        node = bounds.node(index)?;
    }
}

impl<'a> View<'a> {
    /// The trees over triangles, in the order of their numbers: an error in the place of one whose row of `BLAS` leads out of the records,
    /// which no file has that was opened at [`Validation::Tree`](crate::cache::Validation::Tree).
    ///
    /// With two levels each is in its mesh's own space, and instances place it: a query in world space takes [`View::visit`].
    pub fn trees(&self) -> impl Iterator<Item = Result<BlasView<'a>, Malformed>> {
        let view = *self;
        (0..view.blases.len()).map(move |tree| view.blas(tree).ok_or(Malformed::TreeOutOfRange { tree }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::BlasRecord;
    use bytemuck::Zeroable;

    /// A root over two leaves of one triangle each.
    fn small() -> ([Node; 4], [TriangleRecord; 2]) {
        let leaf = |x: f32, first| Node { min: [x, 0.0, 0.0], first, max: [x + 1.0, 1.0, 1.0], count: 1 };
        let root = Node { min: [0.0; 3], first: 2, max: [3.0, 1.0, 1.0], count: 0 };
        ([root, Node::zeroed(), leaf(0.0, 0), leaf(2.0, 1)], [TriangleRecord::zeroed(); 2])
    }

    #[test]
    fn parents_come_before_children_and_skipped_nodes_hide_theirs() {
        let (nodes, triangles) = small();
        let tree = BlasView { nodes: &nodes, triangles: &triangles };
        let mut seen = Vec::new();
        let stopped = tree.visit(|at| {
            seen.push((at.index, at.depth, at.triangles.len()));
            Step::Descend
        });
        assert_eq!((stopped, seen), (Ok(false), vec![(0, 0, 0), (2, 1, 1), (3, 1, 1)]));
        let mut count = 0;
        let walk = |step| tree.visit(|_| step);
        assert_eq!((walk(Step::Skip), walk(Step::Stop)), (Ok(false), Ok(true)));
        tree.visit(|_| {
            count += 1;
            Step::Skip
        })
        .unwrap();
        assert_eq!(count, 1);
        assert_eq!(BlasView { nodes: &[], triangles: &[] }.visit(|_| Step::Descend), Ok(false));
    }

    #[test]
    fn records_that_are_no_tree_end_in_an_error() {
        let (nodes, triangles) = small();
        let broken = |change: &dyn Fn(&mut [Node; 4])| {
            let mut nodes = nodes;
            change(&mut nodes);
            BlasView { nodes: &nodes, triangles: &triangles }.visit(|_| Step::Descend).unwrap_err()
        };
        assert_eq!(broken(&|n| n[0].first = 3), Malformed::ChildOutOfRange { first: 3, nodes: 4 });
        assert_eq!(broken(&|n| n[0].first = u32::MAX), Malformed::ChildOutOfRange { first: u32::MAX, nodes: 4 });
        assert_eq!(broken(&|n| n[3].first = 2), Malformed::LeafOutOfRange { first: 2, count: 1, refs: 2 });
        assert_eq!(broken(&|n| n[3].count = 256), Malformed::LeafOutOfRange { first: 1, count: 256, refs: 2 });
        // Leaves that overlap would show a triangle several times.
        assert_eq!(broken(&|n| (n[2].count, n[3].first) = (2, 0)), Malformed::NotATree { nodes: 4 });
        let loops = broken(&|n| n[2] = Node { count: 0, first: 2, ..n[2] });
        assert!(matches!(loops, Malformed::TooDeep | Malformed::NotATree { .. }), "{loops:?}");
    }

    #[test]
    fn a_tree_that_leads_nowhere_is_told_in_its_place() {
        let (nodes, triangles) = small();
        let row = BlasRecord { node_count: 4, ref_count: 2, ..BlasRecord::zeroed() };
        let blases = [row, BlasRecord { ref_offset: 1, ..row }, row];
        let view =
            View { nodes: &nodes, triangles: &triangles, geoms: &[], blases: &blases, tlas_nodes: &[], instances: &[] };
        let found: Vec<_> = view.trees().map(|tree| tree.map(|tree| tree.triangles.len())).collect();
        assert_eq!(found, [Ok(2), Err(Malformed::TreeOutOfRange { tree: 1 }), Ok(2)]);
    }
}
