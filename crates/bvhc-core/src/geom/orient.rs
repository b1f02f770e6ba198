//! On which side of a line or a plane a point lies, exactly: the signs of determinants of differences of `f32`.
//!
//! `f64` decides nearly always: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates" (1997), bounds
//! its error by the magnitudes of the terms. Where that is not enough, the determinant is summed in whole numbers: a float is a whole number of 24
//! bits times a power of two, so a product of three has 72 bits, and the sum of all of them fits some 900.

use std::cmp::Ordering;

use super::Point;

/// Half the distance from 1 to the next `f64`.
const EPSILON: f64 = 1.0 / (1u64 << 53) as f64;

/// `Greater` where `a`, `b` and `c` turn left, `Less` where they turn right, `Equal` where they lie in a line. All numbers are finite.
pub fn orient2d(a: [f32; 2], b: [f32; 2], c: [f32; 2]) -> Ordering {
    let [[ax, ay], [bx, by], [cx, cy]] = [a, b, c].map(|p| p.map(f64::from));
    let (left, right) = ((ax - cx) * (by - cy), (ay - cy) * (bx - cx));
    let bound = (3.0 + 16.0 * EPSILON) * EPSILON * (left.abs() + right.abs());
    certain(left - right, bound).unwrap_or_else(|| {
        let [no, one] = [[0.0, 0.0], [1.0, 0.0]];
        exact([[[a[0], c[0]], [a[1], c[1]], no], [[b[0], c[0]], [b[1], c[1]], no], [no, no, one]])
    })
}

/// The sign of the determinant of the rows `a - d`, `b - d` and `c - d`. All numbers are finite.
pub fn orient3d(a: Point, b: Point, c: Point, d: Point) -> Ordering {
    let [a64, b64, c64] = [a, b, c].map(|p| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(d[k])));
    let (mut det, mut terms) = (0.0, 0.0);
    for k in 0..3 {
        let (l, m) = ((k + 1) % 3, (k + 2) % 3);
        let (p, q) = (b64[l] * c64[m], b64[m] * c64[l]);
        det += a64[k] * (p - q);
        terms += a64[k].abs() * (p.abs() + q.abs());
    }
    let bound = (7.0 + 56.0 * EPSILON) * EPSILON * terms;
    certain(det, bound).unwrap_or_else(|| exact([a, b, c].map(|p| [0, 1, 2].map(|k| [p[k], d[k]]))))
}

/// The sign, if it is beyond the error's bound. Nothing is: a difference that is 0 in `f64` may come of terms that are not.
fn certain(det: f64, bound: f64) -> Option<Ordering> {
    (det.abs() > bound).then_some(if det > 0.0 { Ordering::Greater } else { Ordering::Less })
}

/// The sign of a determinant whose entries are differences, each of the first number less the second.
fn exact(rows: [[[f32; 2]; 3]; 3]) -> Ordering {
    let mut sum = Sum::default();
    for (columns, even) in [
        ([0, 1, 2], true),
        ([1, 2, 0], true),
        ([2, 0, 1], true),
        ([0, 2, 1], false),
        ([1, 0, 2], false),
        ([2, 1, 0], false),
    ] {
        let factors = [0, 1, 2].map(|row| rows[row][columns[row]]);
        for choice in 0..8usize {
            let taken = [0, 1, 2].map(|k| choice >> k & 1);
            let minus = (taken[0] + taken[1] + taken[2]) % 2 == 1;
            sum.add([0, 1, 2].map(|k| factors[k][taken[k]]), even == minus);
        }
    }
    sum.sign()
}

/// A whole number of 900 bits, times 2⁻⁴⁴⁷: digits of 32 bits with room for carries, which are left until the end.
#[derive(Default)]
struct Sum([i64; 28]);

impl Sum {
    /// Add a product of three floats, or take it away.
    fn add(&mut self, factors: [f32; 3], away: bool) {
        let parts = factors.map(whole);
        let product = parts.iter().map(|p| i128::from(p.0)).product::<i128>(); // 72 bits
        if product == 0 {
            return;
        }
        let shift = (parts.iter().map(|p| p.1).sum::<i32>() + 3 * LEAST) as usize;
        let mut rest = product.unsigned_abs() << (shift % 32);
        let negative = (product < 0) != away;
        for digit in self.0[shift / 32..].iter_mut().take(4) {
            let part = (rest & 0xFFFF_FFFF) as i64;
            *digit += if negative { -part } else { part };
            rest >>= 32;
        }
    }

    fn sign(self) -> Ordering {
        let (mut carry, mut rest) = (0i64, 0i64);
        for digit in self.0 {
            let value = digit + carry;
            carry = value >> 32;
            rest |= value & 0xFFFF_FFFF;
        }
        carry.cmp(&0).then(rest.cmp(&0))
    }
}

/// The smallest `f32` is 2 to the power of minus this.
const LEAST: i32 = 149;

/// A float as a whole number of 24 bits and the power of two that it is multiplied by.
fn whole(v: f32) -> (i32, i32) {
    let (bits, exponent) = (v.to_bits(), (v.to_bits() >> 23 & 0xFF) as i32);
    let fraction = (bits & 0x7F_FFFF) as i32;
    let (m, e) = if exponent == 0 { (fraction, -LEAST) } else { (fraction | 1 << 23, exponent - 1 - LEAST) };
    (if bits >> 31 == 1 { -m } else { m }, e)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn points_a_step_beside_a_line_are_told_apart() {
        for scale in [1.0f32, 1e-38, 1e-45, 1e18, 1e38] {
            let (a, b) = ([0.0, 0.0], [3.0 * scale, 3.0 * scale]);
            let at = |y: f32| orient2d(a, b, [scale, y]);
            assert_eq!(
                [at(scale.next_down()), at(scale), at(scale.next_up())],
                [Ordering::Less, Ordering::Equal, Ordering::Greater],
                "{scale}"
            );
        }
        // f64 gives 0 for each product's difference here, and for their sum.
        let far = |y| orient2d([1e30, 1e-30], [-1e30, -1e-30], [0.0, y]);
        assert_eq!([far(0.0), far(1e-45), far(-1e-45)], [Ordering::Equal, Ordering::Less, Ordering::Greater]);
    }

    #[test]
    fn points_a_step_beside_a_plane_are_told_apart() {
        let (a, b, c) = ([0.0, 0.0, 0.0], [4.0, 0.0, 1.0], [0.0, 4.0, 2.0]);
        let at = |z: f32| orient3d(a, b, c, [1.0, 1.0, z]);
        assert_eq!(
            [at(0.75f32.next_down()), at(0.75), at(0.75f32.next_up())],
            [Ordering::Greater, Ordering::Equal, Ordering::Less]
        );
    }

    /// Exchanging rows turns the sign, however the determinant was found; and whole numbers say what `i128` says.
    #[test]
    fn signs_agree_with_whole_numbers() {
        let mut random = Random::new(7);
        for round in 0..20_000 {
            let most = [2, 30, 5000, 1_000_000][round % 4];
            let [a, b, c, d] = [0; 4].map(|_| [0; 3].map(|_| random.whole(most)));
            let rows = [a, b, c].map(|p| [0, 1, 2].map(|k| p[k] as i128 - d[k] as i128));
            let det: i128 = (0..3)
                .map(|k| {
                    let (l, m) = ((k + 1) % 3, (k + 2) % 3);
                    rows[0][k] * (rows[1][l] * rows[2][m] - rows[1][m] * rows[2][l])
                })
                .sum();
            // The power of two changes nothing, and takes the numbers to where f64 has none. `powi` of a negative power may be 0.
            let power = [1.0, f32::from_bits(1 << 9), f32::from_bits((127 + 100) << 23)][round % 3];
            let scaled = |p: Point| p.map(|v| v * power);
            let exactly = exact([a, b, c].map(|p| [0, 1, 2].map(|k| [scaled(p)[k], scaled(d)[k]])));
            assert_eq!(orient3d(a, b, c, d), det.cmp(&0), "{a:?} {b:?} {c:?} {d:?}");
            assert_eq!(exactly, det.cmp(&0), "{a:?} {b:?} {c:?} {d:?}");
            assert_eq!(orient3d(b, a, c, d), det.cmp(&0).reverse());
            let flat = (rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0]).cmp(&0);
            assert_eq!(orient2d([a[0], a[1]], [b[0], b[1]], [d[0], d[1]]), flat);
        }
    }
}
