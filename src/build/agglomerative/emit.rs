//! From merges to a tree in canonical order.

use super::forest::Forest;
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::simd::LaneBox;
use crate::tree::{Node, Tree};

/// Below this many references a subtree is one task. A constant, so that nothing depends on the number of threads.
const TASK: u32 = 1 << 12;
/// What stands at a reference's place that its leaf does not need.
const GONE: u32 = u32::MAX;

/// Write the tree, each part of it straight to its place: a cluster knows how many nodes and references are below it. The forest is
/// no deeper than trees may be.
pub(super) fn emit(forest: &Forest, exec: &Executor) -> Tree {
    let nodes = bytemuck::zeroed_vec(2 + 2 * forest.root.weight.inner as usize);
    let mut tree = Tree { nodes, refs: vec![0; forest.refs.len()] };
    let (root, below) = tree.nodes.split_at_mut(2);
    let part = Part { nodes: below, refs: &mut tree.refs, first_node: 2, first_ref: 0 };
    let (_, dropped) = exec.run(|| fork(forest, forest.root.number, &mut root[0], part, exec));
    if dropped > 0 {
        close_gaps(&mut tree);
    }
    tree
}

/// A run of the output, for all that is below one node.
struct Part<'a> {
    nodes: &'a mut [Node],
    refs: &'a mut [u32],
    /// Where the runs start in the tree.
    first_node: u32,
    first_ref: u32,
}

impl<'a> Part<'a> {
    fn split(self, nodes: usize, refs: usize) -> (Part<'a>, Part<'a>) {
        let (near_nodes, far_nodes) = self.nodes.split_at_mut(nodes);
        let (near_refs, far_refs) = self.refs.split_at_mut(refs);
        let far = Part {
            nodes: far_nodes,
            refs: far_refs,
            first_node: self.first_node + nodes as u32,
            first_ref: self.first_ref + refs as u32,
        };
        (Part { nodes: near_nodes, refs: near_refs, ..self }, far)
    }
}

/// The upper part of the tree, where the two sides are separate tasks. Returns the box, and how many references are [`GONE`].
fn fork(forest: &Forest, cluster: u32, node: &mut Node, part: Part, exec: &Executor) -> (LaneBox, u32) {
    let Some(merge) = forest.merge(cluster).filter(|merge| merge.count > TASK && merge.inner > 0) else {
        let mut writer = Writer { forest, part, node: 0, slot: 0, dropped: 0 };
        let record = writer.write(cluster);
        *node = record.node();
        return (record.bounds, writer.dropped);
    };
    let first_node = part.first_node;
    let (pair, below) = part.split(2, 0);
    let (left, right) = pair.nodes.split_at_mut(1);
    let [a, b] = merge.children;
    let (nodes, refs) = forest.merge(a).map_or((0, 1), |m| (2 * m.inner as usize, m.count as usize));
    let (near, far) = below.split(nodes, refs);
    let ((x, lost), (y, also)) =
        exec.join(|| fork(forest, a, &mut left[0], near, exec), || fork(forest, b, &mut right[0], far, exec));
    let bounds = x.union(y);
    *node = Node::inner(bounds.aabb(), first_node);
    (bounds, lost + also)
}

/// A node as it is handed up: vectors as a whole, or processors wait for them.
struct Record {
    bounds: LaneBox,
    first: usize,
    count: usize,
}

impl Record {
    #[inline(always)]
    fn node(&self) -> Node {
        let Aabb { min, max } = self.bounds.aabb();
        Node { min, first: self.first as u32, max, count: self.count as u32 }
    }
}

/// Writes a part front to back.
struct Writer<'a> {
    forest: &'a Forest<'a>,
    part: Part<'a>,
    /// Nodes and references that stand.
    node: usize,
    slot: usize,
    dropped: u32,
}

impl Writer<'_> {
    /// Everything below a cluster. As deep as the tree.
    fn write(&mut self, cluster: u32) -> Record {
        let start = self.slot;
        match self.forest.merge(cluster) {
            Some(merge) if merge.inner > 0 => {
                let pair = self.node;
                self.node += 2;
                let [a, b] = merge.children;
                let first = self.write(a);
                self.part.nodes[pair] = first.node();
                let second = self.write(b);
                self.part.nodes[pair + 1] = second.node();
                let bounds = first.bounds.union(second.bounds);
                Record { bounds, first: self.part.first_node as usize + pair, count: 0 }
            }
            _ => {
                let bounds = self.gather(cluster);
                let count = self.tidy(start);
                Record { bounds, first: self.part.first_ref as usize + start, count }
            }
        }
    }

    /// A leaf's references and their box. As deep as a leaf has references.
    fn gather(&mut self, cluster: u32) -> LaneBox {
        if let Some(merge) = self.forest.merge(cluster) {
            let [a, b] = merge.children;
            let first = self.gather(a);
            return first.union(self.gather(b));
        }
        let r = &self.forest.refs[cluster as usize];
        self.part.refs[self.slot] = r.prim;
        self.slot += 1;
        r.lanes()
    }

    /// Put a leaf's references in ascending order, each once: of a triangle that was cut, two parts may have come together. Returns
    /// how many there are.
    fn tidy(&mut self, start: usize) -> usize {
        let slots = &mut self.part.refs[start..self.slot];
        if slots.is_sorted_by(|a, b| a < b) {
            return slots.len();
        }
        slots.sort_unstable();
        let mut kept = 1;
        for i in 1..slots.len() {
            if slots[i] != slots[kept - 1] {
                slots[kept] = slots[i];
                kept += 1;
            }
        }
        slots[kept..].fill(GONE);
        self.dropped += (slots.len() - kept) as u32;
        kept
    }
}

/// Take out what is [`GONE`].
fn close_gaps(tree: &mut Tree) {
    let mut gone = 0;
    let gone_before: Vec<u32> = (tree.refs.iter())
        .map(|prim| {
            gone += u32::from(*prim == GONE);
            gone
        })
        .collect();
    // A leaf's first reference is never gone.
    for node in tree.nodes.iter_mut().filter(|node| node.is_leaf()) {
        node.first -= gone_before[node.first as usize];
    }
    tree.refs.retain(|prim| *prim != GONE);
}
