//! `bvhc chart --stability`: every recipe on scenes that builders are known to fail on.

mod document;
mod sections;

use super::ChartArgs;
use super::output::{self, Made};
use crate::build::Progress;
use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::interrupt;
use crate::cli::names;
use crate::cli::progress::Bar;
use crate::stability::motion::Motion;
use crate::stability::refused::Refused;
use crate::stability::{
    Effort, FAILURES, Failure as Scene, MOTIONS, MotionReport, REFUSED, Refusal, SceneReport, SplitReport, recipes,
    splits,
};
use std::time::Instant;

/// The motion whose number is about spatial splits in trees that are refitted.
const SPLITS: &str = "F29";
/// One in so many rays as are counted is judged by brute force.
const JUDGED: usize = 16;

/// What was asked for, by numbers or names.
struct Asked {
    scenes: Vec<&'static Scene>,
    motions: Vec<&'static Motion>,
    refused: Vec<&'static Refused>,
    splits: bool,
}

/// What was judged.
struct Judged {
    effort: Effort,
    scenes: Vec<SceneReport>,
    motions: Vec<MotionReport>,
    splits: Option<SplitReport>,
    refused: Vec<Refusal>,
    /// Scenes and motions that there was no time for, by their names.
    left_out: Vec<&'static str>,
}

impl Judged {
    /// Everything that is broken, each with the scene before it.
    fn broken(&self) -> Vec<String> {
        let of = |id: &str, name: &str, what: String| format!("{id} {name}, {what}");
        let scenes = self.scenes.iter().flat_map(|s| s.broken().into_iter().map(move |what| of(s.id, s.name, what)));
        let motions = self.motions.iter().filter_map(|m| Some(of(m.id, m.name, m.broken()?)));
        let taken = self.refused.iter().filter(|r| r.refusal.is_none());
        scenes.chain(motions).chain(taken.map(|r| of(r.id, r.name, "taken by some".into()))).collect()
    }
}

pub fn run(asked: &[String], args: &ChartArgs, context: &Context) -> Result<Exit, Failure> {
    let asked = chosen(asked)?;
    output::may_write(args)?;
    let deadline = Instant::now() + args.budget();
    let publishing = interrupt::publish()?;
    let judged = judge(&asked, deadline, args, context)?;
    if !judged.left_out.is_empty() {
        let why = if super::is_interrupted() { "the interruption came before" } else { "the budget left no time for" };
        context.terminal.warn(&format!("{why} {}", judged.left_out.join(", ")));
    }
    let broken = judged.broken();
    // What was not judged is not kept.
    let exit = match (super::is_interrupted(), broken.is_empty(), judged.left_out.is_empty()) {
        (true, ..) => Exit::Interrupted,
        (false, false, _) => Exit::Negative,
        (false, true, false) => Exit::Limit,
        (false, true, true) => Exit::Success,
    };
    let sections = sections::of(&judged, args);
    let made = Made {
        title: "Stability: scenes that builders fail on".into(),
        lead: sections::lead(&judged),
        warnings: broken.iter().map(|what| format!("Broken: {what}.")).collect(),
        sections: sections.all(),
        printed: sections.printed(),
        csv: document::csv(&judged),
        advice: Vec::new(),
    };
    output::write(args, &made, context, |outputs| document::Document::new(&judged, &broken, outputs, exit))?;
    if !context.terminal.json && !args.markdown {
        broken.iter().for_each(|what| context.terminal.warn(what));
    }
    drop(publishing);
    Ok(exit)
}

/// The scenes of these names; all where none is named.
fn chosen(names: &[String]) -> Result<Asked, Failure> {
    let names: Vec<&str> = names.iter().map(|name| name.trim()).filter(|name| !name.is_empty()).collect();
    let is_asked = |id: &str, name: &str| {
        names.is_empty() || names.iter().any(|n| n.eq_ignore_ascii_case(id) || n.eq_ignore_ascii_case(name))
    };
    let known = |n: &&&str| {
        let is = |own: &str| n.eq_ignore_ascii_case(own);
        is(SPLITS)
            || FAILURES.iter().any(|s| is(s.id) || is(s.name))
            || MOTIONS.iter().any(|m| is(m.id) || is(m.name))
            || REFUSED.iter().any(|r| is(r.id) || is(r.name))
    };
    if let Some(unknown) = names.iter().find(|n| !known(n)) {
        let all = FAILURES.iter().map(|s| s.name).chain(MOTIONS.iter().map(|m| m.name));
        let all: Vec<&str> = all.chain(REFUSED.iter().map(|r| r.name)).collect();
        return Err(Failure::new(Exit::Usage, format!("cannot judge {}", names::escape(unknown)))
            .fact("no scene of the list is called so, by name or by number")
            .help(format!("there are {}", all.join(", "))));
    }
    Ok(Asked {
        scenes: FAILURES.iter().filter(|s| is_asked(s.id, s.name)).collect(),
        motions: MOTIONS.iter().filter(|m| is_asked(m.id, m.name)).collect(),
        refused: REFUSED.iter().filter(|r| is_asked(r.id, r.name)).collect(),
        splits: is_asked(SPLITS, SPLITS),
    })
}

fn judge(asked: &Asked, deadline: Instant, args: &ChartArgs, context: &Context) -> Result<Judged, Failure> {
    let (sizes, rays) = (args.sizes(), args.rays as usize);
    let effort = Effort { sizes, rays, judged_rays: rays.div_ceil(JUDGED), rounds: args.rounds() };
    let bar = Bar::new(&context.terminal, "stability");
    let goes_on = || !bar.is_cancelled() && Instant::now() < deadline;
    let internal = |name: &str, error: &dyn std::error::Error| {
        Failure::new(Exit::Internal, format!("cannot judge {name}")).fact(error.to_string())
    };
    let (scenes, motions, refused) = (Vec::new(), Vec::new(), Vec::new());
    let mut judged = Judged { effort, scenes, motions, splits: None, refused, left_out: Vec::new() };
    let steps = (asked.scenes.len() * recipes().len()) as u64;
    let mut done = 0;
    bar.phase("judging", steps);
    for scene in &asked.scenes {
        let report = SceneReport::of(scene, &effort, &context.exec, |_| {
            bar.set(done, steps);
            done += 1;
            goes_on()
        });
        match report.map_err(|e| internal(scene.name, &e))? {
            Some(report) => judged.scenes.push(report),
            None => judged.left_out.push(scene.name),
        }
    }
    // There are many frames.
    let rays = effort.judged_rays;
    for motion in &asked.motions {
        if !goes_on() {
            judged.left_out.push(motion.name);
            continue;
        }
        let report = motion.judged(effort.sizes[0], rays, &context.exec).map_err(|e| internal(motion.name, &e))?;
        judged.motions.push(report);
    }
    if asked.splits && !goes_on() {
        judged.left_out.push(SPLITS);
    } else if asked.splits {
        let report = splits(effort.sizes[1], rays, &context.exec).map_err(|e| internal(SPLITS, &e))?;
        judged.splits = Some(report);
    }
    for refused in &asked.refused {
        judged.refused.push(refused.tried(&context.exec));
    }
    Ok(judged)
}
