//! What a walk reads of a node, whatever its layout.

use crate::layout::{CompactNode, WideNode};
use crate::simd::{Floats, prefetch};

/// A node of up to `N` children.
pub trait WideRecord<const N: usize>: Copy + Sync {
    /// Whether the triangles of leaves stand in [blocks](super::WideView::blocks).
    const IN_BLOCKS: bool;

    /// Minima and maxima of the boxes on an axis, or with `swapped` maxima and minima.
    fn planes<V: Floats<N>>(&self, door: V::Door, axis: usize, swapped: bool) -> (V, V);
    /// Ask for what is read after the boxes.
    fn prefetch_links(&self);
    /// A bit for each lane that has a child. A lane without one may have its bit where its box is empty.
    fn used(&self) -> u32;
    /// The first node or reference of the child in a lane, and how many references it has, 0 for a node.
    fn links(&self, lane: usize) -> (u32, u32);
}

impl<const N: usize> WideRecord<N> for WideNode<N> {
    const IN_BLOCKS: bool = true;

    #[inline(always)]
    fn planes<V: Floats<N>>(&self, door: V::Door, axis: usize, swapped: bool) -> (V, V) {
        let [first, second] = rows(axis, swapped);
        (V::of(door, &self.planes[first]), V::of(door, &self.planes[second]))
    }

    #[inline(always)]
    fn prefetch_links(&self) {
        prefetch(&self.first, size_of_val(&self.first) + size_of_val(&self.count));
    }

    #[inline(always)]
    fn used(&self) -> u32 {
        u32::MAX
    }

    #[inline(always)]
    fn links(&self, lane: usize) -> (u32, u32) {
        (self.first[lane], self.count[lane])
    }
}

impl WideRecord<8> for CompactNode {
    const IN_BLOCKS: bool = false;

    #[inline(always)]
    fn planes<V: Floats<8>>(&self, door: V::Door, axis: usize, swapped: bool) -> (V, V) {
        let (origin, scale) = (V::splat(door, self.corner(axis)), V::splat(door, self.scale(axis)));
        let [first, second] = rows(axis, swapped);
        let first = V::times(V::of_bytes(door, &self.planes[first]), scale);
        let second = V::times(V::of_bytes(door, &self.planes[second]), scale);
        (V::plus(first, origin), V::plus(second, origin))
    }

    #[inline(always)]
    fn prefetch_links(&self) {}

    #[inline(always)]
    fn used(&self) -> u32 {
        (1u32 << self.children.min(8)) - 1
    }

    #[inline(always)]
    fn links(&self, lane: usize) -> (u32, u32) {
        let count = self.counts[lane];
        let first = if count == 0 {
            self.first_node.wrapping_add(nodes_before(self.counts, lane))
        } else {
            self.first_ref.wrapping_add(refs_before(self.counts, lane))
        };
        (first, u32::from(count))
    }
}

/// Which rows of planes are the minima and maxima of an axis.
#[inline(always)]
fn rows(axis: usize, swapped: bool) -> [usize; 2] {
    [axis + 3 * usize::from(swapped), axis + 3 * usize::from(!swapped)]
}

/// How many of the lanes before this one have no references.
#[inline(always)]
fn nodes_before(counts: [u8; 8], lane: usize) -> u32 {
    let before = u64::from_le_bytes(counts);
    // The highest bit of each byte that is not 0, without a carry to the next; then a 1 for each byte that is, in the lanes before.
    let some = ((before & 0x7F7F_7F7F_7F7F_7F7F) + 0x7F7F_7F7F_7F7F_7F7F) | before;
    let none = (!some >> 7) & 0x0101_0101_0101_0101 & below(lane);
    (none.wrapping_mul(0x0101_0101_0101_0101) >> 56) as u32
}

/// The bytes of the lanes before this one, which is at most 7.
#[inline(always)]
fn below(lane: usize) -> u64 {
    (1u64 << (8 * (lane % 8))) - 1
}

/// How many references the lanes before this one have.
#[inline(always)]
fn refs_before(counts: [u8; 8], lane: usize) -> u32 {
    let before = u64::from_le_bytes(counts) & below(lane);
    // Two bytes a sum, and the last of them the sum of all four: at most 8·255.
    let sums = (before & 0x00FF_00FF_00FF_00FF) + (before >> 8 & 0x00FF_00FF_00FF_00FF);
    (sums.wrapping_mul(0x0001_0001_0001_0001) >> 48) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_count_what_stands_in_the_lanes_before() {
        let counts = [255, 0, 255, 255, 0, 0, 255, 255];
        let node = CompactNode { children: 8, first_node: 10, first_ref: 100, counts, ..CompactNode::default() };
        let links: Vec<(u32, u32)> = (0..8).map(|lane| node.links(lane)).collect();
        let nodes: Vec<u32> = links.iter().filter(|l| l.1 == 0).map(|l| l.0).collect();
        let refs: Vec<u32> = links.iter().filter(|l| l.1 > 0).map(|l| l.0).collect();
        assert_eq!(nodes, [10, 11, 12]);
        assert_eq!(refs, [100, 355, 610, 865, 1120]);
        assert_eq!([0, 3, 8].map(|children| CompactNode { children, ..node }.used()), [0, 0b111, 0xFF]);
    }
}
