use super::{Aabb, Affine, round_down, round_up};

/// How far rounding can move a point of the image, relative to the magnitudes that its coordinates are summed from: interpolated vertices are rounded
/// to `f32`, by at most 2⁻²⁴ of themselves. Twice that leaves room for what a ray's way back suffers in `f64`.
const ROUNDING: f64 = 1.0 / (1u64 << 23) as f64;

/// A box that contains the image of everything in a box, while both the box and the map go linearly from one end to the other.
///
/// A point that goes from `v₀` to `v₁`, under a matrix that goes from `M₀` to `M₁`, is at the time `f`
///
/// ```text
/// (1 − f)² · M₀v₀  +  2f(1 − f) · (M₀v₁ + M₁v₀)/2  +  f² · M₁v₁
/// ```
///
/// The three weights are at least 0 and sum up to 1, so the point never leaves the hull of those three, which are the control points of a
/// quadratic Bézier curve. Each of them lies in a box that is known: `M₀B₀`, the mean of `M₀B₁` and `M₁B₀`, and `M₁B₁`. The result is rounded
/// outward, and contains the image of points that were rounded to `f32` after they were interpolated. Where nothing goes anywhere, it is
/// [`Affine::transform_box`].
pub fn swept_box(maps: [&Affine; 2], boxes: [&Aabb; 2]) -> Aabb {
    if maps[0] == maps[1] && boxes[0] == boxes[1] {
        return maps[0].transform_box(boxes[0]);
    }
    if boxes.iter().any(|b| b.is_empty()) {
        return Aabb::EMPTY;
    }
    let mut out = Aabb::EMPTY;
    for axis in 0..3 {
        let image = |map: usize, of: usize| extent(&maps[map].rows[axis], boxes[of]);
        let (first, last, across) = (image(0, 0), image(1, 1), [image(0, 1), image(1, 0)]);
        let middle = [0, 1].map(|end| (across[0].0[end] + across[1].0[end]) / 2.0);
        let magnitude = [first.1, last.1, across[0].1, across[1].1].into_iter().fold(0.0, f64::max);
        let low = first.0[0].min(last.0[0]).min(middle[0]);
        let high = first.0[1].max(last.0[1]).max(middle[1]);
        // Vertices below the normal range are rounded by a fixed step.
        let steps = maps.iter().flat_map(|map| &map.rows[axis][..3]).map(|m| m.abs()).sum::<f64>();
        let slack = magnitude * ROUNDING + steps * f64::from(f32::from_bits(1));
        out.min[axis] = round_down(low - slack);
        out.max[axis] = round_up(high + slack);
    }
    out
}

/// The image of a box on one axis, and the largest sum of the magnitudes of its terms.
fn extent(row: &[f64; 4], of: &Aabb) -> ([f64; 2], f64) {
    let (mut low, mut high, mut magnitude) = (row[3], row[3], row[3].abs());
    for c in 0..3 {
        let (x, y) = (row[c] * f64::from(of.min[c]), row[c] * f64::from(of.max[c]));
        low += x.min(y);
        high += x.max(y);
        magnitude += x.abs().max(y.abs());
    }
    ([low, high], magnitude)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Mix;
    use crate::random::Random;

    #[test]
    fn nothing_leaves_the_swept_box_at_any_time() {
        let mut random = Random::new(3);
        for round in 0..4000 {
            let scale = [1e-40, 1e-3, 1.0, 1e5, 1e15][round % 5];
            let mut number = |s: f64| (s * (2.0 * random.unit() - 1.0)) as f32;
            let mut maps = [0; 2].map(|_| {
                let mut m = [0; 12].map(|_| number(1.0));
                [3, 7, 11].iter().for_each(|i| m[*i] = number(scale * 3.0));
                m
            });
            // Half of them turn over twice, the points and the map: on the way they are far from both ends.
            let turns_over = round % 2 == 0;
            if turns_over {
                maps[1] = maps[0].map(|m| -m);
            }
            let affine = maps.map(|m| Affine::from_f32(&m));
            let mut ends = [0; 2].map(|_| [0; 6].map(|_| [0; 3].map(|_| number(scale))));
            if turns_over {
                ends[1] = ends[0].map(|p| p.map(|c| -c));
            }
            let boxes = [0, 1].map(|i| Aabb::from_points(&ends[i]));
            let swept = swept_box([&affine[0], &affine[1]], [&boxes[0], &boxes[1]]);
            for step in 0..=20 {
                let fraction = if step % 2 == 0 { step as f32 / 20.0 } else { random.unit() as f32 };
                let mix = Mix::new(fraction).unwrap();
                let [first, second] = mix.weights();
                let rows = [0, 1, 2]
                    .map(|r| [0, 1, 2, 3].map(|c| first * affine[0].rows[r][c] + second * affine[1].rows[r][c]));
                for (a, b) in ends[0].iter().zip(&ends[1]) {
                    let p = Affine { rows }.transform_point(mix.point(*a, *b).map(f64::from));
                    for axis in 0..3 {
                        let (low, high) = (f64::from(swept.min[axis]), f64::from(swept.max[axis]));
                        assert!(low <= p[axis] && p[axis] <= high, "{maps:?} {ends:?} at {fraction}: {p:?} {swept:?}");
                    }
                }
            }
        }
    }

    /// What moves to and fro at once, the mesh one way and its instance the other, hardly moves: a hull of all four images would be twice as wide.
    #[test]
    fn a_motion_that_is_undone_takes_little_room() {
        let [here, there] = [0.0, 10.0].map(|x| Affine::translation([x, 0.0, 0.0]));
        let at = |x: f32| Aabb { min: [x, 0.0, 0.0], max: [x + 1.0, 1.0, 1.0] };
        let swept = swept_box([&here, &there], [&at(0.0), &at(-10.0)]);
        assert!(swept.min[0] > -0.01 && swept.max[0] < 1.01, "{swept:?}");
        assert_eq!(swept_box([&there, &there], [&at(0.0), &at(0.0)]), there.transform_box(&at(0.0)));
        assert!(swept_box([&here, &there], [&at(0.0), &Aabb::EMPTY]).is_empty());
    }
}
