//! What has to be done: which output each input has, and whether it is up to date, judged by content and never by time stamps.

use super::frames::{Frames, MOST_FRAMES, OneFrame};
use super::options::{NodeForm, nodes_change};
use super::{BuildArgs, Empty};
use crate::cache::keys::Recipe;
use crate::cache::{self, Codec, Freshness, SectionEntry, SectionKind};
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::identity::{Identity, same_file};
use crate::cli::names;
use crate::cli::numbered::way_out;
use crate::cli::outputs;
use crate::scene::Degenerate;
use crate::scene::frames::Pattern;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// One model.
#[derive(Debug)]
pub struct Input {
    pub path: PathBuf,
    /// Its content, if it came from standard input.
    pub bytes: Option<Vec<u8>>,
    /// Its number, if it is a frame, and the path that its pattern has for that number.
    pub frame: Option<(i32, PathBuf)>,
}

impl Input {
    /// Is it the file at this path?
    pub fn is(&self, path: &Path) -> bool {
        self.bytes.is_none() && same_file(&self.path, path)
    }
}

/// One output and what it is made from.
#[derive(Debug)]
pub struct Job {
    pub input: PathBuf,
    pub output: PathBuf,
    /// The model itself where it came from standard input; `input` then is only its name.
    pub bytes: Option<Vec<u8>>,
    /// The number of the frame, where it is one of a pattern.
    pub frame: Option<i32>,
    /// What a sequence is made from; `None` for a still file.
    pub frames: Option<Frames>,
}

/// Whether a job has anything to do.
#[derive(Clone, Debug)]
pub enum Verdict {
    UpToDate {
        build_key: [u8; 32],
        inputs: Vec<PathBuf>,
    },
    /// With the reason, as a phrase: `rock.bin changed`.
    Stale(String),
}

/// Name each input's output, and refuse what could lose data: two inputs for one output, or an output that is an input.
pub fn jobs(args: &BuildArgs, inputs: Vec<Input>) -> Result<Vec<Job>, Failure> {
    let refuse = |fact: String| Failure::new(Exit::Usage, "cannot build").fact(fact);
    let named = args.output.as_deref();
    let into_folder = named.is_some_and(outputs::is_folder);
    let pattern = pattern_of_output(args, &inputs, into_folder)?;
    let plays = args.frames.of_clip(args.read.model.clip.as_ref());
    if plays.is_some() && inputs.iter().any(|i| i.frame.is_some()) {
        return Err(refuse(
            "--fps and --play are about clips of glTF models, and an input is a pattern of files".into(),
        )
        .help("leave them out"));
    }
    if plays.is_some() && inputs.iter().any(|i| i.bytes.is_some()) {
        return Err(refuse("a clip is played from a file, and an input is standard input".into())
            .help("write the model to a file first"));
    }
    let has_place = |path: &Path| !args.frames.literal && Pattern::parse(path).is_some();
    if let Some(output) = named.filter(|path| plays.is_some() && has_place(path)) {
        let shown = names::path(output);
        return Err(refuse(format!("a clip becomes one file, and {shown} has a place for a frame's number"))
            .help("name a file without one, or add --literal"));
    }
    // One file for all frames of a pattern, where the output is a plain name.
    let inputs = match into_folder || pattern.is_some() || args.inputs.len() != 1 {
        false if !inputs.is_empty() && inputs.iter().all(|i| i.frame.is_some()) => {
            let frames = one_file(&inputs).map_err(refuse)?;
            let Some(output) = named else {
                return Err(refuse("the frames become one file, which has no name yet".into())
                    .help("name it with -o, for example -o frames.bvhc"));
            };
            let jobs = vec![Job { frames: Some(frames), ..still(inputs[0].path.clone(), output.to_owned()) }];
            return refuse_own_inputs(args, &inputs, jobs);
        }
        _ => inputs,
    };
    if let Some(output) = named.filter(|_| inputs.len() > 1 && !into_folder && pattern.is_none()) {
        let shown = names::path(output);
        let refused = refuse(format!("{} inputs need a folder to go to, and {shown} is not one", inputs.len()));
        let help = match inputs.iter().all(|i| i.frame.is_some()) {
            true => format!(
                "write -o {shown}/ to make it a folder, or give each frame a name by a pattern, such as '%04d.bvhc'"
            ),
            false => match Pattern::of_files(&inputs.iter().map(|i| i.path.as_path()).collect::<Vec<_>>()) {
                Some(pattern) => format!(
                    "write -o {shown}/ to make it a folder, or name frames of one file by a pattern, in quotes: bvhc build '{}' -o {shown}",
                    pattern.text()
                ),
                None => format!("write -o {shown}/ to make it a folder"),
            },
        };
        return Err(refused.help(help));
    }
    if args.depfile.phony && args.depfile.asked_by().is_none() {
        return Err(refuse("--depfile-phony is about depfiles, and none is asked for".into())
            .help("name one with --depfile FILE"));
    }
    if let Some(depfile) = &args.depfile.path {
        if inputs.len() > 1 {
            return Err(refuse("one --depfile describes one output, and there are several".into())
                .help("give each output one of its own with --depfile-dir DIR"));
        }
        if let Some(input) = inputs.iter().find(|i| i.is(depfile)) {
            return Err(refuse(format!("the depfile would overwrite the input {}", names::path(&input.path)))
                .help("name another file with --depfile"));
        }
    }

    // Give every input its output, and every output to one input.
    let mut owners: BTreeMap<PathBuf, PathBuf> = BTreeMap::new();
    let mut jobs = Vec::new();
    for Input { path: input, bytes, frame } in inputs {
        if (into_folder || named.is_none()) && bytes.is_some() {
            return Err(refuse("standard input has no name from which to name a file".into())
                .help("name the file itself with -o"));
        }
        let output = if let Some(folder) = named.filter(|_| into_folder) {
            // A frame that repeats another one keeps the name of its own.
            let named = frame.as_ref().map_or(&input, |(_, path)| path);
            let stem = named.file_stem().ok_or_else(|| refuse(format!("{} names no file", names::path(&input))))?;
            let mut name = stem.to_os_string();
            name.push(".bvhc");
            folder.join(name)
        } else if let (Some(pattern), Some((number, _))) = (&pattern, &frame) {
            pattern.path(*number)
        } else {
            named.map_or_else(|| input.with_extension("bvhc"), Path::to_owned)
        };
        if let Some(other) = owners.insert(outputs::place(&output), input.clone()) {
            if other == input {
                return Err(refuse(format!("{} is named twice", names::path(&input))).help("name it once"));
            }
            let fact = format!(
                "{} and {} would both become {}",
                names::path(&other),
                names::path(&input),
                names::path(&output)
            );
            return Err(refuse(fact).help("build one of them into another folder"));
        }
        let frame = frame.map(|(number, _)| number);
        jobs.push(Job { bytes, frame, frames: plays.clone(), ..still(input, output) });
    }
    refuse_own_inputs(args, &[], jobs)
}

fn still(input: PathBuf, output: PathBuf) -> Job {
    Job { input, output, bytes: None, frame: None, frames: None }
}

/// All frames of a pattern.
fn one_file(inputs: &[Input]) -> Result<Frames, String> {
    if inputs.len() > MOST_FRAMES {
        return Err(format!("there are {} frames, and a file holds at most {MOST_FRAMES}", inputs.len()));
    }
    let frame = |input: &Input| {
        let (number, path) = input.frame.as_ref()?;
        Some(OneFrame { number: *number, model: input.path.clone(), held: *path != input.path })
    };
    Ok(Frames::Files(inputs.iter().filter_map(frame).collect()))
}

/// An output is no input, nor the depfile.
fn refuse_own_inputs(args: &BuildArgs, frames: &[Input], jobs: Vec<Job>) -> Result<Vec<Job>, Failure> {
    let refuse = |fact: String| Failure::new(Exit::Usage, "cannot build").fact(fact);
    let of_jobs = jobs.iter().filter(|j| j.bytes.is_none()).map(|j| &j.input);
    let files = of_jobs.chain(frames.iter().map(|i| &i.path)).filter_map(|path| Some((Identity::of(path)?, path)));
    let files: BTreeMap<Identity, &PathBuf> = files.collect();
    let mut depfiles: BTreeMap<PathBuf, &PathBuf> = BTreeMap::new();
    for job in &jobs {
        suits(args, job)?;
        if let Some(input) = Identity::of(&job.output).and_then(|output| files.get(&output)) {
            return Err(refuse(format!("the output {} is the input {}", names::path(&job.output), names::path(input)))
                .help("name another output with -o"));
        }
        if args.depfile.path.as_ref().is_some_and(|d| *d == job.output || same_file(d, &job.output)) {
            return Err(refuse("--depfile and -o name the same file".into()).help("name another file with --depfile"));
        }
        let Some(depfile) = args.depfile.dir.as_ref().and_then(|_| args.depfile.of(&job.output)) else { continue };
        let shown = names::path(&depfile);
        if let Some(other) = depfiles.insert(depfile, &job.output) {
            return Err(refuse(format!(
                "{} and {} would both have the depfile {shown}",
                names::path(other),
                names::path(&job.output)
            ))
            .help("build one of them by another call"));
        }
    }
    Ok(jobs)
}

/// Refuse flags that the kind of the file does not read.
fn suits(args: &BuildArgs, job: &Job) -> Result<(), Failure> {
    let refuse =
        |fact: String| Failure::new(Exit::Usage, format!("cannot build {}", names::path(&job.output))).fact(fact);
    if let (Some(_), Some((flag, why))) = (&job.frames, args.frames.idle()) {
        return Err(refuse(format!("{flag} has no effect: {why}")).help(format!("leave out {flag}")));
    }
    match (&job.frames, args.frames.of_sequences(), args.read.model.degenerate) {
        (None, Some(flag), _) => {
            Err(refuse(format!("{flag} is about the trees of a sequence, and this becomes a still file"))
                .help(format!("leave out {flag}")))
        }
        (Some(_), _, Some(Degenerate::Drop)) => Err(refuse(
            "--degenerate drop is about still files: a triangle without area may have one in another frame".into(),
        )
        .help("leave it out: rays do not hit such triangles anyway")),
        (Some(_), ..) if NodeForm::any_compact(&args.nodes) => Err(refuse(
            "--nodes compact8 is about still files: the boxes of a sequence change from frame to frame".into(),
        )
        .help("leave it out, or take a frame out later: bvhc convert FILE -o OUT --frame N --nodes compact8")),
        (Some(_), ..) if args.orient => Err(refuse(
            "--orient is about still files: what pays in one frame of a sequence may not pay in another".into(),
        )
        .help("leave it out")),
        _ if args.orient && NodeForm::any_compact(&args.nodes) => Err(refuse(
            "--nodes compact8 and --orient each add what rays are traced in, and a ray is traced in one of them".into(),
        )
        .help("leave out --orient")),
        _ => Ok(()),
    }
}

/// The pattern that names an output for each frame; `None` for a folder and for a plain name.
fn pattern_of_output(args: &BuildArgs, inputs: &[Input], into_folder: bool) -> Result<Option<Pattern>, Failure> {
    if args.frames.literal || into_folder || !inputs.iter().all(|i| i.frame.is_some()) {
        return Ok(None);
    }
    let refuse = |fact: String| Failure::new(Exit::Usage, "cannot build").fact(fact);
    let Some(output) = &args.output else { return Ok(None) };
    let shown = || names::path(output);
    match Pattern::parse(output) {
        None => Ok(None),
        Some(Err(why)) => {
            Err(refuse(format!("as a pattern of outputs, {} is wrong: {why}", shown())).help(way_out(&why)))
        }
        Some(Ok(pattern)) if pattern.numbers.is_some() => {
            Err(refuse(format!("{} has a list of frames, and outputs have the numbers of their inputs", shown()))
                .help("choose frames by --frames"))
        }
        Some(Ok(pattern)) => Ok(Some(pattern)),
    }
}

/// What is built whatever its output is like: nothing is read to find out.
pub fn forced(job: &Job) -> Verdict {
    Verdict::Stale(if job.output.exists() { "forced" } else { "missing" }.into())
}

/// Compare an output with what building it now would give.
///
/// Every byte of the output is read and hashed, as those of the inputs are, and everything in it is held against the rules: a damaged or
/// forged file is not up to date.
pub fn examine(job: &Job, recipe: &Recipe, args: &BuildArgs, context: &Context) -> Verdict {
    let exec = &context.exec;
    let found = match &job.bytes {
        Some(bytes) => cache::freshness_of_bytes(&job.output, bytes, recipe, exec),
        None => cache::freshness(&job.output, &job.input, recipe, exec),
    };
    match found {
        Freshness::Stale(reason) => Verdict::Stale(names::escape(&reason.to_string())),
        Freshness::Fresh { head, inputs } => {
            if head.header.prim_count == 0 && args.empty == Empty::Error {
                return Verdict::Stale("there is no triangle in it".to_string());
            }
            let sections = &head.sections;
            if let Some(reason) = codec_change(sections, args.codec).or_else(|| nodes_change(sections, &args.nodes)) {
                return Verdict::Stale(reason.to_string());
            }
            match cache::intact(&job.output, &head, &caches::options(context), exec) {
                Ok(()) => Verdict::UpToDate { build_key: head.header.build_key, inputs },
                Err(error) => Verdict::Stale(names::escape(&error.to_string().replace('\n', " "))),
            }
        }
    }
}

/// Does the file's storage differ from what was asked for? The level of zstd does not count: it is not in the file. A section that gains nothing stays raw, so a file too small to
/// gain counts as either; a large one always gains, but for poses that are stored as differences: they may gain nothing.
fn codec_change(sections: &[SectionEntry], codec: Codec) -> Option<&'static str> {
    const ALWAYS_GAINS: u64 = 64 << 10;
    let any = |of: &dyn Fn(&SectionEntry) -> bool| sections.iter().any(of);
    let moves = any(&|s| s.codec == SectionEntry::DELTA);
    let packed = any(&|s| s.codec == SectionEntry::ZSTD) || moves;
    let large = any(&|s| s.raw_len >= ALWAYS_GAINS);
    // What differences are made of, all together: each section by itself may be small.
    let of_poses = [SectionKind::NODE, SectionKind::TRIX, SectionKind::VPOS];
    let moving = sections.iter().filter(|s| of_poses.contains(&s.kind)).map(|s| s.raw_len).sum::<u64>();
    let poses = any(&|s| s.kind == SectionKind::VPOS) && moving >= ALWAYS_GAINS;
    match codec {
        Codec::Raw if moves => Some("codec compact → raw"),
        Codec::Raw if packed => Some("codec zstd → raw"),
        Codec::Zstd { .. } if moves => Some("codec compact → zstd"),
        Codec::Compact { .. } if !packed && poses => Some("codec raw → compact"),
        Codec::Compact { .. } if !moves && poses => Some("codec zstd → compact"),
        Codec::Zstd { .. } | Codec::Compact { .. } if !packed && large => Some("codec raw → zstd"),
        _ => None,
    }
}
