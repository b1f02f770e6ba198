use crate::geom::Aabb;

/// No leaf lies deeper than this (the root has depth 0), so a traversal that pushes one far child a level needs 64 slots.
pub const MAX_DEPTH: u32 = 64;

/// One node of the file's `NODE` and `TNOD` sections: 32 bytes, two siblings a cache line.
///
/// `count == 0`: an inner node with children `first` and `first + 1`. Otherwise a leaf with references `first .. first + count`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Node {
    pub min: [f32; 3],
    pub first: u32,
    pub max: [f32; 3],
    pub count: u32,
}

const _: () = assert!(size_of::<Node>() == 32);

impl Node {
    pub fn leaf(bounds: Aabb, first: u32, count: u32) -> Node {
        Node { min: bounds.min, first, max: bounds.max, count }
    }

    pub fn inner(bounds: Aabb, first_child: u32) -> Node {
        Node { min: bounds.min, first: first_child, max: bounds.max, count: 0 }
    }

    pub fn is_leaf(&self) -> bool {
        self.count != 0
    }

    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.min, max: self.max }
    }
}

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

/// The depth of the deepest leaf below record 0, in one forward pass, since children lie behind parents.
pub fn max_depth(nodes: &[Node]) -> u32 {
    let mut depth = vec![0u32; nodes.len()];
    let mut deepest = 0;
    for (i, node) in nodes.iter().enumerate() {
        if i == 1 {
            continue;
        }
        deepest = deepest.max(depth[i]);
        if !node.is_leaf() {
            let below = depth[i] + 1;
            // Records that are no tree, children out of range, count as no children.
            if let Some(pair) = depth.get_mut(node.first as usize..).and_then(|d| d.get_mut(..2)) {
                pair.fill(below);
            }
        }
    }
    deepest
}
