use bvhc_core::refit::RefitError;

use crate::exec::Executor;
use crate::geom::Point;

use super::Node;

/// Fit the boxes of a tree to its triangles where they stand now, bottom-up, and leave everything else of it as it is.
///
/// `corners` gives the corners of what stands in each slot of the leaf order. Each leaf gets the smallest box around the whole of its
/// triangles, also where a spatial split had cut it smaller, and each inner node the union of its children's. A tree that was built over these very corners
/// without spatial splits is not changed by one bit.  For records of a file there is
/// [`refit`](mod@crate::refit).
///
/// # Errors
/// Where the nodes are none of a [`Tree`](super::Tree): children behind their parents and within the slice.
pub fn refit(nodes: &mut [Node], corners: impl Fn(usize) -> [Point; 3] + Sync) -> Result<(), RefitError> {
    refit_on(nodes, corners, &Executor::sequential())
}

/// [`refit`] with the threads of `exec`: the same boxes.
///
/// # Errors
/// As [`refit`].
pub fn refit_on(
    nodes: &mut [Node],
    corners: impl Fn(usize) -> [Point; 3] + Sync,
    exec: &Executor,
) -> Result<(), RefitError> {
    bvhc_core::refit::refit_by(nodes, usize::MAX, corners, exec)
}

/// [`refit_on`] of the nodes of a tree that was built here.
pub(crate) fn refit_built(nodes: &mut [Node], corners: impl Fn(usize) -> [Point; 3] + Sync, exec: &Executor) {
    refit_on(nodes, corners, exec).expect("children of a tree stand behind their parents");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, NoProgress};
    use crate::compile::build_tree;
    use crate::geom::Aabb;
    use crate::scene::Mesh;

    /// A wavy sheet at a time.
    fn sheet(time: f32) -> Mesh {
        let side = 24u32;
        let at = |i: u32| {
            let (x, z) = ((i % side) as f32, (i / side) as f32);
            [x, (x * 0.7 + time).sin() * 2.0 + z * 0.1, z]
        };
        let cell = |c: u32| {
            let v = c / (side - 1) * side + c % (side - 1);
            [[v, v + 1, v + side], [v + 1, v + side + 1, v + side]]
        };
        let triangles = (0..(side - 1) * (side - 1)).flat_map(cell).collect();
        Mesh { positions: (0..side * side).map(at).collect(), triangles, ..Mesh::default() }
    }

    #[test]
    fn a_refit_to_the_corners_it_was_built_over_changes_nothing() {
        let mesh = sheet(0.0);
        let exec = Executor::sequential();
        let tree = build_tree(&mesh, &BuildOptions::default(), &exec, &NoProgress).unwrap();
        let mut nodes = tree.nodes.clone();
        refit(&mut nodes, |slot| mesh.corners(tree.refs[slot] as usize)).unwrap();
        let split = tree.refs.len() > mesh.triangles.len();
        assert!(split || nodes == tree.nodes);
    }

    #[test]
    fn boxes_hold_moved_triangles_and_no_more() {
        let (still, moved) = (sheet(0.0), sheet(1.3));
        let exec = Executor::sequential();
        let tree = build_tree(&still, &BuildOptions::default(), &exec, &NoProgress).unwrap();
        let mut nodes = tree.nodes.clone();
        refit(&mut nodes, |slot| moved.corners(tree.refs[slot] as usize)).unwrap();
        assert_ne!(nodes, tree.nodes);
        for (i, node) in nodes.iter().enumerate().filter(|(i, _)| *i != 1) {
            let first = node.first as usize;
            let want = if node.is_leaf() {
                let slots = first..first + node.count as usize;
                let boxes = slots.map(|slot| moved.triangle_box(tree.refs[slot] as usize));
                boxes.fold(Aabb::EMPTY, Aabb::union)
            } else {
                nodes[first].bounds().union(nodes[first + 1].bounds())
            };
            assert_eq!((node.min, node.max), (want.min, want.max), "node {i}");
            assert_eq!((node.first, node.count), (tree.nodes[i].first, tree.nodes[i].count));
        }
        assert_eq!(nodes[0].bounds(), Aabb::from_points(&moved.positions));
    }
}
