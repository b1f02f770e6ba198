//! Object splits of small nodes: every split of the references in the order of their centres, on all axes. For a few references that is
//! quicker than bins, and it misses nothing.

use crate::build::cost::Sah;
use crate::build::prim_ref::PrimRef;
use crate::build::top_down::strategy::Child;
use crate::simd::{LaneBox, Lanes};

/// Largest node that can be swept.
pub(super) const MAX: usize = 32;

/// The cheapest split of the references sorted along an axis.
#[derive(Clone, Copy)]
pub(super) struct SmallSplit {
    /// The references' places in the sorted order.
    order: [u8; MAX],
    live: usize,
    left: usize,
    pub bounds: [LaneBox; 2],
    /// [`Sah::weight`] with areas scaled.
    pub weight: f32,
}

/// The split of least weight; of equal ones the first. `None` where no weight is a finite number.
pub(super) fn find(refs: &[PrimRef], scale: f32) -> Option<SmallSplit> {
    let live = refs.len().min(MAX);
    let mut best: Option<SmallSplit> = None;
    let mut boxes = [LaneBox::EMPTY; MAX];
    let mut centres = [Lanes::splat(0.0); MAX];
    for ((b, c), r) in boxes.iter_mut().zip(&mut centres).zip(refs) {
        *b = r.lanes();
        *c = b.min.plus(b.max);
    }
    for axis in 0..3 {
        // Sort by insertion; equal centres keep their order.
        let mut order = [0u8; MAX];
        let mut keys = [0.0f32; MAX];
        for (i, centre) in centres[..live].iter().enumerate() {
            let key = centre.0[axis];
            let mut at = i;
            while at > 0 && keys[at - 1] > key {
                (keys[at], order[at]) = (keys[at - 1], order[at - 1]);
                at -= 1;
            }
            (keys[at], order[at]) = (key, i as u8);
        }
        if keys[0] == keys[live - 1] {
            continue;
        }

        let mut right = [(LaneBox::EMPTY, 0.0); MAX];
        let mut side = LaneBox::EMPTY;
        for i in (1..live).rev() {
            side = side.union(boxes[order[i] as usize % MAX]);
            right[i] = (side, side.scaled_half_area(scale));
        }
        let mut side = LaneBox::EMPTY;
        for i in 1..live {
            side = side.union(boxes[order[i - 1] as usize % MAX]);
            let weight = Sah::weight(side.scaled_half_area(scale), i as f32, right[i].1, (live - i) as f32);
            if weight < best.map_or(f32::INFINITY, |b| b.weight) {
                best = Some(SmallSplit { order, live, left: i, bounds: [side, right[i].0], weight });
            }
        }
    }
    best
}

impl SmallSplit {
    /// Carry out the split. Both children get no more slots than they have references.
    pub fn apply(&self, refs: &mut [PrimRef]) -> (Child, Child) {
        let mut sorted = [bytemuck::Zeroable::zeroed(); MAX];
        for (to, from) in sorted.iter_mut().zip(&self.order[..self.live]) {
            *to = refs[*from as usize];
        }
        refs.copy_from_slice(&sorted[..self.live]);
        let child = |side: usize, refs: &[PrimRef]| {
            let centroids = refs.iter().fold(LaneBox::EMPTY, |b, r| {
                let r = r.lanes();
                b.grow(r.min.plus(r.max))
            });
            Child { bounds: self.bounds[side].aabb(), centroids: centroids.aabb(), live: refs.len(), slots: refs.len() }
        };
        (child(0, &refs[..self.left]), child(1, &refs[self.left..]))
    }
}
