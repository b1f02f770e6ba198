//! Exact decisions: does this ray meet this triangle, and which of two distances is smaller?
//!
//! Floats are whole numbers times powers of two, and all that is asked are signs of polynomials in them, so whole numbers of
//! sufficient size answer without any rounding and without a proof of error bounds. Where coordinates are of like size, as nearly always,
//! 128 bits suffice; beyond that the library's big integers take over. Both run the same few lines, written once for any `Whole`.
//!
//! For a ray `o + t·d` and a triangle with corners `p, q, r` relative to `o`, the *moments* of the three edges, `d · (p × q)` and so on, are the
//! volumes that the edges span with the ray (six times the signed volumes of Shewchuk's `orient3d`). The ray's line meets the closed triangle if no two moments
//! have opposite signs. Their sum is `n · d`, with the normal `n`: where it is zero, the triangle has no area or is seen edge-on,
//! and counts as missed. Else `t = p · (q × r) / (n · d)`.

mod ratio;
mod whole;

pub use ratio::Ratio;

use self::whole::{Whole, aligned, fit, parts};
use crate::geom::{Point, Ray};
use num_bigint::BigInt;

/// Where a ray's line crosses a triangle, exactly.
#[derive(Clone, Debug)]
pub struct Meeting {
    /// The distance in lengths of the direction; negative behind the origin.
    pub t: Ratio,
    /// Weight of the second corner; zero on the edge across.
    pub u: Ratio,
    /// Weight of the third corner.
    pub v: Ratio,
    /// Weight of the first corner. The three add up to 1.
    pub w: Ratio,
}

/// Where the ray's line crosses the closed triangle, whatever `t_min` and `t_max`. All numbers are finite.
pub fn meet(ray: &Ray, corners: [Point; 3]) -> Option<Meeting> {
    Line::new(ray.origin, ray.direction).meet(corners)
}

/// A line whose numbers are known exactly.
#[derive(Clone, Debug)]
pub(super) enum Line {
    /// Of `f32`.
    Plain { origin: Point, direction: Point },
    /// Of whole numbers times `2^origin_exponent` and `2^direction_exponent`.
    Large { origin: [BigInt; 3], origin_exponent: i32, direction: [BigInt; 3], direction_exponent: i32 },
}

impl Line {
    pub fn new(origin: Point, direction: Point) -> Line {
        Line::Plain { origin, direction }
    }

    /// The line that a matrix of three rows of four maps this ray's to, with nothing rounded.
    pub fn mapped(ray: &Ray, matrix: &[f32; 12]) -> Line {
        let product = |a: f32, b: f32| {
            let ((m, e), (n, f)) = (parts(a), parts(b));
            (m * n, e + f)
        };
        let rows = |v: Point, moved: bool| {
            let last = if moved { 1.0 } else { 0.0 };
            let terms: Vec<(i64, i32)> =
                (0..12).map(|i| product(matrix[i], [v[0], v[1], v[2], last].map(f32::from)[i % 4])).collect();
            let (terms, exponent) = aligned(&terms);
            ([0, 1, 2].map(|row| terms[4 * row..4 * row + 4].iter().sum::<BigInt>()), exponent)
        };
        let ((origin, origin_exponent), (direction, direction_exponent)) =
            (rows(ray.origin, true), rows(ray.direction, false));
        Line::Large { origin, origin_exponent, direction, direction_exponent }
    }

    /// As the function [`meet`].
    pub fn meet(&self, corners: [Point; 3]) -> Option<Meeting> {
        let flat = |p: [Point; 3]| -> [f32; 9] { bytemuck::cast(p) };
        match self {
            Line::Plain { origin, direction } => {
                // One power of two for all that is a place, another for the direction.
                let [x, y, z] = *origin;
                let [a, b, c, d, e, f, g, h, i] = flat(corners);
                let places = [x, y, z, a, b, c, d, e, f, g, h, i].map(parts);
                let steps = direction.map(parts);
                if let (Some((places, e)), Some((steps, f))) = (fit(&places), fit(&steps)) {
                    crossing(&places[..3], &steps, &places[3..])?.meeting(e - f)
                } else {
                    let ((places, e), (steps, f)) = (aligned(&places), aligned(&steps));
                    crossing(&places[..3], &steps, &places[3..])?.meeting(e - f)
                }
            }
            Line::Large { origin, origin_exponent, direction, direction_exponent } => {
                let (corners, e) = aligned(&flat(corners).map(parts));
                let exponent = e.min(*origin_exponent);
                let scaled = |v: &BigInt, e: i32| v << (e - exponent);
                let corners: Vec<BigInt> = corners.iter().map(|v| scaled(v, e)).collect();
                let origin = origin.each_ref().map(|v| scaled(v, *origin_exponent));
                crossing(&origin, direction, &corners)?.meeting(exponent - direction_exponent)
            }
        }
    }
}

/// Numerators and the common denominator, which is not zero.
struct Crossing<T> {
    ahead: T,
    first: T,
    second: T,
    third: T,
    facing: T,
}

impl<T: Whole> Crossing<T> {
    fn meeting(self, exponent: i32) -> Option<Meeting> {
        let facing = self.facing.big();
        let ratio = |top: T, exponent: i32| Ratio::new(top.big(), facing.clone(), exponent);
        let (u, v, w) = (ratio(self.second, 0), ratio(self.third, 0), ratio(self.first, 0));
        Some(Meeting { t: ratio(self.ahead, exponent), u, v, w })
    }
}

/// The geometry at the head of this file. Corners come as nine numbers.
fn crossing<T: Whole>(origin: &[T], direction: &[T], corners: &[T]) -> Option<Crossing<T>> {
    let [p, q, r] = [0, 3, 6].map(|i| [0, 1, 2].map(|k| corners[i + k].minus(&origin[k])));
    let cross =
        |a: &[T; 3], b: &[T; 3]| [(1, 2), (2, 0), (0, 1)].map(|(i, j)| a[i].times(&b[j]).minus(&a[j].times(&b[i])));
    let dot = |a: &[T], b: &[T]| a[0].times(&b[0]).plus(&a[1].times(&b[1])).plus(&a[2].times(&b[2]));
    let across = cross(&q, &r);
    let (first, second, third) =
        (dot(direction, &across), dot(direction, &cross(&r, &p)), dot(direction, &cross(&p, &q)));
    let signs = [first.sign(), second.sign(), third.sign()];
    if signs.contains(&-1) && signs.contains(&1) {
        return None;
    }
    let facing = first.plus(&second).plus(&third);
    (facing.sign() != 0).then(|| Crossing { ahead: dot(&p, &across), first, second, third, facing })
}

#[cfg(test)]
mod tests;
