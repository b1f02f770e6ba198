//! Aims: rays that pass a point exactly where `f32` can say so, and to the nearest `f32` direction elsewhere.

use crate::geom::{Point, Ray};

/// From `from`, rounded, in the direction nearest to that of `to`. The point lies at t ≈ 1.
pub(super) fn toward(from: [f64; 3], to: [f64; 3]) -> Ray {
    let origin = from.map(|v| v as f32);
    let direction = [0, 1, 2].map(|a| (to[a] - f64::from(origin[a])) as f32);
    if direction == [0.0; 3] { Ray::new(origin, [1.0, 0.0, 0.0]) } else { Ray::new(origin, direction) }
}

/// From near `from` exactly through `(a + b) / 2`, which lies at t = ½; `None` where the numbers do not allow it.
///
/// For a vertex, `a` and `b` are the same.
pub(super) fn through_middle(from: [f64; 3], a: Point, b: Point) -> Option<Ray> {
    let (mut origin, mut direction) = ([0.0; 3], [0.0; 3]);
    for axis in 0..3 {
        (origin[axis], direction[axis]) = start(from[axis], f64::from(a[axis]) + f64::from(b[axis]))?;
    }
    (direction != [0.0; 3]).then(|| Ray::new(origin, direction))
}

/// An origin near `wish` and the direction `sum − 2·origin`, both exact.
///
/// The direction must not have more than 24 bits. A sum whose last place is coarse leaves room for a fine origin; otherwise the
/// direction reaches down to the last place of the sum, and so must be short: the origin comes near.
fn start(wish: f64, sum: f64) -> Option<(f32, f32)> {
    let largest = (2.0 * wish.abs()).max(sum.abs());
    if largest == 0.0 {
        return Some((0.0, 0.0));
    }
    let fine = power_of_two(largest) * 2f64.powi(-21);
    let last = last_place(sum);
    let origin = if fine <= last || sum == 0.0 {
        (wish / fine).round() * fine
    } else {
        let step = last.max(power_of_two(sum) * 2f64.powi(-23));
        let reach = 2f64.powi(23) * last - step;
        if reach < 0.0 {
            return None;
        }
        (wish.clamp(0.5 * sum - reach, 0.5 * sum + reach) / step).round() * step
    };
    let direction = sum - 2.0 * origin;
    let exact = |v: f64| f64::from(v as f32) == v;
    (exact(origin) && exact(direction)).then_some((origin as f32, direction as f32))
}

/// The largest power of two that is not above `|v|`.
fn power_of_two(v: f64) -> f64 {
    f64::from_bits(v.to_bits() & 0x7FF0_0000_0000_0000)
}

/// The power of two of the last bit that is set.
fn last_place(v: f64) -> f64 {
    let fraction = v.to_bits() & 0x000F_FFFF_FFFF_FFFF | 0x0010_0000_0000_0000;
    power_of_two(v) * 2f64.powi(fraction.trailing_zeros() as i32 - 52)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn exact_aims_are_exact() {
        let mut random = Random::new(1);
        let (mut vertices, mut edges) = (0, 0);
        for round in 0..2000 {
            let scale = [1.0, 1e-3, 1e6][round % 3];
            let other = [1.0, 1e-9, 1e12][round % 7 % 3];
            let mut point = |scale: f64| [0; 3].map(|_| (scale * (2.0 * random.unit() - 1.0)) as f32);
            let (a, b, from) = (point(scale), point(scale * other), point(scale).map(|v| 3.0 * f64::from(v)));
            let passes = |ray: &Ray, a: Point, b: Point| {
                (0..3).all(|k| {
                    let sum = f64::from(a[k]) + f64::from(b[k]);
                    2.0 * f64::from(ray.origin[k]) + f64::from(ray.direction[k]) == sum
                })
            };
            if let Some(ray) = through_middle(from, a, a) {
                assert!(passes(&ray, a, a), "{ray:?} {a:?}");
                vertices += 1;
            }
            if let Some(ray) = through_middle(from, a, b) {
                assert!(passes(&ray, a, b), "{ray:?} {a:?} {b:?}");
                edges += 1;
            }
        }
        assert!(vertices > 1900 && edges > 500, "{vertices} {edges}");

        // Where there is room, the origin is where it was wished.
        let ray = through_middle([0.3, -20.0, 0.0], [1.0, 2.0, 0.0], [1.0, 2.0, 0.0]).expect("room");
        assert!((ray.origin[0] - 0.3).abs() < 1e-5 && (ray.origin[1] + 20.0).abs() < 1e-5 && ray.origin[2] == 0.0);
    }
}
