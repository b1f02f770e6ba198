//! `--ray`: one ray with its traversal log, and what the oracle and every device say of it.

use super::VerifyArgs;
use super::devices::{self, Bench};
use super::document::Answer;
use super::file::{Held, scene_for};
use super::text;
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::names;
use crate::cli::patterns;
use crate::geom::Ray;
use crate::trace::brute::{self, Standing};
use crate::trace::compare::{Verdict, judge};
use crate::verify::{Query, Replay, Step, Subject, replay, write_ray};
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    /// As `--ray` takes it.
    ray: String,
    files: &'a [Replayed],
}

#[derive(Serialize)]
struct Replayed {
    path: String,
    right: bool,
    steps: Vec<Step>,
    /// Steps that were too many to keep.
    steps_left_out: u64,
    oracle: Vec<Candidate>,
    devices: Vec<DeviceAnswer>,
}

/// A triangle that the ray meets, or may meet.
#[derive(Serialize)]
struct Candidate {
    prim: u32,
    instance: u32,
    nearest: f64,
    farthest: f64,
    /// What exact arithmetic says, and whether `f64` can be off: `hit`, `bare-hit`, `bare-miss`, `unsure`.
    standing: &'static str,
}

#[derive(Serialize)]
struct DeviceAnswer {
    name: String,
    closest: Answer,
    /// `null` where the device has no answer.
    any_hit: Option<bool>,
    verdict: String,
    #[serde(skip)]
    told: String,
    #[serde(skip)]
    right: bool,
}

pub fn run(ray: &Ray, args: &VerifyArgs, bench: &Bench, context: &Context) -> Result<Exit, Failure> {
    let (mut files, mut exits) = (Vec::new(), Vec::new());
    for path in &patterns::expand(&args.files, patterns::CACHES, "verify", &context.terminal)? {
        match one(path, ray, args, bench, context) {
            Ok(replayed) => {
                if !context.terminal.json {
                    context.terminal.print(&told(&replayed, path, ray))?;
                }
                exits.push(if replayed.right { Exit::Success } else { Exit::Negative });
                files.push(replayed);
            }
            Err(failure) => {
                context.terminal.error(&failure);
                exits.push(failure.exit);
            }
        }
    }
    let exit = Exit::combine_verdicts(&exits);
    if context.terminal.json {
        let document =
            Document { schema: "bvhc.verify-ray.v1", exit_code: exit.code(), ray: write_ray(ray), files: &files };
        context.terminal.document(&document)?;
    }
    Ok(exit)
}

fn one(path: &Path, ray: &Ray, args: &VerifyArgs, bench: &Bench, context: &Context) -> Result<Replayed, Failure> {
    let cache = caches::open(path, context)?;
    let Held { scene, .. } = scene_for(&cache, path, args, context)?;
    let view = cache.view();
    let subject = Subject::new(view, &scene, &context.exec);
    let answer = subject.oracle.trace(ray);
    let log = replay(&view, ray);
    let mut devices = vec![of_cpu(&subject, &answer, &log)];
    for mut device in bench.devices(&cache, &context.exec).map_err(|e| devices::failure(&e))? {
        let name = device.name().to_string();
        let closest = device.trace(&[*ray], Query::Closest);
        let any = device.trace(&[*ray], Query::Any);
        devices.push(match (closest, any) {
            (Ok(closest), Ok(any)) => {
                let hit = closest.first().and_then(|r| r.hit());
                let any_hit = any.first().is_some_and(|r| r.is_hit());
                answered(&subject, &answer, name, hit.as_ref(), any_hit)
            }
            (Err(error), _) | (_, Err(error)) => {
                failed(name, error.facts().first().map_or_else(|| error.action(), String::clone))
            }
        });
    }
    let candidates = answer.candidates.iter().map(|c| {
        let mesh = &scene.meshes[scene.instances[c.source.instance as usize].mesh as usize];
        let prim = mesh.source_prim(c.source.triangle as usize);
        Candidate {
            prim,
            instance: c.source.instance,
            nearest: c.nearest,
            farthest: c.farthest,
            standing: standing(c.standing),
        }
    });
    Ok(Replayed {
        path: path.to_string_lossy().into_owned(),
        right: devices.iter().all(|d| d.right),
        steps: log.steps,
        steps_left_out: log.left_out,
        oracle: candidates.collect(),
        devices,
    })
}

fn standing(standing: Standing) -> &'static str {
    match standing {
        Standing::Hit => "hit",
        Standing::BareHit => "bare-hit",
        Standing::BareMiss => "bare-miss",
        Standing::Unsure => "unsure",
    }
}

fn of_cpu(subject: &Subject<'_>, answer: &brute::Answer, log: &Replay) -> DeviceAnswer {
    match (&log.hit, &log.any) {
        (Ok(hit), Ok(any)) => answered(subject, answer, "cpu".into(), hit.as_ref(), *any),
        (Err(reason), _) | (_, Err(reason)) => failed("cpu".into(), reason.to_string()),
    }
}

fn answered(
    subject: &Subject<'_>,
    answer: &brute::Answer,
    name: String,
    hit: Option<&crate::trace::Hit>,
    any: bool,
) -> DeviceAnswer {
    let verdict = judge(&subject.view, &subject.oracle, answer, hit);
    let agrees = any == hit.is_some();
    let mut words = match verdict {
        Verdict::Agree => "right",
        Verdict::Tie => "right: another triangle at the same distance",
        Verdict::Grazing => "right: the ray passes an edge within rounding",
        Verdict::Unsure => "right: rounding the instance's matrix decides",
        Verdict::Missed => "wrong: missed",
        Verdict::Farther => "wrong: a hit behind the nearest one",
        Verdict::False => "wrong: the ray does not meet this triangle there",
    }
    .to_string();
    if !agrees {
        words.push_str(if any { "; any hit says yes" } else { "; any hit says no" });
    }
    DeviceAnswer {
        name,
        closest: Answer::of_hit(hit),
        any_hit: Some(any),
        verdict: words,
        told: text::hit(hit),
        right: verdict.is_right() && agrees,
    }
}

fn failed(name: String, reason: String) -> DeviceAnswer {
    let closest = Answer::Malformed { reason: reason.clone() };
    DeviceAnswer { name, closest, any_hit: None, verdict: "wrong: no answer".into(), told: reason, right: false }
}

fn told(replayed: &Replayed, path: &Path, ray: &Ray) -> String {
    let mut text = format!("{}: ray {}\n", names::path(path), write_ray(ray));
    let mut indent = 0;
    for step in &replayed.steps {
        text.push_str(&line(step, &mut indent));
    }
    if replayed.steps_left_out > 0 {
        text.push_str(&format!("… and {} steps more\n", replayed.steps_left_out));
    }
    for device in &replayed.devices {
        text.push_str(&format!("{:<9} {}: {}\n", device.name, names::escape(&device.told), device.verdict));
    }
    for c in &replayed.oracle {
        let near = match c.standing {
            "hit" => "",
            "bare-hit" => ", within rounding of an edge or of an end",
            "bare-miss" => ", a miss within rounding of an edge or of an end",
            _ => ", perhaps: rounding the instance's matrix decides",
        };
        let at = text::interval(c.nearest, c.farthest);
        text.push_str(&format!("oracle    triangle {} of instance {} at t = {at}{near}\n", c.prim, c.instance));
    }
    if replayed.oracle.is_empty() {
        text.push_str("oracle    nothing\n");
    }
    text
}

/// A step as a line, indented by depth below the tree that is walked.
fn line(step: &Step, base: &mut usize) -> String {
    let pad = |depth: usize| "  ".repeat(depth + 1);
    match step {
        Step::Root { section, node, bounds, met } => {
            let met = if *met { "met" } else { "missed" };
            format!("{}{section}[{node}] {}: {met}\n", pad(*base), shown(bounds))
        }
        Step::Child { section, node, depth, bounds, leaf, near } => {
            let leaf = if *leaf { " leaf" } else { "" };
            let met = near.map_or_else(|| "missed".to_string(), |t| format!("met at {t:?}"));
            format!("{}{section}[{node}]{leaf} {}: {met}\n", pad(*base + *depth as usize), shown(bounds))
        }
        Step::Resume { section, node, near, dropped } => {
            let what = if *dropped { "dropped, it lies behind the best hit" } else { "taken up again" };
            format!("{}{section}[{node}], put off at {near:?}: {what}\n", pad(*base))
        }
        Step::Triangle { record, prim, geom, t, accepted } => {
            let what = if *accepted { "taken" } else { "out of range, or behind the best hit" };
            format!("{}TRIS[{record}] triangle {prim} of part {geom}: crossed at {t:?}, {what}\n", pad(*base))
        }
        Step::Instance { record, id, tree } => {
            *base += 1;
            format!("{}INST[{record}] instance {id}: into tree {tree}\n", pad(*base - 1))
        }
        Step::Return => {
            *base = base.saturating_sub(1);
            String::new()
        }
    }
}

fn shown([min, max]: &[[f32; 3]; 2]) -> String {
    format!("{min:?} … {max:?}")
}
