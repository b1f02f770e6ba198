//! The rough division: halving space at the middle of the centres' box until the groups are small.

use crate::build::exec::Executor;
use crate::build::prim_ref::PrimRef;
use crate::build::top_down::partition::{bounds_of, halve, partition};
use crate::build::top_down::strategy::NodeTask;
use crate::geom::Aabb;

/// References of a group at most.
pub(super) const GROUP: usize = 1 << 10;
/// After so many divisions of space, references are divided by their number: centres that crowd at one place would take one division
/// for every halving of the distance.
const HALVINGS: u32 = 40;

/// References that become one mini tree.
pub(super) struct Group<'a> {
    pub refs: &'a mut [PrimRef],
    pub bounds: Aabb,
    pub centroids: Aabb,
}

/// The groups in the order of the division; none for no references.
pub(super) fn divide<'a>(refs: &'a mut [PrimRef], centroids: Aabb, exec: &Executor) -> Vec<Group<'a>> {
    if refs.is_empty() {
        return Vec::new();
    }
    divide_below(refs, centroids, 0, exec)
}

fn divide_below<'a>(refs: &'a mut [PrimRef], centroids: Aabb, depth: u32, exec: &Executor) -> Vec<Group<'a>> {
    if refs.len() <= GROUP {
        let bounds = bounds_of(refs).0;
        return vec![Group { refs, bounds, centroids }];
    }
    let extent = centroids.extent();
    let axis = (1..3).fold(0, |best, a| if extent[a] > extent[best] { a } else { best });
    let middle = centroids.min[axis] * 0.5 + centroids.max[axis] * 0.5;
    let (mut left, mut sides) = (0, [centroids; 2]);
    if depth < HALVINGS && centroids.min[axis] < middle && middle <= centroids.max[axis] {
        (left, sides) = partition(refs, exec, |r| r.min[axis] + r.max[axis] < middle);
    }
    if left == 0 || left == refs.len() {
        let node = NodeTask { bounds: centroids, centroids, live: refs.len(), depth };
        let (first, second) = halve(&node, refs);
        (left, sides) = (first.live, [first.centroids, second.centroids]);
    }
    let (left_refs, right_refs) = refs.split_at_mut(left);
    let (mut groups, others) = exec.join(
        || divide_below(left_refs, sides[0], depth + 1, exec),
        || divide_below(right_refs, sides[1], depth + 1, exec),
    );
    groups.extend(others);
    groups
}
