//! Which points are farthest in a few fixed directions.

use crate::geom::vector::dot;

/// The axes and the diagonals of the cube: normals of a slab each. Not of length 1.
pub const DIRECTIONS: [[f64; 3]; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0],
];

/// For each of [`DIRECTIONS`] the points with the least and the greatest coordinate along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// The least.
    pub low: [[f64; 3]; 7],
    /// The greatest.
    pub high: [[f64; 3]; 7],
}

impl Extremes {
    /// Of points; nothing of none. Of equal ones the first is taken.
    pub fn of_points(points: &[[f64; 3]]) -> Option<Extremes> {
        let first = *points.first()?;
        let mut found = Extremes { low: [first; 7], high: [first; 7] };
        let at = DIRECTIONS.map(|direction| dot(direction, first));
        let (mut low, mut high) = (at, at);
        for p in &points[1..] {
            for (k, direction) in DIRECTIONS.iter().enumerate() {
                let at = dot(*direction, *p);
                if at < low[k] {
                    (low[k], found.low[k]) = (at, *p);
                }
                if at > high[k] {
                    (high[k], found.high[k]) = (at, *p);
                }
            }
        }
        Some(found)
    }

    /// All fourteen.
    pub fn points(&self) -> [[f64; 3]; 14] {
        std::array::from_fn(|i| if i % 2 == 0 { self.low[i / 2] } else { self.high[i / 2] })
    }
}
