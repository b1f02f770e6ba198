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
pub struct Outcome {
    /// The reference first.
    pub devices: Vec<DeviceOutcome>,
    pub oracle: OracleOutcome,
}

impl Outcome {
    pub fn is_right(&self) -> bool {
        self.devices.iter().all(|d| d.total().mismatches() == 0)
    }

    pub fn first_mismatch(&self) -> Option<&Mismatch> {
        self.devices.iter().find_map(|d| d.first_mismatch.as_ref())
    }
}

/// One device's answers.
#[derive(Clone, Debug)]
pub struct DeviceOutcome {
    pub name: String,
    pub description: String,
    /// See [`Device::deviation`](super::Device::deviation).
    pub deviation: Option<String>,
    /// Parallel to the plan's sets.
    pub sets: Vec<(RaySet, Counts)>,
    pub first_mismatch: Option<Mismatch>,
}

impl DeviceOutcome {
    pub fn total(&self) -> Counts {
        self.sets.iter().fold(Counts::default(), |sum, (_, counts)| sum.plus(counts))
    }
}

/// What the oracle said about the reference's answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct OracleOutcome {
    /// Triangles after instancing, each of which every ray is judged by.
    pub triangles: u64,
    pub rays: u64,
    pub agree: u64,
    pub ties: u64,
    pub grazing: u64,
    pub unsure: u64,
    pub missed: u64,
    pub farther: u64,
    pub false_hits: u64,
    /// Hits, of the sample and of all other rays, that were tested against the one triangle of the scene that they name.
    pub hits_tested: u64,
    pub seconds: f64,
}

impl OracleOutcome {
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
pub struct Mismatch {
    pub device: String,
    pub set: RaySet,
    /// Number of the ray in its set.
    pub index: u64,
    pub ray: Ray,
    pub query: Query,
    pub class: Class,
    pub expected: Expected,
    pub got: Got,
    pub blame: Option<Blame>,
}

/// What is right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// By the oracle: this triangle of the source, at a distance between these.
    Hit { source: Source, prim: u32, nearest: f64, farthest: f64 },
    /// By the oracle.
    Nothing,
    /// By the reference.
    Reference(Option<Hit>),
}

/// What the device said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Got {
    Hit(Hit),
    Nothing,
    /// An answer to [`Query::Any`].
    Any(bool),
    Malformed(Malformed),
}
