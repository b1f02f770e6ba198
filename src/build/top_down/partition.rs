//! Moving references to their side of a split.

use super::strategy::{Child, NodeTask};
use crate::build::prim_ref::{PrimRef, bounds_of};
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::simd::LaneBox;

/// From so many references on, a node is partitioned in chunks of [`CHUNK`]. Constants: the order of the references
/// afterwards must not depend on the number of threads.
const CHUNKED: usize = 1 << 15;
const CHUNK: usize = 1 << 13;

/// Centroid boxes of both sides.
type Sides = [LaneBox; 2];

/// Put the references with `goes_left` first. Returns how many those are, and both sides' centroid boxes.
pub(in crate::build) fn partition(
    refs: &mut [PrimRef],
    exec: &Executor,
    goes_left: impl Fn(&PrimRef) -> bool + Sync,
) -> (usize, [Aabb; 2]) {
    let (left, sides) =
        if refs.len() < CHUNKED { partition_run(refs, &goes_left) } else { partition_chunks(refs, exec, &goes_left) };
    (left, sides.map(LaneBox::aabb))
}

/// One pass without a data-dependent branch: every reference is swapped to the end of the left run, and the run grows
/// or does not. The reference that comes back in exchange belongs to the right.
#[inline]
fn partition_run(refs: &mut [PrimRef], goes_left: &impl Fn(&PrimRef) -> bool) -> (usize, Sides) {
    let mut left = 0;
    for i in 0..refs.len() {
        let is_left = goes_left(&refs[i]);
        let moved: &mut [LaneBox] = bytemuck::cast_slice_mut(refs);
        let (here, there) = (moved[i], moved[left]);
        moved[i] = there;
        moved[left] = here;
        left += usize::from(is_left);
    }
    (left, [centroid_box(&refs[..left]), centroid_box(&refs[left..])])
}

/// Box of the doubled centres. Four at a time, since one would wait for the minimum before it.
fn centroid_box(refs: &[PrimRef]) -> LaneBox {
    let center2 = |r: &PrimRef| {
        let r = r.lanes();
        r.min.plus(r.max)
    };
    let mut boxes = [LaneBox::EMPTY; 4];
    let fours = refs.chunks_exact(4);
    for r in fours.remainder() {
        boxes[0] = boxes[0].grow(center2(r));
    }
    for four in fours {
        for (b, r) in boxes.iter_mut().zip(four) {
            *b = b.grow(center2(r));
        }
    }
    boxes[0].union(boxes[1]).union(boxes[2].union(boxes[3]))
}

/// Partition each chunk, then exchange the references that stand on the wrong side of the final boundary: as many to
/// its left as to its right.
fn partition_chunks(
    refs: &mut [PrimRef],
    exec: &Executor,
    goes_left: &(impl Fn(&PrimRef) -> bool + Sync),
) -> (usize, Sides) {
    let parts = exec.map_chunks_mut(refs, CHUNK, |_, chunk| (chunk.len(), partition_run(chunk, goes_left)));
    let left: usize = parts.iter().map(|(_, (left, _))| left).sum();
    let sides = parts.iter().fold([LaneBox::EMPTY; 2], |[a, b], (_, (_, [c, d]))| [a.union(*c), b.union(*d)]);

    // Collect the runs of strangers in each half.
    let (left_half, right_half) = refs.split_at_mut(left);
    let (mut start, mut in_left, mut in_right) = (0, Vec::new(), Vec::new());
    for (len, (chunk_left, _)) in &parts {
        let (boundary, end) = (start + chunk_left, start + len);
        in_left.push(boundary.min(left)..end.min(left));
        in_right.push(start.max(left) - left..boundary.max(left) - left);
        start = end;
    }
    exchange(left_half, in_left, right_half, in_right, exec);
    (left, sides)
}

/// Swap the k-th reference of the runs `of_a` with the k-th of the runs `of_b`. Both lists ascend and hold equally
/// many.
fn exchange(
    a: &mut [PrimRef],
    of_a: Vec<std::ops::Range<usize>>,
    b: &mut [PrimRef],
    of_b: Vec<std::ops::Range<usize>>,
    exec: &Executor,
) {
    let mut runs_b = cut(b, of_b).into_iter();
    let mut b: &mut [PrimRef] = &mut [];
    let mut swaps = Vec::new();
    'runs: for mut a in cut(a, of_a) {
        while !a.is_empty() {
            while b.is_empty() {
                let Some(next) = runs_b.next() else { break 'runs };
                b = next;
            }
            let common = a.len().min(b.len());
            let (a_head, a_tail) = a.split_at_mut(common);
            let (b_head, b_tail) = b.split_at_mut(common);
            swaps.push((a_head, b_head));
            (a, b) = (a_tail, b_tail);
        }
    }
    exec.map(swaps, |_, (a, b)| a.swap_with_slice(b));
}

/// Disjoint ascending ranges of a slice as slices, without the empty ones.
pub(in crate::build) fn cut<T>(mut slice: &mut [T], ranges: Vec<std::ops::Range<usize>>) -> Vec<&mut [T]> {
    let mut taken = 0;
    let mut out = Vec::with_capacity(ranges.len());
    for range in ranges.into_iter().filter(|r| !r.is_empty()) {
        let (_, tail) = std::mem::take(&mut slice).split_at_mut(range.start - taken);
        let (head, tail) = tail.split_at_mut(range.len());
        out.push(head);
        slice = tail;
        taken = range.end;
    }
    out
}

/// The driver's split where no strategy has one: the references in the order of their centres along the longest side of
/// the centroid box, equal centres in the order of their numbers, cut in the middle.
pub(in crate::build) fn halve(task: &NodeTask, slots: &mut [PrimRef]) -> (Child, Child) {
    let middle = task.live.div_ceil(2);
    let extent = task.centroids.extent();
    let axis = (1..3).fold(0, |best, a| if extent[a] > extent[best] { a } else { best });
    // A full sort, not a selection: where a selection leaves the rest is the standard library's affair and may change with it.
    // Below the first such split the halves are sorted already, which costs one pass.
    slots[..task.live].sort_unstable_by(|a, b| {
        let (ca, cb) = (a.center2()[axis], b.center2()[axis]);
        ca.total_cmp(&cb).then_with(|| bytes_of(a).cmp(&bytes_of(b)))
    });

    // Hand half of the free slots to each side.
    let left_slots = middle + (slots.len() - task.live) / 2;
    slots.copy_within(middle..task.live, left_slots);
    let child = |refs: &[PrimRef], slots: usize| {
        let (bounds, centroids) = bounds_of(refs);
        Child { bounds, centroids, live: refs.len(), slots }
    };
    let right_live = task.live - middle;
    (child(&slots[..middle], left_slots), child(&slots[left_slots..left_slots + right_live], slots.len() - left_slots))
}

/// A total order of references that starts with the primitive's number.
fn bytes_of(r: &PrimRef) -> (u32, u32, [u32; 3], [u32; 3]) {
    (r.prim, r.extra, r.min.map(f32::to_bits), r.max.map(f32::to_bits))
}
