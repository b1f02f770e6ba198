use super::{Aabb, Point};

/// An affine map, three rows of four: `p' = M[.., 0..3] · p + M[.., 3]`. Held in `f64` so that a deep node hierarchy loses
/// nothing before the one rounding to `f32` when it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Row-major: `rows[i][..3]` is row `i` of the linear part, `rows[i][3]` what is added on axis `i`.
    pub rows: [[f64; 4]; 3],
}

impl Affine {
    /// Moves nothing.
    pub const IDENTITY: Affine = Affine { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

    /// The same map into coordinates that are measured from `origin`.
    #[must_use]
    pub fn about(mut self, origin: [f64; 3]) -> Affine {
        (0..3).for_each(|a| self.rows[a][3] -= origin[a]);
        self
    }

    /// From glTF's column-major 4×4 matrix; the last row is taken to be `0 0 0 1`.
    #[inline]
    pub fn from_columns(c: [[f64; 4]; 4]) -> Affine {
        let row = |r: usize| [c[0][r], c[1][r], c[2][r], c[3][r]];
        Affine { rows: [row(0), row(1), row(2)] }
    }

    /// `self · inner`: apply `inner` first.
    #[must_use]
    #[inline]
    pub fn then_inner(&self, inner: &Affine) -> Affine {
        let mut rows = [[0.0; 4]; 3];
        for (out, r) in rows.iter_mut().zip(&self.rows) {
            for (c, cell) in out.iter_mut().enumerate() {
                *cell = r[0] * inner.rows[0][c] + r[1] * inner.rows[1][c] + r[2] * inner.rows[2][c];
            }
            out[3] += r[3];
        }
        Affine { rows }
    }

    /// A move without rotation or scale.
    pub const fn translation([x, y, z]: [f64; 3]) -> Affine {
        Affine { rows: [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]] }
    }

    /// Of the linear part: how much volumes grow, negative where the map mirrors. In plain `f64`; the exact sign of a stored matrix is
    /// [`orientation`](crate::layout::orientation).
    #[inline]
    pub fn determinant(&self) -> f64 {
        let [a, b, c] = &self.rows;
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    }

    /// Whether it turns left into right: its determinant is negative by more than its rounding. Never where it is not finite.
    pub fn mirrors(&self) -> bool {
        // Six products of three factors and five sums: the error is below 8 units of their magnitudes.
        let magnitudes = self.rows.map(|row| row.map(f64::abs));
        let [a, b, c] = &magnitudes;
        let terms = a[0] * (b[1] * c[2] + b[2] * c[1])
            + a[1] * (b[0] * c[2] + b[2] * c[0])
            + a[2] * (b[0] * c[1] + b[1] * c[0]);
        self.determinant() < -8.0 * f64::EPSILON * terms
    }

    /// The cofactor of an entry of the linear part, and the sum of its two products' magnitudes.
    #[inline]
    pub(crate) fn cofactor(&self, row: usize, column: usize) -> (f64, f64) {
        let m = &self.rows;
        let ([r0, r1], [c0, c1]) = ([(row + 1) % 3, (row + 2) % 3], [(column + 1) % 3, (column + 2) % 3]);
        let (p, q) = (m[r0][c0] * m[r1][c1], m[r0][c1] * m[r1][c0]);
        (p - q, p.abs() + q.abs())
    }

    /// The determinant by the cofactors of the first row, and the magnitudes of what it is summed from: (`det`, `terms`) of SPEC 5.5.
    #[inline]
    pub(crate) fn determinant_and_terms(&self) -> (f64, f64) {
        let (mut det, mut terms) = (0.0, 0.0);
        for (c, entry) in self.rows[0].iter().take(3).enumerate() {
            let (value, magnitude) = self.cofactor(0, c);
            det += entry * value;
            terms += (entry * magnitude).abs();
        }
        (det, terms)
    }

    /// What rounding can add to or take from a determinant, as a fraction of the magnitudes that it is summed from. Products of two `f32` are
    /// exact in `f64`; what follows rounds a few times, by 2⁻⁵³ each.
    pub(crate) const LOST: f64 = 1.0 / (1u64 << 48) as f64;

    /// Whether `f64` can tell the inverse of the linear part of a matrix of `f32`: its determinant is more than what rounding may make of it. A
    /// file holds no other (SPEC 5.5). So a matrix is asked as [`Affine::to_f32`] rounds it.
    #[inline]
    pub fn is_invertible_in_f64(&self) -> bool {
        let (det, terms) = self.determinant_and_terms();
        det.abs() > terms * Affine::LOST
    }

    /// What rounding the entries to `f32`, by 2⁻²⁴ each, can do to a determinant, in the same measure.
    const LOST_BY_F32: f64 = 1.0 / (1u64 << 20) as f64;

    /// Whether a file can hold an instance that this map places: it has an inverse, and so has the matrix that [`Affine::to_f32`] makes of it, with
    /// finite entries, and one that `f64` can tell. Neither is left to chance: where rounding to `f32` changes the matrix, its determinant is more than
    /// that may make of it. So a map that is flat but for what rounding put there is not storable.
    pub fn is_storable(&self) -> bool {
        let stored = Affine::from_f32(&self.to_f32());
        let is_finite = |inverse: Affine| inverse.to_f32().iter().all(|entry| entry.is_finite());
        let is_linear_part_exact = (0..3).all(|r| stored.rows[r][..3] == self.rows[r][..3]);
        let (det, terms) = self.determinant_and_terms();
        let survives = is_linear_part_exact || det.abs() > terms * Affine::LOST_BY_F32;
        let has_inverse = self.inverse().is_some() && survives;
        has_inverse && stored.is_invertible_in_f64() && stored.inverse().is_some_and(is_finite)
    }

    /// Whether less than a thousandth is left of what the determinant is summed from. The map then flattens, and turns what is flat: its inverse makes
    /// much of little, and with it of what rounding does to the entries. A scale along the axes is no such map, since nothing cancels there.
    pub fn is_nearly_flat(&self) -> bool {
        let (det, terms) = self.determinant_and_terms();
        det.abs() * 1024.0 < terms
    }

    /// The inverse map, or `None` when the matrix is singular or not finite.
    #[inline]
    pub fn inverse(&self) -> Option<Affine> {
        let det = self.determinant();
        if !det.is_finite() || det == 0.0 {
            return None;
        }
        let m = &self.rows;
        let cofactor =
            |r0: usize, c0: usize, r1: usize, c1: usize| (m[r0][c0] * m[r1][c1] - m[r0][c1] * m[r1][c0]) / det;
        let linear = [
            [cofactor(1, 1, 2, 2), cofactor(0, 2, 2, 1), cofactor(0, 1, 1, 2)],
            [cofactor(1, 2, 2, 0), cofactor(0, 0, 2, 2), cofactor(0, 2, 1, 0)],
            [cofactor(1, 0, 2, 1), cofactor(0, 1, 2, 0), cofactor(0, 0, 1, 1)],
        ];
        let rows = linear.map(|l| [l[0], l[1], l[2], -(l[0] * m[0][3] + l[1] * m[1][3] + l[2] * m[2][3])]);
        rows.iter().flatten().all(|v| v.is_finite()).then_some(Affine { rows })
    }

    /// The image of a position.
    #[inline]
    pub fn transform_point(&self, p: [f64; 3]) -> [f64; 3] {
        self.rows.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3])
    }

    /// The image of a direction or a difference of positions, to which the translation does not apply.
    #[inline]
    pub fn transform_vector(&self, v: [f64; 3]) -> [f64; 3] {
        self.rows.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
    }

    /// A vertex moved by this map, computed in `f64` and rounded once: what a file of one level holds.
    #[inline]
    pub fn bake(&self, p: Point) -> Point {
        self.transform_point(p.map(f64::from)).map(|v| v as f32)
    }

    /// The rows as the 12 floats of an `INST` record.
    #[inline]
    pub fn to_f32(&self) -> [f32; 12] {
        let mut out = [0.0; 12];
        for (o, v) in out.iter_mut().zip(self.rows.iter().flatten()) {
            *o = *v as f32;
        }
        out
    }

    /// From the 12 floats of an `INST` record, row by row; exact.
    #[inline]
    pub fn from_f32(m: &[f32; 12]) -> Affine {
        let row = |r: usize| [0, 1, 2, 3].map(|c| f64::from(m[r * 4 + c]));
        Affine { rows: [row(0), row(1), row(2)] }
    }

    /// A box that contains the image of `b`, rounded outward: each bound is summed in `f64` from the extreme of each term
    /// (Arvo, "Transforming Axis-Aligned Bounding Boxes", Graphics Gems, 1990), widened by a relative 2⁻⁵⁰ of the terms'
    /// magnitudes for the sum's own rounding, and moved to the next `f32` outside.
    #[inline]
    pub fn transform_box(&self, b: &Aabb) -> Aabb {
        if b.is_empty() {
            return Aabb::EMPTY;
        }
        let mut out = Aabb::EMPTY;
        for (axis, r) in self.rows.iter().enumerate() {
            let (mut lo, mut hi, mut magnitude) = (r[3], r[3], r[3].abs());
            for c in 0..3 {
                let (x, y) = (r[c] * f64::from(b.min[c]), r[c] * f64::from(b.max[c]));
                lo += x.min(y);
                hi += x.max(y);
                magnitude += x.abs().max(y.abs());
            }
            let slack = magnitude * 2f64.powi(-50);
            out.min[axis] = round_down(lo - slack);
            out.max[axis] = round_up(hi + slack);
        }
        out
    }
}

/// The largest `f32` that is not above `v`; zero is always positive.
#[inline]
pub fn round_down(v: f64) -> f32 {
    let f = v as f32;
    f32::from_bits(f.to_bits().wrapping_sub(outward(f) * u32::from(f64::from(f) > v))) + 0.0
}

/// The smallest `f32` that is not below `v`; zero is always positive.
#[inline]
pub fn round_up(v: f64) -> f32 {
    let f = v as f32;
    f32::from_bits(f.to_bits().wrapping_add(outward(f) * u32::from(f64::from(f) < v))) + 0.0
}

/// What added to a number's bits gives the next one upward: 1, and −1 below zero, where bits grow downward. A zero has the sign of what was
/// rounded to it, so this holds there too.
#[inline(always)]
fn outward(f: f32) -> u32 {
    ((f.to_bits() as i32 >> 31) | 1) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn skewed() -> Affine {
        Affine { rows: [[0.5, -2.0, 0.25, 7.0], [1.0, 0.3, 0.0, -3.0], [0.0, 0.1, 4.0, 0.5]] }
    }

    #[test]
    fn inverse_undoes_the_map() {
        let product = skewed().then_inner(&skewed().inverse().unwrap());
        for (got, want) in product.rows.iter().flatten().zip(Affine::IDENTITY.rows.iter().flatten()) {
            assert!((got - want).abs() < 1e-12, "{product:?}");
        }
        assert!(
            Affine { rows: [[1.0, 2.0, 3.0, 0.0], [2.0, 4.0, 6.0, 0.0], [0.0, 0.0, 1.0, 0.0]] }.inverse().is_none()
        );
    }

    #[test]
    fn what_is_flat_mirrors_nothing_however_it_is_turned() {
        let flat = [[0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 3.0, 0.0]];
        let turned = |angle: f64, axis: usize| {
            let (l, m) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut rows = Affine::IDENTITY.rows;
            (rows[l][l], rows[l][m], rows[m][l], rows[m][m]) = (angle.cos(), -angle.sin(), angle.sin(), angle.cos());
            Affine { rows }
        };
        for step in 1..200 {
            let by = |k: f64| 0.031 * k * f64::from(step);
            let turn = turned(by(1.0), 0).then_inner(&turned(by(0.7), 1)).then_inner(&turned(by(1.3), 2));
            let scaled = |rows| turn.then_inner(&Affine { rows }).then_inner(&turned(by(0.9), 1));
            assert!(!scaled(flat).mirrors(), "{step}");
            let mut thin = flat;
            thin[0][0] = -1e-9;
            assert!(scaled(thin).mirrors(), "{step}");
            thin[0][0] = 1e-9;
            assert!(!scaled(thin).mirrors(), "{step}");
        }
    }

    #[test]
    fn an_inverse_that_cancels_away_is_not_told() {
        assert!(Affine::IDENTITY.is_invertible_in_f64() && skewed().is_invertible_in_f64());
        for scale in [1e-38, 1e-20, 1e12] {
            let rows = skewed().rows.map(|row| row.map(|entry| entry * scale));
            assert!(Affine { rows }.is_invertible_in_f64(), "{scale}");
        }
        // Rows that differ in their last bits: the exact determinant is 2⁻⁴⁸, and the terms that cancel in it sum up to nearly 6.
        let u = f64::from(1f32.next_down());
        let rows = [[1.0, 1.0, 1.0, 0.0], [1.0, u, 1.0, 0.0], [1.0, 1.0, u, 0.0]];
        let needle = Affine { rows };
        assert!(needle.inverse().is_some() && !needle.is_invertible_in_f64() && !needle.is_storable());
        assert!(skewed().is_storable());
        // Flat along its third axis, turned before and after: what rounding leaves of the determinant is no thickness.
        let turned = |(s, c): (f64, f64), (k, l): (usize, usize)| {
            let mut rows = Affine::IDENTITY.rows;
            (rows[k][k], rows[k][l], rows[l][k], rows[l][l]) = (c, -s, s, c);
            Affine { rows }
        };
        let scaled = |z: f64| Affine { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, z, 0.0]] };
        let around = turned(0.7f64.sin_cos(), (0, 1)).then_inner(&turned(1.1f64.sin_cos(), (1, 2)));
        let flat = |z| around.then_inner(&scaled(z)).then_inner(&turned(2.3f64.sin_cos(), (2, 0)));
        for z in [0.0, 1e-30, 1e-17, 1e-12, 1e-8] {
            assert!(!flat(z).is_storable(), "{z}: {}", flat(z).determinant());
        }
        assert!(flat(1e-5).is_nearly_flat() && !flat(0.1).is_nearly_flat() && !scaled(1e-9).is_nearly_flat());
        assert!(flat(1e-4).is_storable() && scaled(1e-17).is_storable() && scaled(1e-4).is_storable());
        let nan = Affine { rows: [[f64::NAN; 4]; 3] };
        assert!(!nan.is_invertible_in_f64() && !Affine { rows: [[0.0; 4]; 3] }.is_invertible_in_f64());
    }

    #[test]
    fn a_transformed_box_contains_every_transformed_corner() {
        let b = Aabb { min: [-1.3, 0.7, 2.1], max: [4.9, 0.9, 8.8] };
        let image = skewed().transform_box(&b);
        for corner in 0..8 {
            let p = [0, 1, 2].map(|a| f64::from(if corner >> a & 1 == 0 { b.min[a] } else { b.max[a] }));
            let q = skewed().transform_point(p);
            assert!((0..3).all(|a| f64::from(image.min[a]) <= q[a] && q[a] <= f64::from(image.max[a])));
        }
    }

    #[test]
    fn rounding_is_outward_on_both_sides_of_zero() {
        for v in [1.0 + 1e-12, -1.0 - 1e-12, 0.1, -0.1, 0.0, -0.0, 1e-50, -1e-50] {
            let (low, high) = (round_down(v), round_up(v));
            assert!(f64::from(low) <= v && v <= f64::from(high));
            assert!([low, high].iter().all(|f| f.to_bits() != (-0.0f32).to_bits()), "{v}");
        }
    }
}
