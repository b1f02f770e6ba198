use crate::geom::Aabb;
use bvhc_core::layout::{Node, max_depth};

/// A linear tree.
///
/// ```text
/// nodes  [ root | unused | pair | pair | … ]   a pair is two siblings; the pairs stand in depth-first preorder:
///                                              a pair, then the pairs below its first node, then those below its second
/// refs   [ leaf | leaf | leaf | … ]            leaves in the same order, tiling the list without hole or overlap
/// ```
///
/// Record 1 is all zero, so every pair starts at an even index and fills one 64-byte line. Children lie behind their
/// parent, hence no cycle. An empty tree has no nodes at all; a tree of one leaf has two records.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tree {
    /// The layout above; indices count from 0.
    pub nodes: Vec<Node>,
    /// For each slot of the leaf order the item that stands there: a triangle of the mesh, or an instance. With spatial
    /// splits the same item may stand in several leaves.
    pub refs: Vec<u32>,
}

impl Tree {
    /// The box of everything, or the empty box.
    pub fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, Node::bounds)
    }

    /// Nodes that are part of the tree: all records but the unused one.
    pub fn live_nodes(&self) -> usize {
        self.nodes.len().saturating_sub(1)
    }

    /// The deepest leaf's depth; 0 for a single leaf and for the empty tree.
    pub fn max_depth(&self) -> u32 {
        max_depth(&self.nodes)
    }
}
