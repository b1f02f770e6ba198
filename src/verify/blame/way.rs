//! Ways through a tree, whatever its state: no record is taken to be right.

use crate::tree::Node;

/// Nodes from the root to a leaf.
pub type Way = Vec<usize>;

/// The ways to all leaves that are `wanted`.
pub fn ways_to(nodes: &[Node], wanted: impl Fn(&Node) -> bool) -> Vec<Way> {
    let mut leaves = Vec::new();
    let parents = walk(
        nodes,
        |_| true,
        |node| {
            if wanted(&nodes[node]) {
                leaves.push(node);
            }
        },
    );
    leaves.into_iter().map(|leaf| way_from_root(&parents, leaf)).collect()
}

/// The ways to all leaves whose boxes, and those above them, hold the point.
pub fn leaves_at(nodes: &[Node], point: &[f64; 3], rounding: f64) -> Vec<Way> {
    let mut leaves = Vec::new();
    let parents = walk(nodes, |node| holds(&nodes[node], point, rounding), |leaf| leaves.push(leaf));
    leaves.into_iter().map(|leaf| way_from_root(&parents, leaf)).collect()
}

/// The first node on the way, as a step, whose box does not hold the point.
pub fn first_without(nodes: &[Node], way: &[usize], point: &[f64; 3], rounding: f64) -> Option<usize> {
    way.iter().position(|&node| !holds(&nodes[node], point, rounding))
}

/// The first node on the way whose box does not hold that of a child, as a step, and the child.
pub fn first_narrow(nodes: &[Node], way: &[usize]) -> Option<(usize, usize)> {
    way.iter().enumerate().find_map(|(step, &node)| {
        let children = children(nodes, node)?;
        children.into_iter().find(|&c| !nodes[node].bounds().contains(&nodes[c].bounds())).map(|c| (step, c))
    })
}

/// Visit what can be reached through nodes that are `open`, each record once; `leaf` is told the leaves in order of their place. Returned are the
/// parents of all nodes that were reached.
fn walk(nodes: &[Node], open: impl Fn(usize) -> bool, mut leaf: impl FnMut(usize)) -> Vec<u32> {
    let mut parents = vec![UNSEEN; nodes.len()];
    let mut stack = Vec::new();
    if !nodes.is_empty() {
        parents[0] = 0;
        stack.push(0);
    }
    while let Some(node) = stack.pop() {
        if !open(node) {
            continue;
        }
        match children(nodes, node) {
            Some(pair) => {
                for child in pair.into_iter().rev() {
                    if parents[child] == UNSEEN {
                        parents[child] = node as u32;
                        stack.push(child);
                    }
                }
            }
            None if nodes[node].is_leaf() => leaf(node),
            None => {}
        }
    }
    parents
}

const UNSEEN: u32 = u32::MAX;

/// The two children of an inner node, if they are there.
fn children(nodes: &[Node], node: usize) -> Option<[usize; 2]> {
    let first = nodes[node].first as usize;
    (!nodes[node].is_leaf() && first + 1 < nodes.len()).then_some([first, first + 1])
}

fn way_from_root(parents: &[u32], leaf: usize) -> Way {
    let mut way = vec![leaf];
    let mut node = leaf;
    while node != 0 {
        node = parents[node] as usize;
        way.push(node);
    }
    way.reverse();
    way
}

/// Whether a box holds a point, give or take `rounding` of the coordinates in play.
fn holds(node: &Node, point: &[f64; 3], rounding: f64) -> bool {
    (0..3).all(|a| {
        let (min, max) = (f64::from(node.min[a]), f64::from(node.max[a]));
        let slack = rounding * min.abs().max(max.abs()).max(point.iter().fold(0.0, |m, v| m.max(v.abs())));
        min - slack <= point[a] && point[a] <= max + slack
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;

    fn cube(from: f32, to: f32) -> Aabb {
        Aabb { min: [from; 3], max: [to; 3] }
    }

    /// A root over a leaf and an inner node over two leaves.
    fn tree() -> Vec<Node> {
        vec![
            Node::inner(cube(0.0, 4.0), 2),
            Node::leaf(cube(0.0, 0.0), 0, 0),
            Node::leaf(cube(0.0, 1.0), 0, 2),
            Node::inner(cube(1.0, 4.0), 4),
            Node::leaf(cube(1.0, 2.0), 2, 1),
            Node::leaf(cube(2.0, 4.0), 3, 1),
        ]
    }

    #[test]
    fn ways_lead_from_the_root_to_the_leaves_that_are_wanted() {
        let nodes = tree();
        assert_eq!(ways_to(&nodes, |leaf| leaf.first >= 2), [vec![0, 3, 4], vec![0, 3, 5]]);
        assert_eq!(leaves_at(&nodes, &[1.0; 3], 0.0), [vec![0, 2], vec![0, 3, 4]]);
        assert!(ways_to(&[], |_| true).is_empty());
    }

    #[test]
    fn the_first_box_that_is_too_small_is_found() {
        let mut nodes = tree();
        let way = [0, 3, 5];
        assert_eq!(first_without(&nodes, &way, &[3.0; 3], 0.0), None);
        assert_eq!(first_narrow(&nodes, &way), None);
        nodes[3].max = [2.5; 3];
        assert_eq!(first_without(&nodes, &way, &[3.0; 3], 0.0), Some(1));
        assert_eq!(first_narrow(&nodes, &way), Some((1, 5)));
    }

    #[test]
    fn cycles_and_children_out_of_range_end() {
        let mut nodes = tree();
        nodes[3].first = 0;
        assert_eq!(ways_to(&nodes, |_| true), [vec![0, 2]]);
        nodes[0].first = 5;
        assert!(ways_to(&nodes, |_| true).is_empty());
    }
}
