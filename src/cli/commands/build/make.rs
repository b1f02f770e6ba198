//! One build from model to file.

use super::dependencies::nameable;
use super::inputs;
use super::options::NodeForm;
use super::outcome::{Arrival, Built, Model, Times, peak_memory};
use super::plan::Job;
use super::remarks::{Kind, Remark, Remarks, nothing_in_it, with_warnings};
use super::{BuildArgs, Empty};
use crate::build::BuildOptions;
use crate::cache::keys::Recipe;
use crate::cache::{self, Codec, Image, Meta, Staged, Strays, WriteOptions};
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::heap;
use crate::cli::identity::same_file;
use crate::cli::interrupt;
use crate::cli::names;
use crate::cli::outputs;
use crate::cli::progress::Bar;
use crate::compile::{self, LaidOut};
use crate::exec::Executor;
use crate::report::effort::BuildEffort;
use crate::report::file::FileReport;
use crate::scene::{self, InputFile, Posed, ReadOptions, ReadReport, Scene};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Everything that is the same for all jobs of a run.
pub struct Workshop<'a> {
    pub args: &'a BuildArgs,
    pub context: &'a Context,
    pub build: BuildOptions,
    pub read: ReadOptions,
    pub codec: Codec,
    pub recipe: Recipe,
    /// It builds one output and no others.
    pub alone: bool,
    /// Temporary files of earlier runs.
    pub strays: Arc<Strays>,
}

/// Models of so many triangles hold memory that is worth giving back between two steps.
const LARGE: u64 = 1 << 16;

/// A finished build.
pub struct Made {
    pub built: Built,
    pub build_key: [u8; 32],
    /// Of a still file, which is not in its place yet.
    pub file_id: Option<[u8; 32]>,
    pub inputs: Vec<PathBuf>,
}

/// A model that was read and put where it stands.
struct Prepared {
    laid: LaidOut,
    /// Triangles to build over, at most.
    primitives: u64,
    inputs: Vec<InputFile>,
    arrival: Arrival,
    read_time: Duration,
}

impl<'a> Workshop<'a> {
    /// The same work with other threads and another limit.
    pub fn with(&self, context: &'a Context) -> Workshop<'a> {
        let read = ReadOptions { max_memory: context.global.max_memory, ..self.read.clone() };
        let (build, recipe, strays) = (self.build.clone(), self.recipe.clone(), self.strays.clone());
        Workshop { args: self.args, context, build, read, codec: self.codec, recipe, alone: self.alone, strays }
    }

    /// Read, and say all that a build would say before it builds.
    pub fn rehearse(&self, job: &Job) -> Result<Model, Failure> {
        let bar = Bar::new(&self.context.terminal, &names::path(&job.output));
        let Prepared { laid, arrival, .. } = self.prepare(job, &bar)?;
        Ok(Model {
            triangles: laid.meshes.iter().map(|mesh| mesh.triangles.len() as u64).sum(),
            trees: laid.meshes.len() as u64,
            instances: laid.instances.map_or(0, |instances| instances.len() as u64),
            arrival,
        })
    }

    /// Read a model, put everything where it stands, and say what was lost on the way.
    fn prepare(&self, job: &Job, bar: &Bar) -> Result<Prepared, Failure> {
        let (start, terminal) = (Instant::now(), &self.context.terminal);
        let scene = self.read(job, bar)?;
        let (inputs, mut read, rounding) = (scene.inputs.clone(), scene.report.clone(), scene.rounding);
        nameable(job, self.args, inputs.iter().map(|input| input.path.as_path()))?;
        let posed = scene.posed.clone();
        let read_time = start.elapsed();
        caches::fits(&job.input, &scene, &self.build, self.context)?;

        let primitives = compile::primitives_to_build(&scene, &self.build);
        let laid = compile::lay_out(scene, &self.build, &self.context.exec).map_err(|e| caches::build_failure(&e))?;
        let placing = laid.placing.clone();
        read.degenerate_triangles += placing.collapsed;
        let at_rest = self.args.read.at_rest;
        let remarks = Remarks { report: &read, read: &self.read, rounding: &rounding, placing: &placing, at_rest };
        let model = names::path(&job.input);
        let empty = (laid.meshes.is_empty() && self.args.empty == Empty::Keep).then(nothing_in_it);
        let mut warnings = remarks.warnings(self.build.levels);
        warnings.extend(empty);
        self.tell(&model, &warnings);
        self.forgive(&model, &warnings)?;
        self.tell_idle(&model, &read);
        if let Some(posed) = &posed {
            self.tell_moment(&model, posed);
        }
        let name = names::path(&job.output);
        placing.notes.iter().for_each(|note| terminal.detail(&format!("{name}: {note}")));
        if laid.meshes.is_empty() && self.args.empty == Empty::Error {
            return Err(remarks.nothing(&model));
        }
        let arrival = Arrival::new(read, rounding, placing, posed, warnings);
        Ok(Prepared { laid, primitives, inputs, arrival, read_time })
    }

    /// Read, build, write beside the output's place. Nothing is written before the tree is there.
    pub fn make(&self, job: &Job) -> Result<(Made, Option<Staged>), Failure> {
        let start = Instant::now();
        let bar = Bar::new(&self.context.terminal, &names::path(&job.output));
        let Prepared { laid, primitives, inputs, arrival, read_time } = self.prepare(job, &bar)?;
        let give_back = || {
            if primitives >= LARGE {
                heap::give_back()
            }
        };
        give_back();
        if let Some(instances) = laid.instances.as_ref().filter(|_| self.args.orient) {
            return Err(Failure::new(Exit::Usage, format!("cannot build {}", names::path(&job.output)))
                .fact(format!("--orient is about files of one level, and this one has {} instances", instances.len()))
                .help("add --levels one, or leave out --orient"));
        }
        bar.phase("building", primitives);
        let exec = &self.context.exec;
        let mut accel = compile::compile_sound(laid, &self.build, exec, &bar).map_err(|e| caches::build_failure(&e))?;
        give_back();
        let posed = arrival.posed.iter().map(ToString::to_string).collect();
        let mut notes = [posed, std::mem::take(&mut accel.notes)].concat();
        let mut image = Image::of_compiled(accel, exec).map_err(|e| caches::failure(&e))?;
        if NodeForm::any_compact(&self.args.nodes) {
            image.add_compact().map_err(|e| caches::failure(&e))?;
        }
        if self.args.orient {
            caches::fits_turned(&job.output, &image, self.context)?;
            let oriented = compile::orient_image(&mut image, exec).map_err(|e| caches::failure(&e))?;
            self.context.terminal.detail(&format!("{}: {oriented}", names::path(&job.output)));
            notes.push(oriented.to_string());
        }
        let build_time = start.elapsed() - read_time;
        notes.extend(self.effort(start));

        bar.spin("writing");
        let meta = Meta { notes, ..cache::provenance(self.recipe.clone(), &inputs, &arrival.read) };
        let publishing = interrupt::publish()?;
        if !self.args.force {
            outputs::may_replace(&job.output)?;
        }
        let options = WriteOptions::of_build(self.codec);
        // Writing is one thread's work. What has changed meanwhile never takes its place.
        let files = if job.bytes.is_none() { &inputs[..] } else { &[] };
        let ((report, same), staged) = exec.join(
            || (FileReport::of_view(String::new(), 0, &image.view()), unchanged(files, exec)),
            || cache::stage_file(&job.output, &image, &meta, &options, &self.strays, exec),
        );
        same?;
        let (written, staged) = staged.map_err(|e| caches::failure(&e))?;
        staged.temporary().into_iter().for_each(interrupt::stage);
        drop(publishing);
        let times = Times::new(read_time, build_time, start.elapsed());
        let made = Made {
            built: Built::new(&report, &written, arrival, times),
            build_key: written.header.build_key,
            file_id: Some(written.header.file_id),
            inputs: inputs.into_iter().map(|i| i.path).filter(|_| job.bytes.is_none()).collect(),
        };
        Ok((made, Some(staged)))
    }

    /// What the build took so far, as a note, where that was asked for.
    pub(super) fn effort(&self, start: Instant) -> Option<String> {
        let peak_memory = peak_memory().filter(|_| self.alone);
        let threads = self.context.exec.threads() as u64;
        let seconds = start.elapsed().as_secs_f64();
        self.args.record_effort.then(|| BuildEffort { seconds, threads, peak_memory }.to_string())
    }

    /// Whether a policy for what is told was typed, so that it is no news.
    fn is_asked_for(&self, told: &Remark) -> bool {
        match told.kind {
            Kind::WithoutArea => self.args.read.model.degenerate.is_some(),
            Kind::Empty => self.args.empty == Empty::Keep,
            _ => false,
        }
    }

    /// Warn of what nobody asked for, and note what was asked for.
    pub(super) fn tell(&self, place: &str, told: &[Remark]) {
        for remark in told {
            let line = format!("{place}: {}", remark.text);
            match self.is_asked_for(remark) {
                true => self.context.terminal.note(&line),
                false => self.context.terminal.warn(&line),
            }
        }
    }

    /// Refuse a model of which something was told that nobody asked for, where that is wanted.
    pub(super) fn forgive(&self, model: &str, told: &[Remark]) -> Result<(), Failure> {
        let unasked: Vec<Remark> = told.iter().filter(|told| !self.is_asked_for(told)).cloned().collect();
        if !self.args.warnings_as_errors || unasked.is_empty() {
            return Ok(());
        }
        Err(with_warnings(model, &unasked))
    }

    fn read(&self, job: &Job, bar: &Bar) -> Result<Scene, Failure> {
        bar.phase("reading", 1);
        let mut progress = |done: u64, length: u64| bar.set(done, length);
        if let Some(bytes) = &job.bytes {
            let format = self.args.read.input_format.map(Into::into);
            let scene = scene::read_bytes(bytes.clone(), inputs::STDIN, format, None, &self.read);
            return scene.map_err(|e| caches::scene_failure(&e));
        }
        let scene = scene::read_with(&job.input, &self.read, &self.context.exec, &mut progress)
            .map_err(|e| caches::scene_failure(&e))?;
        match scene.inputs.iter().find(|i| same_file(&i.path, &job.output)) {
            Some(input) => Err(inputs::is_an_input(&job.output, &input.path)),
            None => Ok(scene),
        }
    }

    /// Say which moment a model was posed at, and loudly where that is not quite what was asked for.
    /// Name the extensions that were to be ignored and could not be: a misspelt name should not pass for a decision.
    pub(super) fn tell_idle(&self, model: &str, report: &ReadReport) {
        for name in self.read.ignore_extensions.iter().filter(|name| !report.ignored_extensions.contains(name)) {
            let text = format!(
                "{model}: --ignore-extension {} changes nothing, since the model does not list it or it moves no triangles",
                names::escape(name)
            );
            // Among many models some may lack it.
            match self.alone {
                true => self.context.terminal.note(&text),
                false => self.context.terminal.detail(&text),
            }
        }
    }

    fn tell_moment(&self, model: &str, posed: &Posed) {
        let text = format!("{model}: {}", names::escape(&posed.to_string()));
        match posed.is_within() {
            true => self.context.terminal.detail(&text),
            false => self.context.terminal.note(&text),
        }
    }

    /// Read the new file back far enough to know that the header, the table and every size are what was written.
    pub(super) fn check(&self, job: &Job, file_id: [u8; 32]) -> Result<(), Failure> {
        let head = caches::head(&job.output, self.context)?;
        if head.header.file_id == file_id {
            return Ok(());
        }
        Err(Failure::new(Exit::TryAgain, format!("cannot vouch for {}", names::path(&job.output)))
            .fact("another process replaced it after it was written")
            .help("run one build of an output at a time"))
    }
}

/// An editor or exporter may write while we read: then the tree is of no model that ever was.
pub(super) fn unchanged(inputs: &[InputFile], exec: &Executor) -> Result<(), Failure> {
    for input in inputs {
        let now = cache::hash_file(&input.path, exec);
        if !matches!(now, Ok(now) if now == (input.len, input.blake3)) {
            return Err(changed_meanwhile(&input.path));
        }
    }
    Ok(())
}

pub(super) fn changed_meanwhile(path: &std::path::Path) -> Failure {
    Failure::new(Exit::TryAgain, "the input changed")
        .fact(format!("{} is no longer the file that was read", names::path(path)))
        .help("nothing was written; run the same command again")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_that_changes_while_it_is_built_means_try_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        std::fs::write(&path, "v 0 0 0\n").unwrap();
        let (len, blake3) = cache::hash_file(&path, &Executor::sequential()).unwrap();
        let input = InputFile { path: path.clone(), name: "a.obj".into(), len, blake3 };
        assert_eq!(unchanged(std::slice::from_ref(&input), &Executor::sequential()), Ok(()));
        std::fs::write(&path, "v 0 0 1\n").unwrap();
        assert_eq!(unchanged(std::slice::from_ref(&input), &Executor::sequential()).unwrap_err().exit, Exit::TryAgain);
        std::fs::remove_file(&path).unwrap();
        assert_eq!(unchanged(&[input], &Executor::sequential()).unwrap_err().exit, Exit::TryAgain);
    }
}
