use std::fmt;
use std::path::{Path, PathBuf};

/// Why a model was not read. Every message names the file, says the fact with its values and the rule, and ends in one
/// `help:` line where there is a remedy.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    #[error("cannot read {}\n  {source}", path.display())]
    Unreadable { path: PathBuf, source: std::io::Error },

    #[error(
        "cannot read {}\n  buffer {buffer} names {}, which cannot be opened: {source}\nhelp: put the file there, or export \
         the model as one .glb file",
        model.display(), clipped(&path.to_string_lossy())
    )]
    MissingBuffer { model: PathBuf, buffer: usize, path: PathBuf, source: std::io::Error },

    #[error(
        "cannot read {}\n  buffer {buffer} names '{uri}', {why}\n  a model may only name files in its own folder\nhelp: if \
         you trust this model, allow it with --allow-outside",
        model.display()
    )]
    OutsideFolder { model: PathBuf, buffer: usize, uri: String, why: &'static str },

    #[error("cannot read {}\n  {reason}", At(path, *line))]
    Malformed { path: PathBuf, line: Option<u64>, reason: String },

    #[error("cannot read {}\n  it has no statement of an OBJ model, such as v or f; it begins with {found}\nhelp: {advice}", path.display())]
    NotObj { path: PathBuf, found: String, advice: &'static str },

    #[error(
        "cannot read {}\n  it has {degenerate} triangles without area and {non_finite} with NaN or infinite positions; the \
         first is triangle {first} of {mesh}\nhelp: leave them out with --degenerate drop",
        path.display()
    )]
    Degenerate { path: PathBuf, degenerate: u64, non_finite: u64, first: u64, mesh: String },

    #[error(
        "cannot read {}\n  neither its name nor its content is that of an OBJ, glTF or GLB file\nhelp: convert it to one of \
         these",
        path.display()
    )]
    UnknownFormat { path: PathBuf },

    #[error(
        "cannot read {}\n  it needs the glTF extension {extension}, which bvhc does not read: {why}\nhelp: {advice}",
        path.display()
    )]
    UnsupportedExtension { path: PathBuf, extension: String, why: &'static str, advice: String },

    #[error(
        "cannot read {}\n  it needs a reader of glTF {version}; this one reads glTF 2.0\nhelp: export it as glTF 2.0",
        path.display()
    )]
    UnsupportedVersion { path: PathBuf, version: String },

    #[error(
        "cannot read {}\n  {what} needs {} in all; the limit is {}\nhelp: raise it with --max-memory",
        path.display(), Bytes(*need), Bytes(*limit)
    )]
    Memory { path: PathBuf, what: String, need: u64, limit: u64 },

    #[error("cannot read {}\n  {what}; the limit is {limit}", path.display())]
    TooMany { path: PathBuf, what: String, limit: u64 },
}

/// What a caller can do about a [`SceneError`]; the command line maps each kind to one exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
    pub fn kind(&self) -> ErrorKind {
        match self {
            SceneError::Unreadable { .. } | SceneError::MissingBuffer { .. } => ErrorKind::Io,
            SceneError::OutsideFolder { .. }
            | SceneError::Malformed { .. }
            | SceneError::NotObj { .. }
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

/// A text from a file as a message shows it: cut where it is long, and not shown where it looks like data, which may be megabytes.
pub(super) fn clipped(text: &str) -> String {
    const MOST: usize = 120;
    let is_data = text.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("data"))
        && matches!(text.as_bytes().get(4), Some(b':' | b';' | b','));
    let most = if is_data { "data:".len() } else { MOST };
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
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

/// A byte count as people read it: `640 bytes`, `12.5 MiB`.
struct Bytes(u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let units = [("GiB", 30), ("MiB", 20), ("KiB", 10)];
        match units.iter().find(|(_, shift)| self.0 >> shift != 0) {
            Some((unit, shift)) => write!(f, "{:.1} {unit}", self.0 as f64 / (1u64 << shift) as f64),
            None => write!(f, "{} bytes", self.0),
        }
    }
}
