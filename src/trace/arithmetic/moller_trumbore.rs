//! Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997: Cramer's rule for distance and weights, in
//! `f32`, without culling.

use super::{Crossing, TriangleTest, to_object_single};
use crate::cache::{InstanceRecord, TriangleRecord};
use std::marker::PhantomData;

/// Which determinants count as zero, that is, which triangles as seen edge-on.
pub(in crate::trace) trait Bound {
    const EPSILON: f32;
}

/// As the paper's listing has it: an absolute number, whatever the scene's unit.
pub(in crate::trace) struct Published;

/// Only zero itself.
pub(in crate::trace) struct AnyDeterminant;

impl Bound for Published {
    const EPSILON: f32 = 1e-6;
}

impl Bound for AnyDeterminant {
    const EPSILON: f32 = 0.0;
}

pub(in crate::trace) struct MollerTrumbore<B> {
    origin: [f32; 3],
    direction: [f32; 3],
    bound: PhantomData<B>,
}

impl<B: Bound> TriangleTest for MollerTrumbore<B> {
    fn to_object(instance: &InstanceRecord, origin: [f64; 3], direction: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        to_object_single(instance, origin, direction)
    }

    fn new(origin: [f64; 3], direction: [f64; 3]) -> Self {
        MollerTrumbore { origin: origin.map(|v| v as f32), direction: direction.map(|v| v as f32), bound: PhantomData }
    }

    fn axis(&self) -> usize {
        0
    }

    #[inline(always)]
    fn crossing<const AXIS: usize>(&self, triangle: &TriangleRecord) -> Option<Crossing> {
        let (e1, e2) = (sub(triangle.v1, triangle.v0), sub(triangle.v2, triangle.v0));
        let p = cross(self.direction, e2);
        let determinant = dot(e1, p);
        if determinant.abs() < B::EPSILON || determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let from_corner = sub(self.origin, triangle.v0);
        let u = dot(from_corner, p) * inverse;
        if !(0.0..=1.0).contains(&u) {
            return None;
        }
        let q = cross(from_corner, e1);
        let v = dot(self.direction, q) * inverse;
        if v < 0.0 || u + v > 1.0 {
            return None;
        }
        Some(Crossing { t: f64::from(dot(e2, q) * inverse), u: f64::from(u), v: f64::from(v), sum: 1.0 })
    }
}

#[inline(always)]
fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
