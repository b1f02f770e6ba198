//! Other ways to calculate, to be measured against ours: triangle tests and box tests that traversal can be made of.
//!
//! The walk, its order and its stack are the same for all, so what differs in hits, visits and time is due to the arithmetic.
//! [`closest_hit`](super::closest_hit) is the combination [`Arithmetic::OURS`]; nobody who wants hits needs another one.

mod moller_trumbore;
mod watertight;

use bvhc_core::trace::arithmetic::{
    Conservative, Crossing, EdgeRay, Plain, TriangleTest, TwoUlps, dominant, others, trace,
};

use super::{Counters, Hit, Malformed, NoObserver, Observer};
use crate::cache::{InstanceRecord, View};
use crate::geom::Ray;
use moller_trumbore::{AnyDeterminant, MollerTrumbore, Published};
use watertight::Watertight;

/// How a triangle is tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum TriangleArithmetic {
    /// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997, in `f32`, with the absolute bound of 10⁻⁶ on
    /// the determinant that the paper's listing has.
    MollerTrumboreEpsilon,
    /// The same formulas, rejecting a determinant only where it is zero.
    MollerTrumbore,
    /// Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", 2013: `f32`, and `f64` where an edge function is zero.
    Watertight,
    /// Ours: every edge decided in `f64` unless `f32` proves a miss.
    Double,
}

/// How a box is tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum BoxArithmetic {
    /// Slabs as `f32` computes them.
    Plain,
    /// The exit distance two units in the last place farther (Ize, "Robust BVH Ray Traversal", 2013).
    TwoUlps,
    /// Ours: widened by all that rounding can do.
    Conservative,
}

/// A triangle test and a box test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
pub struct Arithmetic {
    /// How a triangle is decided.
    pub triangles: TriangleArithmetic,
    /// How a box is decided.
    pub boxes: BoxArithmetic,
}

impl TriangleArithmetic {
    /// The cheapest first.
    pub const ALL: [TriangleArithmetic; 4] = [
        TriangleArithmetic::MollerTrumboreEpsilon,
        TriangleArithmetic::MollerTrumbore,
        TriangleArithmetic::Watertight,
        TriangleArithmetic::Double,
    ];

    /// As tables and charts have it.
    pub fn name(self) -> &'static str {
        match self {
            TriangleArithmetic::MollerTrumboreEpsilon => "Möller–Trumbore f32, ε = 1e-6",
            TriangleArithmetic::MollerTrumbore => "Möller–Trumbore f32",
            TriangleArithmetic::Watertight => "watertight f32",
            TriangleArithmetic::Double => "f64 (bvhc)",
        }
    }
}

impl BoxArithmetic {
    /// The cheapest first.
    pub const ALL: [BoxArithmetic; 3] = [BoxArithmetic::Plain, BoxArithmetic::TwoUlps, BoxArithmetic::Conservative];

    /// As tables and charts have it.
    pub fn name(self) -> &'static str {
        match self {
            BoxArithmetic::Plain => "plain",
            BoxArithmetic::TwoUlps => "2 ulps",
            BoxArithmetic::Conservative => "conservative",
        }
    }
}

impl Arithmetic {
    /// What [`closest_hit`](super::closest_hit) calculates with.
    pub const OURS: Arithmetic =
        Arithmetic { triangles: TriangleArithmetic::Double, boxes: BoxArithmetic::Conservative };

    /// Every combination, the cheapest first.
    pub fn all() -> impl Iterator<Item = Arithmetic> {
        let row = |triangles| BoxArithmetic::ALL.into_iter().map(move |boxes| Arithmetic { triangles, boxes });
        TriangleArithmetic::ALL.into_iter().flat_map(row)
    }
}

/// [`try_closest_hit`](super::try_closest_hit) by another arithmetic.
pub fn closest_hit_by(arithmetic: Arithmetic, view: &View<'_>, ray: &Ray) -> Result<Option<Hit>, Malformed> {
    by_triangles(arithmetic, view, ray, &mut NoObserver)
}

/// What [`closest_hit_by`] visits.
pub(crate) fn visits_by(arithmetic: Arithmetic, view: &View<'_>, ray: &Ray) -> Result<Counters, Malformed> {
    let mut counters = Counters::default();
    by_triangles(arithmetic, view, ray, &mut counters)?;
    Ok(counters)
}

fn by_triangles<O: Observer>(
    arithmetic: Arithmetic,
    view: &View<'_>,
    ray: &Ray,
    observer: &mut O,
) -> Result<Option<Hit>, Malformed> {
    let boxes = arithmetic.boxes;
    match arithmetic.triangles {
        TriangleArithmetic::MollerTrumboreEpsilon => {
            by_boxes::<MollerTrumbore<Published>, O>(boxes, view, ray, observer)
        }
        TriangleArithmetic::MollerTrumbore => by_boxes::<MollerTrumbore<AnyDeterminant>, O>(boxes, view, ray, observer),
        TriangleArithmetic::Watertight => by_boxes::<Watertight, O>(boxes, view, ray, observer),
        TriangleArithmetic::Double => by_boxes::<EdgeRay, O>(boxes, view, ray, observer),
    }
}

fn by_boxes<T: TriangleTest, O: Observer>(
    boxes: BoxArithmetic,
    view: &View<'_>,
    ray: &Ray,
    observer: &mut O,
) -> Result<Option<Hit>, Malformed> {
    match boxes {
        BoxArithmetic::Plain => trace::<false, T, Plain, O>(view, ray, observer),
        BoxArithmetic::TwoUlps => trace::<false, T, TwoUlps, O>(view, ray, observer),
        BoxArithmetic::Conservative => trace::<false, T, Conservative, O>(view, ray, observer),
    }
}

/// Whether the ray crosses a hit's triangle, as the file has it, between `t_min` and `t_max`, whatever lies before it: tells a hit that is
/// not the nearest from one on nothing. `instance` is the record of the hit's instance. By our arithmetic.
pub(crate) fn is_real(view: &View<'_>, ray: &Ray, hit: &Hit, instance: Option<&InstanceRecord>) -> bool {
    let Some(triangle) = view.triangles.get(hit.triangle) else { return false };
    let (mut origin, mut direction) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
    if let Some(record) = instance {
        (origin, direction) = EdgeRay::to_object(record, origin, direction);
    }
    let test = <EdgeRay as TriangleTest>::new(origin, direction);
    let crossing = match test.axis() {
        0 => test.crossing::<0>(triangle),
        1 => test.crossing::<1>(triangle),
        _ => test.crossing::<2>(triangle),
    };
    crossing.is_some_and(|c| c.t >= f64::from(ray.t_min) && c.t <= f64::from(ray.t_max))
}

/// A mapped ray as renderers in `f32` have it: matrix, products and sums in single precision.
fn to_object_single(instance: &InstanceRecord, origin: [f64; 3], direction: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let m = &instance.world_to_object;
    let (o, d) = (origin.map(|v| v as f32), direction.map(|v| v as f32));
    let linear = |v: [f32; 3], r: usize| m[4 * r] * v[0] + m[4 * r + 1] * v[1] + m[4 * r + 2] * v[2];
    let point = [0, 1, 2].map(|r| f64::from(linear(o, r) + m[4 * r + 3]));
    (point, [0, 1, 2].map(|r| f64::from(linear(d, r))))
}
