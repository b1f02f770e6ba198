//! What a topology costs where its triangles stand in a frame.

use super::frames::Motion;
use crate::build::recipe::options::BuildOptions;
use crate::exec::Executor;
use crate::geom::{Aabb, Point};
use crate::simd::{LaneBox, Lanes};
use crate::tree::Tree;

/// The SAH that a tree has once it is [fitted](crate::tree::refit) to a frame, with the options' costs. 0 where the frame has no area. The tree itself is not
/// changed.
///
/// # Panics
/// Where there is no such frame, or the tree is none over these triangles.
pub fn cost(tree: &Tree, motion: &Motion, frame: usize, options: &BuildOptions) -> f64 {
    cost_by(tree, &triangle_boxes(motion, frame), options, &mut Vec::new())
}

/// [`cost`] of every tree in every frame: a row a frame, a column a tree.
///
/// # Panics
/// Where a tree is none over these triangles.
pub fn costs(trees: &[Tree], motion: &Motion, options: &BuildOptions, exec: &Executor) -> Vec<Vec<f64>> {
    exec.map_range(motion.frames(), |frame| {
        let boxes = triangle_boxes(motion, frame);
        let mut nodes = Vec::new();
        trees.iter().map(|tree| cost_by(tree, &boxes, options, &mut nodes)).collect()
    })
}

/// What the triangles of a frame alone cost, each in a leaf of its own, as a share of the frame's box like [`cost`]. No tree changes it.
///
/// The same motion costs more in a frame with a small box than in one with a large one, whatever the tree. A cost divided by this can be compared with those of
/// other frames.
///
/// # Panics
/// Where there is no such frame.
pub fn triangle_cost(motion: &Motion, frame: usize, options: &BuildOptions) -> f64 {
    let start = (0.0, Aabb::EMPTY);
    let (sum, all) = triangle_boxes(motion, frame)
        .into_iter()
        .map(LaneBox::aabb)
        .fold(start, |(sum, all), b| (sum + half_area(&b), all.union(b)));
    let root = half_area(&all);
    if root > 0.0 { f64::from(options.intersection_cost) * sum / root } else { 0.0 }
}

fn triangle_boxes(motion: &Motion, frame: usize) -> Vec<LaneBox> {
    let positions = motion.positions(frame);
    let around = |triangle: &[u32; 3]| {
        triangle.iter().fold(LaneBox::EMPTY, |b, &v| b.grow(Lanes::of_point(positions[v as usize])))
    };
    motion.triangles().iter().map(around).collect()
}

/// `boxes` is room for those of the nodes, which several trees may have after one another.
fn cost_by(tree: &Tree, triangles: &[LaneBox], options: &BuildOptions, boxes: &mut Vec<LaneBox>) -> f64 {
    let [traversal, intersection] = [options.traversal_cost, options.intersection_cost].map(f64::from);
    boxes.clear();
    boxes.resize(tree.nodes.len(), LaneBox::EMPTY);
    let mut sum = 0.0;
    // Children stand behind their parents; record 1 is none.
    for i in (0..boxes.len()).rev().filter(|i| *i != 1) {
        let node = &tree.nodes[i];
        let first = node.first as usize;
        let weight = if node.is_leaf() {
            let refs = &tree.refs[first..first + node.count as usize];
            boxes[i] = refs.iter().fold(LaneBox::EMPTY, |b, &t| b.union(triangles[t as usize]));
            intersection * f64::from(node.count)
        } else {
            boxes[i] = boxes[first].union(boxes[first + 1]);
            traversal
        };
        sum += weight * half_area_between(boxes[i].min.point(), boxes[i].max.point());
    }
    match boxes.first().map(|root| half_area(&root.aabb())) {
        Some(root) if root > 0.0 => sum / root,
        _ => 0.0,
    }
}

/// Half of it, in `f64`, which no box overflows; 0 of an empty box.
pub(super) fn half_area(b: &Aabb) -> f64 {
    if b.is_empty() { 0.0 } else { half_area_between(b.min, b.max) }
}

/// The same of a box between two corners that is not empty.
fn half_area_between(min: Point, max: Point) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| f64::from(max[k]) - f64::from(min[k]));
    x * y + y * z + z * x
}
