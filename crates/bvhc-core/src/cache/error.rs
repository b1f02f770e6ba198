use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use super::report::{Finding, Report};
use super::rules::{self, Severity};
use crate::layout::SectionKind;
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
        /// The rule that is broken, where, and both values.
        breach: Box<Finding>,
    },
    /// The file may be sound, but it needs something that this version does not know.
    Unsupported {
        /// The file.
        name: String,
        /// The rule that makes a reader refuse it, what this version knows, and what the file needs.
        breach: Box<Finding>,
    },
    /// Sections that are part of what the file is cannot be copied, since this version does not know them.
    NotCopied {
        /// The file.
        name: String,
        /// What they are.
        sections: Vec<SectionKind>,
    },
    /// The file may be sound, but a limit forbids to read or write it.
    Limit {
        /// The file.
        name: String,
        /// Which limit it is, and by how much it is exceeded.
        limit: Limited,
    },
    /// The file has many frames and was opened as a still one: [`Sequence`](super::Sequence) opens it.
    Sequence {
        /// The file.
        name: String,
        /// How many frames its header states.
        frames: u32,
    },
    /// The file is a still one and was opened as a sequence: [`Cache`](super::Cache) opens it.
    Still {
        /// The file.
        name: String,
    },
    /// A sequence has no such frame.
    NoFrame {
        /// The frame that was asked for, counted from 0.
        frame: usize,
        /// How many there are.
        frames: usize,
    },
    /// Nothing lies between two frames of a sequence, since they do not show the same triangles.
    Unlike {
        /// The frames, counted from 0.
        frames: [usize; 2],
        /// What the one shows and the other does not.
        what: Unlike,
    },
    /// What was given to the writer cannot stand in a file. A fault of the program that called it.
    Unwritable {
        /// The file.
        name: String,
        /// What is wrong with it.
        detail: String,
    },
}

/// Why two frames cannot be interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unlike {
    /// There are not as many instances in the one as in the other.
    Instances {
        /// How many each frame has.
        counts: [usize; 2],
    },
    /// An instance shows other triangles, or the same under a tree of another shape: it was built anew between the frames.
    Topology {
        /// The instance's number in the scene.
        instance: u32,
        /// The row of [`Sequence::topologies`](super::Frames::topologies) that it shows in each frame.
        topologies: [u32; 2],
    },
}

impl fmt::Display for Unlike {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Unlike::Instances { counts: [first, second] } => {
                write!(f, "the one has {first} instances, the other {second}, and each needs its like")
            }
            Unlike::Topology { instance, topologies: [first, second] } => write!(
                f,
                "instance {instance} shows topology {first} in the one and {second} in the other, \
                 and only poses of one topology can be interpolated"
            ),
        }
    }
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
    /// It is a sequence where a still file is needed, or the other way round; or its frames are not those that were asked for.
    Frames,
    /// A fault of the calling program.
    Internal,
}

impl fmt::Display for CacheError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CacheError::Io { action, path, .. } => write!(f, "cannot {action} {}", path.display()),
            CacheError::Invalid { name, breach } | CacheError::Unsupported { name, breach } => {
                write!(f, "cannot read {name}: {}", Brief(breach))
            }
            CacheError::NotCopied { name, sections } => {
                let sections: Vec<String> = sections.iter().map(ToString::to_string).collect();
                let sections = sections.join(", ");
                write!(f, "cannot copy {name}: section {sections} is part of its content and may not be copied unread")
            }
            CacheError::Limit { name, limit } => write!(f, "cannot process {name}: {limit}"),
            CacheError::Sequence { name, frames } => {
                write!(f, "cannot read {name} as a still file: it is a sequence of {frames} frames")
            }
            CacheError::NoFrame { frame, frames } => {
                write!(f, "cannot open frame {frame}, counted from 0: the sequence has {frames}")
            }
            CacheError::Unlike { frames: [first, second], what } => {
                write!(f, "cannot interpolate frames {first} and {second}, counted from 0: {what}")
            }
            CacheError::Still { name } => write!(f, "cannot read {name} as a sequence: it is a still file"),
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
            CacheError::Unsupported { .. } | CacheError::NotCopied { .. } => ErrorKind::Unsupported,
            CacheError::Limit { .. } => ErrorKind::Limit,
            CacheError::Sequence { .. }
            | CacheError::Still { .. }
            | CacheError::NoFrame { .. }
            | CacheError::Unlike { .. } => ErrorKind::Frames,
            CacheError::Unwritable { .. } => ErrorKind::Internal,
        }
    }

    /// The number of the broken rule (`E0119`), where one was broken.
    pub fn rule(&self) -> Option<&'static str> {
        match self {
            CacheError::Invalid { breach, .. } | CacheError::Unsupported { breach, .. } => Some(breach.rule.id),
            _ => None,
        }
    }

    /// For `map_err`: the file system's word on an action with a file.
    pub fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> CacheError {
        let path = path.to_owned();
        move |source| CacheError::Io { action, path, source }
    }
}

/// Why the bytes of a file are no use, before it is known which file they are of.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// A rule is broken, or asks for another version or build of this library.
    Breach(Box<Finding>),
    /// The file may be sound, but decoding it would exceed [`OpenOptions::max_memory`](super::OpenOptions::max_memory).
    Memory {
        /// Bytes that the file's sections take.
        needed: u128,
        /// Bytes that they may take.
        limit: u64,
    },
    /// The file may be sound, but part of it was not looked into: the machine has not got the memory.
    NotChecked {
        /// That part, as a sentence.
        left_out: String,
    },
}

impl From<Finding> for Fault {
    fn from(breach: Finding) -> Fault {
        Fault::Breach(Box::new(breach))
    }
}

/// A breach in a sentence with the file's name: the header and the table need no place, since their fields have names.
pub(super) struct Brief<'a>(pub &'a Finding);

impl fmt::Display for Brief<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Finding { rule, place, .. } = self.0;
        if place.section.is_some() {
            write!(f, "{place}: ")?;
        }
        write!(f, "{} ({})", self.0.detail(), rule.id)
    }
}

/// Without the file's name: for what does not keep it from being used.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::Breach(breach) => Brief(breach).fmt(f),
            Fault::Memory { needed, limit } => Limited::Memory { needed: *needed, limit: *limit }.fmt(f),
            Fault::NotChecked { left_out } => f.write_str(left_out),
        }
    }
}

impl Fault {
    /// What a report comes to for somebody who wants the file or nothing: the first error, or else the first part that was not looked into.
    ///
    /// # Errors
    /// Unless everything was looked into and no rule with the severity of an error is broken.
    pub fn of_report(report: &Report) -> Result<(), Fault> {
        let errors = || report.findings.iter().filter(|f| f.rule.severity() == Severity::Error);
        if let Some(breach) = errors().find(|f| f.rule != &rules::E0127) {
            return Err(breach.clone().into());
        }
        if let Some((needed, limit)) = report.over_limit() {
            return Err(Fault::Memory { needed, limit });
        }
        if let Some(why) = report.not_checked.first() {
            return Err(Fault::NotChecked { left_out: why.clone() });
        }
        errors().next().map_or(Ok(()), |f| Err(Fault::NotChecked { left_out: f.detail() }))
    }

    /// The error of the file called `name`.
    pub fn of(self, name: &str) -> CacheError {
        let name = name.to_owned();
        match self {
            // A warning says of a section that this version does not read it.
            Fault::Breach(breach) if breach.rule.is_unsupported() || breach.rule.severity() == Severity::Warning => {
                CacheError::Unsupported { name, breach }
            }
            Fault::Breach(breach) => CacheError::Invalid { name, breach },
            Fault::Memory { needed, limit } => CacheError::Limit { name, limit: Limited::Memory { needed, limit } },
            Fault::NotChecked { left_out } => CacheError::Limit { name, limit: Limited::Machine { left_out } },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::report::Place;

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

        // Whoever set a limit can raise it.
        let over = verdict(&|r| {
            r.exceed(9 << 20, 4 << 20, |needed| format!("the sections take {needed}"));
            r.skip("The compressed sections.");
        });
        let memory = Limited::Memory { needed: 9 << 20, limit: 4 << 20 };
        assert!(matches!(over, Err(CacheError::Limit { limit, .. }) if limit == memory));

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
