//! A node of a wide tree, and what a file says of each tree.

use crate::geom::Aabb;

/// A node of up to `N` children, 4 or 8, with the boxes of the children: a row of `N` floats for each plane, so that a ray meets all of them at
/// once. 128 bytes for 4 and 256 for 8.
///
/// The children stand in the first lanes, in the order of what is below them. A lane that nobody uses has the empty box, and 0 in `first` and `count`.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WideNode<const N: usize> {
    /// The near planes of the children's boxes on the axes x, y and z, then the far ones.
    pub planes: [[f32; N]; 6],
    /// Of a child that is a node the number of its record, which is never 0; of a leaf its first reference. Both count from the tree's own start.
    pub first: [u32; N],
    /// References of a leaf, 1 to 255; 0 for a node.
    pub count: [u32; N],
}

const _: () = assert!(size_of::<WideNode<4>>() == 128 && size_of::<WideNode<8>>() == 256);

/// One wide tree among all, 16 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WideRow {
    /// First of its nodes, which is the root.
    pub node_offset: u64,
    /// How many nodes it has; 0 for a tree without triangles.
    pub node_count: u32,
    /// The most children that wait to be entered at once, those of the node that is being entered included.
    pub waiting: u32,
}

const _: () = assert!(size_of::<WideRow>() == 16);

crate::pod::plain! {
    WideRow = [u64, [u32; 2]];
    WideNode<4> = [[[f32; 4]; 6], [[u32; 4]; 2]];
    WideNode<8> = [[[f32; 8]; 6], [[u32; 8]; 2]];
}

impl<const N: usize> WideNode<N> {
    /// A node without children.
    pub const EMPTY: WideNode<N> = {
        let (low, high) = ([f32::INFINITY; N], [f32::NEG_INFINITY; N]);
        WideNode { planes: [low, low, low, high, high, high], first: [0; N], count: [0; N] }
    };

    /// Put a child into a lane: a node if `count` is 0, otherwise a leaf.
    pub fn set(&mut self, lane: usize, bounds: &Aabb, first: u32, count: u32) {
        for (axis, (low, high)) in bounds.min.into_iter().zip(bounds.max).enumerate() {
            self.planes[axis][lane] = low;
            self.planes[axis + 3][lane] = high;
        }
        (self.first[lane], self.count[lane]) = (first, count);
    }

    /// Whether a child stands in the lane.
    #[inline(always)]
    pub fn has(&self, lane: usize) -> bool {
        self.first[lane] | self.count[lane] != 0
    }

    /// The box of the child in a lane.
    pub fn bounds(&self, lane: usize) -> Aabb {
        let corner = |from: usize| [0, 1, 2].map(|axis| self.planes[from + axis][lane]);
        Aabb { min: corner(0), max: corner(3) }
    }

    /// How many children the node has.
    pub fn children(&self) -> usize {
        (0..N).filter(|lane| self.has(*lane)).count()
    }
}
