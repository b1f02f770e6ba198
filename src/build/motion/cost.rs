//! What a topology costs where its triangles stand in a frame.

use super::motion::Motion;
use crate::build::recipe::options::BuildOptions;
use crate::exec::Executor;
use crate::geom::{Aabb, Point};
use crate::tree::Tree;

/// The SAH of a tree whose boxes are fitted to a frame, with the options' costs; the tree itself is not changed. 0 where the frame has no area.
///
/// The tree must be one over triangles whose corners `corners` knows by the number of the triangle.
pub fn cost(tree: &Tree, corners: impl Fn(usize) -> [Point; 3], options: &BuildOptions) -> f64 {
    let [traversal, intersection] = [options.traversal_cost, options.intersection_cost].map(f64::from);
    let mut boxes = vec![Aabb::EMPTY; tree.nodes.len()];
    let mut sum = 0.0;
    for i in (0..boxes.len()).rev().filter(|i| *i != 1) {
        let node = &tree.nodes[i];
        let first = node.first as usize;
        let weight = if node.is_leaf() {
            let refs = &tree.refs[first..first + node.count as usize];
            boxes[i] = refs.iter().fold(Aabb::EMPTY, |b, &t| b.union(Aabb::from_points(&corners(t as usize))));
            intersection * f64::from(node.count)
        } else {
            boxes[i] = boxes[first].union(boxes[first + 1]);
            traversal
        };
        sum += weight * half_area(&boxes[i]);
    }
    match boxes.first().map(half_area) {
        Some(root) if root > 0.0 => sum / root,
        _ => 0.0,
    }
}

/// [`cost`] of every tree in every frame: a row a frame, a column a tree.
pub fn costs(trees: &[&Tree], motion: &Motion, options: &BuildOptions, exec: &Executor) -> Vec<Vec<f64>> {
    let each = exec.map_range(motion.frames() * trees.len(), |i| {
        let frame = i / trees.len();
        cost(trees[i % trees.len()], |t| motion.corners(frame, t), options)
    });
    match trees.len() {
        0 => vec![Vec::new(); motion.frames()],
        width => each.chunks(width).map(<[f64]>::to_vec).collect(),
    }
}

/// In `f64`, which no box overflows.
pub(super) fn half_area(b: &Aabb) -> f64 {
    if b.is_empty() {
        return 0.0;
    }
    let [x, y, z] = [0, 1, 2].map(|k| f64::from(b.max[k]) - f64::from(b.min[k]));
    x * y + y * z + z * x
}
