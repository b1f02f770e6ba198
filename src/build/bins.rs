//! Object bins: which bin a reference falls into, filling them, and the cheapest plane between two of them.

use super::cost::Sah;
use super::lanes::{LaneBox, Lanes};
use super::prim_ref::PrimRef;
use crate::geom::Aabb;

/// Maps a doubled centre to a bin on each axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinMap {
    origin: Lanes,
    /// Bins per unit; 0 on an axis where all centres are equal, or so near that the quotient is no finite number.
    scale: Lanes,
    last: f32,
}

/// Adding 1.5·2²³ to a small float rounds it to an integer, which then stands in the low bits: cheaper than a saturating conversion.
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
    pub fn bins_of(&self, center2: Lanes) -> [usize; 4] {
        let position = center2.minus(self.origin).times(self.scale).minus(Lanes::splat(0.5));
        position.min(Lanes::splat(self.last)).plus(Lanes::splat(ROUND)).0.map(|v| (v.to_bits() & 0xff) as usize)
    }

    #[inline(always)]
    pub fn bin_on(&self, axis: usize, r: &PrimRef) -> usize {
        let r = r.lanes();
        self.bins_of(r.min.plus(r.max))[axis]
    }
}

/// Bins of the three axes, at most `CAP` an axis. The order in which references are put in, or bins merged, makes no difference.
#[derive(Clone)]
pub(super) struct Bins<const CAP: usize> {
    boxes: [[LaneBox; 3]; CAP],
    counts: [[u32; 3]; CAP],
}

/// The cheapest plane: references in bins `..=bin` of `axis` go left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub axis: usize,
    pub bin: usize,
    /// [`Sah::weight`] with areas scaled.
    pub weight: f32,
}

impl<const CAP: usize> Bins<CAP> {
    pub fn empty() -> Self {
        Bins { boxes: [[LaneBox::EMPTY; 3]; CAP], counts: [[0; 3]; CAP] }
    }

    pub fn fill(&mut self, map: &BinMap, refs: &[PrimRef]) {
        for r in refs {
            let bounds = r.lanes();
            let bins = map.bins_of(bounds.min.plus(bounds.max));
            for axis in 0..3 {
                let bin = bins[axis] % CAP;
                let at = &mut self.boxes[bin][axis];
                *at = at.union(bounds);
                self.counts[bin][axis] += 1;
            }
        }
    }

    #[must_use]
    pub fn merge(mut self, other: &Self) -> Self {
        for (bin, boxes) in other.boxes.iter().enumerate() {
            for (axis, b) in boxes.iter().enumerate() {
                self.boxes[bin][axis] = self.boxes[bin][axis].union(*b);
                self.counts[bin][axis] += other.counts[bin][axis];
            }
        }
        self
    }

    /// The plane of least weight over the given axes and `bins` bins; of equal ones the first. Edges are multiplied by `scale` before areas are
    /// taken, so that neither huge nor tiny scenes leave the range of `f32`. `None` where no plane has a finite weight.
    pub fn best_plane(&self, map: &BinMap, axes: std::ops::Range<usize>, bins: usize, scale: f32) -> Option<Plane> {
        let mut best: Option<Plane> = None;
        let mut right = [(0.0, 0.0); CAP];
        for axis in axes.filter(|&a| map.separates(a)) {
            let (mut side, mut count) = (LaneBox::EMPTY, 0);
            for bin in (1..bins).rev() {
                side = side.union(self.boxes[bin][axis]);
                count += self.counts[bin][axis];
                right[bin] = (side.scaled_half_area(scale), count as f32);
            }
            let (mut side, mut count) = (LaneBox::EMPTY, 0);
            for bin in 0..bins - 1 {
                side = side.union(self.boxes[bin][axis]);
                count += self.counts[bin][axis];
                let (right_area, right_count) = right[bin + 1];
                let weight = Sah::weight(side.scaled_half_area(scale), count as f32, right_area, right_count);
                let sides = count > 0 && right_count > 0.0;
                if sides && best.map_or(weight < f32::INFINITY, |b| weight < b.weight) {
                    best = Some(Plane { axis, bin, weight });
                }
            }
        }
        best
    }

    /// Boxes of the two sides of a plane.
    pub fn sides(&self, plane: &Plane, bins: usize) -> [Aabb; 2] {
        let union = |range: std::ops::Range<usize>| {
            range.fold(LaneBox::EMPTY, |b, bin| b.union(self.boxes[bin][plane.axis])).aabb()
        };
        [union(0..plane.bin + 1), union(plane.bin + 1..bins)]
    }
}
