//! `bvhc verify`: rays traced through cache files on every asked device, and judged by brute force.
//!
//! `devices` chooses and opens the devices, `file` verifies one file, `text`, `document` and `junit` say what came of it, and `ray` traces
//! a single ray again with a log. `accuracy` is another question about the same files.

mod accuracy;
mod devices;
mod document;
mod file;
mod junit;
mod ray;
mod text;
#[cfg(feature = "opencl")]
mod watchdog;

use crate::cli::Context;
use crate::cli::caches;
use crate::cli::drawing;
use crate::cli::exit::Exit;
use crate::cli::failure::{Entry, Failure};
use crate::cli::figures;
use crate::cli::frame_list::FrameList;
use crate::cli::names;
use crate::cli::patterns;
use crate::cli::source::SourceReading;
use crate::geom::Ray;
use crate::trace::rays::RaySet;
use crate::verify::{Asked, Plan, Reference, SETS, read_ray, set_named};
use clap::{Args, ValueEnum};
use devices::{Bench, Wanted};
use document::{Document, FileDocument};
use file::Verified;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Trace rays through cache files on the CPU and on OpenCL devices, and prove the hits right
///
/// Rays look for trouble: aimed at vertices and edges, parallel to axes, started on surfaces. The CPU traces all of them, and each
/// device must find what the CPU finds; brute force over the triangles judges a sample and every difference. Any hit is asked
/// too: it must be found exactly where there is a closest hit. Exit code 0: all right; 1: a wrong hit, told with the ray that shows
/// it and the record that is to blame.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  bvhc verify rock.bvhc --source rock.glb\n  bvhc verify *.bvhc --device all --rays 10M --junit verify.xml\n  bvhc verify rock.bvhc --ray 0.5,0.2,-3,0,0,1\n  bvhc verify rock.bvhc --accuracy --svg rock.svg\n  bvhc verify --list-devices"
)]
pub struct VerifyArgs {
    /// Cache files, folders of them, or quoted patterns such as 'caches/**/*.bvhc'
    #[arg(required_unless_present = "list_devices", value_name = "FILE")]
    files: Vec<PathBuf>,
    /// The model that the files should hold; without it, their own triangles are taken to be right
    #[arg(long, value_name = "MODEL")]
    source: Option<PathBuf>,
    #[command(flatten)]
    reading: SourceReading,
    /// Of sequences: the frames to verify, each against its own triangles: all, or numbers such as 7, 1-100 or 1,5-9
    #[arg(long = "frame", value_name = "all|LIST", value_parser = FrameList::parse, allow_hyphen_values = true)]
    #[arg(conflicts_with_all = ["source", "ray", "accuracy"])]
    frames: Option<FrameList>,
    /// Where to trace: cpu, opencl, opencl:N or all; may be given again. The CPU traces in any case, since its hits are what the
    /// others are compared with [default: opencl where there is a device, else cpu]
    #[arg(long = "device", value_name = "DEVICE", value_parser = devices::parse)]
    devices: Vec<Wanted>,
    /// Show the OpenCL devices
    #[arg(long, conflicts_with_all = ["files", "source", "frames", "devices", "rays", "seed", "rays_from", "any_hit", "reference", "judge", "junit", "ray"])]
    list_devices: bool,
    /// Fail with 5 where there is no usable OpenCL device
    #[arg(long)]
    require_device: bool,
    /// Rays to trace, in equal shares from every set, but for a hundredth of one from `far` [default: 1M, fewer where each enters thousands of nodes and triangles; with --accuracy at most 100k, fewer in large scenes; the frames of a sequence share the 1M, at least 20k each]
    #[arg(long, value_name = "N", value_parser = ray_count)]
    rays: Option<u64>,
    /// Equal seeds give equal rays
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[arg(long, value_name = "SETS", value_delimiter = ',', default_value = "all", value_parser = parse_sets, help = sets_help())]
    rays_from: Vec<Sets>,
    /// Ask only for any hit, as shadow rays do
    #[arg(long)]
    any_hit: bool,
    /// What judges
    #[arg(long, value_enum, value_name = "WHAT", default_value = "bvh")]
    reference: ReferenceName,
    /// Rays that brute force judges in its sample, in equal shares from every set [default: as many as take it a few seconds]
    #[arg(long, value_name = "N", value_parser = ray_count)]
    judge: Option<u64>,
    /// Give up where a device has not come back from one call for so long; calls are made to take less than a second. 0s waits for ever [default: 120s]
    #[arg(long, value_name = "TIME", value_parser = figures::parse_seconds)]
    device_timeout: Option<Duration>,
    /// Write a JUnit report for CI: a suite for each file, a case for each device and set of rays
    #[arg(long, value_name = "FILE", conflicts_with = "ray")]
    junit: Option<PathBuf>,
    /// Trace this one ray and show all that traversal does: ox,oy,oz,dx,dy,dz[,tmin,tmax]
    #[arg(long, value_name = "RAY", allow_hyphen_values = true, value_parser = read_ray)]
    #[arg(conflicts_with_all = ["rays", "seed", "rays_from", "any_hit", "reference", "judge"])]
    ray: Option<Ray>,
    /// Trace instead by a dozen arithmetics, from plain f32 to ours, and count for each what brute force finds wrong, how far
    /// distances are off, and how fast it is on one thread of this machine
    #[arg(long)]
    #[arg(conflicts_with_all = ["devices", "list_devices", "require_device", "rays_from", "any_hit", "reference", "judge", "device_timeout", "junit", "ray"])]
    accuracy: bool,
    /// Draw speed against accuracy, of several files together
    #[arg(long, value_name = "FILE", requires = "accuracy")]
    svg: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ReferenceName {
    /// The CPU's traversal, and brute force for a sample and for every difference
    Bvh,
    /// Brute force for every ray: slow in large scenes
    Brute,
}

/// What a name of `--rays-from` stands for.
#[derive(Clone, Debug, PartialEq)]
struct Sets(Vec<RaySet>);

/// No rays prove nothing.
fn ray_count(text: &str) -> Result<u64, String> {
    match figures::parse_count(text)? {
        0 => Err("no ray proves nothing; write 1 or more".to_string()),
        count => Ok(count),
    }
}

fn set_names() -> String {
    SETS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

fn sets_help() -> String {
    format!("Sets of rays, separated by commas: {} or all", set_names())
}

fn parse_sets(text: &str) -> Result<Sets, String> {
    if text == "all" {
        return Ok(Sets(SETS.iter().map(|(_, set)| *set).collect()));
    }
    let unknown = || format!("`{text}` is no set of rays; there are {} and all", set_names());
    set_named(text).map(|set| Sets(vec![set])).ok_or_else(unknown)
}

/// More than any compiler of kernels has taken.
#[cfg(feature = "opencl")]
const DEVICE_TIMEOUT: Duration = Duration::from_secs(120);

/// Refuse flags that the others leave without effect.
fn reads_all(args: &VerifyArgs) -> Result<(), Failure> {
    let on_cpu = !args.devices.is_empty() && args.devices.iter().all(|device| *device == Wanted::Cpu);
    let refuse = |flag: &str, fact: &str| {
        Err(Failure::new(Exit::Usage, format!("cannot verify with {flag}"))
            .fact(fact)
            .help(format!("leave out {flag}")))
    };
    if args.judge.is_some() && matches!(args.reference, ReferenceName::Brute) {
        return refuse("--judge", "with --reference brute, every ray is judged");
    }
    if args.device_timeout.is_some() && on_cpu && !args.require_device {
        return refuse("--device-timeout", "it is about OpenCL devices, and --device names the CPU alone");
    }
    Ok(())
}

pub fn run(args: &VerifyArgs, context: &Context) -> Result<Exit, Failure> {
    reads_all(args)?;
    #[cfg(feature = "opencl")]
    watchdog::watch(args.device_timeout.unwrap_or(DEVICE_TIMEOUT), args.junit.clone(), context);
    if args.list_devices {
        return devices::list(context);
    }
    args.reading.suits(args.source.as_ref())?;
    args.junit.iter().chain(&args.svg).try_for_each(|path| drawing::may_replace(path))?;
    if args.accuracy {
        return accuracy::run(args, context);
    }
    let opened = Instant::now();
    let bench = Bench::open(&args.devices, args.require_device, context);
    if let (Err(failure), Some(path)) = (&bench, &args.junit) {
        // A CI system that finds no report may take the step for one that did not run.
        junit::write(path, &[junit::without_devices(failure, opened.elapsed())])?;
    }
    let bench = bench?;
    if let Some(ray) = &args.ray {
        return ray::run(ray, args, &bench, context);
    }
    let plan = plan(args);
    let mut verdicts = Verdicts {
        context,
        plan: &plan,
        documents: Vec::new(),
        suites: Vec::new(),
        exits: Vec::new(),
        frames: FrameSum::default(),
    };
    for path in &patterns::expand(&args.files, patterns::CACHES, "verify", &context.terminal)? {
        let mut start = Instant::now();
        // A sequence is verified frame by frame, whether or not it was asked for.
        let is_sequence = caches::is_sequence(path, context);
        if let Some(model) = args.source.as_ref().filter(|_| is_sequence) {
            verdicts.fail(path, None, not_of_a_model(path, model));
            continue;
        }
        let whole = is_sequence;
        let done = match args.frames.as_ref().or(whole.then_some(&FrameList::All)) {
            None => verdicts.take(path, None, file::verify(path, args, &plan, &bench, context), start.elapsed()),
            Some(frames) => {
                verdicts.frames = FrameSum::default();
                let done = file::verify_frames(path, frames, args, &plan, &bench, context, |number, result| {
                    let took = std::mem::replace(&mut start, Instant::now()).elapsed();
                    verdicts.take(path, Some(number), result, took)
                });
                done.and_then(|()| verdicts.sum(path))
            }
        };
        match done {
            Ok(()) => {}
            Err(failure) if failure.exit == Exit::Interrupted => {
                verdicts.fail(path, None, failure);
                break;
            }
            Err(failure) => verdicts.fail(path, None, failure),
        }
    }
    let Verdicts { documents, suites, exits, .. } = verdicts;
    if let Some(path) = &args.junit {
        junit::write(path, &suites)?;
    }
    let exit = Exit::combine_verdicts(&exits);
    if context.terminal.json {
        context.terminal.document(&Document::new(exit, &plan, &documents))?;
    }
    Ok(exit)
}

/// Why a sequence is not verified against a model.
fn not_of_a_model(path: &Path, model: &Path) -> Failure {
    let (file, model) = (names::path(path), names::path(model));
    Failure::new(Exit::Usage, format!("cannot verify {file} against {model}"))
        .fact("it is a sequence, and each of its frames is verified against its own triangles")
        .help(format!("leave out --source; whether the frames are those of the model is told by: bvhc check {file} --source {model}"))
}

/// What the frames of a sequence come to.
#[derive(Clone, Copy, Debug, Default)]
struct FrameSum {
    frames: u64,
    right: u64,
    /// Of the first device.
    rays: u64,
    hits: u64,
    /// Of all devices.
    mismatches: u64,
}

impl FrameSum {
    fn add(&mut self, verified: &Verified) {
        let totals: Vec<_> = verified.outcome.devices.iter().map(|device| device.total()).collect();
        self.frames += 1;
        self.right += u64::from(verified.is_right());
        self.rays += totals.first().map_or(0, |total| total.rays);
        self.hits += totals.first().map_or(0, |total| total.hits);
        self.mismatches += totals.iter().map(|total| total.mismatches()).sum::<u64>();
    }
}

/// What came of the files so far.
struct Verdicts<'a> {
    context: &'a Context,
    plan: &'a Plan,
    documents: Vec<Entry<FileDocument>>,
    suites: Vec<junit::Suite>,
    exits: Vec<Exit>,
    /// Of the sequence at hand.
    frames: FrameSum,
}

impl Verdicts<'_> {
    /// Tell the verdict on a file or a frame of one. Only an interruption comes back as an error.
    fn take(
        &mut self,
        path: &Path,
        frame: Option<i32>,
        result: Result<Verified, Failure>,
        took: Duration,
    ) -> Result<(), Failure> {
        self.suites.push(junit::suite(path, frame, &result, took));
        let verified = match result {
            Ok(verified) => verified,
            Err(failure) if failure.exit == Exit::Interrupted => return Err(failure),
            Err(failure) => {
                self.fail(path, frame, failure);
                return Ok(());
            }
        };
        let terminal = &self.context.terminal;
        if !(terminal.json || terminal.quiet && verified.is_right()) {
            terminal.print(&text::verdict(&verified, self.plan, self.context))?;
        }
        self.frames.add(&verified);
        self.exits.push(verified.exit());
        self.documents.push(Entry::Done(FileDocument::new(&verified)));
        Ok(())
    }

    /// Tell what the frames of a sequence come to.
    fn sum(&self, path: &Path) -> Result<(), Failure> {
        let terminal = &self.context.terminal;
        let is_right = self.frames.right == self.frames.frames;
        if self.frames.frames < 2 || terminal.json || terminal.quiet && is_right {
            return Ok(());
        }
        terminal.print(&text::sum(path, &self.frames, self.context))
    }

    fn fail(&mut self, path: &Path, frame: Option<i32>, failure: Failure) {
        self.context.terminal.error(&failure);
        self.exits.push(failure.exit);
        self.documents.push(Entry::failed(path, frame, &failure));
    }
}

fn plan(args: &VerifyArgs) -> Plan {
    // Each set once, in the order of the registry, however they were asked for.
    let wanted = |set: &RaySet| args.rays_from.iter().any(|sets| sets.0.contains(set));
    Plan {
        rays: args.rays.unwrap_or(Plan::default().rays),
        seed: args.seed,
        sets: SETS.iter().map(|(_, set)| *set).filter(wanted).collect(),
        asked: if args.any_hit { Asked::AnyHit } else { Asked::Both },
        reference: match args.reference {
            ReferenceName::Bvh => Reference::Bvh,
            ReferenceName::Brute => Reference::Brute,
        },
        judged: args.judge,
        ..Plan::default()
    }
}
