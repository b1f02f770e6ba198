//! The exit codes: one table, from which `--help`, the man page and docs/commands.md are generated.

/// How the process ends. Any other non-zero status means that the process was killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    Success = 0,
    Negative = 1,
    Usage = 2,
    Io = 3,
    Model = 4,
    Unsupported = 5,
    Limit = 6,
    Internal = 7,
    Worse = 8,
    Mixed = 10,
    TryAgain = 75,
    Interrupted = 130,
}

impl Exit {
    pub const ALL: [Exit; 12] = [
        Exit::Success,
        Exit::Negative,
        Exit::Usage,
        Exit::Io,
        Exit::Model,
        Exit::Unsupported,
        Exit::Limit,
        Exit::Internal,
        Exit::Worse,
        Exit::Mixed,
        Exit::TryAgain,
        Exit::Interrupted,
    ];

    pub fn code(self) -> u8 {
        self as u8
    }

    /// The name in JSON error objects.
    pub fn name(self) -> &'static str {
        match self {
            Exit::Success => "success",
            Exit::Negative => "negative",
            Exit::Usage => "usage",
            Exit::Io => "io",
            Exit::Model => "model",
            Exit::Unsupported => "unsupported",
            Exit::Limit => "limit",
            Exit::Internal => "internal",
            Exit::Worse => "worse",
            Exit::Mixed => "mixed",
            Exit::TryAgain => "try-again",
            Exit::Interrupted => "interrupted",
        }
    }

    pub fn meaning(self) -> &'static str {
        match self {
            Exit::Success => "done, valid, or already up to date",
            Exit::Negative => {
                "negative verdict: an invalid file, a wrong hit, or work that --dry-run --exit-code found"
            }
            Exit::Usage => "the command line is wrong",
            Exit::Io => "a file could not be read or written, or the program of another builder failed",
            Exit::Model => "a model is malformed or refused by policy",
            Exit::Unsupported => "a format version or feature that this version does not support, or no usable device",
            Exit::Limit => "a limit was exceeded, such as --max-memory",
            Exit::Internal => "a bug in bvhc: please report",
            Exit::Worse => "a condition of stats --compare --fail-if holds",
            Exit::Mixed => "inputs ended differently, each told by itself (all alike: that code)",
            Exit::TryAgain => "an input changed while it was being built; nothing was written, try again",
            Exit::Interrupted => "interrupted (SIGINT, SIGTERM); no partial output is left",
        }
    }

    /// The code for a run over several inputs: the common one, or [`Exit::Mixed`].
    pub fn combine(results: impl IntoIterator<Item = Exit>) -> Exit {
        let mut results = results.into_iter();
        let first = results.next().unwrap_or(Exit::Success);
        results.fold(first, |all, one| if all == one { all } else { Exit::Mixed })
    }
}

impl Exit {
    /// As [`Exit::combine`] for verdicts: a negative one about one of several files is a negative end, not a mixed one, as long as
    /// every file was judged.
    pub fn combine_verdicts(results: &[Exit]) -> Exit {
        let judged = results.iter().all(|e| matches!(e, Exit::Success | Exit::Negative));
        if judged && results.contains(&Exit::Negative) {
            Exit::Negative
        } else {
            Exit::combine(results.iter().copied())
        }
    }
}

impl From<Exit> for std::process::ExitCode {
    fn from(exit: Exit) -> Self {
        exit.code().into()
    }
}

/// The table at the end of `--help` and in the man page.
pub fn help_table() -> String {
    let mut text = String::from("Exit codes:\n");
    for exit in Exit::ALL {
        text.push_str(&format!("  {:>3}  {}\n", exit.code(), exit.meaning()));
    }
    text.truncate(text.trim_end().len());
    text
}

/// The same as a Markdown table, for docs/commands.md.
pub fn markdown_table() -> String {
    let mut text = String::from("| code | name | meaning |\n|---:|---|---|\n");
    for exit in Exit::ALL {
        text.push_str(&format!("| {} | {} | {} |\n", exit.code(), exit.name(), exit.meaning()));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_and_names_are_unique_and_ascending() {
        assert!(Exit::ALL.windows(2).all(|w| w[0].code() < w[1].code()));
        let names: std::collections::BTreeSet<_> = Exit::ALL.iter().map(|e| e.name()).collect();
        assert_eq!(names.len(), Exit::ALL.len());
    }

    #[test]
    fn a_common_failure_keeps_its_code_and_different_ends_are_mixed() {
        assert_eq!(Exit::combine([]), Exit::Success);
        assert_eq!(Exit::combine([Exit::Io, Exit::Io]), Exit::Io);
        assert_eq!(Exit::combine([Exit::Io, Exit::Model]), Exit::Mixed);
        assert_eq!(Exit::combine([Exit::Success, Exit::Io, Exit::Io]), Exit::Mixed);
        assert_eq!(Exit::combine([Exit::Success, Exit::Success]), Exit::Success);
    }
}
