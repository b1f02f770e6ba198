use super::blame::Blame;
use super::class::{Class, Counts};
use super::device::Query;
use crate::geom::Ray;
use crate::trace::brute::Source;
use crate::trace::compare::Verdict;
use crate::trace::rays::RaySet;
use crate::trace::{Hit, Malformed};
use serde::Serialize;

/// What verifying a file came to.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Outcome {
    /// The reference first.
    pub devices: Vec<DeviceOutcome>,
    /// What brute force said, which everything else rests on.
    pub oracle: OracleOutcome,
}

impl Outcome {
    /// Whether no device gave a wrong answer.
    pub fn is_right(&self) -> bool {
        self.devices.iter().all(|d| d.total().mismatches() == 0)
    }

    /// Of the first device that has one.
    pub fn first_mismatch(&self) -> Option<&Mismatch> {
        self.devices.iter().find_map(|d| d.first_mismatch.as_ref())
    }
}

/// One device's answers.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct DeviceOutcome {
    /// See [`Device::name`](super::Device::name).
    pub name: String,
    /// See [`Device::description`](super::Device::description).
    pub description: String,
    /// See [`Device::deviation`](super::Device::deviation).
    pub deviation: Option<String>,
    /// Parallel to the plan's sets.
    pub sets: Vec<(RaySet, Counts)>,
    /// In the order of the sets and their rays.
    pub first_mismatch: Option<Mismatch>,
}

impl DeviceOutcome {
    /// Over all sets.
    pub fn total(&self) -> Counts {
        self.sets.iter().fold(Counts::default(), |sum, (_, counts)| sum.plus(counts))
    }
}

/// What the oracle said about the reference's answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct OracleOutcome {
    /// Triangles after instancing, each of which every ray is judged by.
    pub instanced_triangles: u64,
    /// The sample: rays that were judged against every triangle.
    pub rays: u64,
    /// See [`Verdict::Agree`].
    pub agree: u64,
    /// See [`Verdict::Tie`].
    pub ties: u64,
    /// See [`Verdict::Grazing`].
    pub grazing: u64,
    /// See [`Verdict::Unsure`].
    pub unsure: u64,
    /// See [`Verdict::Missed`].
    pub missed: u64,
    /// See [`Verdict::Farther`].
    pub farther: u64,
    /// See [`Verdict::False`].
    pub false_hits: u64,
    /// Hits, of the sample and of all other rays, that were tested against the one triangle of the scene that they name.
    pub hits_tested: u64,
    /// Spent on judging, by the clock.
    pub seconds: f64,
}

impl OracleOutcome {
    /// Count a ray of the sample.
    pub fn add(&mut self, verdict: Verdict) {
        self.rays += 1;
        *match verdict {
            Verdict::Agree => &mut self.agree,
            Verdict::Tie => &mut self.ties,
            Verdict::Grazing => &mut self.grazing,
            Verdict::Unsure => &mut self.unsure,
            Verdict::Missed => &mut self.missed,
            Verdict::Farther => &mut self.farther,
            Verdict::False => &mut self.false_hits,
        } += 1;
    }
}

/// A wrong answer, with all that is needed to see it again.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Mismatch {
    /// See [`Device::name`](super::Device::name).
    pub device: String,
    /// The set that the ray is of.
    pub set: RaySet,
    /// Number of the ray in its set.
    pub index: u64,
    /// What was traced, bit for bit.
    pub ray: Ray,
    /// What was asked about it.
    pub query: Query,
    /// How the answer is wrong.
    pub class: Class,
    /// What is right.
    pub expected: Expected,
    /// What the device said.
    pub got: Got,
    /// The record that makes the ray go wrong, where one was found.
    pub blame: Option<Blame>,
}

/// What is right.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Expected {
    /// By the oracle: this triangle of the source, at a distance between these.
    Hit {
        /// The triangle in the scene.
        source: Source,
        /// Its number in the source mesh.
        prim: u32,
        /// The smallest `t` that is right.
        nearest: f64,
        /// The largest.
        farthest: f64,
    },
    /// By the oracle.
    Nothing,
    /// By the reference.
    Reference(Option<Hit>),
}

/// What the device said.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Got {
    /// An answer to [`Query::Closest`].
    Hit(Hit),
    /// An answer to [`Query::Closest`].
    Nothing,
    /// An answer to [`Query::Any`].
    Any(bool),
    /// The walk gave up.
    Malformed(Malformed),
}
