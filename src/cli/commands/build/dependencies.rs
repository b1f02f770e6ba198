//! The files that an output depends on, for Ninja and Make: which depfile it has, and when that is asked for and written.

use super::plan::Job;
use super::{BuildArgs, io_failure};
use crate::cache::{self, CacheError, Staged, Strays};
use crate::cli::caches;
use crate::cli::depfile;
use crate::cli::failure::Failure;
use crate::cli::interrupt;
use crate::cli::names;
use crate::cli::terminal::Terminal;
use clap::Args;
use std::path::{Path, PathBuf};

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Build systems")]
pub struct DepfileArgs {
    /// Write the files that the output depends on as a rule for Ninja and Make, also when it is up to date
    #[arg(long = "depfile", value_name = "FILE")]
    pub path: Option<PathBuf>,
    /// Folder that receives such a file for each output, called as it with .d behind, for several inputs
    #[arg(long = "depfile-dir", value_name = "DIR", conflicts_with_all = ["path", "target"])]
    pub dir: Option<PathBuf>,
    /// Target of the rule; default: the output as given
    #[arg(long = "depfile-target", value_name = "NAME", requires = "path")]
    pub target: Option<PathBuf>,
    /// Add an empty rule for each input, so that Make goes on when one is removed
    #[arg(long = "depfile-phony")]
    pub phony: bool,
}

impl DepfileArgs {
    /// The flag that asks for depfiles, if one does.
    pub fn asked_by(&self) -> Option<&'static str> {
        self.path.as_ref().map(|_| "--depfile").or(self.dir.as_ref().map(|_| "--depfile-dir"))
    }

    /// The depfile of an output.
    pub fn of(&self, output: &Path) -> Option<PathBuf> {
        let in_dir = |dir: &PathBuf| {
            let mut name = output.file_name().unwrap_or_default().to_os_string();
            name.push(".d");
            dir.join(name)
        };
        self.path.clone().or_else(|| self.dir.as_ref().map(in_dir))
    }
}

/// See to all of a job's depfile that can be told before the build, so that no output is left without one.
pub fn ask(job: &Job, args: &BuildArgs) -> Result<(), Failure> {
    let Some(path) = &args.depfile.of(&job.output) else { return Ok(()) };
    if !args.force {
        depfile::may_replace(path)?;
    }
    let made = job.output.parent().filter(|_| args.output.as_ref() != Some(&job.output));
    depfile::writable(path, args.depfile.dir.as_deref().or(made))?;
    nameable(job, args, job.bytes.is_none().then_some(job.input.as_path()))
}

/// Refuse files that a depfile cannot name, where one is asked for: before they are built, so that no output is left without its depfile.
pub fn nameable<'p>(job: &Job, args: &BuildArgs, inputs: impl IntoIterator<Item = &'p Path>) -> Result<(), Failure> {
    if args.depfile.asked_by().is_none() {
        return Ok(());
    }
    let inputs: Vec<PathBuf> = inputs.into_iter().map(Path::to_owned).collect();
    depfile::render(target_of(job, args), &inputs, args.depfile.phony).map(drop)
}

fn target_of<'a>(job: &'a Job, args: &'a BuildArgs) -> &'a Path {
    args.depfile.target.as_deref().unwrap_or(&job.output)
}

/// Write a job's depfile, where one is asked for, in one step: it is old or new as a whole.
pub fn write(
    job: &Job,
    args: &BuildArgs,
    inputs: &[PathBuf],
    strays: &Strays,
    terminal: &Terminal,
) -> Result<(), Failure> {
    let Some(path) = &args.depfile.of(&job.output) else { return Ok(()) };
    let target = target_of(job, args);
    if args.depfile.target.is_none() && target.as_os_str().as_encoded_bytes().contains(&b'%') {
        let name = names::path(target);
        let quoted = name.trim_matches('\'').replace('%', "\\%");
        terminal.warn(&format!(
            "Ninja reads the % in {name} as it is, but Make as a pattern; for Make add --depfile-target '{quoted}'"
        ));
    }
    let text = depfile::render(target, inputs, args.depfile.phony)?;
    if let Some(folder) = &args.depfile.dir {
        std::fs::create_dir_all(folder).map_err(|e| io_failure("create", folder, &e))?;
    }
    let _publishing = interrupt::publish()?;
    let staged = cache::stage_bytes(path, strays, &text).and_then(Staged::put);
    staged.map(drop).map_err(|error| match error {
        CacheError::Io { source, .. } => io_failure("write", path, &source),
        other => caches::failure(&other),
    })
}
