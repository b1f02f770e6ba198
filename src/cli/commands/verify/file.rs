//! One file: opened, its scene read, verified.

use super::VerifyArgs;
use super::devices::{self, Bench};
use crate::cache::Cache;
use crate::cache::check::{Finding, Limits, check_records};
use crate::cache::rules::Severity;
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::names;
use crate::cli::progress::Bar;
use crate::scene::{self, ReadOptions, Scene};
use crate::verify::{Cpu, Outcome, Plan, Subject, VerifyError, is_of_model, scene_of_file};
use std::path::{Path, PathBuf};

/// A file with its verdict.
pub struct Verified {
    pub path: PathBuf,
    /// The model that the oracle was told of; `None`: the file's own triangles.
    pub source: Option<PathBuf>,
    pub outcome: Outcome,
}

impl Verified {
    pub fn exit(&self) -> Exit {
        if self.outcome.is_right() { Exit::Success } else { Exit::Negative }
    }
}

pub fn verify(
    path: &Path,
    args: &VerifyArgs,
    plan: &Plan,
    bench: &Bench,
    context: &Context,
) -> Result<Verified, Failure> {
    let bar = Bar::new(&context.terminal, &names::path(path));
    bar.spin("opening");
    let cache = caches::open(path, context)?;
    let finding = check_first(&cache, path, context)?;
    let scene = scene_for(&cache, path, args, context)?;
    let subject = Subject::new(cache.view(), &scene);
    let of_this_file = |failure: Failure| failure.fact(format!("the file is {}", names::path(path)));
    let mut others = bench.devices(cache.view()).map_err(|e| of_this_file(devices::failure(&e)))?;
    bar.phase("verifying", plan.rays);
    match crate::verify::run(&subject, &mut Cpu::new(cache.view()), &mut others, plan, &bar) {
        Ok(outcome) => match finding.filter(|_| outcome.is_right()) {
            Some(finding) => Err(broken(&finding, path).fact("no ray showed it")),
            None => Ok(Verified { path: path.to_path_buf(), source: args.source.clone(), outcome }),
        },
        Err(VerifyError::Device(error)) => Err(of_this_file(devices::failure(&error))),
        Err(VerifyError::Cancelled) => Err(Failure::interrupted()),
    }
}

/// Rules without which there is nothing to trace: the records are no tree, or no numbers. And the hole in a cut triangle, which is proved
/// where it is found. What breaks any other rule is left for rays to show, with the record that is to blame.
const NO_RAYS: [&str; 12] =
    ["E0401", "E0402", "E0403", "E0404", "E0405", "E0406", "E0408", "E0410", "E0412", "E0417", "E0425", "E0503"];

/// Hold the records against their rules before any ray is traced; the first breach that rays may show is handed back.
fn check_first(cache: &Cache, path: &Path, context: &Context) -> Result<Option<Finding>, Failure> {
    let limits = Limits { max_issues: 1, ..Limits::default() };
    let header = cache.header();
    let report = check_records(&cache.view(), header.tree_flags, Some(header), &limits, &context.exec);
    let errors: Vec<Finding> = report.findings.into_iter().filter(|f| f.rule.severity() == Severity::Error).collect();
    match errors.iter().find(|f| f.rule.id.starts_with("E03") || NO_RAYS.contains(&f.rule.id)) {
        Some(finding) => Err(broken(finding, path)),
        None => Ok(errors.into_iter().next()),
    }
}

fn broken(finding: &Finding, path: &Path) -> Failure {
    Failure::new(Exit::Negative, format!("cannot verify {}: its records break a rule", names::path(path)))
        .fact(finding.to_string())
        .help(format!("bvhc check {}", names::path(path)))
}

/// What the file should hold: the model, read as the file says that it was read, or else what the file itself says.
pub fn scene_for(cache: &Cache, path: &Path, args: &VerifyArgs, context: &Context) -> Result<Scene, Failure> {
    let Some(model) = &args.source else {
        return scene_of_file(&cache.view(), cache.names()).map_err(|e| {
            let failure = Failure::from_message(Exit::Negative, &e.to_string());
            failure.fact(format!("the file is {}", names::path(path))).help(format!("bvhc check {}", names::path(path)))
        });
    };
    let (read, _) = caches::recorded(cache.meta());
    let read = ReadOptions { allow_outside: args.allow_outside, max_memory: context.global.max_memory, ..read };
    let mut scene = scene::read(model, &read).map_err(|e| caches::scene_failure(&e))?;

    // Instances of nothing are in no file, and would shift the numbers of the others.
    let Scene { meshes, instances, .. } = &mut scene;
    instances.retain(|i| meshes.get(i.mesh as usize).is_some_and(|m| !m.triangles.is_empty()));
    is_of_model(&cache.view(), &scene).map_err(|e| {
        let failure = Failure::from_message(Exit::Negative, &e.to_string());
        let (file, model) = (names::path(path), names::path(model));
        failure
            .fact(format!("the file is {file}"))
            .fact(format!("the model is {model}"))
            .help(format!("bvhc check {file} --source {model}"))
    })?;
    Ok(scene)
}
