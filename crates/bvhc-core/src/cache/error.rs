use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use super::report::{Place, Report};
use super::rules::{self, Rule, Severity};
use crate::size;

/// Why a cache could not be read, written or converted.
#[derive(Debug)]
#[non_exhaustive]
pub enum CacheError {
    /// The file system said no.
    Io {
        /// What was tried: a verb, such as `open`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// The bytes break a rule of the format: this is no cache, or a damaged one.
    Invalid {
        /// The file.
        name: String,
        /// Number of the broken rule.
        rule: &'static str,
        /// What is expected and what was found.
        detail: String,
    },
    /// The file may be sound, but it needs something that this version does not know.
    Unsupported {
        /// The file.
        name: String,
        /// Number of the rule that makes a reader refuse it.
        rule: &'static str,
        /// What it needs, and what this version knows.
        detail: String,
    },
    /// The file may be sound, but a limit forbids to read or write it.
    Limit {
        /// The file.
        name: String,
        /// Which limit it is, and by how much it is exceeded.
        limit: Limited,
    },
    /// What was given to the writer cannot stand in a file. A fault of the program that called it.
    Unwritable {
        /// The file.
        name: String,
        /// What is wrong with it.
        detail: String,
    },
}

/// The limits that a file can exceed.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limited {
    /// [`OpenOptions::max_memory`](super::OpenOptions::max_memory).
    Memory {
        /// Bytes that the file's sections take.
        needed: u128,
        /// Bytes that they may take.
        limit: u64,
    },
    /// The memory that the machine has.
    Machine {
        /// What was not looked into for want of it, as a sentence.
        left_out: String,
    },
    /// What the format can hold.
    Format {
        /// Of what there is too much.
        what: &'static str,
        /// Bytes that it has.
        found: usize,
        /// Bytes that it may have.
        most: usize,
    },
}

impl fmt::Display for Limited {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Limited::Memory { needed, limit } => {
                let [needed, limit] = size::beyond(*needed, *limit);
                write!(f, "its sections take {needed} of memory and the limit is {limit}")
            }
            Limited::Machine { left_out } => write!(f, "part of it is not checked: {left_out}"),
            Limited::Format { what, found, most } => write!(f, "{what} has {found} bytes and may have {most}"),
        }
    }
}

/// The classes of [`CacheError`] that exit codes distinguish.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The file system said no.
    Io,
    /// The bytes break a rule of the format.
    Invalid,
    /// A newer version or another build of this library is needed.
    Unsupported,
    /// A limit forbids it.
    Limit,
    /// A fault of the calling program.
    Internal,
}

impl fmt::Display for CacheError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CacheError::Io { action, path, .. } => write!(f, "cannot {action} {}", path.display()),
            CacheError::Invalid { name, rule, detail } | CacheError::Unsupported { name, rule, detail } => {
                write!(f, "cannot read {name}: {detail} ({rule})")
            }
            CacheError::Limit { name, limit } => write!(f, "cannot process {name}: {limit}"),
            CacheError::Unwritable { name, detail } => write!(f, "cannot write {name}: {detail}"),
        }
    }
}

impl std::error::Error for CacheError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            CacheError::Io { source, .. } => Some(source),
            _ => None,
        }
    }
}

impl CacheError {
    /// The class of the error.
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

    /// For `map_err`: the file system's word on an action with a file.
    pub fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> CacheError {
        let path = path.to_owned();
        move |source| CacheError::Io { action, path, source }
    }
}

/// A broken rule before it is known which file broke it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Number of the broken rule, such as `E0119`.
    pub rule: &'static str,
    /// What was expected and what was found, without the file's name.
    pub detail: String,
    /// Which [`CacheError`] it becomes.
    pub class: FaultClass,
}

/// What a [`Fault`] says about the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FaultClass {
    /// The bytes break the format.
    Invalid,
    /// The file may be sound, for a later version or another build of this library.
    Unsupported,
    /// The file may be sound, but decoding it would exceed [`OpenOptions::max_memory`](super::OpenOptions::max_memory).
    MemoryLimit {
        /// Bytes that the file's sections take.
        needed: u128,
        /// Bytes that they may take.
        limit: u64,
    },
    /// The file may be sound, but part of it, which the detail names, was not looked into: the machine has not got the memory.
    NotChecked,
}

/// Without the file's name: for what does not keep it from being used.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.detail, self.rule)
    }
}

impl Fault {
    /// A breach that makes the file invalid, in the caller's words.
    pub fn invalid(rule: &'static str, detail: impl Into<String>) -> Fault {
        Fault { rule, detail: detail.into(), class: FaultClass::Invalid }
    }

    /// Something that this version or build does not know, in the caller's words.
    pub fn unsupported(rule: &'static str, detail: impl Into<String>) -> Fault {
        Fault { rule, detail: detail.into(), class: FaultClass::Unsupported }
    }

    /// A breach of a rule at a place, in the rule's own words.
    pub fn breach(rule: &'static Rule, place: Place, expected: &str, actual: &str) -> Fault {
        let text = rule.describe(expected, actual);
        let detail = if place.section.is_some() { format!("{place}: {text}") } else { text };
        let class = if rule.is_unsupported() { FaultClass::Unsupported } else { FaultClass::Invalid };
        Fault { rule: rule.id, detail, class }
    }

    /// What a report comes to for somebody who wants the file or nothing: the first error, or else the first part that was not looked into.
    ///
    /// # Errors
    /// Unless everything was looked into and no rule with the severity of an error is broken.
    pub fn of_report(report: &Report) -> Result<(), Fault> {
        let errors = || report.findings.iter().filter(|f| f.rule.severity() == Severity::Error);
        if let Some(f) = errors().find(|f| f.rule != &rules::E0127) {
            return Err(Fault::invalid(f.rule.id, format!("{}: {}", f.place, f.detail)));
        }
        let class = FaultClass::NotChecked;
        if let Some(why) = report.not_checked.first() {
            return Err(Fault { rule: rules::E0127.id, detail: why.clone(), class });
        }
        errors().next().map_or(Ok(()), |f| Err(Fault { rule: f.rule.id, detail: f.detail.clone(), class }))
    }

    /// Decoded sections would take `needed` bytes, more than `limit`: rule E0127.
    pub fn memory(needed: u128, limit: u64) -> Fault {
        let detail = Limited::Memory { needed, limit }.to_string();
        Fault { rule: "E0127", detail, class: FaultClass::MemoryLimit { needed, limit } }
    }

    /// The error of the file called `name`.
    pub fn of(self, name: &str) -> CacheError {
        let (name, rule, detail) = (name.to_owned(), self.rule, self.detail);
        match self.class {
            FaultClass::Invalid => CacheError::Invalid { name, rule, detail },
            FaultClass::Unsupported => CacheError::Unsupported { name, rule, detail },
            FaultClass::MemoryLimit { needed, limit } => {
                CacheError::Limit { name, limit: Limited::Memory { needed, limit } }
            }
            FaultClass::NotChecked => CacheError::Limit { name, limit: Limited::Machine { left_out: detail } },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_checked_is_not_sound() {
        let verdict = |fill: &dyn Fn(&mut Report)| {
            let mut report = Report::new(1);
            fill(&mut report);
            Fault::of_report(&report).map_err(|fault| fault.of("a.bvhc"))
        };
        assert!(verdict(&|_| ()).is_ok());
        let warn = |r: &mut Report| r.add(&rules::W0401, Place::file(), || ("0".into(), "-0".into()));
        assert!(verdict(&warn).is_ok());

        // The file may be sound, so it is not called invalid.
        let left_out =
            [verdict(&|r| r.skip("The rest.")), verdict(&|r| r.starve(Place::file(), "The vertices of tree 3"))];
        for error in left_out.map(Result::unwrap_err) {
            assert!(matches!(error, CacheError::Limit { limit: Limited::Machine { .. }, .. }), "{error:?}");
            assert!(error.to_string().contains("not checked: The "), "{error}");
        }

        // A rule that is broken all the same says more.
        let both = verdict(&|r| {
            r.starve(Place::file(), "The shape of tree 0");
            r.add(&rules::E0412, Place::file(), || ("finite".into(), "it is not".into()));
        });
        assert_eq!(both.unwrap_err().rule(), Some("E0412"));
    }

    #[test]
    fn a_report_without_memory_counts_it_as_an_error() {
        let mut report = Report::new(1);
        report.starve(Place::file(), "The vertices of tree 3");
        assert!(!report.is_valid());
        assert_eq!((report.count(&rules::E0127), report.not_checked.len()), (1, 1));
    }
}
