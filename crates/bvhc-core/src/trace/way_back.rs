//! How a ray gets into the space of an instance that moves.

use crate::cache::BetweenInstance;
use crate::geom::vector::{dot, sub};
use crate::geom::{Affine, Mix};

/// The way of a ray into the space of an instance's tree: `linear · (p − from) + to`.
pub struct WayBack {
    pub linear: [[f64; 3]; 3],
    from: [f64; 3],
    to: [f64; 3],
}

impl BetweenInstance {
    /// Origin and direction of a ray in the space of the instance's tree at that time. `t` stays what it is, since nothing is normalised.
    ///
    /// The stored inverse serves at both ends, and at all times where the instance [stands](BetweenInstance::stands); between, the interpolated
    /// matrix is inverted in `f64`. `None` where it has no inverse: see [`Between::closest_hit`](crate::cache::Between::closest_hit).
    #[inline]
    pub fn to_object(&self, mix: &Mix, origin: [f64; 3], direction: [f64; 3]) -> Option<([f64; 3], [f64; 3])> {
        let way = way_back(self, mix)?;
        let linear = |v: [f64; 3], r: usize| dot(way.linear[r], v);
        let origin = sub(origin, way.from);
        let origin = [0, 1, 2].map(|r| linear(origin, r) + way.to[r]);
        let direction = [0, 1, 2].map(|r| linear(direction, r));
        let usable = origin.iter().chain(&direction).all(|v| v.is_finite()) && direction != [0.0; 3];
        usable.then_some((origin, direction))
    }
}

/// `None` where the instance is flat at that time.
#[inline]
pub fn way_back(instance: &BetweenInstance, mix: &Mix) -> Option<WayBack> {
    let [first, second] = mix.weights();
    if instance.stands() || first == 0.0 || second == 0.0 {
        let end = usize::from(first == 0.0);
        let [x, y, z] = Affine::from_f32(&instance.ends[end].world_to_object).rows;
        let linear = [x, y, z].map(|[a, b, c, _]| [a, b, c]);
        return Some(WayBack { linear, from: [0.0; 3], to: [x[3], y[3], z[3]] });
    }
    let [x, y, z] = instance.object_to_world(mix).rows;
    let linear = inverse([x, y, z].map(|[a, b, c, _]| [a, b, c]))?;
    Some(WayBack { linear, from: [x[3], y[3], z[3]], to: [0.0; 3] })
}

/// The inverse of three rows, unless they are as good as flat: where the terms of the determinant cancel to 2⁻³² of themselves, what is
/// left of them is too rough to send a ray back by. Short of that, where rows are of like size, a ray is off by about 2⁻¹⁸ of its distance to the
/// instance at most; where nothing cancels, by a few units of `f64`.
#[inline]
fn inverse(m: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let minor = |r0: usize, c0: usize, r1: usize, c1: usize| (m[r0][c0] * m[r1][c1], m[r0][c1] * m[r1][c0]);
    let (mut determinant, mut terms) = (0.0, 0.0);
    for c in 0..3 {
        let (p, q) = minor(1, (c + 1) % 3, 2, (c + 2) % 3);
        determinant += m[0][c] * (p - q);
        terms += m[0][c].abs() * (p.abs() + q.abs());
    }
    const FLAT: f64 = 1.0 / (1u64 << 32) as f64;
    // False for NaN too.
    if !(determinant.abs() > terms * FLAT) {
        return None;
    }
    let entry = |r: usize, c: usize| {
        let (p, q) = minor((c + 1) % 3, (r + 1) % 3, (c + 2) % 3, (r + 2) % 3);
        (p - q) / determinant
    };
    Some([0, 1, 2].map(|r| [0, 1, 2].map(|c| entry(r, c))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inverse_undoes_its_matrix_unless_that_is_flat() {
        let turned = |f: f64| [[1.0 - 2.0 * f, 0.1, 0.0], [0.0, 1.0 - 2.0 * f, 0.0], [0.3, 0.0, 1.0]];
        for f in [0.0, 0.25, 0.499, 0.7] {
            let (m, back) = (turned(f), inverse(turned(f)).unwrap());
            for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                let product = dot(m[r], [back[0][c], back[1][c], back[2][c]]);
                assert!((product - f64::from(u8::from(r == c))).abs() < 1e-9, "{f}: {m:?} {back:?}");
            }
        }
        let third = 1.0 / 3.0;
        let cancelling = [[1.0, third, 0.0], [3.0, 3.0 * third + 1e-12, 0.0], [0.0, 0.0, 1.0]];
        for flat in [turned(0.5), cancelling, [[0.0; 3]; 3], [[f64::NAN; 3]; 3], [[f64::INFINITY; 3]; 3]] {
            assert_eq!(inverse(flat), None, "{flat:?}");
        }
        // Small is not flat.
        assert!(inverse([[1e-40, 0.0, 0.0], [0.0, 1e-40, 0.0], [0.0, 0.0, 1e-40]]).is_some());
    }
}
