//! What a triangle test must be able to do, so that the same walk can calculate in several ways.

use crate::layout::{InstanceRecord, TriangleRecord};

/// A ray made ready for tests of triangles.
pub trait TriangleTest: Sized {
    /// The ray in an instance's own space.
    fn to_object(instance: &InstanceRecord, origin: [f64; 3], direction: [f64; 3]) -> ([f64; 3], [f64; 3]);

    /// The direction is finite and not zero.
    fn new(origin: [f64; 3], direction: [f64; 3]) -> Self;

    /// What `crossing` wants as its constant.
    fn axis(&self) -> usize;

    /// Where the ray's line crosses the triangle, at any distance.
    fn crossing<const AXIS: usize>(&self, triangle: &TriangleRecord) -> Option<Crossing>;
}

/// A hit as a test finds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The distance in lengths of the direction; the caller holds it against the ray's range.
    pub t: f64,
    /// Weight of the second corner, times `sum`: only a hit that counts is worth dividing for.
    pub u: f64,
    /// Weight of the third corner, times `sum`.
    pub v: f64,
    /// What the weights are divided by; never 0.
    pub sum: f64,
}

/// The axis of the largest component; among equals the first.
#[inline(always)]
pub fn dominant(direction: [f64; 3]) -> usize {
    let [x, y, z] = [direction[0].abs(), direction[1].abs(), direction[2].abs()];
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// The two axes after this one.
#[inline(always)]
pub const fn others(axis: usize) -> (usize, usize) {
    match axis {
        0 => (1, 2),
        1 => (2, 0),
        _ => (0, 1),
    }
}
