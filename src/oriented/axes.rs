//! Boxes along the axes as one kind of bounds among others.

use super::volume::BoundingVolume;
use crate::geom::Aabb;

impl BoundingVolume for Aabb {
    /// Three slabs: for both planes a subtraction and a product, and four comparisons for the ray's two ends.
    const OPERATIONS: u32 = 24;

    fn of_points(points: &[[f64; 3]]) -> Option<Aabb> {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in points {
            low = [0, 1, 2].map(|a| low[a].min(p[a]));
            high = [0, 1, 2].map(|a| high[a].max(p[a]));
        }
        let outward = |v: f64, up: bool| {
            let near = v as f32;
            match f64::from(near).total_cmp(&v) {
                std::cmp::Ordering::Less if up => near.next_up(),
                std::cmp::Ordering::Greater if !up => near.next_down(),
                _ => near,
            }
        };
        let bounds = Aabb { min: low.map(|v| outward(v, false)), max: high.map(|v| outward(v, true)) };
        (!points.is_empty()).then_some(bounds)
    }

    fn merged(&self, other: &Aabb) -> Aabb {
        self.union(*other)
    }

    fn area(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|a| f64::from(self.max[a]) - f64::from(self.min[a]));
        2.0 * (x * y + y * z + z * x)
    }
}
