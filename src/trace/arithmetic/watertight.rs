//! Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", 2013: corners relative to the origin, sheared so that the ray becomes
//! an axis, and three edge functions, in `f32`; where one of them is zero, all three again in `f64` from the same sheared corners.
//!
//! Both sides of a triangle are met, so the paper's exchange of axes that keeps the winding is left out.

use super::{Crossing, TriangleTest, dominant, others, to_object_single};
use crate::cache::{InstanceRecord, TriangleRecord};

pub(in crate::trace) struct Watertight {
    axis: usize,
    origin: [f32; 3],
    /// `d_x / d_z`, `d_y / d_z` and `1 / d_z`.
    shear: [f32; 3],
}

impl TriangleTest for Watertight {
    fn to_object(instance: &InstanceRecord, origin: [f64; 3], direction: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        to_object_single(instance, origin, direction)
    }

    fn new(origin: [f64; 3], direction: [f64; 3]) -> Self {
        let axis = dominant(direction);
        let (kx, ky) = others(axis);
        let d = direction.map(|v| v as f32);
        Watertight { axis, origin: origin.map(|v| v as f32), shear: [d[kx] / d[axis], d[ky] / d[axis], 1.0 / d[axis]] }
    }

    fn axis(&self) -> usize {
        self.axis
    }

    #[inline(always)]
    fn crossing<const AXIS: usize>(&self, triangle: &TriangleRecord) -> Option<Crossing> {
        let (kx, ky) = others(AXIS);
        let [sx, sy, sz] = self.shear;
        let [a, b, c] = [triangle.v0, triangle.v1, triangle.v2].map(|p| {
            let [x, y, z] = [kx, ky, AXIS].map(|k| p[k] - self.origin[k]);
            [x - sx * z, y - sy * z, z]
        });
        let edge = |p: [f32; 3], q: [f32; 3]| p[0] * q[1] - p[1] * q[0];
        let (mut u, mut v, mut w) = (edge(c, b), edge(a, c), edge(b, a));
        if u == 0.0 || v == 0.0 || w == 0.0 {
            let wide = |p: [f32; 3], q: [f32; 3]| {
                (f64::from(p[0]) * f64::from(q[1]) - f64::from(p[1]) * f64::from(q[0])) as f32
            };
            (u, v, w) = (wide(c, b), wide(a, c), wide(b, a));
        }
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None;
        }
        let depth = u * (sz * a[2]) + v * (sz * b[2]) + w * (sz * c[2]);
        let inverse = 1.0 / sum;
        Some(Crossing { t: f64::from(depth * inverse), u: f64::from(v * inverse), v: f64::from(w * inverse), sum: 1.0 })
    }
}
