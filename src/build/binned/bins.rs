//! Object bins: which bin a reference falls into, filling them, and the cheapest plane between two of them.

use crate::build::cost::Sah;
use crate::build::prim_ref::PrimRef;
use crate::geom::Aabb;
use crate::simd::{LaneBox, Lanes};

/// Maps a doubled centre to a bin on each axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinMap {
    origin: Lanes,
    /// Bins per unit; 0 on an axis where all centres are equal, or so near that the quotient is no finite number.
    scale: Lanes,
    last: f32,
}

/// Adding 1.5·2²³ to a small float rounds it to an integer, which then stands in the low bits: cheaper than a
/// saturating conversion.
const ROUND: f32 = 12_582_912.0;

impl BinMap {
    pub fn new(centroids: &Aabb, bins: usize) -> BinMap {
        // A little less than `bins`, so that the largest centre falls into the last bin rather than behind it.
        let width = bins as f32 * 0.9999;
        let scale = centroids.extent().map(|e| {
            let scale = width / e;
            if e > 0.0 && scale.is_finite() && scale > 0.0 { scale } else { 0.0 }
        });
        BinMap { origin: Lanes::of_point(centroids.min), scale: Lanes::of_point(scale), last: (bins - 1) as f32 }
    }

    /// Whether the axis has more than one bin.
    pub fn separates(&self, axis: usize) -> bool {
        self.scale.0[axis] > 0.0
    }

    /// The bin on each axis: `floor((c - origin)·scale)`, but for ties.
    #[inline(always)]
    pub fn bins_of(&self, center2: Lanes) -> [u32; 4] {
        let position = center2.minus(self.origin).axes().times(self.scale).minus(Lanes::splat(0.5));
        position.min(Lanes::splat(self.last)).plus(Lanes::splat(ROUND)).low_bytes()
    }

    /// One axis' half of the map: the same arithmetic, hence the same bins.
    pub fn on_axis(&self, axis: usize) -> AxisMap {
        AxisMap { axis, origin: self.origin.0[axis], scale: self.scale.0[axis], last: self.last }
    }
}

/// [`BinMap`] on one axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct AxisMap {
    axis: usize,
    origin: f32,
    scale: f32,
    last: f32,
}

impl AxisMap {
    #[inline(always)]
    pub fn bin_of(&self, r: &PrimRef) -> u32 {
        let position = (r.min[self.axis] + r.max[self.axis] - self.origin) * self.scale - 0.5;
        let position = if position < self.last { position } else { self.last };
        (position + ROUND).to_bits() & 0xff
    }
}

/// From so many references a bin on, two or four sets of bins are filled in turn; below, that costs more than it saves.
const TWO_SETS: usize = 8;
const FOUR_SETS: usize = 32;

/// Bins of the three axes, at most `CAP` an axis. The order in which references are put in, or bins merged, makes no
/// difference.
#[derive(Clone)]
pub(super) struct Bins<const CAP: usize> {
    boxes: [[LaneBox; 3]; CAP],
    counts: [[i32; 4]; CAP],
}

/// The cheapest plane: references in bins `..=bin` of `axis` go left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub axis: usize,
    pub bin: u32,
    /// [`Sah::weight`] with areas scaled.
    pub weight: f32,
}

impl<const CAP: usize> Bins<CAP> {
    pub const EMPTY: Self = Bins { boxes: [[LaneBox::EMPTY; 3]; CAP], counts: [[0; 4]; CAP] };

    /// Neighbours often fall into one bin, and the box of the one must be written and read again before the other can join it.
    /// So many references are put into several sets of bins in turn.
    pub fn fill(&mut self, map: &BinMap, refs: &[PrimRef]) {
        match refs.len() / CAP {
            ..TWO_SETS => refs.iter().for_each(|r| self.put(map, r)),
            ..FOUR_SETS => self.fill_in_turn::<1>(map, refs),
            _ => self.fill_in_turn::<3>(map, refs),
        }
    }

    /// [`Bins::fill`] with so many sets beside this one.
    #[inline(never)]
    fn fill_in_turn<const MORE: usize>(&mut self, map: &BinMap, refs: &[PrimRef]) {
        let mut others = [const { Self::EMPTY }; MORE];
        let groups = refs.chunks_exact(1 + MORE);
        groups.remainder().iter().for_each(|r| self.put(map, r));
        for group in groups {
            self.put(map, &group[MORE]);
            for (set, r) in others.iter_mut().zip(group) {
                set.put(map, r);
            }
        }
        others.iter().for_each(|set| self.merge(set));
    }

    #[inline(always)]
    fn put(&mut self, map: &BinMap, r: &PrimRef) {
        let bounds = r.lanes();
        let bins = map.bins_of(bounds.min.plus(bounds.max));
        for (axis, bin) in bins.into_iter().take(3).enumerate() {
            let bin = bin as usize % CAP;
            let at = &mut self.boxes[bin][axis];
            *at = at.union(bounds);
            self.counts[bin][axis] += 1;
        }
    }

    pub fn merge(&mut self, other: &Self) {
        for (bin, boxes) in other.boxes.iter().enumerate() {
            for (axis, b) in boxes.iter().enumerate() {
                self.boxes[bin][axis] = self.boxes[bin][axis].union(*b);
                self.counts[bin][axis] += other.counts[bin][axis];
            }
        }
    }

    /// The plane of least weight over the given axes and `bins` bins; of equal ones the first. Edges are multiplied by
    /// `scale` before areas are taken, so that neither huge nor tiny scenes leave the range of `f32`. `None` where no
    /// plane has a finite weight.
    ///
    /// The three axes are swept side by side, one a lane. A plane with nothing on one side has a NaN for its weight (no
    /// box times no references), which is less than nothing else.
    pub fn best_plane(&self, map: &BinMap, axes: std::ops::Range<usize>, bins: usize, scale: f32) -> Option<Plane> {
        let bins = bins.min(CAP);
        let scale = Lanes::splat(scale);

        // Weigh everything right of each plane.
        let mut right = [Lanes::splat(0.0); CAP];
        let mut side = Sides::EMPTY;
        for bin in (1..bins).rev() {
            side.extend(&self.boxes[bin], self.counts[bin]);
            right[bin] = side.weights(scale);
        }

        // Add what is left of it, and keep each axis' least sum.
        let mut side = Sides::EMPTY;
        let (mut least, mut at) = (Lanes::splat(f32::INFINITY), Lanes::splat(0.0));
        for (bin, right) in right[..bins].iter().skip(1).enumerate() {
            side.extend(&self.boxes[bin], self.counts[bin]);
            let weight = side.weights(scale).plus(*right);
            at = weight.if_less(least, Lanes::splat(bin as f32), at);
            least = weight.min(least);
        }

        // Take the best axis.
        let mut best: Option<Plane> = None;
        for axis in axes.filter(|&a| map.separates(a)) {
            let weight = least.0[axis];
            if weight < best.map_or(f32::INFINITY, |b| b.weight) {
                best = Some(Plane { axis, bin: at.0[axis] as u32, weight });
            }
        }
        best
    }

    /// Boxes of the two sides of a plane.
    pub fn sides(&self, plane: &Plane, bins: usize) -> [Aabb; 2] {
        let middle = plane.bin as usize + 1;
        let union = |bins: &[[LaneBox; 3]]| bins.iter().fold(LaneBox::EMPTY, |b, bin| b.union(bin[plane.axis])).aabb();
        [union(&self.boxes[..middle]), union(&self.boxes[middle..bins])]
    }
}

/// One side of a plane on each axis.
struct Sides {
    boxes: [LaneBox; 3],
    counts: [i32; 4],
}

impl Sides {
    const EMPTY: Sides = Sides { boxes: [LaneBox::EMPTY; 3], counts: [0; 4] };

    #[inline(always)]
    fn extend(&mut self, boxes: &[LaneBox; 3], counts: [i32; 4]) {
        for (side, bin) in self.boxes.iter_mut().zip(boxes) {
            *side = side.union(*bin);
        }
        for (side, bin) in self.counts.iter_mut().zip(counts) {
            *side += bin;
        }
    }

    #[inline(always)]
    fn weights(&self, scale: Lanes) -> Lanes {
        let [x, y, z] = self.boxes;
        Sah::side_weights(LaneBox::scaled_half_areas([x, y, z, z], scale), Lanes::of_counts(self.counts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::prim_ref::bounds_of;

    #[test]
    fn sets_filled_in_turn_hold_what_one_holds() {
        for count in [1, 8 * TWO_SETS - 1, 8 * TWO_SETS, 8 * TWO_SETS + 1, 8 * FOUR_SETS, 8 * FOUR_SETS + 3] {
            let at = |i: usize| [i * 7919 % 101, i * 104_729 % 37, i % 5].map(|v| v as f32);
            let boxes = (0..count).map(|i| Aabb { min: at(i), max: at(i).map(|v| v + 0.5 + (i % 3) as f32) });
            let refs: Vec<PrimRef> = boxes.zip(0..).map(|(b, prim)| PrimRef::new(&b, prim)).collect();
            let map = BinMap::new(&bounds_of(&refs).1, 8);
            let (mut in_turn, mut one_by_one) = (Bins::<8>::EMPTY, Bins::<8>::EMPTY);
            in_turn.fill(&map, &refs);
            refs.iter().for_each(|r| one_by_one.put(&map, r));
            assert_eq!(in_turn.counts, one_by_one.counts, "{count}");
            let corners = |bins: &Bins<8>| bins.boxes.map(|bin| bin.map(LaneBox::aabb));
            assert_eq!(corners(&in_turn), corners(&one_by_one), "{count}");
        }
    }
}
