//! Planes that halve the scene's box, halve the halves, and so on: the planes between the cells of a Morton grid.

use crate::geom::Aabb;

/// Halvings on each axis.
const BITS: u32 = 21;

/// A grid of cubic cells, 2²¹ along the longest side of the scene's box.
pub(super) struct Planes {
    low: [f64; 3],
    per_unit: f64,
}

/// The coarsest plane through a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    pub axis: usize,
    pub position: f32,
    /// Side of the blocks that planes as coarse as this bound, as a share of the scene's: 1/2 for the plane in the
    /// middle, a half less with every level.
    pub importance: f32,
}

impl Planes {
    /// `None` over a box without extent.
    pub fn over(bounds: &Aabb) -> Option<Planes> {
        let extent = (0..3).map(|a| f64::from(bounds.max[a]) - f64::from(bounds.min[a])).fold(0.0, f64::max);
        let per_unit = f64::from(1u32 << BITS) / extent;
        (extent > 0.0 && per_unit.is_finite()).then(|| Planes { low: bounds.min.map(f64::from), per_unit })
    }

    /// The coarsest plane strictly inside the box; of two as coarse, the one across the longer side.
    pub fn coarsest(&self, b: &Aabb) -> Option<Plane> {
        let mut best: Option<(u32, f32, Plane)> = None;
        for axis in 0..3 {
            let cell = |v: f32| (((f64::from(v) - self.low[axis]) * self.per_unit) as u32).min((1 << BITS) - 1);
            let (low, high) = (cell(b.min[axis]), cell(b.max[axis]));
            let Some(bit) = (low ^ high).checked_ilog2() else { continue };
            let position = (f64::from(high >> bit << bit) / self.per_unit + self.low[axis]) as f32;
            // Rounding may put the plane onto a face.
            if !(b.min[axis] < position && position < b.max[axis]) {
                continue;
            }
            let extent = b.max[axis] - b.min[axis];
            if best.is_none_or(|(b, e, _)| (bit, extent) > (b, e)) {
                let importance = (1u32 << bit) as f32 / (1u32 << BITS) as f32;
                best = Some((bit, extent, Plane { axis, position, importance }));
            }
        }
        best.map(|(_, _, plane)| plane)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coarsest_plane_is_found() {
        let planes = Planes::over(&Aabb { min: [0.0; 3], max: [8.0, 4.0, 1.0] }).unwrap();
        let find = |min: [f32; 3], max: [f32; 3]| planes.coarsest(&Aabb { min, max });
        assert_eq!(find([3.0, 0.1, 0.1], [5.0, 0.2, 0.2]), Some(Plane { axis: 0, position: 4.0, importance: 0.5 }));
        assert_eq!(find([0.5, 1.5, 0.1], [0.7, 2.5, 0.2]), Some(Plane { axis: 1, position: 2.0, importance: 0.25 }));
        let longer = find([1.5, 1.0, 0.1], [2.5, 3.0, 0.2]).unwrap();
        assert_eq!((longer.axis, longer.position), (1, 2.0));
        assert_eq!(find([1.0; 3], [1.0; 3]), None);
        assert!(Planes::over(&Aabb { min: [1.0; 3], max: [1.0; 3] }).is_none());
    }

    #[test]
    fn planes_are_strictly_inside_at_any_scale() {
        for scale in [1e-44f32, 1e-30, 1.0, 1e30, 3e38] {
            let planes = Planes::over(&Aabb { min: [-scale; 3], max: [scale; 3] });
            for i in 0..200u32 {
                let a = (i as f32 / 100.0 - 1.0) * scale;
                let b = Aabb { min: [a, a * 0.5, 0.0], max: [a + scale * 0.01, a * 0.5 + scale * 1e-7, 0.0] };
                if let Some(p) = planes.as_ref().and_then(|planes| planes.coarsest(&b)) {
                    assert!(b.min[p.axis] < p.position && p.position < b.max[p.axis]);
                }
            }
        }
    }
}
