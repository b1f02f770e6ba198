//! The rough division: halving space at the middle of the centres' box until the groups are small.
//!
//! Nothing of it is left in the tree but the groups' borders. Those of a binned SAH suit scans better, by 2 % of the SAH, but take so long
//! to find that nothing would be won over the plain sweep.

use crate::build::prim_ref::{PrimRef, bounds_of};
use crate::build::top_down::partition::{halve, partition};
use crate::build::top_down::strategy::NodeTask;
use crate::exec::Executor;
use crate::geom::Aabb;

/// References of a group at most.
const GROUP: usize = 1 << 11;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::prim_ref::PrimRefs;

    fn point(p: [f32; 3]) -> Aabb {
        Aabb { min: p, max: p }
    }

    #[test]
    fn groups_are_small_tight_and_hold_everything_whatever_the_places() {
        let spread = |i: usize| point([(i * 7919 % 10_007) as f32, (i * 104_729 % 1_009) as f32, 0.0]);
        let series = |i: usize| point([0.5f32.powi(i as i32 % 149), 0.0, 0.0]);
        let same = |_: usize| point([1.0, -2.0, 3.0]);
        let extreme = |i: usize| point([if i.is_multiple_of(2) { f32::MAX } else { f32::MIN }, i as f32 * 1e-45, 0.0]);
        let places: [&dyn Fn(usize) -> Aabb; 4] = [&spread, &series, &same, &extreme];
        for place in places {
            for count in [0, 1, GROUP, GROUP + 1, 20_000] {
                let exec = Executor::new(2).unwrap();
                let boxes: Vec<Aabb> = (0..count).map(place).collect();
                let mut input = PrimRefs::of_boxes(&boxes, &exec);
                let groups = divide(&mut input.refs, input.centroids, &exec);
                let mut seen = vec![false; count];
                for group in &groups {
                    assert!((1..=GROUP).contains(&group.refs.len()));
                    assert_eq!((group.bounds, group.centroids), bounds_of(group.refs));
                    group.refs.iter().for_each(|r| assert!(!std::mem::replace(&mut seen[r.prim as usize], true)));
                }
                assert!(!seen.contains(&false));
                // No crowd of crumbs, not even where halving space takes one place off at a time.
                assert!(groups.len() <= 64 + count / 8, "{} groups of {count}", groups.len());
            }
        }
    }
}
