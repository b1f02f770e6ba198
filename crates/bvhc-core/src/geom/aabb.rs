use super::Point;

/// An axis-aligned box, closed on all sides. `min > max` on any axis means "empty".
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The smallest coordinate on each axis.
    pub min: Point,
    /// The largest coordinate on each axis.
    pub max: Point,
}

crate::pod::plain! {
    Aabb = [Point, Point];
}

impl Aabb {
    /// The box that contains nothing and is the neutral element of [`Aabb::union`].
    pub const EMPTY: Aabb = Aabb { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// The smallest box around some points; [`Aabb::EMPTY`] around none. The coordinates must be numbers.
    #[inline]
    pub fn from_points(points: &[Point]) -> Aabb {
        points.iter().fold(Aabb::EMPTY, |b, p| b.grow(*p))
    }

    /// The smallest box that also contains `p`.
    #[must_use]
    #[inline]
    pub fn grow(self, p: Point) -> Aabb {
        self.union(Aabb { min: p, max: p })
    }

    /// The smallest box that contains both.
    #[must_use]
    #[inline]
    pub fn union(self, other: Aabb) -> Aabb {
        let mut out = self;
        for axis in 0..3 {
            out.min[axis] = min(self.min[axis], other.min[axis]);
            out.max[axis] = max(self.max[axis], other.max[axis]);
        }
        out
    }

    /// The common part of two boxes; empty where they do not touch.
    #[must_use]
    #[inline]
    pub fn intersection(self, other: Aabb) -> Aabb {
        let mut out = self;
        for axis in 0..3 {
            out.min[axis] = max(self.min[axis], other.min[axis]);
            out.max[axis] = min(self.max[axis], other.max[axis]);
        }
        out
    }

    /// Whether `min > max` on some axis. A box without extent, such as that of one point, is not empty.
    #[inline]
    pub fn is_empty(&self) -> bool {
        (0..3).any(|a| self.min[a] > self.max[a])
    }

    /// Finite and `min <= max` on every axis; written so that NaN fails.
    #[inline]
    pub fn is_valid(&self) -> bool {
        (0..3).all(|a| self.min[a] <= self.max[a] && self.min[a].is_finite() && self.max[a].is_finite())
    }

    /// Half the surface area (`dx·dy + dy·dz + dz·dx`), 0 for an empty box. The SAH only ever needs ratios of areas,
    /// so the factor 2 is left out everywhere.
    #[inline]
    pub fn half_area(&self) -> f32 {
        let [x, y, z] = self.extent();
        if x < 0.0 || y < 0.0 || z < 0.0 { 0.0 } else { x * y + y * z + z * x }
    }

    /// `max - min` per axis; negative for an empty box.
    #[inline]
    pub fn extent(&self) -> Point {
        [self.max[0] - self.min[0], self.max[1] - self.min[1], self.max[2] - self.min[2]]
    }

    /// Twice the centre. Builders compare centres only with each other, so the division is left out, as are its rounding
    /// and its underflow.
    #[inline]
    pub fn center2(&self) -> Point {
        [self.min[0] + self.max[0], self.min[1] + self.max[1], self.min[2] + self.max[2]]
    }

    /// Whether two boxes have a point in common; touching counts, and an empty box overlaps nothing.
    #[inline]
    pub fn overlaps(&self, other: &Aabb) -> bool {
        (0..3).all(|a| self.min[a] <= other.max[a] && other.min[a] <= self.max[a])
    }

    /// Exact containment: no tolerance is needed, because unions of boxes round nothing.
    #[inline]
    pub fn contains(&self, inner: &Aabb) -> bool {
        (0..3).all(|a| self.min[a] <= inner.min[a] && inner.max[a] <= self.max[a])
    }
}

/// `f32::min` without its NaN rule: compiles to one instruction, and gives the same bits as the SIMD twin.
#[inline]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline]
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_is_neutral_and_has_no_area() {
        let b = Aabb { min: [0.0, 1.0, 2.0], max: [3.0, 4.0, 5.0] };
        assert_eq!(Aabb::EMPTY.union(b), b);
        assert_eq!(Aabb::EMPTY.half_area(), 0.0);
        assert!(Aabb::EMPTY.is_empty() && !Aabb::EMPTY.is_valid() && b.is_valid());
    }

    #[test]
    fn half_area_of_a_brick() {
        let b = Aabb { min: [0.0; 3], max: [1.0, 2.0, 3.0] };
        assert_eq!(b.half_area(), 11.0);
    }

    #[test]
    fn disjoint_boxes_intersect_in_an_empty_box() {
        let a = Aabb { min: [0.0; 3], max: [1.0; 3] };
        let b = Aabb { min: [2.0, 0.0, 0.0], max: [3.0, 1.0, 1.0] };
        assert!(a.intersection(b).is_empty());
        assert!(a.union(b).contains(&b) && !a.contains(&b));
    }
}
