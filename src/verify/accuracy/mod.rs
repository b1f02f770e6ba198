//! How right and how fast: the same rays by every [`Arithmetic`], judged by the oracle and timed on one thread.
//!
//! `judge` counts errors, `pace` measures time and work, `summary` adds files up. Rays are *fair* (what a renderer traces: camera, chords,
//! bounces, occlusion) or *hard* (aimed at vertices and edges, within faces, from surfaces, from far away): an error among the first is
//! seen in pictures, the second say what arithmetic can be trusted with. Time and visits are of the fair ones.

mod judge;
mod pace;
mod summary;

use crate::build::Progress;
use crate::cache::View;
use crate::exec::Executor;
use crate::geom::Ray;
use crate::trace::Malformed;
use crate::trace::arithmetic::Arithmetic;
use crate::trace::brute::Oracle;
use crate::trace::rays::{RaySet, Sampler};
use serde::Serialize;

pub use judge::{Distance, Errors};

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// Rays that the oracle judges, over all sets, unless its work ends sooner.
    pub rays: u64,
    /// Of the rays; equal seeds give equal rays on every machine.
    pub seed: u64,
    /// What the oracle may spend, in rays × triangles.
    pub oracle_work: u64,
    /// Fair rays that are timed.
    pub timed: u64,
    /// How often each arithmetic traces them; the median counts.
    pub rounds: u32,
}

impl Default for Measure {
    fn default() -> Measure {
        Measure { rays: 100_000, seed: 1, oracle_work: 20_000_000_000, timed: 1 << 15, rounds: 5 }
    }
}

impl Measure {
    /// How far progress goes in a scene of so many triangles, instances counted.
    pub fn steps(&self, triangles: u64) -> u64 {
        self.judged(triangles) + u64::from(self.rounds) * Arithmetic::all().count() as u64
    }

    /// As many rays as the oracle has time for.
    fn judged(&self, triangles: u64) -> u64 {
        self.rays.min((self.oracle_work / triangles.max(1)).max(LEAST * RaySet::ALL.len() as u64))
    }
}

/// Fewest rays of a set that are judged, however large the scene.
const LEAST: u64 = 64;

/// What came out for one file, or for several together.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Report {
    /// Of the scene, instances counted.
    pub instanced_triangles: u64,
    /// Rays that the oracle judged.
    pub fair_rays: u64,
    /// Of the hard sets likewise.
    pub hard_rays: u64,
    /// Fair rays that were timed.
    pub timed_rays: u64,
    /// How often each arithmetic traced them.
    pub rounds: u32,
    /// In the order of [`Arithmetic::all`].
    pub rows: Vec<Row>,
}

/// One arithmetic.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Row {
    /// Which one.
    #[serde(flatten)]
    pub arithmetic: Arithmetic,
    /// Wrong answers among the fair rays.
    pub fair: Errors,
    /// Wrong answers among the hard rays.
    pub hard: Errors,
    /// Of the right hits of fair rays.
    pub distance: Distance,
    /// Of the right hits of hard rays. Many of those start on a triangle, where a unit of the true distance is next to nothing.
    pub hard_distance: Distance,
    /// Median over rounds, one thread, millions.
    pub mrays_per_second: f64,
    /// Of the timed rays; an inner node is two box tests.
    pub inner_nodes_per_ray: f64,
    /// Triangle tests of the timed rays.
    pub triangles_per_ray: f64,
}

impl Report {
    /// Rays that the oracle judged.
    pub fn judged(&self) -> u64 {
        self.fair_rays + self.hard_rays
    }

    /// What [`closest_hit`](crate::trace::closest_hit) itself came to.
    pub fn ours(&self) -> &Row {
        let ours = self.rows.iter().find(|r| r.arithmetic == Arithmetic::OURS);
        ours.unwrap_or(&self.rows[self.rows.len() - 1])
    }
}

/// Why there is no report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AccuracyError {
    /// The tree cannot be walked.
    #[error(transparent)]
    Malformed(#[from] Malformed),
    /// [`Progress::is_cancelled`] said so.
    #[error("Interrupted.")]
    Cancelled,
}

/// Whether a renderer traces such rays, rather than a tester.
fn is_fair(set: RaySet) -> bool {
    matches!(set, RaySet::Camera | RaySet::Uniform | RaySet::Bounce | RaySet::Shadow)
}

/// Rays of one kind.
#[derive(Default)]
struct Rays {
    fair: Vec<Ray>,
    hard: Vec<Ray>,
}

/// `count` rays of all sets.
fn rays(sampler: &Sampler<'_>, count: u64, seed: u64) -> Rays {
    let mut rays = Rays::default();
    for (set, share) in RaySet::ALL.into_iter().zip(RaySet::shares(&RaySet::ALL, count)) {
        let to = if is_fair(set) { &mut rays.fair } else { &mut rays.hard };
        to.extend(sampler.rays(set, share as usize, seed));
    }
    rays
}

/// Measure one file. `oracle` and `sampler` are of its source scene, in which no instance is without triangles.
///
/// `progress` advances by one for each judged ray and by one for each pass over the timed rays.
///
/// # Errors
/// Where the tree is malformed, or `progress` says so.
pub fn measure(
    view: &View<'_>,
    oracle: &Oracle<'_>,
    sampler: &Sampler<'_>,
    measure: &Measure,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Report, AccuracyError> {
    let instanced_triangles = oracle.scene().instanced_triangles();
    let judged = rays(sampler, measure.judged(instanced_triangles), measure.seed);
    let mut tallies = judge::Tallies::new(view, oracle);
    for (fair, rays) in [(true, &judged.fair), (false, &judged.hard)] {
        for some in rays.chunks(CHUNK) {
            if progress.is_cancelled() {
                return Err(AccuracyError::Cancelled);
            }
            tallies.add(fair, some, &oracle.trace_all(some, exec), exec)?;
            progress.advance(some.len() as u64);
        }
    }
    let timed = timed_rays(sampler, measure);
    let paces = pace::paces(view, &timed, measure.rounds, progress)?;
    let rows = Arithmetic::all().zip(tallies.finish()).zip(paces);
    let rows = rows.map(|((arithmetic, tally), pace)| Row {
        arithmetic,
        fair: tally.fair,
        hard: tally.hard,
        distance: tally.distance,
        hard_distance: tally.hard_distance,
        mrays_per_second: pace.mrays_per_second,
        inner_nodes_per_ray: pace.inner_nodes_per_ray,
        triangles_per_ray: pace.triangles_per_ray,
    });
    Ok(Report {
        instanced_triangles,
        fair_rays: judged.fair.len() as u64,
        hard_rays: judged.hard.len() as u64,
        timed_rays: timed.len() as u64,
        rounds: measure.rounds,
        rows: rows.collect(),
    })
}

/// Rays that are judged between two looks at whether to go on.
const CHUNK: usize = 1 << 10;

/// Fair rays only, of another seed than the judged ones.
fn timed_rays(sampler: &Sampler<'_>, measure: &Measure) -> Vec<Ray> {
    let sets = RaySet::ALL.into_iter().filter(|s| is_fair(*s));
    let share = measure.timed.div_ceil(sets.clone().count() as u64) as usize;
    sets.flat_map(|set| sampler.rays(set, share, !measure.seed)).collect()
}
