//! Boxes made anew from what leaves hold, in a tree whose shape stays.

use crate::geom::Aabb;
use crate::layout::{IndexedTriangleRecord, Node};

/// Fit every box to what is below it, from the leaves up. `leaf` gives the box of so many items from a first one on.
///
/// Children lie behind their parents (rule E0402), so one pass from the end is enough. What leads elsewhere keeps its box: records that are no tree
/// are told of by whoever walks them.
pub fn fit(nodes: &mut [Node], leaf: impl Fn(usize, usize) -> Option<Aabb>) {
    for i in (0..nodes.len()).rev().filter(|i| *i != 1) {
        let Node { first, count, .. } = nodes[i];
        let first = first as usize;
        let bounds = if count != 0 {
            leaf(first, count as usize)
        } else {
            let pair = nodes.get(first..).and_then(|n| n.first_chunk::<2>()).filter(|_| first > i);
            pair.map(|[a, b]| a.bounds().union(b.bounds()))
        };
        if let Some(Aabb { min, max }) = bounds {
            (nodes[i].min, nodes[i].max) = (min, max);
        }
    }
}

/// [`fit`] to whole triangles: in a tree with spatial splits, leaves may hold parts of triangles, which cannot follow their vertices.
pub fn fit_whole(nodes: &mut [Node], triangles: &[IndexedTriangleRecord], vertices: &[[f32; 3]]) {
    fit(nodes, |first, count| {
        let some = triangles.get(first..first.checked_add(count)?)?;
        let corners = some.iter().flat_map(|triangle| triangle.corners);
        let at = |bounds: Aabb, v: u32| vertices.get(v as usize).map_or(bounds, |p| bounds.grow(*p));
        Some(corners.fold(Aabb::EMPTY, at))
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn boxes_follow_the_leaves_and_broken_links_are_left_alone() {
        let node = |first, count| Node { first, count, ..Node::zeroed() };
        let sound = [node(2, 0), Node::zeroed(), node(4, 0), node(0, 1), node(1, 1), node(2, 1)];
        let leaf = |first: usize, count: usize| {
            assert_eq!(count, 1);
            Some(Aabb { min: [first as f32; 3], max: [first as f32 + 1.0; 3] })
        };
        let mut nodes = sound;
        fit(&mut nodes, leaf);
        let along: Vec<[f32; 2]> = nodes.iter().map(|n| [n.min[0], n.max[0]]).collect();
        assert_eq!(along, [[0.0, 3.0], [0.0, 0.0], [1.0, 3.0], [0.0, 1.0], [1.0, 2.0], [2.0, 3.0]]);

        // A cycle, and links beyond the records.
        for first in [0, 2, 5, u32::MAX] {
            let mut nodes = sound;
            nodes[2].first = first;
            fit(&mut nodes, leaf);
            assert_eq!(nodes[2].max, [0.0; 3]);
        }
        fit(&mut [], leaf);
    }
}
