//! Boxes in two vectors of four floats, as builders use them.

use super::Lanes;

crate::pod::plain! {
    LaneBox = [Lanes, Lanes];
}

/// A box in two registers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct LaneBox {
    /// Near corner in the first three lanes. What is in the fourth, no method looks at.
    pub min: Lanes,
    /// Far corner likewise.
    pub max: Lanes,
}

impl LaneBox {
    /// Contains nothing: the neutral element of [`LaneBox::union`].
    pub const EMPTY: LaneBox = LaneBox { min: Lanes::splat(f32::INFINITY), max: Lanes::splat(f32::NEG_INFINITY) };

    /// The smallest box that contains both.
    #[inline(always)]
    pub fn union(self, other: LaneBox) -> LaneBox {
        LaneBox { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The smallest box that also contains `p`.
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
        let [x, y, z, _] = Lanes::transpose(boxes.map(|b| b.max.minus(b.min)));
        let [x, y, z] = [x.times(scale), y.times(scale), z.times(scale)];
        x.times(y).plus(y.times(z)).plus(z.times(x))
    }

    /// The same box without the fourth lanes.
    #[inline(always)]
    pub fn aabb(self) -> crate::geom::Aabb {
        crate::geom::Aabb { min: self.min.point(), max: self.max.point() }
    }
}

#[cfg(test)]
mod tests {
    use super::{LaneBox, Lanes};
    use crate::geom::Aabb;

    #[test]
    fn four_areas_are_the_four_areas() {
        let boxes = [1.0f32, 2.5, 0.3, 7.0].map(|s| {
            let b = Aabb { min: [-s, 0.1, 0.2], max: [s, 0.1 + s * 0.7, s + 9.0] };
            LaneBox { min: Lanes::of_point(b.min), max: Lanes::of_point(b.max) }
        });
        let together = LaneBox::scaled_half_areas(boxes, Lanes::splat(0.37));
        let single = boxes.map(|b| b.scaled_half_area(0.37));
        assert_eq!(together.0.map(f32::to_bits), single.map(f32::to_bits));
    }
}
