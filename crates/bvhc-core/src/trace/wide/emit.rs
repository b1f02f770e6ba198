//! The nodes of a wide tree, as a plan has them.

use super::plan::Plan;
#[cfg(any(test, feature = "testing"))]
use super::plan::area;
use crate::layout::{BlasView, Node, WideNode};
#[cfg(any(test, feature = "testing"))]
use crate::trace::{hit::Malformed, visit::Step};

/// Something that says which nodes below one become its children.
pub trait Shape {
    /// Whether the node becomes a leaf, with all below it.
    fn is_leaf(&self, node: u32) -> bool;
    /// Put the children of a node of its own into `lanes`, in the order of what is below them, and say how many they are.
    fn children<const N: usize>(&self, nodes: &[Node], node: u32, lanes: &mut [u32; N]) -> usize;
}

impl Shape for Plan {
    fn is_leaf(&self, node: u32) -> bool {
        Plan::is_leaf(self, node)
    }

    fn children<const N: usize>(&self, nodes: &[Node], node: u32, lanes: &mut [u32; N]) -> usize {
        let mut count = 0;
        // The right ones wait. A leaf has one lane, so whoever shares lanes has children.
        let (mut waiting, mut height) = ([(0, 0); N], 0);
        let mut next = (node, N);
        loop {
            while let Some([left, right]) = self.split(next.0, next.1).filter(|_| next.1 > 1) {
                let first = nodes[next.0 as usize].first;
                waiting[height] = (first + 1, right);
                height += 1;
                next = (first, left);
            }
            lanes[count] = next.0;
            count += 1;
            if height == 0 {
                return count;
            }
            height -= 1;
            next = waiting[height];
        }
    }
}

/// What other libraries do: the child of largest area is replaced by its own children until all lanes are full. Leaves stay what they are.
#[cfg(any(test, feature = "testing"))]
pub struct Greedy<'a>(&'a [Node]);

#[cfg(any(test, feature = "testing"))]
impl<'a> Greedy<'a> {
    pub fn new(tree: &BlasView<'a>) -> Result<Greedy<'a>, Malformed> {
        tree.visit(|_| Step::Descend)?;
        Ok(Greedy(tree.nodes))
    }
}

#[cfg(any(test, feature = "testing"))]
impl Shape for Greedy<'_> {
    fn is_leaf(&self, node: u32) -> bool {
        self.0[node as usize].is_leaf()
    }

    fn children<const N: usize>(&self, nodes: &[Node], node: u32, lanes: &mut [u32; N]) -> usize {
        let first = nodes[node as usize].first;
        (lanes[0], lanes[1]) = (first, first + 1);
        let mut count = 2;
        while count < N {
            let inner = (0..count).filter(|lane| !nodes[lanes[*lane] as usize].is_leaf());
            let largest = inner.reduce(|a, b| {
                let [x, y] = [a, b].map(|lane| area(&nodes[lanes[lane] as usize]));
                if y > x { b } else { a }
            });
            let Some(lane) = largest else { break };
            let first = nodes[lanes[lane] as usize].first;
            lanes.copy_within(lane + 1..count, lane + 2);
            (lanes[lane], lanes[lane + 1]) = (first, first + 1);
            count += 1;
        }
        count
    }
}

/// The nodes of one tree behind `out`, each before those below it, and the most children that wait at once while one is entered.
///
/// `tree` was walked without an error.
pub fn emit<const N: usize>(tree: &BlasView<'_>, shape: &impl Shape, out: &mut Vec<WideNode<N>>) -> u32 {
    let nodes = tree.nodes;
    let start = out.len();
    let Some(root) = nodes.first() else { return 0 };
    if shape.is_leaf(0) {
        let mut only = WideNode::EMPTY;
        let [first, end] = refs_below(nodes, 0);
        only.set(0, &root.bounds(), first, end - first);
        out.push(only);
        return 1;
    }
    // A node, where its parent names it, and how many children wait beside it or above.
    let mut pending = vec![(0, None::<(usize, usize)>, 0)];
    let mut most = 0;
    while let Some((node, named_by, waiting)) = pending.pop() {
        let index = out.len();
        if let Some((parent, lane)) = named_by {
            let parent: &mut WideNode<N> = &mut out[parent];
            parent.first[lane] = (index - start) as u32;
        }
        let mut wide = WideNode::EMPTY;
        let mut lanes = [0; N];
        let count = shape.children(nodes, node, &mut lanes);
        most = most.max(waiting + count as u32);
        for (lane, &child) in lanes[..count].iter().enumerate().rev() {
            let bounds = nodes[child as usize].bounds();
            if shape.is_leaf(child) {
                let [first, end] = refs_below(nodes, child);
                wide.set(lane, &bounds, first, end - first);
            } else {
                wide.set(lane, &bounds, 0, 0);
                pending.push((child, Some((index, lane)), waiting + count as u32 - 1));
            }
        }
        out.push(wide);
    }
    most
}

/// From the first reference below a node to behind the last one, which are consecutive.
fn refs_below(nodes: &[Node], node: u32) -> [u32; 2] {
    let leaf_at = |side: u32| {
        let mut node = &nodes[node as usize];
        while !node.is_leaf() {
            node = &nodes[(node.first + side) as usize];
        }
        node
    };
    let (first, last) = (leaf_at(0), leaf_at(1));
    [first.first, last.first + last.count]
}
