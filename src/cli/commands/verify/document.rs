//! The verdicts as JSON.

use super::file::Verified;
use crate::cli::exit::Exit;
use crate::cli::failure::Entry;
use crate::trace::Hit;
use crate::verify::{
    Asked, Blame, Class, Counts, DeviceOutcome, Expected, Got, Mismatch, OracleOutcome, Placed, Plan, Query, Reference,
    set_name, write_ray,
};
use serde::Serialize;

#[derive(Serialize)]
pub struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    rays: u64,
    seed: u64,
    sets: Vec<&'static str>,
    asked: &'static str,
    reference: &'static str,
    files: &'a [Entry<FileDocument>],
}

impl<'a> Document<'a> {
    pub fn new(exit: Exit, plan: &Plan, files: &'a [Entry<FileDocument>]) -> Document<'a> {
        Document {
            schema: "bvhc.verify.v1",
            exit_code: exit.code(),
            rays: plan.rays,
            seed: plan.seed,
            sets: plan.sets.iter().map(|s| set_name(*s)).collect(),
            asked: match plan.asked {
                Asked::Both => "closest-and-any-hit",
                Asked::AnyHit => "any-hit",
            },
            reference: match plan.reference {
                Reference::Bvh => "bvh",
                Reference::Brute => "brute",
            },
            files,
        }
    }
}

#[derive(Serialize)]
pub struct FileDocument {
    path: String,
    /// The number of a sequence's frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<i32>,
    /// `null`: the file's own triangles.
    source: Option<String>,
    right: bool,
    /// How the file's triangles stand to the model's; `null` without a model.
    placing: Option<Placed>,
    devices: Vec<DeviceDocument>,
    oracle: OracleOutcome,
    /// Nodes that wait at most on the stack of a traversal.
    stack: u32,
}

#[derive(Serialize)]
struct DeviceDocument {
    name: String,
    description: String,
    /// Why its last bits may differ; `null` where they must not.
    deviation: Option<String>,
    mismatches: u64,
    total: Counts,
    sets: Vec<SetDocument>,
    first_mismatch: Option<MismatchDocument>,
}

#[derive(Serialize)]
struct SetDocument {
    set: &'static str,
    mismatches: u64,
    #[serde(flatten)]
    counts: Counts,
}

#[derive(Serialize)]
struct MismatchDocument {
    class: Class,
    query: &'static str,
    set: &'static str,
    index: u64,
    /// As `--ray` takes it.
    ray: String,
    expected: Answer,
    got: Answer,
    blame: Option<Blame>,
}

/// A hit, nothing, or whatever else is known.
#[derive(Serialize)]
#[serde(tag = "answer", rename_all = "kebab-case")]
pub enum Answer {
    Hit(HitDocument),
    /// By the oracle, which knows distances as an interval.
    Triangle {
        prim: u32,
        instance: u32,
        nearest: f64,
        farthest: f64,
    },
    Nothing,
    Any {
        hit: bool,
    },
    Malformed {
        reason: String,
    },
}

#[derive(Serialize)]
pub struct HitDocument {
    t: f32,
    u: f32,
    v: f32,
    prim: u32,
    geom: u32,
    instance: Option<u32>,
    /// Record of `TRIS`.
    triangle: usize,
}

impl From<&Hit> for HitDocument {
    fn from(h: &Hit) -> HitDocument {
        HitDocument { t: h.t, u: h.u, v: h.v, prim: h.prim, geom: h.geom, instance: h.instance, triangle: h.triangle }
    }
}

impl Answer {
    pub fn of_hit(hit: Option<&Hit>) -> Answer {
        hit.map_or(Answer::Nothing, |h| Answer::Hit(h.into()))
    }
}

impl From<&Expected> for Answer {
    fn from(expected: &Expected) -> Answer {
        match expected {
            Expected::Hit { source, prim, nearest, farthest } => {
                Answer::Triangle { prim: *prim, instance: source.instance, nearest: *nearest, farthest: *farthest }
            }
            Expected::Nothing => Answer::Nothing,
            Expected::Reference(hit) => Answer::of_hit(hit.as_ref()),
        }
    }
}

impl From<&Got> for Answer {
    fn from(got: &Got) -> Answer {
        match got {
            Got::Hit(hit) => Answer::Hit(hit.into()),
            Got::Nothing => Answer::Nothing,
            Got::Any(hit) => Answer::Any { hit: *hit },
            Got::Malformed(reason) => Answer::Malformed { reason: reason.to_string() },
        }
    }
}

impl FileDocument {
    pub fn new(verified: &Verified) -> FileDocument {
        FileDocument {
            path: verified.path.to_string_lossy().into_owned(),
            frame: verified.frame,
            source: verified.source.as_ref().map(|p| p.to_string_lossy().into_owned()),
            right: verified.is_right(),
            placing: verified.placed.clone(),
            devices: verified.outcome.devices.iter().map(device).collect(),
            oracle: verified.outcome.oracle,
            stack: verified.stack,
        }
    }
}

fn device(device: &DeviceOutcome) -> DeviceDocument {
    let total = device.total();
    let sets = device.sets.iter().map(|(set, counts)| SetDocument {
        set: set_name(*set),
        mismatches: counts.mismatches(),
        counts: *counts,
    });
    DeviceDocument {
        name: device.name.clone(),
        description: device.description.clone(),
        deviation: device.deviation.clone(),
        mismatches: total.mismatches(),
        total,
        sets: sets.collect(),
        first_mismatch: device.first_mismatch.as_ref().map(mismatch),
    }
}

fn mismatch(m: &Mismatch) -> MismatchDocument {
    MismatchDocument {
        class: m.class,
        query: match m.query {
            Query::Closest => "closest",
            Query::Any => "any",
        },
        set: set_name(m.set),
        index: m.index,
        ray: write_ray(&m.ray),
        expected: (&m.expected).into(),
        got: (&m.got).into(),
        blame: m.blame.clone(),
    }
}
