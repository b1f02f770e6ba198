//! What ends a walk over records that nobody checked, and keeps it inside them: one definition, for rays and for other queries.

use super::hit::Malformed;
use crate::layout::{MAX_LEAF, Node};

/// The records of one tree during one walk, and how much of them is left to enter.
///
/// A tree enters each pair of siblings at most once, so more entries than pairs betray a record with two parents or a cycle, and more items
/// than there are, leaves that overlap. A walk that takes every record from here therefore ends on every input.
pub struct Bounds<'a, T, N = Node> {
    nodes: &'a [N],
    items: &'a [T],
    /// How often a walk may still enter a node: once for each that has children.
    entries_left: usize,
    items_left: usize,
}

impl<'a, T> Bounds<'a, T> {
    #[inline(always)]
    pub fn new(nodes: &'a [Node], items: &'a [T]) -> Bounds<'a, T> {
        Bounds { nodes, items, entries_left: nodes.len() / 2, items_left: items.len() }
    }

    /// A node by its number.
    #[inline(always)]
    pub fn node(&self, index: u32) -> Result<&'a Node, Malformed> {
        let Some(node) = self.nodes.get(index as usize) else {
            return Err(child_out_of_range(index, self.nodes.len()));
        };
        Ok(node)
    }

    /// The children of an inner node, which is entered by this.
    #[inline(always)]
    pub fn enter(&mut self, first: u32) -> Result<&'a [Node; 2], Malformed> {
        let Some(pair) = self.nodes.get(first as usize..).and_then(|n| n.first_chunk::<2>()) else {
            return Err(child_out_of_range(first, self.nodes.len()));
        };
        self.count_entry()?;
        Ok(pair)
    }
}

impl<'a, T, N> Bounds<'a, T, N> {
    /// Those of a wide tree, whose every record is a node that may be entered.
    #[inline(always)]
    pub fn of_wide(nodes: &'a [N], items: &'a [T]) -> Bounds<'a, T, N> {
        Bounds { nodes, items, entries_left: nodes.len(), items_left: items.len() }
    }

    /// A node of a wide tree by its number, which is entered by this.
    #[inline(always)]
    pub fn enter_wide(&mut self, index: u32) -> Result<&'a N, Malformed> {
        let Some(node) = self.nodes.get(index as usize) else {
            return Err(child_out_of_range(index, self.nodes.len()));
        };
        self.count_entry()?;
        Ok(node)
    }

    #[inline(always)]
    fn count_entry(&mut self) -> Result<(), Malformed> {
        if self.entries_left == 0 {
            return Err(not_a_tree(self.nodes.len()));
        }
        self.entries_left -= 1;
        Ok(())
    }

    /// The items of a leaf.
    #[inline(always)]
    pub fn leaf(&mut self, first: u32, count: u32) -> Result<&'a [T], Malformed> {
        let items = self.items.get(first as usize..).and_then(|i| i.get(..count as usize));
        let Some(items) = items.filter(|_| count <= MAX_LEAF) else {
            return Err(leaf_out_of_range(first, count, self.items.len()));
        };
        self.count_items(items.len())?;
        Ok(items)
    }

    /// So many items are in the leaf that the walk has come to.
    #[inline(always)]
    pub fn count_items(&mut self, count: usize) -> Result<(), Malformed> {
        if count > self.items_left {
            return Err(not_a_tree(self.nodes.len()));
        }
        self.items_left -= count;
        Ok(())
    }
}

#[cold]
fn child_out_of_range(first: u32, nodes: usize) -> Malformed {
    Malformed::ChildOutOfRange { first, nodes }
}

#[cold]
fn leaf_out_of_range(first: u32, count: u32, refs: usize) -> Malformed {
    Malformed::LeafOutOfRange { first, count, refs }
}

#[cold]
fn not_a_tree(nodes: usize) -> Malformed {
    Malformed::NotATree { nodes }
}
