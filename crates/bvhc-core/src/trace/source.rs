//! Where a walk takes its nodes and items from: the records of a file as they lie, or what lies between those of two frames.

use std::borrow::Borrow;

use super::bounds::Bounds;
use super::hit::Malformed;
use crate::layout::Node;

/// A tree that can be walked.
pub trait Tree {
    /// A node with its box.
    type Node: Borrow<Node>;
    /// What a walk takes everything from.
    type Source: Source;

    /// `None` for an empty tree.
    fn root(&self) -> Option<Self::Node>;
    /// At the start of a walk.
    fn source(&self) -> Self::Source;
}

/// The nodes of one tree and what its leaves hold, during one walk. It ends the walk on every input, as [`Bounds`] does.
pub trait Source {
    /// Two siblings with their boxes.
    type Pair: Borrow<[Node; 2]>;
    /// What a leaf holds.
    type Items;

    /// `first` and `count` of a node.
    fn links(&self, index: u32) -> Result<(u32, u32), Malformed>;
    /// The children of an inner node, which is entered by this.
    fn enter(&mut self, first: u32) -> Result<Self::Pair, Malformed>;
    /// The items of a leaf.
    fn leaf(&mut self, first: u32, count: u32) -> Result<Self::Items, Malformed>;
}

/// Records as they lie.
pub struct Records<'a, T> {
    pub nodes: &'a [Node],
    pub items: &'a [T],
}

impl<'a, T> Tree for Records<'a, T> {
    type Node = &'a Node;
    type Source = Bounds<'a, T>;

    #[inline(always)]
    fn root(&self) -> Option<&'a Node> {
        self.nodes.first()
    }

    #[inline(always)]
    fn source(&self) -> Bounds<'a, T> {
        Bounds::new(self.nodes, self.items)
    }
}

impl<'a, T> Source for Bounds<'a, T> {
    type Pair = &'a [Node; 2];
    type Items = &'a [T];

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
