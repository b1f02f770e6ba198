//! The project's only triangle splitter: what part of a triangle lies between two axis-aligned planes or inside a box.
//!
//! Cutting follows Sutherland and Hodgman, "Reentrant Polygon Clipping" (1974), cut down to axis-aligned planes. Results are
//! *conservative*: the returned `f32` boxes contain every point of the exact intersection, so a ray that hits the triangle
//! there enters the box. The argument, for coordinate `k` and `M` = the largest |coordinate k| of the triangle:
//!
//! 1. A corner is exact. A cut point is `a + t·(b - a)` in `f64` with `t` within a relative 4·2⁻⁵³ of the truth, so it misses the
//!    exact point of the (computed) edge by less than 16·2⁻⁵³·M. At most seven cuts follow each other: < 2⁻⁴⁶·M in all.
//! 2. Errors do not grow where an edge is nearly parallel to a plane, because every cut is made against the plane moved
//!    outward by `slack = 2⁻⁴⁶·M`: a point of the exact polygon inside the plane has its computed twin inside the moved one.
//! 3. `(v ∓ margin) as f32` with `margin = 2⁻²³·M + 2⁻¹⁴⁹` is outside of `v ∓ slack`, since the conversion moves a value by at most
//!    2⁻²⁴·|v| (or 2⁻¹⁵⁰ among denormals) and `2⁻²³ - 2⁻²⁴ > 2·2⁻⁴⁶`.
//!
//! The box is then cut with the reference's own box (which contains the part by induction) and with the plane (exactly).
//! So flat triangles stay flat and no box is looser than about one `f32` step of `M`.

use super::{Aabb, Point};

/// A triangle plus six cuts has nine corners; the rest is room for rounding.
const MAX_CORNERS: usize = 12;

/// A triangle or the part of it inside a box, as corners in order.
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
    pub fn triangle(corners: &[Point; 3]) -> Polygon {
        let mut out = Polygon { corners: [[0.0; 3]; MAX_CORNERS], len: 3, magnitude: [0.0; 3], overflow: false };
        for (to, from) in out.corners.iter_mut().zip(corners) {
            *to = from.map(f64::from);
        }
        for k in 0..3 {
            out.magnitude[k] = out.corners[0][k].abs().max(out.corners[1][k].abs()).max(out.corners[2][k].abs());
        }
        out
    }

    /// The part of the triangle inside a reference's box. A box that contains the triangle costs three comparisons.
    pub fn inside(corners: &[Point; 3], b: &Aabb) -> Polygon {
        let mut out = Polygon::triangle(corners);
        for axis in 0..3 {
            let slack = out.magnitude[axis] * SLACK;
            let (lo, hi) = (f64::from(b.min[axis]) - slack, f64::from(b.max[axis]) + slack);
            if corners.iter().any(|c| f64::from(c[axis]) < lo) {
                out.keep(axis, lo, 1.0);
            }
            if corners.iter().any(|c| f64::from(c[axis]) > hi) {
                out.keep(axis, hi, -1.0);
            }
        }
        out
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
                self.push(lerp(a, b, axis, plane));
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
    pub fn bounds(&self, within: &Aabb) -> Aabb {
        if self.overflow {
            return *within;
        }
        let piece = self.corners[..self.len].iter().fold(Piece::EMPTY, |p, c| p.grow(c));
        piece.round_out(&self.magnitude, within)
    }

    /// Chop a reference along `axis` into the slabs `first ..= last` of `planes`, one box a slab in `out.boxes()`, each conservative, inside `within` and between its planes; empty where the polygon has no point.
    ///
    /// `within` is the reference's box, and `first`, `last` are the slabs that it spans. Each edge is walked once: corners
    /// grow the slab that they lie in, crossings grow the slabs on both sides of the plane.
    pub fn chop<const CAP: usize>(
        &self,
        axis: usize,
        planes: &Planes,
        (first, last): (usize, usize),
        within: &Aabb,
        out: &mut Slabs<CAP>,
    ) {
        let count = last - first + 1;
        let pieces = &mut out.pieces[..count];
        pieces.fill(Piece::EMPTY);
        let slab = |x: f64| planes.slab(x).clamp(first, last) - first;
        let n = self.len;
        let mut slabs = [0usize; MAX_CORNERS];
        for (s, c) in slabs[..n].iter_mut().zip(&self.corners) {
            *s = slab(c[axis]);
        }
        for i in 0..n {
            let next = if i + 1 == n { 0 } else { i + 1 };
            let (mut a, mut b) = (&self.corners[i], &self.corners[next]);
            let (mut sa, mut sb) = (slabs[i], slabs[next]);
            pieces[sa] = pieces[sa].grow(a);
            if sa == sb {
                continue;
            }
            if sa > sb {
                (a, b, sa, sb) = (b, a, sb, sa);
            }
            let inverse = 1.0 / (b[axis] - a[axis]);
            for s in sa..sb {
                let cut = lerp_by(a, b, (planes.at(first + s + 1) - a[axis]) * inverse);
                pieces[s] = pieces[s].grow(&cut);
                pieces[s + 1] = pieces[s + 1].grow(&cut);
            }
        }
        for (s, (piece, out)) in pieces.iter().zip(&mut out.boxes).enumerate() {
            let slab = planes.cut_box(within, axis, first + s);
            *out = if self.overflow { slab } else { piece.round_out(&self.magnitude, &slab) };
        }
    }

    /// Cut a reference in two at `plane`: the box of the part below and the box of the part above, either possibly empty.
    pub fn split(&self, axis: usize, plane: f32, within: &Aabb) -> (Aabb, Aabb) {
        let (below, above) = split_box(within, axis, plane);
        if self.overflow {
            return (below, above);
        }
        let at = f64::from(plane);
        let (mut lower, mut upper) = (Piece::EMPTY, Piece::EMPTY);
        for i in 0..self.len {
            let (a, b) = (&self.corners[i], &self.corners[if i + 1 == self.len { 0 } else { i + 1 }]);
            // A corner on the plane belongs to both parts, or the part that only ends there would lose its tip.
            if a[axis] <= at {
                lower = lower.grow(a);
            }
            if a[axis] >= at {
                upper = upper.grow(a);
            }
            if (a[axis] < at && b[axis] > at) || (a[axis] > at && b[axis] < at) {
                let (a, b) = if a[axis] <= b[axis] { (a, b) } else { (b, a) };
                let cut = lerp_by(a, b, (at - a[axis]) * (1.0 / (b[axis] - a[axis])));
                lower = lower.grow(&cut);
                upper = upper.grow(&cut);
            }
        }
        (lower.round_out(&self.magnitude, &below), upper.round_out(&self.magnitude, &above))
    }
}

/// Both halves of a box at a plane, sharing the plane: the box clip mode, and the outer limit of the exact one.
pub fn split_box(b: &Aabb, axis: usize, plane: f32) -> (Aabb, Aabb) {
    let (mut below, mut above) = (*b, *b);
    below.max[axis] = plane.min(b.max[axis]);
    above.min[axis] = plane.max(b.min[axis]);
    (below, above)
}

/// Equidistant planes that cut an interval into slabs. Slab `s` is `at(s) <= x <= at(s + 1)`; a coordinate on a plane belongs
/// to the slab above it when a reference begins there and to the slab below when it ends there.
#[derive(Clone, Copy, Debug)]
pub struct Planes {
    low: f32,
    step: f32,
    scale: f32,
    count: usize,
}

/// Most slabs an axis can have.
pub const MAX_SLABS: usize = 256;

impl Planes {
    /// `None` where the interval is too narrow (or not finite), so that two planes would coincide.
    pub fn new(low: f32, high: f32, count: usize) -> Option<Planes> {
        let count = count.clamp(2, MAX_SLABS);
        let step = (high - low) / count as f32;
        let scale = count as f32 / (high - low);
        let planes = Planes { low, step, scale, count };
        // The spacing at the far ends bounds the rounding everywhere: four f32 steps keep neighbours apart.
        let coarse = low.abs().max(high.abs()) * (4.0 * f32::EPSILON);
        (step > coarse && scale.is_finite() && step.is_finite()).then_some(planes)
    }

    pub fn count(&self) -> usize {
        self.count
    }

    /// Plane `i` in `0 ..= count`, increasing; computed the same way everywhere, so that binning and partition agree.
    #[inline]
    pub fn position(&self, i: usize) -> f32 {
        self.low + self.step * i as f32
    }

    #[inline]
    fn at(&self, i: usize) -> f64 {
        f64::from(self.position(i))
    }

    /// The last slab whose lower plane is not above `x`.
    #[inline]
    fn slab(&self, x: f64) -> usize {
        let mut s = self.guess(x as f32);
        while s > 0 && x < self.at(s) {
            s -= 1;
        }
        while s + 1 < self.count && x >= self.at(s + 1) {
            s += 1;
        }
        s
    }

    #[inline]
    fn guess(&self, x: f32) -> usize {
        // A float-to-integer cast saturates: below the range it is 0.
        (((x - self.low) * self.scale) as usize).min(self.count - 1)
    }

    /// The slabs that `min ..= max` spans. Plane `i` lies strictly inside the interval exactly if `first < i <= last`.
    #[inline]
    pub fn span(&self, min: f32, max: f32) -> (usize, usize) {
        let (mut first, mut last) = (self.guess(min), self.guess(max));
        while first > 0 && min < self.position(first) {
            first -= 1;
        }
        while first + 1 < self.count && min >= self.position(first + 1) {
            first += 1;
        }
        while last > first && max <= self.position(last) {
            last -= 1;
        }
        while last + 1 < self.count && max > self.position(last + 1) {
            last += 1;
        }
        (first, last.max(first))
    }

    /// The part of a box inside slab `s`.
    #[inline]
    pub fn cut_box(&self, b: &Aabb, axis: usize, s: usize) -> Aabb {
        let mut out = *b;
        out.min[axis] = if s == 0 { b.min[axis] } else { b.min[axis].max(self.position(s)) };
        out.max[axis] = if s + 1 == self.count { b.max[axis] } else { b.max[axis].min(self.position(s + 1)) };
        out
    }
}

/// How far a plane is moved outward, relative to `M`: step 2 of the argument.
const SLACK: f64 = 1.0 / (1u64 << 46) as f64;
/// How far a bound is moved outward, relative to `M`: step 3 of the argument.
const MARGIN: f64 = 1.0 / (1u64 << 23) as f64;
/// The smallest positive `f32`: half of it is the conversion error among denormals.
const TINY: f64 = 1.401298464324817e-45;

/// Where [`Polygon::chop`] leaves its boxes: room for `CAP` slabs, to be made once and used for many references.
pub struct Slabs<const CAP: usize> {
    pieces: [Piece; CAP],
    boxes: [Aabb; CAP],
}

impl<const CAP: usize> Default for Slabs<CAP> {
    fn default() -> Self {
        Slabs { pieces: [Piece::EMPTY; CAP], boxes: [Aabb::EMPTY; CAP] }
    }
}

impl<const CAP: usize> Slabs<CAP> {
    /// The boxes of the last [`Polygon::chop`], its first slab first; what follows its last slab is stale.
    pub fn boxes(&self) -> &[Aabb] {
        &self.boxes
    }
}

/// Bounds still in `f64`.
#[derive(Clone, Copy)]
struct Piece {
    min: [f64; 3],
    max: [f64; 3],
}

impl Piece {
    const EMPTY: Piece = Piece { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    #[inline]
    fn grow(mut self, p: &[f64; 3]) -> Piece {
        for k in 0..3 {
            self.min[k] = if p[k] < self.min[k] { p[k] } else { self.min[k] };
            self.max[k] = if p[k] > self.max[k] { p[k] } else { self.max[k] };
        }
        self
    }

    /// To `f32`, outward, and cut with `within`.
    #[inline]
    fn round_out(&self, magnitude: &[f64; 3], within: &Aabb) -> Aabb {
        let mut out = *within;
        for k in 0..3 {
            let margin = magnitude[k] * MARGIN + TINY;
            let (lo, hi) = ((self.min[k] - margin) as f32, (self.max[k] + margin) as f32);
            out.min[k] = if lo > within.min[k] { lo } else { within.min[k] };
            out.max[k] = if hi < within.max[k] { hi } else { within.max[k] };
        }
        if out.is_empty() { Aabb::EMPTY } else { out }
    }
}

/// The point of edge `a b` on the plane; its coordinate there is the plane's, exactly.
#[inline]
fn lerp(a: &[f64; 3], b: &[f64; 3], axis: usize, plane: f64) -> [f64; 3] {
    let mut p = lerp_by(a, b, (plane - a[axis]) * (1.0 / (b[axis] - a[axis])));
    p[axis] = plane;
    p
}

/// `t` is held below 1, so that a denormal edge, whose inverse overflows, ends in its end point and not in a NaN.
#[inline]
fn lerp_by(a: &[f64; 3], b: &[f64; 3], t: f64) -> [f64; 3] {
    let t = if t < 1.0 { t } else { 1.0 };
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])]
}

#[cfg(test)]
mod tests;
