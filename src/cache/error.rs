use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Why a cache could not be read, written or converted.
#[derive(Debug, thiserror::Error)]
pub enum CacheError {
    /// The file system said no.
    #[error("cannot {action} {}: {source}", path.display())]
    Io { action: &'static str, path: PathBuf, source: io::Error },
    /// The bytes break a rule of the format: this is no cache, or a damaged one.
    #[error(
        "cannot read {name}: {detail} ({rule})\nhelp: bvhc explain {rule} · build it again: bvhc build MODEL -o FILE --force"
    )]
    Invalid { name: String, rule: &'static str, detail: String },
    /// The file may be sound, but it needs something that this version does not know, named in `detail`.
    #[error(
        "cannot read {name}: {detail} ({rule})\nhelp: use the bvhc that wrote it or a newer one, or rebuild with: bvhc build MODEL -o FILE --force"
    )]
    Unsupported { name: String, rule: &'static str, detail: String },
    /// The file may be sound, but a limit forbids to read or write it.
    #[error("cannot process {name}: {detail}\nhelp: {help}")]
    Limit { name: String, detail: String, help: &'static str },
    /// What was given to the writer cannot stand in a file.
    #[error(
        "cannot write {name}: {detail}\nhelp: this is a fault of the program that called the writer; please report it"
    )]
    Unwritable { name: String, detail: String },
}

/// The classes of [`CacheError`] that exit codes distinguish.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    Io,
    Invalid,
    Unsupported,
    Limit,
    Internal,
}

impl CacheError {
    pub fn kind(&self) -> ErrorKind {
        match self {
            CacheError::Io { .. } => ErrorKind::Io,
            CacheError::Invalid { .. } => ErrorKind::Invalid,
            CacheError::Unsupported { .. } => ErrorKind::Unsupported,
            CacheError::Limit { .. } => ErrorKind::Limit,
            CacheError::Unwritable { .. } => ErrorKind::Internal,
        }
    }

    /// The number of the broken rule (`E0119`), where one was broken.
    pub fn rule(&self) -> Option<&'static str> {
        match self {
            CacheError::Invalid { rule, .. } | CacheError::Unsupported { rule, .. } => Some(rule),
            _ => None,
        }
    }

    pub(super) fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> CacheError {
        let path = path.to_owned();
        move |source| CacheError::Io { action, path, source }
    }
}

/// A broken rule before it is known which file broke it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fault {
    pub rule: &'static str,
    pub detail: String,
    pub class: FaultClass,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FaultClass {
    Invalid,
    Unsupported,
    MemoryLimit,
}

/// Without the file's name: for what does not keep it from being used.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.detail, self.rule)
    }
}

impl Fault {
    pub fn invalid(rule: &'static str, detail: impl Into<String>) -> Fault {
        Fault { rule, detail: detail.into(), class: FaultClass::Invalid }
    }

    pub fn unsupported(rule: &'static str, detail: impl Into<String>) -> Fault {
        Fault { rule, detail: detail.into(), class: FaultClass::Unsupported }
    }

    pub fn memory(needed: u128, limit: u64) -> Fault {
        let detail = format!("its sections take {needed} bytes of memory and the limit is {limit} bytes");
        Fault { rule: "E0127", detail, class: FaultClass::MemoryLimit }
    }

    pub fn of(self, name: &str) -> CacheError {
        let (name, rule, detail) = (name.to_owned(), self.rule, self.detail);
        match self.class {
            FaultClass::Invalid => CacheError::Invalid { name, rule, detail },
            FaultClass::Unsupported => CacheError::Unsupported { name, rule, detail },
            FaultClass::MemoryLimit => {
                CacheError::Limit { name, detail, help: "if you trust the file, raise the limit: --max-memory 32G" }
            }
        }
    }
}
