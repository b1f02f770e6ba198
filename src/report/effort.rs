//! [`BuildEffort`]: what a build took, as a note of META tells it where that was asked for.

use serde::Serialize;
use std::fmt;

/// What a build took, on the machine that ran it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BuildEffort {
    /// From the start of reading until the file was ready to be written.
    pub seconds: f64,
    /// Threads that it could use.
    pub threads: u64,
    /// Largest resident set until then, in bytes; `None` where the process built something else too, or the system does not tell.
    pub peak_memory: Option<u64>,
}

/// How the note begins.
const TOOK: &str = "the build took ";

impl fmt::Display for BuildEffort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let threads = if self.threads == 1 { "thread" } else { "threads" };
        write!(f, "{TOOK}{:.6} s on {} {threads}", self.seconds, self.threads)?;
        match self.peak_memory {
            Some(bytes) => write!(f, ", {bytes} bytes at the peak"),
            None => Ok(()),
        }
    }
}

impl BuildEffort {
    /// A note read back; `None` for any other note.
    pub fn of_note(note: &str) -> Option<BuildEffort> {
        let (seconds, rest) = note.strip_prefix(TOOK)?.split_once(" s on ")?;
        let (threads, rest) = rest.split_once(" thread")?;
        let peak = rest.trim_start_matches('s').strip_prefix(", ");
        let peak = peak.map(|peak| peak.strip_suffix(" bytes at the peak")?.parse::<u64>().ok());
        let read = BuildEffort {
            seconds: seconds.parse().ok().filter(|seconds: &f64| *seconds >= 0.0 && seconds.is_finite())?,
            threads: threads.parse().ok()?,
            peak_memory: match peak {
                Some(bytes) => Some(bytes?),
                None => None,
            },
        };
        (read.to_string() == note).then_some(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_noted_is_read_back() {
        for effort in [
            BuildEffort { seconds: 0.25, threads: 1, peak_memory: None },
            BuildEffort { seconds: 1234.5, threads: 64, peak_memory: Some(9 << 30) },
        ] {
            assert_eq!(BuildEffort::of_note(&effort.to_string()), Some(effort));
        }
        for other in [
            "",
            "the build took",
            "the build took x s on 2 threads",
            "the build took inf s on 2 threads",
            "the build took 0.250000 s on 2 threads, much",
        ] {
            assert_eq!(BuildEffort::of_note(other), None, "{other}");
        }
    }
}
