//! Boxes in a basis of their own.

use super::basis::Basis;
use super::volume::UNIT;
use crate::geom::vector::dot;

/// All points whose coordinates along the basis are between two ends.
///
/// It is three slabs: it holds what its planes hold, and nothing depends on how nearly they meet at right angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedBox {
    /// What it lies along.
    pub basis: Basis,
    /// The least coordinate along each axis.
    pub low: [f64; 3],
    /// The greatest.
    pub high: [f64; 3],
}

impl OrientedBox {
    /// Around points, in a given basis; nothing around none.
    ///
    /// A coordinate is three products and two sums, so it is wrong by at most `3u / (1 − 3u)` times the sum of the point's own; moving
    /// the plane by `8u` times that sum covers the rounding of the plane as well (Higham, "Accuracy and Stability of Numerical
    /// Algorithms", 2002, section 3.1).
    pub fn in_basis(basis: Basis, points: &[[f64; 3]]) -> Option<OrientedBox> {
        (!points.is_empty()).then(|| OrientedBox::spanned(basis, points))
    }

    /// Around a triangle, in [its own basis](Basis::of_triangle).
    pub fn of_triangle(corners: &[[f64; 3]; 3]) -> OrientedBox {
        OrientedBox::spanned(Basis::of_triangle(corners), corners)
    }

    fn spanned(basis: Basis, points: &[[f64; 3]]) -> OrientedBox {
        let (mut low, mut high, mut most) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0.0f64);
        for p in points {
            let c = basis.coordinates(*p);
            low = [0, 1, 2].map(|k| low[k].min(c[k]));
            high = [0, 1, 2].map(|k| high[k].max(c[k]));
            most = most.max(p[0].abs() + p[1].abs() + p[2].abs());
        }
        let margin = 8.0 * UNIT * most;
        OrientedBox { basis, low: low.map(|v| v - margin), high: high.map(|v| v + margin) }
    }

    /// Around boxes, in a given basis; nothing around none.
    pub fn around(basis: Basis, boxes: impl IntoIterator<Item = OrientedBox>) -> Option<OrientedBox> {
        let (mut low, mut high, mut any) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], false);
        for b in boxes {
            let (near, far) = b.seen_from(&basis);
            low = [0, 1, 2].map(|k| low[k].min(near[k]));
            high = [0, 1, 2].map(|k| high[k].max(far[k]));
            any = true;
        }
        any.then_some(OrientedBox { basis, low, high })
    }

    /// The box's ends along another basis.
    ///
    /// A point with coordinates `q` in its own basis `B` is `B⁻¹q`, and along an axis `a` it is `(B a)·q`, up to how far `Bᵀ` is from `B⁻¹`: at
    /// most `3 · Basis::ERROR` times `Σ|q|`, and 1 % of that. Rounding of `B a`, of the products and of the sums is at most `7u Σ|q|`.
    fn seen_from(&self, basis: &Basis) -> ([f64; 3], [f64; 3]) {
        if *basis == self.basis {
            return (self.low, self.high);
        }
        let turn = basis.axes().map(|axis| self.basis.coordinates(axis));
        let (low, high) = self.turned(&turn);
        let reach: f64 = (0..3).map(|k| self.low[k].abs().max(self.high[k].abs())).sum();
        let margin = (3.1 * Basis::ERROR + 10.0 * UNIT) * reach;
        (low.map(|v| v - margin), high.map(|v| v + margin))
    }

    /// The box's ends along axes whose coordinates in its own basis these are, as far as rounding tells.
    #[inline(always)]
    fn turned(&self, turn: &[[f64; 3]; 3]) -> ([f64; 3], [f64; 3]) {
        let middle = [0, 1, 2].map(|k| 0.5 * (self.low[k] + self.high[k]));
        let half = [0, 1, 2].map(|k| 0.5 * (self.high[k] - self.low[k]));
        let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
        for k in 0..3 {
            let at = dot(turn[k], middle);
            let reach = dot(turn[k].map(f64::abs), half);
            (low[k], high[k]) = (at - reach, at + reach);
        }
        (low, high)
    }

    /// Half the area of the lesser of the two boxes around both that lie along one of them, and whether it lies along `other`. Without
    /// margins: for comparing.
    #[inline]
    pub fn merged_half_area(&self, other: &OrientedBox) -> (f64, bool) {
        let turn = other.basis.axes().map(|axis| self.basis.coordinates(axis));
        let back = [0, 1, 2].map(|k| [turn[0][k], turn[1][k], turn[2][k]]);
        let along = |own: &OrientedBox, (low, high): ([f64; 3], [f64; 3])| {
            half_area([0, 1, 2].map(|k| own.high[k].max(high[k]) - own.low[k].min(low[k])))
        };
        let (mine, theirs) = (along(self, other.turned(&back)), along(other, self.turned(&turn)));
        if theirs < mine { (theirs, true) } else { (mine, false) }
    }

    /// Around both, along one of them, whichever is less.
    pub(super) fn merged_along_one(&self, other: &OrientedBox) -> OrientedBox {
        let (own, foreign) = if self.merged_half_area(other).1 { (other, self) } else { (self, other) };
        let (low, high) = foreign.seen_from(&own.basis);
        OrientedBox {
            basis: own.basis,
            low: [0, 1, 2].map(|k| own.low[k].min(low[k])),
            high: [0, 1, 2].map(|k| own.high[k].max(high[k])),
        }
    }

    /// Half the surface area.
    #[inline]
    pub fn half_area(&self) -> f64 {
        half_area([0, 1, 2].map(|k| self.high[k] - self.low[k]))
    }

    /// The eight corners, as far as rounding tells.
    pub fn corners(&self) -> [[f64; 3]; 8] {
        std::array::from_fn(|i| {
            self.basis.point([0, 1, 2].map(|k| if i >> k & 1 == 0 { self.low[k] } else { self.high[k] }))
        })
    }
}

#[inline(always)]
fn half_area([x, y, z]: [f64; 3]) -> f64 {
    x * y + y * z + z * x
}
