//! `bvhc build`: models in, cache files out.
//!
//! `options` are the flags that change the output, `inputs` what the arguments name, `frames` what patterns of frames stand for, `plan` decides what has to be done and why, `dependencies` tells build systems of what, `make` does it for one output, `publish` puts outputs in their places, `many` does it all for many outputs,
//! `outcome` says what was done, `remarks` what did not arrive whole, `remembered` what did not when an output was built that is up to date, and `sequence` makes one file of many frames.

mod dependencies;
mod frames;
mod inputs;
mod make;
mod many;
pub mod options;
mod outcome;
mod plan;
mod publish;
mod remarks;
mod remembered;
mod sequence;

use crate::cache::keys::Recipe;
use crate::cache::{Codec, Staged};
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::names;
use crate::cli::outputs;
use crate::compile::orient_option;
use crate::report::info::hex;
use crate::scene::ReadOptions;
use crate::size::bytes;
use clap::{Args, ValueEnum};
use dependencies::DepfileArgs;
use frames::FrameArgs;
pub use frames::clip_of;
use make::{Made, Workshop};
use outcome::{Outcome, Status};
use plan::{Job, Verdict};
use publish::{SyncMode, put_all};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Instant, SystemTime};

/// Compile models into cache files
///
/// Reads OBJ, glTF and GLB. An output whose inputs, options and builder have not changed is left alone.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct BuildArgs {
    /// Models to compile: files, folders of them, quoted patterns such as 'models/*.obj' or 'heli.%04d.obj', or `-` for standard input
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// File to write, which for a pattern of frames holds them all; a folder (`DIR/`) that receives one .bvhc file per input;
    /// or a pattern such as 'heli.%04d.bvhc' for a file per frame [default: beside each input, with the extension .bvhc]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Build even what is up to date, and over files that are no caches
    #[arg(short, long)]
    pub force: bool,
    /// What to do with a model in which no triangle is left
    #[arg(long, value_enum, value_name = "POLICY", default_value = "error")]
    pub empty: Empty,
    /// Treat warnings about a model as errors, and write nothing then
    #[arg(long)]
    pub warnings_as_errors: bool,
    /// Say what would be built and why, and write nothing: no output, no depfile, no time stamp. Models that would be built are read, and their faults are told
    #[arg(short = 'n', long)]
    pub dry_run: bool,
    /// With --dry-run: exit with 1 if anything would be built
    #[arg(long, requires = "dry_run")]
    pub exit_code: bool,
    /// Give outputs that are up to date a new time stamp, for Make
    #[arg(long)]
    pub touch: bool,
    /// Do not read the written file back
    #[arg(long)]
    pub no_check: bool,
    /// How sections are stored: raw can be mapped, zstd is smaller (levels 1 to 22, usually 3), compact is about a tenth of a
    /// raw sequence (level usually 9) and zstd in a still file. A file does not say its level, so another level alone builds nothing: use --force or `bvhc convert`
    #[arg(long, value_name = "raw|zstd[:LEVEL]|compact[:LEVEL]", default_value = "raw", value_parser = parse_codec)]
    pub codec: Codec,
    /// Write into META what the build took, for `bvhc stats`: seconds, threads, and the peak memory of a model that is built alone. The file's bytes then differ from
    /// run to run
    #[arg(long)]
    pub record_effort: bool,
    /// When outputs are put in their places, and what a power cut may do to them; a sequence always waits for the disk
    #[arg(long, value_enum, value_name = "WHEN", default_value = "each")]
    pub sync: SyncMode,
    /// Forms of trees to store. binary is always stored; compact8 adds trees with eight children a node: about ten more bytes a triangle, faster
    /// rays, the same hits. Not for sequences
    #[arg(long, value_name = "FORM,…", value_enum, value_delimiter = ',', default_value = "binary")]
    pub nodes: Vec<options::NodeForm>,
    /// Turn subtrees whose boxes pay along other axes, as measured rays say: 32 more bytes a node there, fewer nodes a ray, the same hits. The tree itself
    /// stays what it is. For still files of one level
    #[arg(long)]
    pub orient: bool,

    #[command(flatten)]
    pub frames: FrameArgs,
    #[command(flatten)]
    pub read: options::ReadArgs,
    #[command(flatten)]
    pub tree: options::TreeArgs,
    #[command(flatten)]
    pub depfile: DepfileArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Empty {
    /// Refuse it and write nothing
    Error,
    /// Write a cache that no ray hits
    Keep,
}

const EXAMPLES: &str = "Examples:
  bvhc build rock.glb -o rock.bvhc
  bvhc build *.obj -o caches/ --preset balanced
  bvhc build 'heli.%04d.obj' -o heli.bvhc --frames 1-100      one file for all frames
  bvhc build fox.glb -o fox.bvhc --clip Walk --fps 24         likewise
  export-scene | bvhc build - --input-format glb -o scene.bvhc
  bvhc build rock.gltf -o rock.bvhc --depfile rock.bvhc.d     for Ninja and Make
  bvhc build rock.glb -o rock.bvhc --dry-run                  says why it would build";

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    files: &'a [Outcome],
}

pub fn run(args: &BuildArgs, context: &Context) -> Result<Exit, Failure> {
    let jobs = plan::jobs(args, inputs::expand(args, context)?)?;
    let workshop = workshop(args, context, jobs.len() == 1)?;
    if let Some(note) = args.tree.search_given_up(&workshop.build) {
        context.terminal.note(&note);
    }
    let (outcomes, exits): (Vec<Outcome>, Vec<Exit>) = match &jobs[..] {
        [job] => std::iter::once(attend(job, &workshop)?).unzip(),
        _ => many::attend_all(&jobs, &workshop)?.into_iter().unzip(),
    };

    // A dry run has failed only where it could not find out; having something to do is an answer.
    let mut exit = Exit::combine(exits);
    let stale = outcomes.iter().any(|o| o.status == Status::WouldBuild);
    if args.exit_code && exit == Exit::Success && stale {
        exit = Exit::Negative;
    }
    if context.terminal.json {
        let document = Document { schema: "bvhc.build.v1", exit_code: exit.code(), files: &outcomes };
        context.terminal.document(&document)?;
    } else if jobs.len() > 1 {
        context.terminal.note(&summary(&outcomes));
        if let Some(peak) = outcome::peak_memory() {
            context.terminal.detail(&format!("peak memory of all builds together: {}", bytes(peak)));
        }
    }
    Ok(exit)
}

fn workshop<'a>(args: &'a BuildArgs, context: &'a Context, alone: bool) -> Result<Workshop<'a>, Failure> {
    let build = args.tree.resolve().map_err(|e| caches::build_failure(&e))?;
    let read = ReadOptions { max_memory: context.global.max_memory, ..args.read.resolve() };
    let method = build.method;
    let mut recipe =
        Recipe { method: method.to_string(), builder_revision: build.revision(), options: build.effective() };
    recipe.options.extend(read.effective());
    recipe.options.extend(args.orient.then(orient_option));
    Ok(Workshop { args, context, build, read, codec: args.codec, recipe, alone, strays: Arc::default() })
}

/// Do one job and report it at once.
fn attend(job: &Job, workshop: &Workshop) -> Result<(Outcome, Exit), Failure> {
    let settled = settle(job, workshop).and_then(|mut settled| {
        if let Settled::Written(written) = &mut settled {
            let start = Instant::now();
            let staged = written.staged.take().into_iter().collect();
            put_all(staged, workshop.args.sync, &workshop.context.exec).into_iter().collect::<Result<(), _>>()?;
            written.made.built.times.wait(start.elapsed());
        }
        finish(job, settled, workshop)
    });
    report(job, settled, workshop)
}

/// A failure is reported and counted, so that the other jobs go on; only a signal, which ends the whole run, comes back as an error.
fn report(
    job: &Job,
    settled: Result<(Outcome, String), Failure>,
    workshop: &Workshop,
) -> Result<(Outcome, Exit), Failure> {
    let terminal = &workshop.context.terminal;
    match settled {
        Ok((outcome, line)) => {
            if !terminal.json && !terminal.quiet {
                terminal.result(&line)?;
            }
            Ok((outcome, Exit::Success))
        }
        Err(failure) if failure.exit == Exit::Interrupted => Err(failure),
        Err(cause) => {
            let mut failure = Failure::new(cause.exit, format!("cannot build {}", names::path(&job.output)));
            failure.facts = std::iter::once(cause.action).chain(cause.facts).collect();
            failure.help = cause.help;
            terminal.error(&failure);
            let mut outcome = Outcome::new(job, Status::Failed);
            outcome.error = Some((&failure).into());
            Ok((outcome, failure.exit))
        }
    }
}

/// A job as far as it goes without others.
enum Settled {
    /// With the line that says what was done.
    Done(Box<Outcome>, String),
    Written(Box<Written>),
}

/// An output that is written, and not in its place yet.
struct Written {
    made: Made,
    staged: Option<Staged>,
    /// Why it was built.
    reason: String,
}

/// Do one job, but for putting its output in place.
fn settle(job: &Job, workshop: &Workshop) -> Result<Settled, Failure> {
    let (args, context) = (workshop.args, workshop.context);
    inputs::readable(job)?;
    outputs::is_no_pipe(&job.output)?;
    args.read.suit(&job.input, job.bytes.as_deref(), args.frames.plays())?;
    dependencies::ask(job, args)?;
    let recipe = match &job.frames {
        Some(frames) => &sequence::recipe(workshop, frames),
        None => &workshop.recipe,
    };
    let verdict = match args.force && !args.dry_run {
        true => plan::forced(job),
        false => plan::examine(job, recipe, args, context),
    };
    let name = names::path(&job.output);
    let reason = match verdict {
        Verdict::UpToDate { build_key, inputs } if !args.force => {
            let warnings = workshop.remembered(job)?;
            workshop.forgive_again(job, &warnings)?;
            warnings.iter().for_each(|warning| context.terminal.detail(&format!("{name}: {}", warning.text)));
            workshop.tell_unrecorded(job)?;
            if !args.dry_run {
                dependencies::write(job, args, &inputs, &workshop.strays, &context.terminal)?;
                if args.touch {
                    touch(&job.output)?;
                }
            }
            let build_key = hex(&build_key);
            let line = format!("{name}  up to date (key {})", &build_key[..8]);
            let outcome = Outcome { build_key: Some(build_key), warnings, ..Outcome::new(job, Status::UpToDate) };
            return Ok(Settled::Done(Box::new(outcome), line));
        }
        Verdict::UpToDate { .. } => "forced".to_string(),
        Verdict::Stale(reason) => reason,
    };
    if !args.force {
        outputs::may_replace(&job.output)?;
    }
    if args.dry_run {
        let from = job.frame.map_or_else(String::new, |_| format!(" from {}", names::path(&job.input)));
        // A folder that -o names is made by the build.
        if job.output.parent().is_none_or(Path::exists) || args.output.as_ref() == Some(&job.output) {
            outputs::writable(&job.output)?;
        }
        let (model, frames) = match &job.frames {
            Some(frames) => (None, format!(" ({})", workshop.rehearse_sequence(job, frames)?)),
            None => (Some(workshop.rehearse(job)?), String::new()),
        };
        let line = format!("{name}  would build{from}: {reason}{frames}");
        let warnings = model.as_ref().map_or_else(Vec::new, |model| model.arrival.warnings.clone());
        let outcome = Outcome { reason: Some(reason), model, warnings, ..Outcome::new(job, Status::WouldBuild) };
        return Ok(Settled::Done(Box::new(outcome), line));
    }

    // Build it, and make the folder first where -o names one.
    if reason != "missing" {
        context.terminal.detail(&format!("{name}: {reason}"));
    }
    if let Some(folder) = job.output.parent().filter(|_| args.output.as_ref() != Some(&job.output)) {
        std::fs::create_dir_all(folder).map_err(|e| io_failure("create", folder, &e))?;
    }
    outputs::writable(&job.output)?;
    let (made, staged) = match &job.frames {
        Some(frames) => (workshop.make_sequence(job, frames)?, None),
        None => workshop.make(job)?,
    };
    // Before the output takes its place: one that is new never has the depfile of an older one, or none.
    dependencies::write(job, args, &made.inputs, &workshop.strays, &context.terminal)?;
    Ok(Settled::Written(Box::new(Written { made, staged, reason })))
}

/// What is left once the output is in its place; the line says what was done.
fn finish(job: &Job, settled: Settled, workshop: &Workshop) -> Result<(Outcome, String), Failure> {
    let (mut made, reason) = match settled {
        Settled::Done(outcome, line) => return Ok((*outcome, line)),
        Settled::Written(written) => (written.made, written.reason),
    };
    // The system counts a process, and cannot tell what each of several builds holds.
    made.built.peak_memory = outcome::peak_memory().filter(|_| workshop.alone);
    let (args, context) = (workshop.args, workshop.context);
    if let Some(file_id) = made.file_id.filter(|_| !args.no_check) {
        workshop.check(job, file_id)?;
    }
    context.terminal.detail(&made.built.detail(job));
    let line = made.built.line(job);
    let outcome = Outcome {
        reason: Some(reason),
        build_key: Some(hex(&made.build_key)),
        warnings: std::mem::take(&mut made.built.arrival.warnings),
        built: Some(made.built),
        ..Outcome::new(job, Status::Built)
    };
    Ok((outcome, line))
}

fn touch(path: &Path) -> Result<(), Failure> {
    let file = std::fs::File::options().append(true).open(path);
    file.and_then(|f| f.set_modified(SystemTime::now())).map_err(|e| io_failure("touch", path, &e))
}

fn io_failure(verb: &str, path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(Exit::Io, format!("cannot {verb} {}", names::path(path))).fact(error.to_string())
}

fn summary(outcomes: &[Outcome]) -> String {
    let count = |status| outcomes.iter().filter(|o| o.status == status).count();
    let parts = [(Status::Built, "built"), (Status::WouldBuild, "would be built"), (Status::UpToDate, "up to date")];
    let failed = std::iter::once((Status::Failed, "failed"));
    let parts = parts.into_iter().chain(failed).map(|(status, text)| (count(status), text)).filter(|(n, _)| *n > 0);
    parts.map(|(n, text)| format!("{n} {text}")).collect::<Vec<_>>().join(", ")
}

/// `raw`, `zstd`, `compact`, or one of these two with `:LEVEL`.
pub fn parse_codec(text: &str) -> Result<Codec, String> {
    Codec::parse(text)
        .ok_or_else(|| "choose raw, zstd or compact, and after these two :LEVEL with a level of 1 to 22".to_string())
}
