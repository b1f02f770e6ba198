use super::block::TriangleBlock;
use super::record::WideRecord;
use crate::layout::{TriangleRecord, View, WideNode, WideRow};

/// A scene with wide trees, as borrowed slices: what rays are traced through.
#[derive(Clone, Copy, Debug)]
pub struct WideView<'a, const N: usize, T = WideNode<N>> {
    /// The scene: triangles, rows of trees, and the tree over the instances, which stays binary.
    pub view: View<'a>,
    /// The wide nodes of all trees.
    pub nodes: &'a [T],
    /// One row for each tree.
    pub rows: &'a [WideRow],
    /// The triangle of the tree that each reference of a leaf is: [`WideTrees::order`](super::WideTrees::order) or
    /// [`CompactTrees::order`](super::CompactTrees::order).
    pub order: &'a [u32],
    /// Of [`WideTrees`](super::WideTrees) the triangles behind each four references; empty for others.
    pub blocks: &'a [TriangleBlock],
}

/// One wide tree.
pub struct WideTree<'a, T> {
    pub nodes: &'a [T],
    pub triangles: &'a [TriangleRecord],
    /// The triangle of each reference that the leaves may name.
    pub order: &'a [u32],
    pub blocks: &'a [TriangleBlock],
}

impl<'a, const N: usize, T: WideRecord<N>> WideView<'a, N, T> {
    /// One tree, over the triangles of the view from `first_triangle` on; `None` where its row leads out of the records.
    #[inline(always)]
    pub(super) fn tree(
        &self,
        blas: usize,
        first_triangle: usize,
        triangles: &'a [TriangleRecord],
    ) -> Option<WideTree<'a, T>> {
        let row = self.rows.get(blas)?;
        let start = usize::try_from(row.node_offset).ok()?;
        let nodes = self.nodes.get(start..start.checked_add(row.node_count as usize)?)?;
        // References in blocks are counted over all trees.
        let order = match T::IN_BLOCKS {
            true => self.order,
            false => self.order.get(first_triangle..first_triangle.checked_add(triangles.len())?)?,
        };
        Some(WideTree { nodes, triangles, order, blocks: self.blocks })
    }
}
