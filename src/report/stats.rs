//! What the trees of a file are like. [`TreeStats`] is a monoid: `fold` one tree, `+` any number of them.

use crate::tree::Node;
use crate::tree::quality::{REPORT_INTERSECTION_COST, REPORT_TRAVERSAL_COST};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::Add;

/// Sums over one or more trees. Shares and means are methods, because sums add and means do not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TreeStats {
    pub trees: u64,
    /// Live nodes.
    pub nodes: u64,
    pub leaves: u64,
    /// Leaf slots.
    pub refs: u64,
    /// Distinct primitives, as the BLAS records say.
    pub prims: u64,
    pub max_depth: u32,
    /// Σ over trees of the root's half area.
    pub root_area: f64,
    /// Σ over inner nodes of C_T·A(n).
    pub inner_cost: f64,
    /// Σ over leaves of C_I·N(n)·A(n).
    pub leaf_cost: f64,
    /// Σ over inner nodes of A(left ∩ right) / A(parent), where the parent has an area.
    pub overlap: f64,
    /// Σ over inner nodes of A(left ∩ right).
    pub overlap_area: f64,
    /// Σ over the inner nodes at each depth of A(left ∩ right) / A(parent), the root's first.
    pub overlap_at: Vec<f64>,
    /// Σ over inner nodes with a volume of the share of it that neither child's box has.
    pub empty: f64,
    /// Inner nodes with a volume.
    pub solid_nodes: u64,
    /// Nodes at each depth, the root's first.
    pub nodes_per_depth: Vec<u64>,
    pub leaves_per_depth: Vec<u64>,
    /// Leaves by their number of primitives.
    pub leaf_sizes: BTreeMap<u32, u64>,
}

impl TreeStats {
    /// Walk one tree in record order; children lie behind their parents, so one forward pass knows every depth. Records
    /// that break this rule (the file was not checked) are left out instead of being followed.
    pub fn of_tree(nodes: &[Node], prims: u64) -> TreeStats {
        let mut stats = TreeStats { trees: 1, prims, ..TreeStats::default() };
        let Some(root) = nodes.first() else { return stats };
        stats.root_area = half_area(root);
        let mut depths = vec![NOT_REACHED; nodes.len()];
        depths[0] = 0;
        for (i, node) in nodes.iter().enumerate() {
            let depth = depths[i];
            if depth == NOT_REACHED {
                continue;
            }
            stats.add_node(node, depth);
            if node.is_leaf() {
                continue;
            }

            // Enter the children and measure how much of the parent both of them cover.
            let first = node.first as usize;
            let Some([left, right]) = nodes.get(first..first.saturating_add(2)) else { continue };
            if first <= i {
                continue;
            }
            depths[first] = depth + 1;
            depths[first + 1] = depth + 1;
            let shared = intersection_area(left, right);
            stats.overlap_area += shared;
            let parent = half_area(node);
            if parent > 0.0 {
                stats.overlap += shared / parent;
            }
            let at = depth as usize;
            stats.overlap_at.resize(stats.overlap_at.len().max(at + 1), 0.0);
            stats.overlap_at[at] += if parent > 0.0 { shared / parent } else { 0.0 };
            stats.add_empty(node, left, right);
        }
        stats
    }

    fn add_node(&mut self, node: &Node, depth: u32) {
        self.nodes += 1;
        self.max_depth = self.max_depth.max(depth);
        bump(&mut self.nodes_per_depth, depth);
        if node.is_leaf() {
            self.leaves += 1;
            self.refs += u64::from(node.count);
            self.leaf_cost += REPORT_INTERSECTION_COST * f64::from(node.count) * half_area(node);
            *self.leaf_sizes.entry(node.count).or_default() += 1;
            bump(&mut self.leaves_per_depth, depth);
        } else {
            self.inner_cost += REPORT_TRAVERSAL_COST * half_area(node);
        }
    }

    fn add_empty(&mut self, node: &Node, left: &Node, right: &Node) {
        let whole = volume_of(extent(node));
        if whole > 0.0 && whole.is_finite() {
            let filled = volume_of(extent(left)) + volume_of(extent(right)) - volume_of(common(left, right));
            self.empty += (1.0 - filled / whole).clamp(0.0, 1.0);
            self.solid_nodes += 1;
        }
    }

    /// The SAH cost: for one tree the usual sum, for several the mean over rays that hit a root box, that is weighted by
    /// the roots' areas. 0 where there is no area.
    pub fn sah(&self) -> f64 {
        self.inner_sah() + self.leaf_sah()
    }

    pub fn inner_sah(&self) -> f64 {
        ratio(self.inner_cost, self.root_area)
    }

    pub fn leaf_sah(&self) -> f64 {
        ratio(self.leaf_cost, self.root_area)
    }

    pub fn inner_nodes(&self) -> u64 {
        self.nodes - self.leaves
    }

    pub fn refs_per_leaf(&self) -> f64 {
        ratio(self.refs as f64, self.leaves as f64)
    }

    /// References beyond one per primitive, as a share of the primitives: 0.211 for 21.1 % more.
    pub fn duplication(&self) -> f64 {
        if self.prims == 0 { 0.0 } else { self.refs as f64 / self.prims as f64 - 1.0 }
    }

    /// Mean over inner nodes of A(left ∩ right) / A(parent).
    pub fn mean_overlap(&self) -> f64 {
        ratio(self.overlap, self.inner_nodes() as f64)
    }

    /// [`TreeStats::mean_overlap`] of the inner nodes at each depth, the root's first.
    pub fn overlap_per_depth(&self) -> Vec<f64> {
        let inner = |depth: usize| {
            let leaves = self.leaves_per_depth.get(depth).copied().unwrap_or(0);
            self.nodes_per_depth.get(depth).copied().unwrap_or(0).saturating_sub(leaves)
        };
        self.overlap_at.iter().enumerate().map(|(depth, sum)| ratio(*sum, inner(depth) as f64)).collect()
    }

    /// Mean over the inner nodes with a volume V of (V(parent) − V(left ∪ right)) / V(parent): space in which a ray is told of by the node, and meets
    /// neither child. 0 to 1.
    pub fn mean_empty(&self) -> f64 {
        ratio(self.empty, self.solid_nodes as f64)
    }

    /// Σ A(left ∩ right) / A(root): how many nodes a ray visits in vain, roughly.
    pub fn overlap_per_root(&self) -> f64 {
        ratio(self.overlap_area, self.root_area)
    }
}

impl Add for TreeStats {
    type Output = TreeStats;

    fn add(mut self, other: TreeStats) -> TreeStats {
        self.trees += other.trees;
        self.nodes += other.nodes;
        self.leaves += other.leaves;
        self.refs += other.refs;
        self.prims += other.prims;
        self.max_depth = self.max_depth.max(other.max_depth);
        self.root_area += other.root_area;
        self.inner_cost += other.inner_cost;
        self.leaf_cost += other.leaf_cost;
        self.overlap += other.overlap;
        self.overlap_area += other.overlap_area;
        self.overlap_at.resize(self.overlap_at.len().max(other.overlap_at.len()), 0.0);
        for (sum, more) in self.overlap_at.iter_mut().zip(&other.overlap_at) {
            *sum += more;
        }
        self.empty += other.empty;
        self.solid_nodes += other.solid_nodes;
        add_histogram(&mut self.nodes_per_depth, &other.nodes_per_depth);
        add_histogram(&mut self.leaves_per_depth, &other.leaves_per_depth);
        for (size, n) in other.leaf_sizes {
            *self.leaf_sizes.entry(size).or_default() += n;
        }
        self
    }
}

const NOT_REACHED: u32 = u32::MAX;

fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

fn bump(histogram: &mut Vec<u64>, depth: u32) {
    let depth = depth as usize;
    if histogram.len() <= depth {
        histogram.resize(depth + 1, 0);
    }
    histogram[depth] += 1;
}

fn add_histogram(into: &mut Vec<u64>, other: &[u64]) {
    if into.len() < other.len() {
        into.resize(other.len(), 0);
    }
    for (a, b) in into.iter_mut().zip(other) {
        *a += b;
    }
}

fn half_area(n: &Node) -> f64 {
    area_of(extent(n))
}

fn intersection_area(a: &Node, b: &Node) -> f64 {
    area_of(common(a, b))
}

fn extent(n: &Node) -> [f64; 3] {
    [0, 1, 2].map(|a| f64::from(n.max[a]) - f64::from(n.min[a]))
}

/// The edges of what two boxes share; one below 0 where they share nothing.
fn common(a: &Node, b: &Node) -> [f64; 3] {
    [0, 1, 2].map(|x| f64::from(a.max[x].min(b.max[x])) - f64::from(a.min[x].max(b.min[x])))
}

/// 0 where the box is empty or not a number.
fn volume_of([x, y, z]: [f64; 3]) -> f64 {
    if x >= 0.0 && y >= 0.0 && z >= 0.0 { x * y * z } else { 0.0 }
}

/// Half area of a box with these edges; 0 where it is empty or not a number.
fn area_of([x, y, z]: [f64; 3]) -> f64 {
    if x >= 0.0 && y >= 0.0 && z >= 0.0 { x * y + y * z + z * x } else { 0.0 }
}

/// The same facts with names, means included: what every text is made from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TreeReport {
    pub trees: u64,
    pub nodes: u64,
    pub leaves: u64,
    pub references: u64,
    pub triangles: u64,
    pub duplication: f64,
    pub max_depth: u32,
    pub sah: f64,
    pub sah_nodes: f64,
    pub sah_leaves: f64,
    pub references_per_leaf: f64,
    pub mean_sibling_overlap: f64,
    pub overlap_per_root_area: f64,
    pub overlap_per_depth: Vec<f64>,
    pub mean_empty_share: f64,
    pub nodes_per_depth: Vec<u64>,
    pub leaves_per_depth: Vec<u64>,
    /// Pairs of leaf size and number of leaves, ascending.
    pub leaf_sizes: Vec<(u32, u64)>,
}

impl From<&TreeStats> for TreeReport {
    fn from(s: &TreeStats) -> TreeReport {
        TreeReport {
            trees: s.trees,
            nodes: s.nodes,
            leaves: s.leaves,
            references: s.refs,
            triangles: s.prims,
            duplication: s.duplication(),
            max_depth: s.max_depth,
            sah: s.sah(),
            sah_nodes: s.inner_sah(),
            sah_leaves: s.leaf_sah(),
            references_per_leaf: s.refs_per_leaf(),
            mean_sibling_overlap: s.mean_overlap(),
            overlap_per_root_area: s.overlap_per_root(),
            overlap_per_depth: s.overlap_per_depth(),
            mean_empty_share: s.mean_empty(),
            nodes_per_depth: s.nodes_per_depth.clone(),
            leaves_per_depth: s.leaves_per_depth.clone(),
            leaf_sizes: s.leaf_sizes.iter().map(|(&size, &n)| (size, n)).collect(),
        }
    }
}

/// The same of the tree over instances, whose leaves hold instances.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TopReport {
    pub nodes: u64,
    pub leaves: u64,
    pub instances: u64,
    pub max_depth: u32,
    pub sah: f64,
    pub sah_nodes: f64,
    pub sah_leaves: f64,
    pub instances_per_leaf: f64,
    pub mean_sibling_overlap: f64,
    pub overlap_per_root_area: f64,
    pub overlap_per_depth: Vec<f64>,
    pub mean_empty_share: f64,
    pub nodes_per_depth: Vec<u64>,
    pub leaves_per_depth: Vec<u64>,
    /// Pairs of leaf size and number of leaves, ascending.
    pub leaf_sizes: Vec<(u32, u64)>,
}

impl From<&TreeStats> for TopReport {
    fn from(s: &TreeStats) -> TopReport {
        let tree = TreeReport::from(s);
        TopReport {
            nodes: tree.nodes,
            leaves: tree.leaves,
            instances: tree.references,
            max_depth: tree.max_depth,
            sah: tree.sah,
            sah_nodes: tree.sah_nodes,
            sah_leaves: tree.sah_leaves,
            instances_per_leaf: tree.references_per_leaf,
            mean_sibling_overlap: tree.mean_sibling_overlap,
            overlap_per_root_area: tree.overlap_per_root_area,
            overlap_per_depth: tree.overlap_per_depth,
            mean_empty_share: tree.mean_empty_share,
            nodes_per_depth: tree.nodes_per_depth,
            leaves_per_depth: tree.leaves_per_depth,
            leaf_sizes: tree.leaf_sizes,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;
    use crate::tree::quality;

    /// Two unit cubes that overlap by half, under their union.
    fn two_leaves() -> Vec<Node> {
        let left = Aabb { min: [0.0; 3], max: [1.0; 3] };
        let right = Aabb { min: [0.5, 0.0, 0.0], max: [1.5, 1.0, 1.0] };
        vec![
            Node::inner(left.union(right), 2),
            bytemuck::Zeroable::zeroed(),
            Node::leaf(left, 0, 3),
            Node::leaf(right, 3, 1),
        ]
    }

    #[test]
    fn one_tree_counts_what_is_there() {
        let s = TreeStats::of_tree(&two_leaves(), 3);
        assert_eq!((s.nodes, s.leaves, s.refs, s.max_depth), (3, 2, 4, 1));
        assert_eq!(s.nodes_per_depth, [1, 2]);
        assert_eq!(s.leaves_per_depth, [0, 2]);
        assert_eq!(s.leaf_sizes.iter().map(|(&k, &n)| (k, n)).collect::<Vec<_>>(), [(1, 1), (3, 1)]);
        assert!((s.duplication() - 1.0 / 3.0).abs() < 1e-12);
        // root 1.5×1×1 has half area 4, the common part 0.5×1×1 has 2
        assert!((s.overlap - 0.5).abs() < 1e-12);
    }

    /// Against sums that are written down node by node, for a tree with an inner node on each of two depths.
    #[test]
    fn overlap_and_empty_space_have_closed_forms() {
        let cube = |x: f32, width: f32| Aabb { min: [x, 0.0, 0.0], max: [x + width, 1.0, 1.0] };
        let (left, far, near) = (cube(0.0, 1.0), cube(3.0, 1.0), cube(2.5, 1.0));
        let right = far.union(near);
        let nodes = vec![
            Node::inner(left.union(right), 2),
            bytemuck::Zeroable::zeroed(),
            Node::leaf(left, 0, 1),
            Node::inner(right, 4),
            Node::leaf(near, 1, 1),
            Node::leaf(far, 2, 1),
        ];
        let s = TreeStats::of_tree(&nodes, 3);
        // The root, 4 long, has a gap of 1.5 and no overlap; its right child, 1.5 long with half area 4, is full, and 0.5 of it, with 2, is shared.
        assert_eq!(s.overlap_per_depth(), [0.0, 0.5]);
        assert_eq!((s.mean_empty(), s.solid_nodes), (1.5 / 4.0 / 2.0, 2));
        assert_eq!(s.mean_overlap(), 0.25);
        let both = s.clone() + TreeStats::of_tree(&two_leaves(), 3);
        assert_eq!((both.overlap_per_depth(), both.mean_empty()), (vec![0.25, 0.5], 0.125));
        // A flat node has no volume to be empty.
        let flat = Aabb { min: [0.0; 3], max: [1.0, 1.0, 0.0] };
        let flat = vec![Node::inner(flat, 2), nodes[1], Node::leaf(flat, 0, 1), Node::leaf(flat, 1, 1)];
        assert_eq!(TreeStats::of_tree(&flat, 2).mean_empty(), 0.0);
    }

    #[test]
    fn sah_agrees_with_the_one_that_the_file_stores() {
        let nodes = two_leaves();
        assert_eq!(TreeStats::of_tree(&nodes, 4).sah() as f32, quality::sah(&nodes));
    }

    #[test]
    fn the_empty_stats_are_neutral_and_trees_add() {
        let s = TreeStats::of_tree(&two_leaves(), 3);
        assert_eq!(TreeStats::default() + s.clone(), s);
        assert_eq!(s.clone() + TreeStats::default(), s);
        let twice = s.clone() + s.clone();
        assert_eq!((twice.trees, twice.nodes, twice.max_depth), (2, 6, 1));
        assert!((twice.sah() - s.sah()).abs() < 1e-12, "the SAH of two equal trees is that of one");
    }

    #[test]
    fn broken_children_are_not_followed() {
        let mut nodes = two_leaves();
        nodes[0].first = u32::MAX;
        assert_eq!(TreeStats::of_tree(&nodes, 3).nodes, 1);
        nodes[0].first = 0;
        assert_eq!(TreeStats::of_tree(&nodes, 3).nodes, 1);
    }
}
