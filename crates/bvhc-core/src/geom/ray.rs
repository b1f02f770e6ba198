use super::Point;

/// A ray segment: points `origin + t·direction` for `t_min <= t <= t_max`. The direction need not be a unit vector; `t` is
/// measured in its length, so that a ray keeps its `t` when an instance transform maps it.
///
/// A ray that starts at a hit meets the triangle that it starts from in about half of all cases, since its origin is rounded. Start it a
/// little off the triangle, along the normal on the side that it leaves to, or pass over hits of the same instance, part and number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t` is 0, in the scene's own unit.
    pub origin: Point,
    /// Of any length but 0, which is the unit of `t`.
    pub direction: Point,
    /// Hits before it do not count. Negative values look behind the origin.
    pub t_min: f32,
    /// Hits behind it do not count. Infinity for a ray without end.
    pub t_max: f32,
}

impl Ray {
    /// The half-infinite ray with `t_min = 0`.
    #[inline]
    pub fn new(origin: Point, direction: Point) -> Ray {
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The same ray ending at `t_max`: for a shadow ray, the distance to the light. To the triangle of a hit it is `hit.t.next_up()`.
    #[must_use]
    #[inline]
    pub fn until(self, t_max: f32) -> Ray {
        Ray { t_max, ..self }
    }
}
