//! Which nodes of a binary tree stay when it is collapsed, at least cost.
//!
//! For each node `n` and each number of lanes `i`, `C(n, i)` is what it costs at least to put everything below `n` into at most `i` lanes of a node above
//! it (Ylitie et al. 2017, equations 1 to 4):
//!
//! ```text
//! C(n, 1) = min(leaf, D(n, N) + A·node_cost)       n becomes one leaf, or a node of its own
//! C(n, i) = min(D(n, i), C(n, i − 1))              its two children share the lanes, or one lane stays empty
//! D(n, i) = min over k of C(left, k) + C(right, i − k)
//! ```

use super::collapse::Collapse;
use crate::layout::{BlasView, Node};
use crate::trace::hit::Malformed;
use crate::trace::visit::Step;

/// What was decided for every record of a tree.
pub struct Plan {
    decisions: Vec<Decision>,
}

/// Four bits for each number of lanes from 2 on: how many of them the left child gets, or 0 if one lane less is as good. Those of all lanes are for a node
/// of its own. The highest bit: in one lane, the node is a leaf.
#[derive(Clone, Copy, Default)]
struct Decision(u32);

const LEAF: u32 = 1 << 31;

/// What stands below a node that was decided.
struct Below<const N: usize> {
    /// `C(n, 1)` to `C(n, N − 1)`; the last is not asked for.
    costs: [f64; N],
    /// The references, if they are consecutive; otherwise no leaf can have them.
    refs: Option<[u32; 2]>,
}

impl Plan {
    /// Decide for a whole tree of `N` lanes, at most 8. Among equal costs the fewer nodes win, then the fewer lanes, then the fewer of them for the left child.
    pub fn new<const N: usize>(tree: &BlasView<'_>, collapse: &Collapse) -> Result<Plan, Malformed> {
        let mut order = Vec::with_capacity(tree.nodes.len());
        tree.visit(|at| {
            order.push(at.index as u32);
            Step::Descend
        })?;
        let mut decisions = vec![Decision::default(); tree.nodes.len()];
        // Backward, so that both children of a node were decided last: the left one after the right one.
        let mut below: Vec<Below<N>> = Vec::new();
        for &index in order.iter().rev() {
            let node = &tree.nodes[index as usize];
            let (decision, found) = if node.is_leaf() {
                leaf(node, collapse)
            } else {
                let (Some(left), Some(right)) = (below.pop(), below.pop()) else {
                    return Err(Malformed::NotATree { nodes: tree.nodes.len() });
                };
                inner(node, &left, &right, collapse)
            };
            decisions[index as usize] = decision;
            below.push(found);
        }
        Ok(Plan { decisions })
    }

    /// Whether the node is a leaf where it has one lane.
    pub fn is_leaf(&self, node: u32) -> bool {
        self.decisions[node as usize].0 & LEAF != 0
    }

    /// How an inner node's children share `lanes` lanes. `None` where it takes one lane.
    pub fn split(&self, node: u32, lanes: usize) -> Option<[usize; 2]> {
        (2..=lanes).rev().find_map(|i| match self.decisions[node as usize].of(i) {
            0 => None,
            left => Some([left, i - left]),
        })
    }
}

impl Decision {
    fn of(self, lanes: usize) -> usize {
        (self.0 >> (4 * (lanes - 2)) & 0b1111) as usize
    }

    fn set(&mut self, lanes: usize, left: usize) {
        self.0 |= (left as u32) << (4 * (lanes - 2));
    }
}

fn leaf<const N: usize>(node: &Node, collapse: &Collapse) -> (Decision, Below<N>) {
    let cost = area(node) * collapse.leaf_cost(node.count);
    (Decision(LEAF), Below { costs: [cost; N], refs: Some([node.first, node.first + node.count]) })
}

fn inner<const N: usize>(node: &Node, left: &Below<N>, right: &Below<N>, collapse: &Collapse) -> (Decision, Below<N>) {
    let refs = match (left.refs, right.refs) {
        (Some([first, middle]), Some([begin, end])) if middle == begin => Some([first, end]),
        _ => None,
    };
    let mut decision = Decision::default();
    let shared = |lanes: usize| {
        let cost = |k: usize| left.costs[k - 1] + right.costs[lanes - k - 1];
        (2..lanes).fold((cost(1), 1), |best, k| if cost(k) < best.0 { (cost(k), k) } else { best })
    };
    let (all, left_of_all) = shared(N);
    let mut costs = [all + area(node) * collapse.node_cost; N];
    if let Some([first, end]) = refs.filter(|[first, end]| end - first <= collapse.max_leaf) {
        let as_leaf = area(node) * collapse.leaf_cost(end - first);
        if as_leaf <= costs[0] {
            decision.0 |= LEAF;
            costs[0] = as_leaf;
        }
    }
    for lanes in 2..N {
        let (cost, k) = shared(lanes);
        costs[lanes - 1] = costs[lanes - 2];
        if cost < costs[lanes - 1] {
            costs[lanes - 1] = cost;
            decision.set(lanes, k);
        }
    }
    // All lanes are those of a node of its own, which has no choice but to share them out.
    decision.set(N, left_of_all);
    (decision, Below { costs, refs })
}

/// Half the area, in `f64`, where no box of floats overflows.
pub fn area(node: &Node) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|axis| f64::from(node.max[axis]) - f64::from(node.min[axis]));
    x * y + y * z + z * x
}
