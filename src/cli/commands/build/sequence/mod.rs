//! A sequence: many frames, one file.

mod again;
mod rehearse;
mod told;

use super::Empty;
use super::dependencies::nameable;
use super::frames::{Fps, Frames, MOST_FRAMES, OneFrame, TreeChoice};
use super::inputs;
use super::make::{Made, Workshop, changed_meanwhile, unchanged};
use super::outcome::{Arrival, Built, SequenceBuilt, Times};
use super::plan::Job;
use super::remarks::{Remarks, nothing_in};
use crate::build::motion;
use crate::build::{BuildOptions, Levels, Named, Progress};
use crate::cache::keys::Recipe;
use crate::cache::{self, Meta, WriteSummary};
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::cli::interrupt;
use crate::cli::names;
use crate::cli::outputs;
use crate::cli::progress::Bar;
use crate::scene::{self, Animation, Clip, Degenerate, InputFile, ReadOptions, Scene, Seconds};
use crate::sequence::{FrameLabel, Incoming, Refit, RefitPolicy, SequenceBuilder, SequenceError, Trees};
use again::Plan;
use std::time::{Duration, Instant};
use told::{Arrived, Told, arrive, own_cuts};

/// Frames a second of a clip whose keys are not uniform.
const FILM: f64 = 24.0;

/// Frames that trees are made for; those of longer sequences are thinned out evenly.
const SURVEYED: usize = 24;

/// Some of so many frames, spread evenly from the first to the last.
fn some(frames: usize) -> impl Iterator<Item = usize> {
    let count = frames.min(SURVEYED);
    (0..count).map(move |i| i * (frames - 1) / (count.max(2) - 1))
}

/// The option that says which frames a sequence has.
const CHOICE: &str = "sequence";

/// What the frames of a sequence are read with: triangles without area stay, since they may have one in another frame.
fn read_options(read: &ReadOptions) -> ReadOptions {
    let degenerate = if read.degenerate == Degenerate::Error { Degenerate::Error } else { Degenerate::Keep };
    ReadOptions { degenerate, moment: None, faces: true, ..read.clone() }
}

/// A sequence always has a top level. Parts of triangles cannot follow when those move, so that no tree that may be refitted has any.
fn build_options(build: &BuildOptions, policy: &RefitPolicy) -> BuildOptions {
    let split_budget = if policy.refit == Refit::Never { build.split_budget } else { 1.0 };
    BuildOptions { levels: Levels::Two, split_budget, ..build.clone() }
}

/// What decides a sequence's content beside its inputs.
pub fn recipe(workshop: &Workshop, frames: &Frames) -> Recipe {
    recipe_of(workshop, &frames.recorded())
}

/// The same for frames by what is recorded of them.
fn recipe_of(workshop: &Workshop, frames: &str) -> Recipe {
    let policy = workshop.args.frames.policy();
    // What is told first where a file is out of date.
    let mut options: Vec<(String, String)> = vec![
        (CHOICE.into(), frames.into()),
        ("refit".into(), policy.refit.name().into()),
        ("trees".into(), workshop.args.frames.trees().to_string()),
        ("rebuild_ratio".into(), policy.rebuild_ratio.to_string()),
    ];
    options.extend(policy.keyframe_every.map(|every| ("keyframe_every".into(), every.to_string())));
    options.extend(build_options(&workshop.build, &policy).effective());
    options.extend(read_options(&workshop.read).effective());
    let builder_revision = workshop.recipe.builder_revision + motion::REVISION;
    Recipe { options, builder_revision, ..workshop.recipe.clone() }
}

/// A build's ear for signals without its count of triangles: the bar counts frames.
struct Ear<'a>(&'a Bar);

impl Progress for Ear<'_> {
    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

impl Workshop<'_> {
    /// Read, build and write a sequence frame by frame. Nothing is at the output's place before everything else has succeeded.
    pub fn make_sequence(&self, job: &Job, frames_of: &Frames) -> Result<Made, Failure> {
        let start = Instant::now();
        if self.build.levels == Levels::One {
            return Err(Failure::new(Exit::Usage, "cannot build a sequence with one level")
                .fact("each frame has a top level, by which what stands still is stored once")
                .help("leave out --levels one and --flatten"));
        }
        let (name, model) = (names::path(&job.output), names::path(&job.input));
        let bar = Bar::new(&self.context.terminal, &name);
        let ear = Ear(&bar);
        let (read, policy) = (read_options(&self.read), self.args.frames.policy());
        let exec = &self.context.exec;
        let build = build_options(&self.build, &policy);
        let mut builder =
            SequenceBuilder::new(&job.output, &build, policy, self.codec, exec, &ear).map_err(|e| failure(&e))?;
        if self.surveys(2).is_some() && self.args.tree.is_given() {
            self.context.terminal.note(&format!(
                "{name}: meshes that move get trees for all their frames, made by sweep and reinsertion; the options for trees hold for \
                 meshes that stand still, and for all with --trees first"
            ));
        }
        let mut told = Told { at_rest: self.args.read.at_rest, ..Told::default() };
        match frames_of {
            Frames::Files(list) => self.files(job, list, &read, &mut builder, &mut told, &bar)?,
            Frames::Clip { choice, fps, range } => {
                let mut progress = |_, _| ();
                scene::play(&job.input, choice, &read, exec, &mut progress, |clip| {
                    let times = self.times(clip.animation(), *fps, *range, &model)?;
                    self.clip(clip, &times, &read, &mut builder, &mut told, &bar)
                })
                .map_err(|e| caches::scene_failure(&e))??;
            }
        }
        self.not_an_input(job, &told.inputs)?;
        nameable(job, self.args, told.inputs.iter().map(|input| input.path.as_path()))?;

        let read_time = told.reading(start.elapsed());
        let Told { mut report, rounding, placing, inputs, frames, troubled, changed, read: were_read, .. } = told;
        if let Some(path) = changed {
            return Err(changed_meanwhile(&path));
        }
        report.degenerate_triangles += placing.collapsed;
        let at_rest = self.args.read.at_rest;
        let remarks = Remarks { report: &report, read: &read, rounding: &rounding, placing: &placing, at_rest };
        if frames.iter().all(|frame| frame.instanced_triangles == 0) && self.args.empty == Empty::Error {
            return Err(remarks.nothing(&model));
        }
        let mut warnings = remarks.warnings(Levels::Two);
        let empty = nothing_in(frames.iter().filter(|frame| frame.instanced_triangles == 0).count() as u64);
        warnings.extend(empty);
        let place = match troubled[..] {
            [] => name.clone(),
            [only] => format!("{name}, frame {only}"),
            [first, ..] => {
                format!("{name}, {} from {first} on", figures::counted(troubled.len() as u64, "frame", "frames"))
            }
        };
        self.tell(&place, &warnings);
        self.forgive(&place, &warnings)?;

        self.tell_idle(&model, &report);
        if let Some(note) = own_cuts(&frames) {
            self.context.terminal.note(&format!("{name}: {note}"));
        }

        bar.spin("writing");
        let build_time = start.elapsed().saturating_sub(read_time);
        unchanged(&inputs, exec)?;
        let provenance = cache::provenance(recipe(self, frames_of), &inputs, &report);
        let meta = Meta { notes: self.effort(start).into_iter().collect(), ..provenance };
        let publishing = interrupt::publish()?;
        if !self.args.force {
            outputs::may_replace(&job.output)?;
        }
        let surveyed = builder.surveyed();
        let written = builder.finish(&meta).map_err(|e| failure(&e))?;
        drop(publishing);
        if !self.args.no_check {
            self.check(job, written.header.file_id)?;
        }
        let times = Times::new(read_time, build_time, start.elapsed());
        let arrival = Arrival::new(report, rounding, placing, None, warnings);
        Ok(self.made(&written, SequenceBuilt::new(frames, surveyed, were_read.len() as u64), inputs, arrival, times))
    }

    fn made(
        &self,
        written: &WriteSummary,
        sequence: SequenceBuilt,
        inputs: Vec<InputFile>,
        arrival: Arrival,
        times: Times,
    ) -> Made {
        let built = Built::of_sequence(sequence, written, arrival, times);
        let inputs = inputs.into_iter().map(|input| input.path).collect();
        Made { built, build_key: written.header.build_key, file_id: None, inputs }
    }

    /// How many trees are made for all frames together, if any are.
    fn surveys(&self, frames: usize) -> Option<Trees> {
        let args = &self.args.frames;
        match args.trees() {
            TreeChoice::Surveyed(trees) if frames > 1 && args.policy().refit != Refit::Never => Some(trees),
            _ => None,
        }
    }

    /// The frames of a pattern: while one is built, the next one is read.
    fn files(
        &self,
        job: &Job,
        list: &[OneFrame],
        read: &ReadOptions,
        builder: &mut SequenceBuilder,
        told: &mut Told,
        bar: &Bar,
    ) -> Result<(), Failure> {
        let exec = &self.context.exec;
        let read_one = |frame: &OneFrame| -> Result<(Scene, Duration), Failure> {
            let start = Instant::now();
            let scene =
                scene::read_with(&frame.model, read, exec, &mut |_, _| ()).map_err(|e| caches::scene_failure(&e));
            Ok((scene?, start.elapsed()))
        };
        let prior = self.prior(job, list);
        if let Some(trees) = self.surveys(list.len()) {
            bar.spin("looking at frames of");
            let read: Vec<_> = exec.map(some(list.len()).collect(), |_, index| (index, read_one(&list[index])));
            let mut scenes = Vec::with_capacity(read.len());
            for (index, one) in read {
                let (scene, took) = one?;
                told.read_time += took;
                told.read.insert(index);
                told.surveyed.extend_from_slice(&scene.inputs);
                scenes.push(scene);
            }
            let start = Instant::now();
            builder.survey(scenes, trees).map_err(|e| failure(&e))?;
            told.add_time += start.elapsed();
        }
        bar.phase("frames of", list.len() as u64);
        let preparer = builder.preparer();
        let read_one = |index: usize| -> Result<Incoming<Arrived>, Failure> {
            let frame = &list[index];
            let (scene, took) = read_one(frame)?;
            caches::fits(&frame.model, &scene, &self.build, self.context)?;
            arrive(&preparer, scene, frame.label(), took)
        };
        let mut plan = match prior {
            Some(prior) => self.take(prior, builder, read_one)?,
            None => Plan::read_all(),
        };
        let adding = builder.add_all(
            list.len(),
            |some| {
                let ready = some.map(|index| (index, plan.ready(index, &list[index]))).collect();
                let read = |_, (index, ready): (usize, Option<_>)| ready.map_or_else(|| read_one(index), Ok);
                exec.map(ready, read).into_iter().collect()
            },
            read_one,
            |i, outcome, arrived: Arrived| {
                told.frame(i, &arrived, outcome, read);
                bar.set(i as u64 + 1, list.len() as u64);
                Ok(())
            },
        )?;
        told.add_time += adding;
        Ok(())
    }

    fn clip(
        &self,
        clip: &mut Clip<'_, '_, '_>,
        times: &[Seconds],
        read: &ReadOptions,
        builder: &mut SequenceBuilder,
        told: &mut Told,
        bar: &Bar,
    ) -> Result<(), Failure> {
        if let Some(trees) = self.surveys(times.len()) {
            bar.spin("looking at frames of");
            let start = Instant::now();
            let scenes: Result<Vec<Scene>, _> = some(times.len()).map(|index| clip.at(times[index])).collect();
            let scenes = scenes.map_err(|e| caches::scene_failure(&e))?;
            told.read_time += start.elapsed();
            let start = Instant::now();
            builder.survey(scenes, trees).map_err(|e| failure(&e))?;
            told.add_time += start.elapsed();
        }
        bar.phase("frames of", times.len() as u64);
        let preparer = builder.preparer();
        let adding = builder.add_all(
            times.len(),
            |some| {
                some.map(|i| {
                    let start = Instant::now();
                    let scene = clip.at(times[i]).map_err(|e| caches::scene_failure(&e))?;
                    let label = FrameLabel { number: i as i32, time: Some(times[i].get() as f32), held: false };
                    arrive(&preparer, scene, label, start.elapsed())
                })
                .collect()
            },
            // A clip is one file: where it changed, every frame did.
            |_| Err(Failure::new(Exit::Internal, "cannot pose a frame twice")),
            |i, outcome, arrived: Arrived| {
                told.frame(i, &arrived, outcome, read);
                bar.set(i as u64 + 1, times.len() as u64);
                Ok(())
            },
        )?;
        told.add_time += adding;
        Ok(())
    }

    /// The times at which a clip is posed, and why those.
    fn times(
        &self,
        animation: &Animation,
        fps: Fps,
        range: Option<(Seconds, Seconds)>,
        model: &str,
    ) -> Result<Vec<Seconds>, Failure> {
        let refuse = |fact: String| Failure::new(Exit::Usage, format!("cannot play a clip of {model}")).fact(fact);
        let shown = names::escape(&animation.to_string());
        let (rate, why) = match (fps, animation.keys.and_then(|keys| keys.rate)) {
            (Fps::Rate(rate), _) => (rate, String::new()),
            (Fps::Auto, Some(rate)) => (rate, ", as its keys have".to_string()),
            (Fps::Auto, None) => (FILM, ", since its keys are not uniform".to_string()),
        };
        let keys = animation.keys.map(|keys| (f64::from(keys.first), f64::from(keys.last)));
        let (first, last) = match (range, keys) {
            (Some((from, to)), _) => (from.get(), to.get()),
            (None, Some(keys)) => keys,
            (None, None) => return Err(refuse(format!("{shown} moves nothing of the scene")).help("leave out --fps")),
        };
        // A frame that lies a thousandth beyond the end is meant.
        let steps = ((last - first) * rate + 1e-3).floor();
        if !(steps < MOST_FRAMES as f64) {
            return Err(refuse(format!(
                "from {first} to {last} s at {rate} frames a second there are more than {MOST_FRAMES} frames"
            ))
            .help("choose a part of it by --play FROM..TO, or a lower --fps"));
        }
        // Keys are f32, and so is the time that the file keeps: who poses the model at that time sees the frame.
        let times: Vec<Seconds> =
            (0..=steps as u64).filter_map(|k| Seconds::new(f64::from((first + k as f64 / rate) as f32))).collect();
        let count = figures::counted(times.len() as u64, "frame", "frames");
        if let Some(keys) = animation.keys
            && let Some((from, to)) = range
            && (keys.holds_at(from) || keys.holds_at(to))
        {
            let all = to.get() < f64::from(keys.first) || from.get() > f64::from(keys.last);
            let part = if all { "all" } else { "part" };
            let note = format!("{model}: {shown} holds its first or last value in {part} of {from} to {to} s ({keys})");
            self.context.terminal.note(&note);
        }
        self.context.terminal.detail(&format!("{model}: {shown}: {count} from {first} s on, {rate} a second{why}"));
        Ok(times)
    }

    fn not_an_input(&self, job: &Job, inputs: &[InputFile]) -> Result<(), Failure> {
        match inputs.iter().find(|input| crate::cli::identity::same_file(&input.path, &job.output)) {
            Some(input) => Err(inputs::is_an_input(&job.output, &input.path)),
            None => Ok(()),
        }
    }
}

impl From<SequenceError> for Failure {
    fn from(error: SequenceError) -> Failure {
        failure(&error)
    }
}

fn failure(error: &SequenceError) -> Failure {
    match error {
        SequenceError::Build(error) => caches::build_failure(error),
        SequenceError::Cache(error) => caches::failure(error),
    }
}
