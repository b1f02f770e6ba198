//! What the user reads when a command cannot do its work.

use super::exit::Exit;
use super::names;
use serde::Serialize;
use std::path::Path;

/// A failed action: what was tried, the facts that stopped it, and a command that helps.
///
/// ```text
/// error: cannot build rock.bvhc
///   rock.obj does not exist
/// help: …
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Failure {
    pub exit: Exit,
    /// The failed action, beginning with "cannot".
    pub action: String,
    /// One a line; the fact with both values, then the rule.
    pub facts: Vec<String>,
    pub help: Option<String>,
}

/// The same in a JSON document.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorObject {
    exit_code: u8,
    exit_name: &'static str,
    /// The failed action.
    text: String,
    facts: Vec<String>,
    help: Option<String>,
}

/// The object that `--json` puts on stderr, one line.
#[derive(Serialize)]
struct Line {
    schema: &'static str,
    reason: &'static str,
    #[serde(flatten)]
    error: ErrorObject,
}

/// One of several files in a JSON document: what a command found, or why it could not.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Entry<T> {
    Done(T),
    Failed {
        path: String,
        /// The number of a sequence's frame.
        #[serde(skip_serializing_if = "Option::is_none")]
        frame: Option<i32>,
        error: ErrorObject,
    },
}

impl<T> Entry<T> {
    pub fn failed(path: &Path, frame: Option<i32>, failure: &Failure) -> Entry<T> {
        Entry::Failed { path: path.to_string_lossy().into_owned(), frame, error: failure.into() }
    }

    pub fn done(&self) -> Option<&T> {
        match self {
            Entry::Done(found) => Some(found),
            Entry::Failed { .. } => None,
        }
    }

    /// What was found of those files of which anything was.
    pub fn all_done(entries: Vec<Entry<T>>) -> Vec<T> {
        let done = |entry| match entry {
            Entry::Done(found) => Some(found),
            Entry::Failed { .. } => None,
        };
        entries.into_iter().filter_map(done).collect()
    }
}

impl From<&Failure> for ErrorObject {
    fn from(failure: &Failure) -> ErrorObject {
        ErrorObject {
            exit_code: failure.exit.code(),
            exit_name: failure.exit.name(),
            text: failure.action.clone(),
            facts: failure.facts.clone(),
            help: failure.help.clone(),
        }
    }
}

impl Failure {
    pub fn new(exit: Exit, action: impl Into<String>) -> Failure {
        Failure { exit, action: action.into(), facts: Vec::new(), help: None }
    }

    pub fn interrupted() -> Failure {
        Failure::new(Exit::Interrupted, "interrupted")
            .fact("outputs that were reported are in their places; all others are as they were")
    }

    #[must_use]
    pub fn fact(mut self, fact: impl Into<String>) -> Failure {
        self.facts.push(fact.into());
        self
    }

    #[must_use]
    pub fn facts(mut self, facts: impl IntoIterator<Item = String>) -> Failure {
        self.facts.extend(facts);
        self
    }

    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Failure {
        self.help = Some(help.into());
        self
    }

    /// Text for people, without the final line break. `paint` colours the leading word.
    pub fn to_text(&self, paint: impl Fn(&str) -> String) -> String {
        let mut text = format!("{} {}", paint("error:"), names::escape(&self.action));
        for line in self.facts.iter().flat_map(|f| f.lines()) {
            text.push_str("\n  ");
            text.push_str(&names::escape(line));
        }
        if let Some(help) = &self.help {
            text.push_str("\nhelp: ");
            text.push_str(&names::escape(help));
        }
        text
    }

    pub fn to_json(&self) -> String {
        let line = Line { schema: "bvhc.error.v1", reason: "error", error: self.into() };
        // Strings and small integers always serialise.
        serde_json::to_string(&line).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facts_stand_a_line_each_before_the_help() {
        let f =
            Failure::new(Exit::Model, "cannot read a.obj").facts(["one".into(), "two".into()]).help("export it again");
        assert_eq!(f.to_text(str::to_string), "error: cannot read a.obj\n  one\n  two\nhelp: export it again");
    }

    #[test]
    fn foreign_text_cannot_steer_the_terminal() {
        let f = Failure::new(Exit::Model, "cannot read \u{1b}[2J").fact("name \u{202e}");
        assert!(f.to_text(str::to_string).chars().all(|c| c == '\n' || !c.is_control() && c != '\u{202e}'));
    }

    #[test]
    fn json_carries_code_and_name() {
        let f = Failure::new(Exit::TryAgain, "the input changed").help("again");
        let v: serde_json::Value = serde_json::from_str(&f.to_json()).unwrap();
        assert_eq!(
            (v["reason"].as_str(), v["exit_code"].as_u64(), v["exit_name"].as_str()),
            (Some("error"), Some(75), Some("try-again"))
        );
    }
}
