//! [`Outline`]: the upper levels of a tree, node by node.

use crate::cache::View;
use crate::tree::Node;
use crate::tree::quality::{REPORT_INTERSECTION_COST, REPORT_TRAVERSAL_COST};
use serde::Serialize;

/// A node of an outline.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutlineNode {
    /// Number of its record in the file: in `NODE`, or in `TNOD` for the tree over instances.
    pub node: u64,
    /// Levels below the node that the outline starts at, which has 0.
    pub depth: u32,
    /// Near corner of its box.
    pub min: [f32; 3],
    /// Far corner of its box.
    pub max: [f32; 3],
    /// Area of its box over that of the tree's root: what share of the rays that cross the root cross the node too. 0 where the root has none.
    pub area_share: f64,
    /// What it and all below it add to the SAH of the tree, as a share of that SAH. 0 where that is 0.
    pub sah_share: f64,
    /// Of a tree over triangles: references to triangles below it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub references: Option<u64>,
    /// Of the tree over instances: instances below it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instances: Option<u64>,
    /// Nodes below it, itself included.
    pub nodes: u64,
    /// Depth of the deepest leaf below it, counted from it.
    pub height: u32,
    /// Whether it has no children.
    pub is_leaf: bool,
}

/// The nodes of a tree down to some depth, a parent before its children.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outline {
    /// `tree` over triangles, or `top` over instances.
    pub of: &'static str,
    /// In depth-first order.
    pub nodes: Vec<OutlineNode>,
}

impl Outline {
    /// From record `root` of `NODE` down, or without one from the root of the file: of the tree over instances in a file of two levels.
    ///
    /// `None` where no node has this number.
    pub fn of_view(view: &View<'_>, root: Option<u64>, depth: u32) -> Option<Outline> {
        let Some(root) = root else {
            return match view.tlas_nodes {
                [] => Outline::of_view(view, Some(0), depth),
                top => Some(Outline { of: "top", nodes: instances_in(nodes(top, 0, 0, depth)) }),
            };
        };
        let holds = |blas: &&crate::cache::BlasRecord| {
            root.checked_sub(blas.node_offset).is_some_and(|local| local < u64::from(blas.node_count) && local != 1)
        };
        let number = view.blases.iter().position(|blas| holds(&blas))?;
        let (tree, offset) = (view.blas(number)?.nodes, view.blases[number].node_offset);
        Some(Outline { of: "tree", nodes: nodes(tree, (root - offset) as usize, offset, depth) })
    }
}

/// Sums over all that is below a node.
#[derive(Clone, Copy, Default)]
struct Below {
    sah: f64,
    refs: u64,
    nodes: u64,
    height: u32,
}

fn nodes(tree: &[Node], root: usize, offset: u64, depth: u32) -> Vec<OutlineNode> {
    // Children lie behind their parents, so one pass from the end has each child before its parent.
    let mut below = vec![Below::default(); tree.len()];
    for (i, node) in tree.iter().enumerate().rev() {
        let area = half_area(node);
        below[i] = match children(tree, i) {
            Some([left, right]) => {
                let (a, b) = (below[left], below[right]);
                Below {
                    sah: REPORT_TRAVERSAL_COST * area + a.sah + b.sah,
                    refs: a.refs.saturating_add(b.refs),
                    nodes: (1 + a.nodes).saturating_add(b.nodes),
                    height: 1 + a.height.max(b.height),
                }
            }
            None => {
                let refs = u64::from(node.count);
                Below { sah: REPORT_INTERSECTION_COST * refs as f64 * area, refs, nodes: 1, height: 0 }
            }
        };
    }
    let (whole, area) = (below.first().map_or(0.0, |b| b.sah), tree.first().map_or(0.0, half_area));
    let share = |part: f64, of: f64| if of > 0.0 { part / of } else { 0.0 };
    let (mut found, mut open) = (Vec::new(), vec![(root, 0)]);
    while let Some((i, level)) = open.pop() {
        let (Some(node), Some(sums)) = (tree.get(i), below.get(i)) else { continue };
        let inner = children(tree, i);
        found.push(OutlineNode {
            node: offset + i as u64,
            depth: level,
            min: node.min,
            max: node.max,
            area_share: share(half_area(node), area),
            sah_share: share(sums.sah, whole),
            references: Some(sums.refs),
            instances: None,
            nodes: sums.nodes,
            height: sums.height,
            is_leaf: inner.is_none(),
        });
        if let Some([left, right]) = inner.filter(|_| level < depth) {
            open.extend([(right, level + 1), (left, level + 1)]);
        }
    }
    found
}

/// What the tree over instances refers to is instances.
fn instances_in(mut nodes: Vec<OutlineNode>) -> Vec<OutlineNode> {
    nodes.iter_mut().for_each(|node| node.instances = node.references.take());
    nodes
}

/// The children of an inner node; none where records are no tree.
fn children(tree: &[Node], i: usize) -> Option<[usize; 2]> {
    let node = &tree[i];
    let first = node.first as usize;
    (!node.is_leaf() && first > i && first + 1 < tree.len()).then_some([first, first + 1])
}

fn half_area(node: &Node) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| (f64::from(node.max[k]) - f64::from(node.min[k])).max(0.0));
    x * y + y * z + z * x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;
    use crate::tree::quality::sah;

    /// A unit cube and one twice as long, side by side.
    fn tree() -> Vec<Node> {
        let left = Aabb { min: [0.0; 3], max: [1.0; 3] };
        let right = Aabb { min: [1.0, 0.0, 0.0], max: [3.0, 1.0, 1.0] };
        let unused = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };
        vec![Node::inner(left.union(right), 2), unused, Node::leaf(left, 0, 2), Node::leaf(right, 2, 1)]
    }

    #[test]
    fn shares_have_closed_forms() {
        // Half areas: root 7, left 3, right 5. SAH · 7 = 1.2 · 7 + 2 · 3 + 5 = 19.4.
        let found = nodes(&tree(), 0, 100, 9);
        let shares: Vec<(u64, f64, f64)> =
            found.iter().map(|n| (n.node, n.area_share * 7.0, n.sah_share * 19.4)).collect();
        for ((node, area, cost), expected) in shares.iter().zip([(100, 7.0, 19.4), (102, 3.0, 6.0), (103, 5.0, 5.0)]) {
            assert_eq!(*node, expected.0);
            assert!((area - expected.1).abs() < 1e-9 && (cost - expected.2).abs() < 1e-9, "{shares:?}");
        }
        assert!((f64::from(sah(&tree())) - 19.4 / 7.0).abs() < 1e-6, "the SAH that is shared out is the file's");
        assert_eq!(
            [found[0].references, Some(found[0].nodes), Some(u64::from(found[0].height))],
            [Some(3), Some(3), Some(1)]
        );
        assert_eq!(nodes(&tree(), 0, 0, 0).len(), 1);
        assert_eq!(nodes(&tree(), 3, 0, 5).iter().map(|n| n.node).collect::<Vec<_>>(), [3]);
    }

    #[test]
    fn records_that_are_no_tree_end() {
        let mut broken = tree();
        broken[0].first = 0;
        assert_eq!(nodes(&broken, 0, 0, 64).len(), 1);
        broken[0].first = 3;
        assert!(nodes(&broken, 0, 0, 64)[0].is_leaf);
        assert!(nodes(&[], 0, 0, 64).is_empty());
    }
}
