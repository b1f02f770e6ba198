//! Boxes and points as vectors of four floats, as builders use them.

use super::ops;

/// Four floats in one vector register: three axes, and a fourth lane that nobody looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub struct Lanes(pub [f32; 4]);

impl Lanes {
    #[inline]
    pub const fn splat(v: f32) -> Lanes {
        Lanes([v; 4])
    }

    #[inline(always)]
    pub fn of_point(p: [f32; 3]) -> Lanes {
        Lanes([p[0], p[1], p[2], 0.0])
    }

    #[inline(always)]
    pub fn of_counts(counts: [i32; 4]) -> Lanes {
        Lanes(ops::from_counts(counts))
    }

    #[inline(always)]
    pub fn point(self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }

    /// `if self < other { self } else { other }` per lane.
    #[inline(always)]
    pub fn min(self, other: Lanes) -> Lanes {
        Lanes(ops::min(self.0, other.0))
    }

    /// `if self > other { self } else { other }` per lane.
    #[inline(always)]
    pub fn max(self, other: Lanes) -> Lanes {
        Lanes(ops::max(self.0, other.0))
    }

    #[inline(always)]
    pub fn plus(self, other: Lanes) -> Lanes {
        Lanes(ops::add(self.0, other.0))
    }

    #[inline(always)]
    pub fn minus(self, other: Lanes) -> Lanes {
        Lanes(ops::sub(self.0, other.0))
    }

    #[inline(always)]
    pub fn times(self, other: Lanes) -> Lanes {
        Lanes(ops::mul(self.0, other.0))
    }

    /// `if self < than { x } else { y }` per lane.
    #[inline(always)]
    pub fn if_less(self, than: Lanes, x: Lanes, y: Lanes) -> Lanes {
        Lanes(ops::if_less(self.0, than.0, x.0, y.0))
    }

    /// The three axes, and 0 in the fourth lane. Needed before a multiplication: a reference's integers are tiny floats
    /// there, and processors take a hundred cycles for a product with one.
    #[inline(always)]
    pub fn axes(self) -> Lanes {
        Lanes(ops::axes(self.0))
    }

    /// The low byte of each lane's bits.
    #[inline(always)]
    pub fn low_bytes(self) -> [u32; 4] {
        ops::low_bytes(self.0)
    }
}

crate::pod::plain! {
    Lanes = [[f32; 4]];
    LaneBox = [Lanes, Lanes];
}

/// A box in two registers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct LaneBox {
    pub min: Lanes,
    pub max: Lanes,
}

impl LaneBox {
    pub const EMPTY: LaneBox = LaneBox { min: Lanes::splat(f32::INFINITY), max: Lanes::splat(f32::NEG_INFINITY) };

    #[inline(always)]
    pub fn union(self, other: LaneBox) -> LaneBox {
        LaneBox { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    #[inline(always)]
    pub fn grow(self, p: Lanes) -> LaneBox {
        LaneBox { min: self.min.min(p), max: self.max.max(p) }
    }

    /// See [`Aabb::half_area`](crate::geom::Aabb::half_area); the box must not be empty. Edges are scaled first.
    #[inline(always)]
    pub fn scaled_half_area(self, scale: f32) -> f32 {
        let [x, y, z, _] = self.max.minus(self.min).axes().times(Lanes::splat(scale)).0;
        x * y + y * z + z * x
    }

    /// [`LaneBox::scaled_half_area`] of four boxes at once.
    #[inline(always)]
    pub fn scaled_half_areas(boxes: [LaneBox; 4], scale: Lanes) -> Lanes {
        let [x, y, z, _] = ops::transpose(boxes.map(|b| b.max.minus(b.min).0)).map(Lanes);
        let [x, y, z] = [x.times(scale), y.times(scale), z.times(scale)];
        x.times(y).plus(y.times(z)).plus(z.times(x))
    }

    #[inline(always)]
    pub fn aabb(self) -> crate::geom::Aabb {
        crate::geom::Aabb { min: self.min.point(), max: self.max.point() }
    }
}

#[cfg(test)]
mod tests {
    use super::{LaneBox, Lanes, ops};
    use crate::geom::Aabb;
    use crate::simd::portable;

    fn bits(v: [f32; 4]) -> [u32; 4] {
        v.map(f32::to_bits)
    }

    #[test]
    fn both_twins_give_the_same_bits() {
        let special = [
            0.0,
            -0.0,
            1.0,
            -1.5,
            0.1,
            255.3,
            12_582_912.0,
            f32::MIN_POSITIVE,
            1e-45,
            -1e-40,
            f32::MAX,
            f32::MIN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
        ];
        let vector = |i: usize| [0, 1, 2, 3].map(|k| special[(i * (k + 1) + k) % special.len()]);
        for i in 0..special.len() {
            for j in 0..special.len() {
                let (a, b, x, y) = (vector(i), vector(j), vector(i + j), vector(i * j + 1));
                assert_eq!(bits(ops::min(a, b)), bits(portable::min(a, b)), "min {a:?} {b:?}");
                assert_eq!(bits(ops::max(a, b)), bits(portable::max(a, b)), "max {a:?} {b:?}");
                assert_eq!(bits(ops::if_less(a, b, x, y)), bits(portable::if_less(a, b, x, y)));
                assert_eq!(ops::low_bytes(a), portable::low_bytes(a));
                assert_eq!(bits(ops::axes(a)), bits(portable::axes(a)));
                assert_eq!(ops::transpose([a, b, x, y]).map(bits), portable::transpose([a, b, x, y]).map(bits));

                // A NaN made by arithmetic has no specified bits.
                let same = |p: [f32; 4], q: [f32; 4]| {
                    p.iter().zip(q).all(|(p, q)| p.to_bits() == q.to_bits() || p.is_nan() && q.is_nan())
                };
                assert!(same(ops::add(a, b), portable::add(a, b)) && same(ops::sub(a, b), portable::sub(a, b)));
                assert!(same(ops::mul(a, b), portable::mul(a, b)));
            }
        }
        for counts in [[0, 1, 2, 3], [i32::MAX, (1 << 24) + 1, 12_345_678, 7]] {
            assert_eq!(bits(ops::from_counts(counts)), bits(portable::from_counts(counts)));
        }
    }

    #[test]
    fn four_areas_are_the_four_areas() {
        let boxes = [1.0f32, 2.5, 0.3, 7.0].map(|s| {
            let b = Aabb { min: [-s, 0.1, 0.2], max: [s, 0.1 + s * 0.7, s + 9.0] };
            LaneBox { min: Lanes::of_point(b.min), max: Lanes::of_point(b.max) }
        });
        let together = LaneBox::scaled_half_areas(boxes, Lanes::splat(0.37));
        assert_eq!(bits(together.0), bits(boxes.map(|b| b.scaled_half_area(0.37))));
    }
}
