use super::node::Node;
use super::records::{BlasRecord, GeomRecord, InstanceRecord, TriangleRecord};

/// A cache's content as borrowed slices: what traversal reads, whether it is mapped, decompressed or just built.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// All BLAS nodes, tree after tree; see [`BlasRecord::node_offset`].
    pub nodes: &'a [Node],
    /// All leaf-ordered triangles, tree after tree.
    pub triangles: &'a [TriangleRecord],
    /// The source parts, which [`TriangleRecord::geom`] indexes.
    pub geoms: &'a [GeomRecord],
    /// One record for each tree.
    pub blases: &'a [BlasRecord],
    /// Empty in a one-level file.
    pub tlas_nodes: &'a [Node],
    /// In the order of the TLAS's leaves; empty in a one-level file.
    pub instances: &'a [InstanceRecord],
}

/// One tree of a [`View`]: indices in `nodes` count from 0 into these slices.
#[derive(Clone, Copy, Debug)]
pub struct BlasView<'a> {
    /// The root first; empty for an empty tree.
    pub nodes: &'a [Node],
    /// In leaf order: a leaf with `first` and `count` names `triangles[first .. first + count]`.
    pub triangles: &'a [TriangleRecord],
}

impl<'a> View<'a> {
    /// The tree of BLAS `index`, or `None` where the index or the record's ranges do not fit the slices.
    #[inline]
    pub fn blas(&self, index: usize) -> Option<BlasView<'a>> {
        let record = self.blases.get(index)?;
        let range = |offset: u64, count: u32| {
            let start = usize::try_from(offset).ok()?;
            Some(start..start.checked_add(count as usize)?)
        };
        Some(BlasView {
            nodes: self.nodes.get(range(record.node_offset, record.node_count)?)?,
            triangles: self.triangles.get(range(record.ref_offset, record.ref_count)?)?,
        })
    }
}
