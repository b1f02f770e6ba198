//! Boxes in `f64`, for measuring what `f32` cannot hold.

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub min: [f64; 3],
    pub max: [f64; 3],
}

impl Bounds {
    /// The box that contains nothing.
    pub const EMPTY: Bounds = Bounds { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// The smallest box around some points. A coordinate that is NaN does not count.
    pub fn of(points: impl IntoIterator<Item = [f64; 3]>) -> Bounds {
        points.into_iter().fold(Bounds::EMPTY, |all, p| all.union(Bounds { min: p, max: p }))
    }

    /// The smallest box that contains both.
    pub fn union(self, other: Bounds) -> Bounds {
        Bounds {
            min: [0, 1, 2].map(|a| self.min[a].min(other.min[a])),
            max: [0, 1, 2].map(|a| self.max[a].max(other.max[a])),
        }
    }

    /// The length of the longest side, 0 of an empty box.
    pub fn longest(&self) -> f64 {
        (0..3).map(|a| self.max[a] - self.min[a]).fold(0.0, f64::max)
    }

    pub fn corners(&self) -> [[f64; 3]; 8] {
        std::array::from_fn(|k| [0, 1, 2].map(|a| if k >> a & 1 == 0 { self.min[a] } else { self.max[a] }))
    }
}

impl From<crate::geom::Aabb> for Bounds {
    fn from(of: crate::geom::Aabb) -> Bounds {
        Bounds { min: of.min.map(f64::from), max: of.max.map(f64::from) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;

    #[test]
    fn a_box_holds_its_points_and_has_their_extremes_for_corners() {
        let points = [[1.0, -2.0, 0.5], [-1.0, f64::NAN, 3.0], [0.0, 4.0, 1.0]];
        let bounds = Bounds::of(points);
        assert_eq!(bounds, Bounds { min: [-1.0, -2.0, 0.5], max: [1.0, 4.0, 3.0] });
        assert_eq!((bounds.longest(), Bounds::EMPTY.longest(), Bounds::of([])), (6.0, 0.0, Bounds::EMPTY));
        assert_eq!(Bounds::of(bounds.corners()), bounds);
        assert_eq!((bounds.corners()[0], bounds.corners()[7]), (bounds.min, bounds.max));
        assert_eq!(Bounds::from(Aabb::EMPTY), Bounds::EMPTY);
    }
}
