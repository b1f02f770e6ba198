use super::{Aabb, Point};

/// Linear interpolation between two ends, at one fraction of the way.
///
/// A number between `a` and `b` is `(1 − f)·a + f·b`, with both products and the sum in `f64` and the result rounded to the nearest `f32`. What
/// rays between two frames are promised follows from two properties of these operations, and from nothing else.
///
/// - *Order is kept.* Both weights are at least 0 and the same for all numbers. So each product, the sum and the last rounding are monotone in `a`
///   and in `b`: from `a ≤ a'` and `b ≤ b'` follows `mix(a, b) ≤ mix(a', b')`, to the bit and without a tolerance. A box that is interpolated this
///   way therefore contains every point that is, if each end of the box contains that end of the point.
/// - *Nothing leaves the way.* The result lies between `a` and `b`, and is `a` where both are equal: the error of the `f64` operations is far below
///   half a step of `f32`. What stands still does not tremble, and nothing overflows.
///
/// Interpolation as `a + f·(b − a)` has neither property, since the difference is rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    first: f64,
    second: f64,
}

impl Mix {
    /// So far on the way from the first end to the second: 0 is the first, 1 the second. `None` for anything that is not from 0 to 1.
    #[inline]
    pub fn new(fraction: f32) -> Option<Mix> {
        let second = f64::from(fraction);
        (0.0..=1.0).contains(&second).then_some(Mix { first: 1.0 - second, second })
    }

    /// The weights of the first and of the second end. Their sum is 1, up to the rounding of the first.
    #[inline]
    pub fn weights(&self) -> [f64; 2] {
        [self.first, self.second]
    }

    /// Between two numbers.
    #[inline(always)]
    pub fn number(&self, a: f32, b: f32) -> f32 {
        (self.first * f64::from(a) + self.second * f64::from(b)) as f32
    }

    /// Between two positions.
    #[inline(always)]
    pub fn point(&self, a: Point, b: Point) -> Point {
        [0, 1, 2].map(|axis| self.number(a[axis], b[axis]))
    }

    /// Between two boxes.
    #[inline(always)]
    pub fn bounds(&self, a: &Aabb, b: &Aabb) -> Aabb {
        Aabb { min: self.point(a.min, b.min), max: self.point(a.max, b.max) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Numbers that rounding treats worst: the largest and the smallest, neighbours, and far ones beside near ones.
    fn special(random: &mut Random) -> f32 {
        let v = [0.0, 1.0, f32::MAX, f32::MIN_POSITIVE, f32::from_bits(1), 1.5e-30, 3.3e30, 16_777_216.0];
        let v = v[random.below(8) as usize];
        let near = f32::from_bits(v.to_bits().wrapping_add(random.below(3) as u32));
        let v = if near.is_finite() { near } else { v };
        let v = if random.below(4) == 0 { random.unit() as f32 } else { v };
        if random.below(2) == 0 { -v } else { v }
    }

    fn fraction(random: &mut Random) -> f32 {
        match random.below(8) {
            0 => 0.0,
            1 => 1.0,
            2 => 1.0 - f32::EPSILON / 2.0,
            3 => f32::from_bits(1 + random.below(4) as u32),
            4 => 2f32.powi(-(random.below(40) as i32)),
            _ => random.unit() as f32,
        }
    }

    #[test]
    fn order_is_kept_and_nothing_leaves_the_way() {
        let mut random = Random::new(1);
        for _ in 0..400_000 {
            let mix = Mix::new(fraction(&mut random)).unwrap();
            let [mut a, mut b] = [0; 2].map(|_| [special(&mut random), special(&mut random)]);
            a.sort_by(f32::total_cmp);
            b.sort_by(f32::total_cmp);
            let [low, high] = [0, 1].map(|i| mix.number(a[i], b[i]));
            assert!(low <= high, "{mix:?} {a:?} {b:?}");
            for (i, v) in [low, high].into_iter().enumerate() {
                assert!(a[i].min(b[i]) <= v && v <= a[i].max(b[i]), "{mix:?} {} {}: {v}", a[i], b[i]);
                assert_eq!(mix.number(a[i], a[i]), a[i], "{mix:?}");
            }
        }
    }

    #[test]
    fn a_box_between_boxes_contains_the_points_between_their_points() {
        let mut random = Random::new(2);
        for _ in 0..100_000 {
            let mix = Mix::new(fraction(&mut random)).unwrap();
            let [a, b] = [0; 2].map(|_| [0; 3].map(|_| [0; 3].map(|_| special(&mut random))));
            let bounds = mix.bounds(&Aabb::from_points(&a), &Aabb::from_points(&b));
            for (a, b) in a.iter().zip(&b) {
                assert!(bounds.contains(&Aabb::from_points(&[mix.point(*a, *b)])), "{mix:?} {a:?} {b:?}");
            }
        }
    }

    #[test]
    fn ends_are_the_ends_and_beyond_them_there_is_nothing() {
        for v in [0.3f32, f32::MAX, -1e-44] {
            assert_eq!(Mix::new(0.0).unwrap().number(v, -7.5).to_bits(), v.to_bits());
            assert_eq!(Mix::new(1.0).unwrap().number(-7.5, v).to_bits(), v.to_bits());
        }
        assert_eq!([-1e-30, 1.0f32.next_up(), f32::NAN, f32::INFINITY].map(Mix::new), [None; 4]);
        assert_eq!(Mix::new(-0.0).map(|mix| mix.weights()), Some([1.0, 0.0]));
    }
}
