//! Frames of a sequence: which files a pattern such as `heli.%04d.obj` stands for, what is missing, and how a clip is played.

mod chosen;

use crate::build::Named;
use crate::cli::commands::build::remarks::{Kind, Remark};
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::cli::names;
use crate::cli::numbered;
use crate::cli::reading::choice;
use crate::scene::Seconds;
use crate::scene::frames::{MOST_NUMBERS, Numbers, Pattern, ranges};
use crate::sequence::{Refit, RefitPolicy, Trees};
pub use chosen::{Frames, MOST_FRAMES, OneFrame, clip_of};
use clap::{Args, ValueEnum};
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Frames")]
pub struct FrameArgs {
    /// Frames of the patterns among the inputs, such as 1-100, 1-100x5 or 1,5,10-20; default: from the first
    /// to the last that is there
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    pub frames: Option<Numbers>,
    /// What to do where a frame is not there [default: error]
    #[arg(long, value_enum, value_name = "POLICY")]
    pub missing: Option<Missing>,
    /// Play a glTF clip as a sequence with so many frames a second, or `auto`: as many as its keys have where
    /// they are uniform, else 24
    #[arg(long, value_name = "N|auto", value_parser = Fps::parse, conflicts_with = "time")]
    pub fps: Option<Fps>,
    /// Play only this stretch of a glTF clip, in seconds, such as 0.5..2; without --fps as `--fps auto`
    #[arg(long, value_name = "FROM..TO", value_parser = stretch, conflicts_with = "time", allow_hyphen_values = true)]
    pub play: Option<(Seconds, Seconds)>,
    /// Whether the trees of a sequence are refitted to what moved [default: auto]
    #[arg(long, value_name = "MODE", value_parser = choice::<Refit>())]
    pub refit: Option<Refit>,
    /// How many trees a mesh of a sequence may have for all its frames, each of which takes the best: 1 to 8, or auto, which is
    /// up to 3 where more pay; `first` builds the tree for the frame that shows the mesh first, which reads no frame twice [default: auto]
    #[arg(long, value_name = "N|auto|first", value_parser = tree_choice)]
    trees: Option<TreeChoice>,
    /// Build a tree of a sequence anew where refitting has raised its SAH cost to so many times what it was [default: 1.2]
    #[arg(long, value_name = "RATIO", value_parser = ratio)]
    rebuild_ratio: Option<f32>,
    /// Build a mesh's tree anew after at most N poses, so that later frames need no earlier tree and, with --codec compact, no earlier frame,
    /// unless a mesh stands as before. Implies --trees first
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_FRAMES as i64), conflicts_with = "trees")]
    keyframe_every: Option<u32>,
    /// Take inputs and output as plain names, without frames and without *, ? and []
    #[arg(long)]
    pub literal: bool,
}

/// How many frames of a clip make a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fps {
    Auto,
    Rate(f64),
}

impl Fps {
    fn parse(text: &str) -> Result<Fps, String> {
        match text.parse::<f64>() {
            _ if text == "auto" => Ok(Fps::Auto),
            Ok(rate) if rate > 0.0 && rate <= 1e6 => Ok(Fps::Rate(rate)),
            _ => Err("choose auto, or frames a second above 0 and up to 1000000, such as 24".to_string()),
        }
    }
}

impl Named for Refit {
    const KIND: &'static str = "mode";

    fn names() -> Vec<(Self, &'static str)> {
        vec![(Refit::Auto, "auto"), (Refit::Never, "never"), (Refit::Always, "always")]
    }
}

/// Whether trees are made for all frames together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeChoice {
    First,
    Surveyed(Trees),
}

impl std::fmt::Display for TreeChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            TreeChoice::Surveyed(Trees::AtMost(most)) => most.fmt(f),
            TreeChoice::Surveyed(_) => f.write_str("auto"),
            TreeChoice::First => f.write_str("first"),
        }
    }
}

fn tree_choice(text: &str) -> Result<TreeChoice, String> {
    match (text, text.parse()) {
        ("first", _) => Ok(TreeChoice::First),
        ("auto", _) => Ok(TreeChoice::Surveyed(Trees::Auto)),
        (_, Ok(most @ 1..=8)) => Ok(TreeChoice::Surveyed(Trees::AtMost(most))),
        _ => Err("choose 1 to 8, auto or first".to_string()),
    }
}

fn stretch(text: &str) -> Result<(Seconds, Seconds), String> {
    let both = text.split_once("..").and_then(|(from, to)| Some((from.parse().ok()?, to.parse().ok()?)));
    both.filter(|(from, to): &(Seconds, Seconds)| from <= to)
        .ok_or_else(|| "a stretch is two times in seconds, the earlier one first, such as 0.5..2".to_string())
}

fn ratio(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|ratio| (1.0..=1e6).contains(ratio))
        .ok_or_else(|| "a ratio is 1 or more, such as 1.2".to_string())
}

impl FrameArgs {
    /// When trees are built anew.
    pub fn policy(&self) -> RefitPolicy {
        let default = RefitPolicy::default();
        RefitPolicy {
            refit: self.refit.unwrap_or(default.refit),
            rebuild_ratio: self.rebuild_ratio.unwrap_or(default.rebuild_ratio),
            keyframe_every: self.keyframe_every.and_then(NonZeroU32::new),
        }
    }

    /// Whether trees are made for all frames together.
    pub fn trees(&self) -> TreeChoice {
        let default = if self.keyframe_every.is_some() { TreeChoice::First } else { TreeChoice::Surveyed(Trees::Auto) };
        self.trees.unwrap_or(default)
    }

    /// The first flag that was given and that plays a clip.
    pub fn plays(&self) -> Option<&'static str> {
        self.fps.map(|_| "--fps").or(self.play.map(|_| "--play"))
    }

    /// The first flag that was given and that says nothing beside `--refit`, and why.
    pub fn idle(&self) -> Option<(&'static str, &'static str)> {
        match self.policy().refit {
            Refit::Never => [
                ("--trees", self.trees.is_some()),
                ("--rebuild-ratio", self.rebuild_ratio.is_some()),
                ("--keyframe-every", self.keyframe_every.is_some()),
            ]
            .into_iter()
            .find_map(|(flag, is_given)| is_given.then_some(flag))
            .map(|flag| (flag, "with --refit never, every frame has trees of its own")),
            Refit::Always if self.rebuild_ratio.is_some() => {
                Some(("--rebuild-ratio", "with --refit always, no tree is built anew for what refitting costs"))
            }
            _ => None,
        }
    }

    /// The first flag that was given and that only a sequence reads.
    pub fn of_sequences(&self) -> Option<&'static str> {
        let given = [
            ("--refit", self.refit.is_some()),
            ("--trees", self.trees.is_some()),
            ("--rebuild-ratio", self.rebuild_ratio.is_some()),
            ("--keyframe-every", self.keyframe_every.is_some()),
        ];
        given.into_iter().find_map(|(flag, is_given)| is_given.then_some(flag))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Missing {
    /// Build nothing
    Error,
    /// Leave the frame out
    Skip,
    /// Build the frame before it once more
    Hold,
}

/// One frame of a pattern.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    pub number: i32,
    /// The path that names it: of its file, or the one that the pattern has for a frame that is held.
    pub path: PathBuf,
    /// The file that is there: another one for a frame that is held.
    pub model: PathBuf,
}

/// What a pattern stands for.
#[derive(Debug)]
pub struct Sequence {
    pub frames: Vec<Frame>,
    /// What a user would want to know of it, to be printed as it is.
    pub summary: String,
    /// What might not be meant, as warnings.
    pub warnings: Vec<String>,
    /// Those of them that `--missing` does not ask for.
    pub unasked: Vec<Remark>,
}

/// The frames of a path that is a pattern; `None` for one that is a plain name or exists.
pub fn resolve(path: &Path, args: &FrameArgs) -> Option<Result<Sequence, Failure>> {
    if args.literal {
        return None;
    }
    Some(numbered::pattern(path, "build")?.and_then(|pattern| find(path, &pattern, args)))
}

fn find(path: &Path, pattern: &Pattern, args: &FrameArgs) -> Result<Sequence, Failure> {
    let shown = names::path(path);
    let refuse = |exit, fact: String| Failure::new(exit, format!("cannot build {shown}")).fact(fact);
    let wanted = match (&args.frames, &pattern.numbers) {
        (Some(_), Some(_)) => {
            return Err(refuse(Exit::Usage, "the name has a list of frames, and --frames gives another one".into())
                .help("leave out one of them"));
        }
        (numbers, None) | (None, numbers) => numbers.as_ref(),
    };
    let folder = numbered::folder(path, pattern, "build")?;
    let there = {
        let ends = folder.files.keys().next().zip(folder.files.keys().next_back());
        let (first, last) = ends.map_or((0, 0), |(first, last)| (*first, *last));
        format!("{}, {first} to {last}", figures::counted(folder.files.len() as u64, "frame", "frames"))
    };

    // Go through the numbers in order, and see to those that have no file.
    let policy = args.missing.unwrap_or(Missing::Error);
    let numbers = wanted.map_or_else(|| folder.expected(), |list| Some(list.list().to_vec())).ok_or_else(|| {
        refuse(
            Exit::Usage,
            format!("there are {there}, and a sequence has at most {} frames", figures::count(MOST_NUMBERS as u64)),
        )
        .help("choose frames by --frames")
    })?;
    let absent: Vec<i32> = numbers.iter().copied().filter(|n| !folder.files.contains_key(n)).collect();
    let gaps = ranges(&absent);
    let missing = match absent.len() {
        1 => format!("frame {gaps} is missing"),
        n => format!("{} frames are missing: {gaps}", figures::count(n as u64)),
    };
    if !absent.is_empty() && policy == Missing::Error {
        return Err(
            refuse(Exit::Io, format!("{missing}; there are {there}")).help("leave such frames out with --missing skip")
        );
    }
    let mut frames: Vec<Frame> = Vec::new();
    for number in numbers {
        match (folder.files.get(&number), frames.last(), policy) {
            (Some(name), ..) => {
                let path = pattern.file(name);
                frames.push(Frame { number, model: path.clone(), path });
            }
            (None, Some(before), Missing::Hold) => {
                let model = before.model.clone();
                frames.push(Frame { number, path: pattern.path(number), model });
            }
            (None, None, Missing::Hold) => {
                return Err(refuse(
                    Exit::Io,
                    format!("frame {number} is missing, and there is none before it to hold"),
                )
                .help("begin with a frame that is there, by --frames"));
            }
            (None, ..) => {}
        }
    }
    if frames.is_empty() {
        return Err(refuse(Exit::Io, format!("no frame of --frames is there; there are {there}"))
            .help("choose among those by --frames, or leave it out"));
    }

    let mut warnings = Vec::new();
    if !absent.is_empty() {
        let done = if policy == Missing::Hold { "the frame before is held" } else { "left out" };
        warnings.push(format!("{shown}: {missing} ({done})"));
    }
    let asked = warnings.len();
    warnings.extend(numbered::left_out(path, &folder));
    let summary = format!("{shown}: {there}");
    let unasked = warnings[asked..].iter().map(|warning| Kind::Frames.remark(warning)).collect();
    Ok(Sequence { frames, summary, warnings, unasked })
}

#[cfg(test)]
mod tests;
