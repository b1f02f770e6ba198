//! Slabs in fixed directions.

use super::extremes::DIRECTIONS;
use super::polytope;
use super::volume::{BoundingVolume, UNIT};
use crate::geom::vector::dot;

/// What is between two planes in each of [`DIRECTIONS`]: a box with its corners cut off (Klosowski, Held, Mitchell, Sowizral and Zikan,
/// "Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs", 1998).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dop14 {
    /// The least coordinate along each direction.
    pub low: [f64; 7],
    /// The greatest.
    pub high: [f64; 7],
}

impl BoundingVolume for Dop14 {
    /// Seven slabs. A ray's coordinates along the directions are the same at every node.
    const OPERATIONS: u32 = 56;

    /// A coordinate is two sums, wrong by at most `2u / (1 − 2u)` times the sum of the point's own; `8u` of that covers the plane's rounding.
    fn of_points(points: &[[f64; 3]]) -> Option<Dop14> {
        let (mut low, mut high, mut most) = ([f64::INFINITY; 7], [f64::NEG_INFINITY; 7], 0.0f64);
        for p in points {
            for (k, direction) in DIRECTIONS.iter().enumerate() {
                let at = dot(*direction, *p);
                (low[k], high[k]) = (low[k].min(at), high[k].max(at));
            }
            most = most.max(p[0].abs() + p[1].abs() + p[2].abs());
        }
        // Along the axes nothing is rounded.
        let margin = |k: usize| if k < 3 { 0.0 } else { 8.0 * UNIT * most };
        let bounds = Dop14 {
            low: std::array::from_fn(|k| low[k] - margin(k)),
            high: std::array::from_fn(|k| high[k] + margin(k)),
        };
        (!points.is_empty()).then_some(bounds)
    }

    fn merged(&self, other: &Dop14) -> Dop14 {
        Dop14 {
            low: std::array::from_fn(|k| self.low[k].min(other.low[k])),
            high: std::array::from_fn(|k| self.high[k].max(other.high[k])),
        }
    }

    fn area(&self) -> f64 {
        let mut planes = [([0.0; 3], 0.0); 14];
        for (k, direction) in DIRECTIONS.iter().enumerate() {
            planes[2 * k] = (*direction, self.high[k]);
            planes[2 * k + 1] = (direction.map(|c| -c), -self.low[k]);
        }
        polytope::area(&planes)
    }
}
