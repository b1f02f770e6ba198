//! Where a walk takes its nodes and items from: the records of a file as they lie, or what lies between those of two frames.

use std::borrow::Borrow;

use super::bounds::Bounds;
use super::hit::Malformed;
use crate::layout::{BlasView, Node, TriangleRecord};

/// The nodes of one tree and what its leaves hold, during one walk. It ends the walk on every input, as [`Bounds`] does.
pub trait Source {
    /// A node with its box.
    type Node: Borrow<Node>;
    /// Two siblings with their boxes.
    type Pair: Borrow<[Node; 2]>;
    /// What a leaf holds.
    type Items;

    /// `None` for an empty tree.
    fn root(&self) -> Option<Self::Node>;
    /// `first` and `count` of a node.
    fn links(&self, index: u32) -> Result<(u32, u32), Malformed>;
    /// The children of an inner node, which is entered by this.
    fn enter(&mut self, first: u32) -> Result<Self::Pair, Malformed>;
    /// The items of a leaf.
    fn leaf(&mut self, first: u32, count: u32) -> Result<Self::Items, Malformed>;
}

/// The records as they lie.
impl<'a, T> Source for Bounds<'a, T> {
    type Node = &'a Node;
    type Pair = &'a [Node; 2];
    type Items = &'a [T];

    #[inline(always)]
    fn root(&self) -> Option<&'a Node> {
        self.nodes().first()
    }

    #[inline(always)]
    fn links(&self, index: u32) -> Result<(u32, u32), Malformed> {
        let node = self.node(index)?;
        Ok((node.first, node.count))
    }

    #[inline(always)]
    fn enter(&mut self, first: u32) -> Result<&'a [Node; 2], Malformed> {
        Bounds::enter(self, first)
    }

    #[inline(always)]
    fn leaf(&mut self, first: u32, count: u32) -> Result<&'a [T], Malformed> {
        Bounds::leaf(self, first, count)
    }
}

/// A tree over triangles, ready for a walk.
pub trait Triangles {
    /// What a walk takes its nodes and triangles from.
    type Walk: Source<Items: IntoIterator<Item: Borrow<TriangleRecord>>>;

    /// At the start of a walk.
    fn walk(&self) -> Self::Walk;
}

impl<'a> Triangles for BlasView<'a> {
    type Walk = Bounds<'a, TriangleRecord>;

    #[inline(always)]
    fn walk(&self) -> Bounds<'a, TriangleRecord> {
        Bounds::new(self.nodes, self.triangles)
    }
}
