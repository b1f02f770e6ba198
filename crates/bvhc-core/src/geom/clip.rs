//! The project's only maker of clipped boxes: what part of a triangle lies between two axis-aligned planes or inside a box.
//!
//! Results are *conservative*: the returned `f32` boxes contain every point of the exact intersection, so a ray that hits
//! the triangle there enters the box. The argument, for coordinate `k` and `M` = the largest |coordinate k| of the triangle:
//!
//! 1. A corner is exact. A cut point is `a + t·(b - a)` in `f64` with `t` within a relative 4·2⁻⁵³ of the truth, so it misses the
//!    exact point of its edge by less than 16·2⁻⁵³·M, whatever the angle between edge and plane.
//! 2. [`slab_bounds`] cuts the exact triangle once. [`Polygon`] cuts up to six times, each time the computed polygon; there an edge
//!    nearly parallel to a plane would magnify earlier errors, so every cut is made at the plane moved outward by
//!    `slack = 2⁻⁴⁶·M`: a point of the exact polygon inside the plane has its computed twin inside the moved one.
//! 3. Bounds are moved outward by `slack`, which exceeds the sum of all errors, and then to the next `f32` outside.
//! 4. The box is cut with the reference's own box, which contains the part by induction, and with the plane, exactly.
//!
//! So flat triangles stay flat, boxes only shrink, and no bound is looser than about one `f32` step.

use super::affine::{round_down, round_up};
use super::vector::{cross, dot, sub};
use super::{Aabb, Point};

/// A box that contains the part of the triangle with `low <= x[axis] <= high`, cut with `within`; empty where there is no such part.
#[inline]
pub fn slab_bounds(corners: &[Point; 3], axis: usize, low: f32, high: f32, within: &Aabb) -> Aabb {
    let (low, high) = (f64::from(low.max(within.min[axis])), f64::from(high.min(within.max[axis])));
    let corners = corners.map(|c| c.map(f64::from));
    let mut part = Bounds::EMPTY;
    for i in 0..3 {
        // From the lower end upward, so that an edge is cut at the same point whoever owns it.
        let (a, b) = (&corners[i], &corners[(i + 1) % 3]);
        let (a, b) = if a[axis] <= b[axis] { (a, b) } else { (b, a) };
        if b[axis] < low || a[axis] > high {
            continue;
        }
        // A corner on a plane belongs to the slabs on both sides, or the one that only ends there would lose its tip.
        let inverse = 1.0 / (b[axis] - a[axis]);
        let end = |corner: &[f64; 3], plane: f64, inside: bool| {
            if inside { *corner } else { along(a, b, (plane - a[axis]) * inverse) }
        };
        part = part.grow(&end(a, low, a[axis] >= low)).grow(&end(b, high, b[axis] <= high));
    }
    let (below_high, _) = split_box(within, axis, high as f32);
    let (_, between) = split_box(&below_high, axis, low as f32);
    part.round_out(&magnitude(&corners), &between)
}

/// Cut a reference in two at `plane`: the box of the part below and the box of the part above, either possibly empty.
#[inline]
pub fn split(corners: &[Point; 3], axis: usize, plane: f32, within: &Aabb) -> (Aabb, Aabb) {
    let part = |low, high| slab_bounds(corners, axis, low, high, within);
    (part(f32::NEG_INFINITY, plane), part(plane, f32::INFINITY))
}

/// Both halves of a box at a plane, sharing the plane: the box clip mode, and the outer limit of the exact one. A plane outside leaves
/// one half empty.
#[inline]
pub fn split_box(b: &Aabb, axis: usize, plane: f32) -> (Aabb, Aabb) {
    let (mut below, mut above) = (*b, *b);
    below.max[axis] = plane.min(b.max[axis]);
    above.min[axis] = plane.max(b.min[axis]);
    let closed = |b: Aabb| if b.is_empty() { Aabb::EMPTY } else { b };
    (closed(below), closed(above))
}

/// A triangle plus six cuts has nine corners; the rest is room for rounding.
const MAX_CORNERS: usize = 12;

/// A triangle or the part of it inside a box, as corners in order, cut after Sutherland and Hodgman, "Reentrant Polygon Clipping" (1974).
#[derive(Clone, Copy)]
pub struct Polygon {
    corners: [[f64; 3]; MAX_CORNERS],
    len: usize,
    /// The `M` of the module's argument.
    magnitude: [f64; 3],
    /// More corners than there is room for, which only rounding could make: nothing is known but the reference's box.
    overflow: bool,
}

impl Polygon {
    /// The whole triangle, uncut.
    #[inline]
    pub fn triangle(corners: &[Point; 3]) -> Polygon {
        let exact = corners.map(|c| c.map(f64::from));
        let mut out =
            Polygon { corners: [[0.0; 3]; MAX_CORNERS], len: 3, magnitude: magnitude(&exact), overflow: false };
        out.corners[..3].copy_from_slice(&exact);
        out
    }

    /// The part of the triangle inside a box.
    #[inline]
    pub fn inside(corners: &[Point; 3], b: &Aabb) -> Polygon {
        let mut out = Polygon::triangle(corners);
        out.cut(b, SLACK);
        out
    }

    /// Cut what there is with a box, the planes where they are: for areas. Bounds of the result promise nothing.
    #[inline]
    pub fn cut_exactly(&mut self, b: &Aabb) {
        self.cut(b, 0.0);
    }

    /// Cut with a box whose planes are moved outward by `slack` times the magnitude.
    fn cut(&mut self, b: &Aabb, slack: f64) {
        for axis in 0..3 {
            let slack = self.magnitude[axis] * slack;
            let (lo, hi) = (f64::from(b.min[axis]) - slack, f64::from(b.max[axis]) + slack);
            if self.corners().iter().any(|c| c[axis] < lo) {
                self.keep(axis, lo, 1.0);
            }
            if self.corners().iter().any(|c| c[axis] > hi) {
                self.keep(axis, hi, -1.0);
            }
        }
    }

    /// A box around it, to tell quickly what it cannot reach; empty where the polygon is.
    #[inline]
    pub fn reach(&self) -> Aabb {
        let piece = self.corners().iter().fold(Bounds::EMPTY, |p, c| p.grow(c));
        Aabb { min: piece.min.map(round_down), max: piece.max.map(round_up) }
    }

    /// The surface's area, one side of it.
    #[inline]
    pub fn area(&self) -> f64 {
        let Some((first, rest)) = self.corners().split_first() else { return 0.0 };
        let fan = rest.windows(2).map(|w| cross(sub(w[0], *first), sub(w[1], *first)));
        let twice = fan.fold([0.0; 3], |sum, n| [0, 1, 2].map(|k| sum[k] + n[k]));
        0.5 * dot(twice, twice).sqrt()
    }

    /// Keep the part with `sign · (x[axis] - plane) >= 0`.
    fn keep(&mut self, axis: usize, plane: f64, sign: f64) {
        let old = *self;
        self.len = 0;
        for i in 0..old.len {
            let (a, b) = (&old.corners[i], &old.corners[if i + 1 == old.len { 0 } else { i + 1 }]);
            let (da, db) = (sign * (a[axis] - plane), sign * (b[axis] - plane));
            if da >= 0.0 {
                self.push(*a);
            }
            if (da >= 0.0) != (db >= 0.0) {
                // From the lower end upward, so that an edge shared by two polygons is cut at the same point.
                let (a, b) = if a[axis] <= b[axis] { (a, b) } else { (b, a) };
                let mut cut = along(a, b, (plane - a[axis]) / (b[axis] - a[axis]));
                cut[axis] = plane;
                self.push(cut);
            }
        }
    }

    fn push(&mut self, corner: [f64; 3]) {
        if self.len == MAX_CORNERS {
            self.overflow = true;
            return;
        }
        self.corners[self.len] = corner;
        self.len += 1;
    }

    /// A box that contains the polygon, cut with `within`; empty where the polygon is.
    #[inline]
    pub fn bounds(&self, within: &Aabb) -> Aabb {
        if self.overflow {
            return *within;
        }
        let piece = self.corners[..self.len].iter().fold(Bounds::EMPTY, |p, c| p.grow(c));
        piece.round_out(&self.magnitude, within)
    }

    /// The least and greatest coordinates along three axes, to `f32` and outward: they hold the exact part of the triangle. `None` where the
    /// polygon is not known, or there is none.
    ///
    /// A coordinate is a point's product with an axis. Corners miss exact points by less than the `slack` of the module's argument in each of their own
    /// coordinates, and so by `Σ |axis| · slack` in this one; three products and two sums round by at most `2⁻⁵¹ · Σ |axis| · M`. Twice the slack is
    /// more than both.
    #[inline]
    pub fn along(&self, axes: &[[f64; 3]; 3]) -> Option<Aabb> {
        if self.overflow || self.len == 0 {
            return None;
        }
        let mut out = Aabb::EMPTY;
        for (k, axis) in axes.iter().enumerate() {
            let slack = 2.0 * SLACK * dot(axis.map(f64::abs), self.magnitude);
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for corner in self.corners() {
                let at = dot(*axis, *corner);
                (low, high) = (if at < low { at } else { low }, if at > high { at } else { high });
            }
            (out.min[k], out.max[k]) = (round_down(low - slack), round_up(high + slack));
        }
        Some(out)
    }

    /// The corners in order; none where the triangle misses the box by more than rounding.
    #[inline]
    pub fn corners(&self) -> &[[f64; 3]] {
        &self.corners[..self.len]
    }
}

/// How far a plane or a bound is moved outward, relative to `M`.
const SLACK: f64 = 1.0 / (1u64 << 46) as f64;

fn magnitude(corners: &[[f64; 3]; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| corners[0][k].abs().max(corners[1][k].abs()).max(corners[2][k].abs()))
}

/// Bounds still in `f64`.
#[derive(Clone, Copy)]
struct Bounds {
    min: [f64; 3],
    max: [f64; 3],
}

impl Bounds {
    const EMPTY: Bounds = Bounds { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    #[inline]
    fn grow(mut self, p: &[f64; 3]) -> Bounds {
        for (k, v) in p.iter().enumerate() {
            self.min[k] = if *v < self.min[k] { *v } else { self.min[k] };
            self.max[k] = if *v > self.max[k] { *v } else { self.max[k] };
        }
        self
    }

    /// To `f32`, outward, and cut with `within`.
    fn round_out(&self, magnitude: &[f64; 3], within: &Aabb) -> Aabb {
        let mut out = *within;
        for (k, magnitude) in magnitude.iter().enumerate() {
            let slack = magnitude * SLACK;
            let (lo, hi) = (round_down(self.min[k] - slack), round_up(self.max[k] + slack));
            out.min[k] = if lo > within.min[k] { lo } else { within.min[k] };
            out.max[k] = if hi < within.max[k] { hi } else { within.max[k] };
        }
        if out.is_empty() { Aabb::EMPTY } else { out }
    }
}

/// The point of edge `a b` at share `t`, which is held below 1 against rounding.
#[inline]
fn along(a: &[f64; 3], b: &[f64; 3], t: f64) -> [f64; 3] {
    let t = if t < 1.0 { t } else { 1.0 };
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])]
}

#[cfg(all(test, not(target_family = "wasm")))]
mod tests;
