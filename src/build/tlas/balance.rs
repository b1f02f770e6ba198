//! Halving by count: how instances are grouped, and the way out where clustering would go too deep.

use crate::geom::Aabb;

/// Depth of a tree over `count` items that is halved at every node.
pub(super) fn depth(count: u32) -> u32 {
    count.max(1).next_power_of_two().trailing_zeros()
}

/// Reorder at least two `items` so that the first half lies before the second on the axis where box centres are spread
/// widest, and return where the second half starts. Equal centres are ordered by item.
pub(super) fn partition(items: &mut [u32], bounds: &impl Fn(u32) -> Aabb) -> usize {
    let centers = items.iter().fold(Aabb::EMPTY, |b, &i| b.grow(bounds(i).center2()));
    let [x, y, z] = centers.extent();
    let axis = if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    };
    let mid = items.len().div_ceil(2);
    items.select_nth_unstable_by(mid, |&a, &b| {
        bounds(a).center2()[axis].total_cmp(&bounds(b).center2()[axis]).then(a.cmp(&b))
    });
    mid
}
