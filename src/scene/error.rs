use super::animation::{Animation, AnimationChoice};
use super::resemblance::Resemblance;
use crate::size::beyond;
use std::fmt;
use std::path::{Path, PathBuf};

pub(super) use super::excerpt::clipped;

/// Why a model was not read: data, which a program puts into its own words.
///
/// The text of each is the failed action with the file's name, and then facts with their values, one a line. It names no flag of the
/// command line, and not its [source](std::error::Error::source).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The model cannot be opened or read.
    #[error("cannot read {}", path.display())]
    Unreadable {
        /// The model.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file that the model names cannot be opened.
    #[error(
        "cannot read {}\n  buffer {buffer} names {}, which cannot be opened",
        model.display(), clipped(&path.to_string_lossy())
    )]
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
    #[error(
        "cannot read {}\n  buffer {buffer} names '{uri}', {why}\n  a model may only name files in its own folder",
        model.display()
    )]
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
    #[error("cannot read {}\n  {reason}", At(path, *line))]
    Malformed {
        /// The model.
        path: PathBuf,
        /// The line, where the format has lines.
        line: Option<u64>,
        /// What is wrong.
        reason: String,
    },
    /// A text without any statement of an OBJ model.
    #[error("cannot read {}\n  it has no statement of an OBJ model, such as v or f; it begins with {found}", path.display())]
    NotObj {
        /// The file.
        path: PathBuf,
        /// How it begins.
        found: String,
        /// What it may be instead.
        resembles: Resemblance,
    },
    /// What stands in the place of a glTF model or of one of its buffers.
    #[error("cannot read {}\n  {what} is {resembles} in the place of the data", path.display())]
    InPlaceOfData {
        /// The model.
        path: PathBuf,
        /// The file itself, or a buffer and the file that it names.
        what: String,
        /// What it is.
        resembles: Resemblance,
    },
    /// [`Degenerate::Error`](super::Degenerate::Error) and triangles that it refuses.
    #[error(
        "cannot read {}\n  it has {degenerate} triangles without area, {non_finite} with NaN or infinite positions and {out_of_range} with \
         positions beyond the range of f32; the first is triangle {first} of {mesh}",
        path.display()
    )]
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
    #[error("cannot read {}\n  neither its name nor its content is that of an OBJ, glTF or GLB file", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The model needs a glTF extension that is not read: see [`ReadOptions::ignore_extensions`](super::ReadOptions::ignore_extensions).
    #[error("cannot read {}\n  it needs the glTF extension {extension}, which bvhc does not read: {why}", path.display())]
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
    #[error("cannot read {}\n  it needs a reader of glTF {version}; this one reads glTF 2.0", path.display())]
    UnsupportedVersion {
        /// The model.
        path: PathBuf,
        /// The version that it needs.
        version: String,
    },
    /// There is no animation such as [`ReadOptions::moment`](super::ReadOptions::moment) asks for, or more than one.
    #[error("cannot read {}\n  {}", path.display(), AnimationsToChoose { asked, found: *found, count: *count, animations })]
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
    /// [`ReadOptions::max_memory`](super::ReadOptions::max_memory) is too small.
    #[error("cannot read {}\n  {what} needs {} in all; the limit is {}", path.display(), beyond(*need, *limit)[0], beyond(*need, *limit)[1])]
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
    #[error("cannot read {}\n  {what}; the limit is {limit}", At(path, *line))]
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
            | SceneError::Degenerate { .. } => ErrorKind::BadModel,
            SceneError::UnknownFormat { .. }
            | SceneError::UnsupportedExtension { .. }
            | SceneError::UnsupportedVersion { .. } => ErrorKind::Unsupported,
            SceneError::Memory { .. } | SceneError::TooMany { .. } => ErrorKind::Limit,
        }
    }

    pub(super) fn malformed(path: &Path, reason: impl Into<String>) -> SceneError {
        SceneError::Malformed { path: path.to_owned(), line: None, reason: reason.into() }
    }

    pub(super) fn malformed_line(path: &Path, line: u64, reason: impl Into<String>) -> SceneError {
        SceneError::Malformed { path: path.to_owned(), line: Some(line), reason: reason.into() }
    }
}

/// `path`, or `path line 12`.
struct At<'a>(&'a Path, Option<u64>);

impl fmt::Display for At<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}", self.0.display())?;
        self.1.map_or(Ok(()), |line| write!(f, " line {line}"))
    }
}

/// Why an animation was not found, and which animations there are, one a line.
struct AnimationsToChoose<'a> {
    asked: &'a AnimationChoice,
    found: u64,
    count: u64,
    animations: &'a [Animation],
}

impl fmt::Display for AnimationsToChoose<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let AnimationsToChoose { asked, found, count, animations } = *self;
        match asked {
            _ if count == 0 => write!(f, "it has no animations"),
            AnimationChoice::Only => write!(f, "it has {count} animations, and which is meant is not said"),
            AnimationChoice::Number(number) => {
                write!(f, "it has no animation {number}; the last is animation {}", count - 1)
            }
            AnimationChoice::Name(name) if found == 0 => write!(f, "it has no animation named '{}'", clipped(name)),
            AnimationChoice::Name(name) => {
                write!(f, "it has {found} animations named '{}'; their numbers tell them apart", clipped(name))
            }
        }?;
        for animation in animations {
            match animation.keys {
                Some(keys) => write!(f, "\n  {animation}: {keys}"),
                None => write!(f, "\n  {animation}: nothing of the scene moves"),
            }?;
        }
        match count.saturating_sub(animations.len() as u64) {
            0 => Ok(()),
            more => write!(f, "\n  and {more} more"),
        }
    }
}
