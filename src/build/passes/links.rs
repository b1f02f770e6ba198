//! What a [`Tree`] does not say outright: links up, heights, and how many references a leaf has by where they stand.
//!
//! In canonical order everything below a node is one run of the nodes and one of the references, so subtrees are done side by side.

use crate::build::top_down::partition::cut;
use crate::exec::Executor;
use crate::tree::Tree;
use std::ops::Range;

/// The root's parent.
pub(super) const NONE: u32 = u32::MAX;
/// Nodes of a subtree that is one task. A constant, so that nothing depends on the number of threads.
const RUN: usize = 1 << 14;

pub(super) struct Links {
    /// By pair: the node that has it as its children.
    pub parents: Vec<u32>,
    /// By node: the longest way down to a leaf.
    pub heights: Vec<u8>,
    /// By reference: the number of its leaf's if it is the first of them.
    pub leaf_counts: Vec<u8>,
}

impl Links {
    /// Of a tree in canonical order with a root that is no leaf.
    pub fn of(tree: &Tree, exec: &Executor) -> Links {
        let mut links = Links {
            parents: vec![NONE; tree.nodes.len() / 2],
            heights: vec![0; tree.nodes.len()],
            leaf_counts: vec![0; tree.refs.len()],
        };
        let Division { upper, runs } = Division::of(tree);
        let nodes = || runs.iter().map(|(nodes, _)| nodes.clone());
        let pairs = cut(&mut links.parents, nodes().map(|run| run.start / 2..run.end / 2).collect());
        let heights = cut(&mut links.heights, nodes().collect());
        let refs = cut(&mut links.leaf_counts, runs.iter().map(|(_, refs)| refs.clone()).collect());
        let jobs: Vec<_> = runs.iter().zip(pairs.into_iter().zip(heights).zip(refs)).collect();
        exec.map(jobs, |_, ((nodes, refs), ((parents, heights), leaf_counts))| {
            let mut part = Part { tree, nodes: nodes.start, refs: refs.start, parents, heights, leaf_counts };
            nodes.clone().rev().for_each(|i| part.link(i));
        });
        let Links { parents, heights, leaf_counts } = &mut links;
        let mut whole = Part { tree, nodes: 0, refs: 0, parents, heights, leaf_counts };
        upper.into_iter().rev().for_each(|i| whole.link(i));
        links
    }
}

/// Part of the links under work, from some node and some reference on.
struct Part<'a> {
    tree: &'a Tree,
    nodes: usize,
    refs: usize,
    parents: &'a mut [u32],
    heights: &'a mut [u8],
    leaf_counts: &'a mut [u8],
}

impl Part<'_> {
    /// Note what a node tells; nodes below it come before it.
    #[inline(always)]
    fn link(&mut self, node: usize) {
        let record = &self.tree.nodes[node];
        let first = record.first as usize;
        if record.is_leaf() {
            self.leaf_counts[first - self.refs] = record.count as u8;
        } else {
            let first = first - self.nodes;
            self.parents[first / 2] = node as u32;
            self.heights[node - self.nodes] = 1 + self.heights[first].max(self.heights[first + 1]);
        }
    }
}

/// A tree taken apart.
struct Division {
    /// Nodes that are in no run, parents before their children.
    upper: Vec<usize>,
    /// All that is below some of those, as runs of nodes and of references, in ascending order.
    runs: Vec<(Range<usize>, Range<usize>)>,
}

impl Division {
    fn of(tree: &Tree) -> Division {
        let (mut upper, mut runs) = (Vec::new(), Vec::new());
        // A node, and where the nodes and references below it end.
        let mut open = vec![(0, tree.nodes.len(), tree.refs.len())];
        while let Some((node, end, refs_end)) = open.pop() {
            upper.push(node);
            let record = &tree.nodes[node];
            if record.is_leaf() {
                continue;
            }
            let first = record.first as usize;
            if end - first <= RUN {
                runs.push((first..end, first_ref(tree, node)..refs_end));
                continue;
            }
            let right = &tree.nodes[first + 1];
            let middle = if right.is_leaf() { end } else { right.first as usize };
            open.push((first + 1, end, refs_end));
            open.push((first, middle, first_ref(tree, first + 1)));
        }
        Division { upper, runs }
    }
}

/// Where the references below a node begin.
fn first_ref(tree: &Tree, mut node: usize) -> usize {
    while !tree.nodes[node].is_leaf() {
        node = tree.nodes[node].first as usize;
    }
    tree.nodes[node].first as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, NoProgress, Preset, initial_tree};
    use crate::scene::Mesh;

    #[test]
    fn subtrees_side_by_side_link_as_the_whole_does() {
        let at = |i: u32| (i.wrapping_mul(2_654_435_761) >> 12) as f32 * 1e-5;
        let count = 3 * RUN as u32;
        let positions = (0..3 * count).map(|i| [at(i / 3), at(i / 3 + count), at(i) * 1e-3]).collect();
        let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        let exec = Executor::new(2).unwrap();
        let tree = initial_tree(&mesh, &BuildOptions::preset(Preset::Draft), &exec, &NoProgress).unwrap();
        assert!(Division::of(&tree).runs.len() > 2);

        let links = Links::of(&tree, &exec);
        let (mut parents, mut heights) = (vec![NONE; tree.nodes.len() / 2], vec![0; tree.nodes.len()]);
        let mut leaf_counts = vec![0; tree.refs.len()];
        let mut whole = Part {
            tree: &tree,
            nodes: 0,
            refs: 0,
            parents: &mut parents,
            heights: &mut heights,
            leaf_counts: &mut leaf_counts,
        };
        (0..tree.nodes.len()).rev().filter(|i| *i != 1).for_each(|i| whole.link(i));
        assert!(links.parents == parents && links.heights == heights && links.leaf_counts == leaf_counts);
        assert_eq!(u32::from(heights[0]), tree.max_depth());
    }
}
