//! What every kind of bounds can do, whatever its shape.

/// Rounding of `f64`: half the distance from 1 to the next number.
pub(super) const UNIT: f64 = f64::EPSILON / 2.0;

/// A convex shape that stands for what it holds: cheaper to ask than its contents, and worth the more the smaller it is.
///
/// Its first user called it an abstraction hull; the field says bounding volume.
pub trait BoundingVolume: Sized {
    /// Additions, multiplications, divisions, minima and maxima of a ray's test, counted, without what is done once for a ray.
    const OPERATIONS: u32;

    /// Around points; nothing around none. The points are inside even by exact arithmetic.
    fn of_points(points: &[[f64; 3]]) -> Option<Self>;

    /// Around both, of the same kind. All of both is inside.
    fn merged(&self, other: &Self) -> Self;

    /// Surface area, in the square of the scene's unit.
    fn area(&self) -> f64;

    /// How much rays pay for it, up to a factor that all kinds share: rays that meet it, for whom area stands, times
    /// [`OPERATIONS`](BoundingVolume::OPERATIONS).
    fn cost(&self) -> f64 {
        f64::from(Self::OPERATIONS) * self.area()
    }
}
