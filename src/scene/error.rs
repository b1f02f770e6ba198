use super::animation::{Animation, AnimationChoice};
use super::resemblance::Resemblance;
use crate::size::beyond;
use std::fmt;
use std::path::{Path, PathBuf};

pub(super) use super::excerpt::clipped;

/// Why a model was not read: data, which a program puts into its own words.
///
/// It is an [action](SceneError::action) that failed and the [facts](SceneError::facts) that stopped it; its text is both in one line. None of them names
/// a flag of the command line, nor the error's [source](std::error::Error::source).
#[derive(Debug)]
#[non_exhaustive]
pub enum SceneError {
    /// The model cannot be opened or read.
    Unreadable {
        /// The model.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file that the model names cannot be opened.
    MissingBuffer {
        /// The model.
        model: PathBuf,
        /// Number of the glTF buffer.
        buffer: usize,
        /// The file that it names.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The model names a file outside of its folder: see [`ReadOptions::allow_outside`](super::ReadOptions::allow_outside).
    OutsideFolder {
        /// The model.
        model: PathBuf,
        /// Number of the glTF buffer.
        buffer: usize,
        /// What it names.
        uri: String,
        /// Where that leads.
        why: &'static str,
    },
    /// The model breaks its format.
    Malformed {
        /// The model.
        path: PathBuf,
        /// The line, where the format has lines.
        line: Option<u64>,
        /// What is wrong.
        reason: String,
    },
    /// A text without any statement of an OBJ model.
    NotObj {
        /// The file.
        path: PathBuf,
        /// How it begins.
        found: String,
        /// What it may be instead.
        resembles: Resemblance,
    },
    /// What stands in the place of a glTF model or of one of its buffers.
    InPlaceOfData {
        /// The model.
        path: PathBuf,
        /// The file itself, or a buffer and the file that it names.
        what: String,
        /// What it is.
        resembles: Resemblance,
    },
    /// [`Degenerate::Error`](super::Degenerate::Error) and triangles that it refuses.
    Degenerate {
        /// The model.
        path: PathBuf,
        /// Triangles without area.
        degenerate: u64,
        /// Triangles with NaN or infinite corners.
        non_finite: u64,
        /// Triangles with corners that `f32` cannot hold.
        out_of_range: u64,
        /// Number of the first of them in its mesh.
        first: u64,
        /// That mesh.
        mesh: String,
    },
    /// Neither the file's name nor its content is that of a model.
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The model needs a glTF extension that is not read: see [`ReadOptions::ignore_extensions`](super::ReadOptions::ignore_extensions).
    UnsupportedExtension {
        /// The model.
        path: PathBuf,
        /// Name of the extension.
        extension: String,
        /// What it does to triangles.
        why: &'static str,
        /// Whether the data are there without it, so that it can be ignored.
        ignorable: bool,
    },
    /// The model is of another version of glTF.
    UnsupportedVersion {
        /// The model.
        path: PathBuf,
        /// The version that it needs.
        version: String,
    },
    /// There is no animation such as [`ReadOptions::moment`](super::ReadOptions::moment) asks for, or more than one.
    NoSuchAnimation {
        /// The model.
        path: PathBuf,
        /// Which animation was meant.
        asked: AnimationChoice,
        /// How many animations that may be: none, or several.
        found: u64,
        /// How many animations the model has.
        count: u64,
        /// They, or the first of them.
        animations: Vec<Animation>,
    },
    /// There is no scene of the number that [`ReadOptions::scene`](super::ReadOptions::scene) asks for.
    NoSuchScene {
        /// The model.
        path: PathBuf,
        /// Which scene was meant.
        asked: u32,
        /// How many scenes the model has.
        count: u64,
    },
    /// [`ReadOptions::max_memory`](super::ReadOptions::max_memory) is too small.
    Memory {
        /// The model.
        path: PathBuf,
        /// What is to be held.
        what: String,
        /// Bytes that would be needed.
        need: u64,
        /// Bytes that may be used.
        limit: u64,
    },
    /// More than 32-bit numbers count, or than can be cut.
    TooMany {
        /// The model.
        path: PathBuf,
        /// The line, where one alone is too much.
        line: Option<u64>,
        /// What there is too much of, with its number.
        what: String,
        /// The largest number.
        limit: u64,
    },
}

/// What a caller can do about a [`SceneError`]; the command line maps each kind to one exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A file cannot be opened or read.
    Io,
    /// The model breaks its format or a stated policy.
    BadModel,
    /// The model is fine, but uses what this program does not read.
    Unsupported,
    /// Reading would take more than it may.
    Limit,
}

impl SceneError {
    /// The class of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            SceneError::Unreadable { .. } | SceneError::MissingBuffer { .. } => ErrorKind::Io,
            SceneError::OutsideFolder { .. }
            | SceneError::Malformed { .. }
            | SceneError::NotObj { .. }
            | SceneError::InPlaceOfData { .. }
            | SceneError::NoSuchAnimation { .. }
            | SceneError::NoSuchScene { .. }
            | SceneError::Degenerate { .. } => ErrorKind::BadModel,
            SceneError::UnknownFormat { .. }
            | SceneError::UnsupportedExtension { .. }
            | SceneError::UnsupportedVersion { .. } => ErrorKind::Unsupported,
            SceneError::Memory { .. } | SceneError::TooMany { .. } => ErrorKind::Limit,
        }
    }

    /// The model, and the line where the format has lines and one is to blame.
    pub fn place(&self) -> (&Path, Option<u64>) {
        match self {
            SceneError::MissingBuffer { model: path, .. } | SceneError::OutsideFolder { model: path, .. } => {
                (path, None)
            }
            SceneError::Malformed { path, line, .. } | SceneError::TooMany { path, line, .. } => (path, *line),
            SceneError::Unreadable { path, .. }
            | SceneError::NotObj { path, .. }
            | SceneError::InPlaceOfData { path, .. }
            | SceneError::Degenerate { path, .. }
            | SceneError::UnknownFormat { path }
            | SceneError::UnsupportedExtension { path, .. }
            | SceneError::UnsupportedVersion { path, .. }
            | SceneError::NoSuchAnimation { path, .. }
            | SceneError::NoSuchScene { path, .. }
            | SceneError::Memory { path, .. } => (path, None),
        }
    }

    /// What could not be done, beginning with "cannot".
    pub fn action(&self) -> String {
        let (path, line) = self.place();
        let line = line.map_or_else(String::new, |line| format!(" line {line}"));
        format!("cannot read {}{line}", path.display())
    }

    /// What stopped it, with the values that decide; without a full stop, each one line. None where the [source](std::error::Error::source) says it all.
    pub fn facts(&self) -> Vec<String> {
        let fact = match self {
            SceneError::Unreadable { .. } => return Vec::new(),
            SceneError::MissingBuffer { buffer, path, .. } => {
                format!("buffer {buffer} names {}, which cannot be opened", clipped(&path.to_string_lossy()))
            }
            SceneError::OutsideFolder { buffer, uri, why, .. } => {
                let names = format!("buffer {buffer} names '{uri}', {why}");
                return vec![names, "a model may only name files in its own folder".to_owned()];
            }
            SceneError::Malformed { reason, .. } => reason.clone(),
            SceneError::NotObj { found, .. } => {
                format!("it has no statement of an OBJ model, such as v or f; it begins with {found}")
            }
            SceneError::InPlaceOfData { what, resembles, .. } => {
                format!("{what} is {resembles} in the place of the data")
            }
            SceneError::Degenerate { degenerate, non_finite, out_of_range, first, mesh, .. } => format!(
                "it has {degenerate} triangles without area, {non_finite} with NaN or infinite positions and {out_of_range} with \
                 positions beyond the range of f32; the first is triangle {first} of {mesh}"
            ),
            SceneError::UnknownFormat { .. } => {
                "neither its name nor its content is that of an OBJ, glTF or GLB file".to_owned()
            }
            SceneError::UnsupportedExtension { extension, why, .. } => {
                format!("it needs the glTF extension {extension}, which bvhc does not read: {why}")
            }
            SceneError::UnsupportedVersion { version, .. } => {
                format!("it needs a reader of glTF {version}; this one reads glTF 2.0")
            }
            SceneError::NoSuchAnimation { asked, found, count, animations, .. } => {
                return animations_to_choose(asked, *found, *count, animations);
            }
            SceneError::NoSuchScene { count: 0, .. } => "it has no scenes that could be chosen".to_owned(),
            SceneError::NoSuchScene { asked, count, .. } => {
                format!("it has no scene {asked}; its scenes are numbered from 0 to {}", count - 1)
            }
            SceneError::Memory { what, need, limit, .. } => {
                let [need, limit] = beyond(*need, *limit);
                format!("with {what}, reading holds {need}, and more may follow; the limit is {limit}")
            }
            SceneError::TooMany { what, limit, .. } => format!("{what}; the limit is {limit}"),
        };
        vec![fact]
    }

    pub(super) fn malformed(path: &Path, reason: impl Into<String>) -> SceneError {
        SceneError::Malformed { path: path.to_owned(), line: None, reason: reason.into() }
    }

    pub(super) fn malformed_line(path: &Path, line: u64, reason: impl Into<String>) -> SceneError {
        SceneError::Malformed { path: path.to_owned(), line: Some(line), reason: reason.into() }
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let facts = self.facts();
        let colon = if facts.is_empty() { "" } else { ": " };
        write!(f, "{}{colon}{}", self.action(), facts.join("; "))
    }
}

impl std::error::Error for SceneError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            SceneError::Unreadable { source, .. } | SceneError::MissingBuffer { source, .. } => Some(source),
            _ => None,
        }
    }
}

/// Why an animation was not found, and which animations there are, one a fact.
fn animations_to_choose(asked: &AnimationChoice, found: u64, count: u64, animations: &[Animation]) -> Vec<String> {
    let why = match asked {
        _ if count == 0 => "it has no animations".to_owned(),
        AnimationChoice::Only => format!("it has {count} animations, and which is meant is not said"),
        AnimationChoice::Number(number) => {
            format!("it has no animation {number}; the last is animation {}", count - 1)
        }
        AnimationChoice::Name(name) if found == 0 => format!("it has no animation named '{}'", clipped(name)),
        AnimationChoice::Name(name) => {
            format!("it has {found} animations named '{}'; their numbers tell them apart", clipped(name))
        }
    };
    let told = |animation: &Animation| match &animation.keys {
        Some(keys) => format!("{animation}: {keys}"),
        None => format!("{animation}: nothing of the scene moves"),
    };
    let more = count.saturating_sub(animations.len() as u64);
    let rest = (more > 0).then(|| format!("and {more} more"));
    std::iter::once(why).chain(animations.iter().map(told)).chain(rest).collect()
}
