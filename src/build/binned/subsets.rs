//! The best split of two, three or four references, by trying all of them.
//!
//! Most nodes of a tree are that small. Seven splits of four references are fewer than the planes between four bins on
//! three axes, and no plane can do better.

use crate::build::cost::Sah;
use crate::build::prim_ref::PrimRef;
use crate::geom::Aabb;
use crate::simd::{LaneBox, Lanes};

/// Most references for which every split is tried.
pub(in crate::build) const EXHAUSTIVE: usize = 4;

/// A set of the node's references, one bit each in slot order: those that go left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::build) struct Subset(usize);

impl Subset {
    /// The set of the references in these slots.
    pub fn of(slots: impl Iterator<Item = usize>) -> Subset {
        Subset(slots.fold(0, |set, slot| set | 1 << slot))
    }

    pub fn has(self, slot: usize) -> bool {
        self.0 >> slot & 1 == 1
    }

    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }
}

/// Splits of `n` references into two sides that are not empty, but for swapping the sides.
const CANDIDATES: [&[usize]; EXHAUSTIVE + 1] = [&[], &[], &[1], &[1, 2, 4], &[1, 2, 4, 8, 3, 5, 9]];

/// The split of least weight, its weight and the two sides' boxes; of equal ones the first. `None` where no weight is
/// finite.
pub(in crate::build) fn best_subset(refs: &[PrimRef], scale: f32) -> Option<(Subset, f32, [Aabb; 2])> {
    let candidates = CANDIDATES.get(refs.len())?;
    let all = (1usize << refs.len()) - 1;

    // Take the box of every set from the one without its lowest member.
    let mut boxes = [LaneBox::EMPTY; 1 << EXHAUSTIVE];
    for set in 1..=all {
        let lowest = set.trailing_zeros() as usize;
        boxes[set] = boxes[set & (set - 1)].union(refs[lowest].lanes());
    }
    let mut weights = [0.0; 1 << EXHAUSTIVE];
    for first in (0..=all).step_by(4) {
        let four = [boxes[first], boxes[first + 1], boxes[first + 2], boxes[first + 3]];
        let counts = [0, 1, 2, 3].map(|k| (first + k).count_ones() as i32);
        let four = Sah::side_weights(LaneBox::scaled_half_areas(four, Lanes::splat(scale)), Lanes::of_counts(counts));
        weights[first..first + 4].copy_from_slice(&four.0);
    }

    let mut best: Option<(usize, f32)> = None;
    for &set in *candidates {
        let weight = weights[set] + weights[all ^ set];
        if weight < best.map_or(f32::INFINITY, |b| b.1) {
            best = Some((set, weight));
        }
    }

    // The side with the lower centre goes left, as with planes.
    let (set, weight) = best?;
    let set = if is_right_of(&boxes[set], &boxes[all ^ set]) { all ^ set } else { set };
    Some((Subset(set), weight, [boxes[set].aabb(), boxes[all ^ set].aabb()]))
}

/// Whether `a`'s centre is behind `b`'s on the axis on which they are farthest apart.
fn is_right_of(a: &LaneBox, b: &LaneBox) -> bool {
    let [x, y, z, _] = a.min.plus(a.max).minus(b.min.plus(b.max)).0;
    let larger = |p: f32, q: f32| if q.abs() > p.abs() { q } else { p };
    larger(larger(x, y), z) > 0.0
}

/// Put the subset's members first.
pub(super) fn partition_subset(refs: &mut [PrimRef], subset: Subset) -> usize {
    let mut left = 0;
    for i in 0..refs.len().min(EXHAUSTIVE) {
        if subset.has(i) {
            refs.swap(i, left);
            left += 1;
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(x: f32, prim: u32) -> PrimRef {
        PrimRef::new(&Aabb { min: [x, 0.0, 0.0], max: [x + 1.0, 1.0, 1.0] }, prim)
    }

    #[test]
    fn pairs_are_found_that_no_order_suggests() {
        let mut refs = [cube(0.0, 0), cube(50.0, 1), cube(1.0, 2), cube(51.0, 3)];
        let (subset, weight, bounds) = best_subset(&refs, 1.0).unwrap();
        assert_eq!(subset, Subset(0b0101));
        assert_eq!(weight, 2.0 * 5.0 + 2.0 * 5.0);
        assert_eq!((bounds[0].max[0], bounds[1].min[0]), (2.0, 50.0));
        assert_eq!(partition_subset(&mut refs, subset), 2);
        assert_eq!(refs.map(|r| r.prim), [0, 2, 1, 3]);
    }

    #[test]
    fn the_lower_side_goes_left() {
        let refs = [cube(9.0, 0), cube(0.0, 1)];
        assert_eq!(best_subset(&refs, 1.0).unwrap().0, Subset(0b10));
        let three = [cube(9.0, 0), cube(0.0, 1), cube(8.0, 2)];
        assert_eq!(best_subset(&three, 1.0).unwrap().0, Subset(0b010));
    }

    #[test]
    fn areas_that_are_no_numbers_give_no_split() {
        assert!(best_subset(&[cube(0.0, 0), cube(5.0, 1)], f32::NAN).is_none());
    }
}
