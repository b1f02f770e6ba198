use crate::geom::Aabb;

/// No leaf lies deeper than this (the root has depth 0), so a traversal that pushes one far child a level needs 64 slots.
pub const MAX_DEPTH: u32 = 64;

/// No leaf has more references than this, so that a count fits 8 bits.
pub const MAX_LEAF: u32 = 255;

/// One node of the file's `NODE` and `TNOD` sections: 32 bytes, two siblings a cache line.
///
/// `count == 0`: an inner node with children `first` and `first + 1`. Otherwise a leaf with references `first .. first + count`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Near corner of the box, which contains everything below the node.
    pub min: [f32; 3],
    /// Of an inner node its first child, which is even; of a leaf its first reference. Both count from the tree's own start.
    pub first: u32,
    /// Far corner of the box.
    pub max: [f32; 3],
    /// References of a leaf, 1 to 255; 0 for an inner node.
    pub count: u32,
}

const _: () = assert!(size_of::<Node>() == 32);

crate::pod::plain! {
    Node = [[f32; 3], u32, [f32; 3], u32];
}

impl Node {
    /// A leaf over references `first .. first + count`; a `count` of 0 would make it an inner node.
    #[inline]
    pub fn leaf(bounds: Aabb, first: u32, count: u32) -> Node {
        Node { min: bounds.min, first, max: bounds.max, count }
    }

    /// An inner node whose children are records `first_child` and `first_child + 1`.
    #[inline]
    pub fn inner(bounds: Aabb, first_child: u32) -> Node {
        Node { min: bounds.min, first: first_child, max: bounds.max, count: 0 }
    }

    /// Whether the node has references and no children.
    #[inline]
    pub fn is_leaf(&self) -> bool {
        self.count != 0
    }

    /// The box of everything below the node.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.min, max: self.max }
    }
}

/// The depth of the deepest leaf below record 0, in one forward pass, since children lie behind parents.
#[inline]
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
