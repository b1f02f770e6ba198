//! The two streams: results on stdout, everything else on stderr. What is shown and how is decided once, at the start.

use super::exit::Exit;
use super::failure::Failure;
use std::cell::RefCell;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// When to use colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ColorChoice {
    /// On a terminal, unless NO_COLOR is set or TERM is `dumb`
    Auto,
    Always,
    Never,
}

static INTERRUPTION_IS_TOLD: AtomicBool = AtomicBool::new(false);

/// A remark on stderr with `--json`, beside the lines of errors.
#[derive(serde::Serialize)]
struct RemarkLine<'a> {
    schema: &'static str,
    reason: &'static str,
    text: &'a str,
    /// As errors have them.
    facts: [&'a str; 0],
    help: Option<&'a str>,
}

/// Where a command talks to.
#[derive(Clone, Copy, Debug)]
pub struct Terminal {
    /// Nothing but errors on stderr.
    pub quiet: bool,
    pub verbose: u8,
    /// One JSON document on stdout instead of text.
    pub json: bool,
    color_out: bool,
    color_err: bool,
    progress: bool,
}

/// The few colours of the tool, as SGR numbers.
#[derive(Clone, Copy, Debug)]
pub enum Paint {
    Red,
    Green,
    Yellow,
}

impl Terminal {
    pub fn new(choice: ColorChoice, quiet: bool, verbose: u8, json: bool) -> Terminal {
        let dumb = std::env::var_os("TERM").is_some_and(|t| t == "dumb");
        let no_color = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
        let allowed = |tty: bool| match choice {
            ColorChoice::Always => true,
            ColorChoice::Never => false,
            ColorChoice::Auto => tty && !no_color && !dumb,
        };
        let (out_tty, err_tty) = (io::stdout().is_terminal(), io::stderr().is_terminal());
        Terminal {
            quiet,
            verbose,
            json,
            color_out: allowed(out_tty),
            color_err: allowed(err_tty),
            progress: err_tty && !dumb && !quiet && !json,
        }
    }

    /// The same, without progress bars.
    pub fn still(self) -> Terminal {
        Terminal { progress: false, ..self }
    }

    /// Say what was held back.
    pub fn say(&self, lines: &[String]) {
        lines.iter().for_each(|line| self.stderr(line));
    }

    /// Draw a progress bar?
    pub fn wants_progress(&self) -> bool {
        self.progress
    }

    /// Use colour on stdout?
    pub fn wants_colour(&self) -> bool {
        self.color_out
    }

    /// Write text to stdout as it is. Where its reader has gone away (`bvhc … | head`), the work goes on without it: outputs are wanted all the same, and
    /// the exit code must not depend on who listens.
    pub fn print(&self, text: &str) -> Result<(), Failure> {
        let mut out = io::stdout().lock();
        match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => {
                Err(Failure::new(Exit::Io, "cannot write to standard output").fact(error.to_string()))
            }
            _ => Ok(()),
        }
    }

    /// Write one result line to stdout.
    pub fn result(&self, line: &str) -> Result<(), Failure> {
        self.print(&format!("{line}\n"))
    }

    /// Write one JSON document to stdout, indented for the reader and ended by a line break.
    pub fn document(&self, value: &impl serde::Serialize) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(value)
            .map_err(|e| Failure::new(Exit::Internal, "cannot write JSON").fact(e.to_string()))?;
        self.result(&text)
    }

    /// A remark on stderr that `-q` silences.
    pub fn note(&self, line: &str) {
        self.remark("note", line);
    }

    /// A remark on stderr that only `-v` shows.
    pub fn detail(&self, line: &str) {
        if self.verbose > 0 {
            self.remark("note", line);
        }
    }

    pub fn warn(&self, line: &str) {
        self.remark("warning", line);
    }

    /// As text, or as one line of JSON.
    fn remark(&self, reason: &'static str, line: &str) {
        match (self.quiet, self.json, reason) {
            (true, ..) => {}
            (false, true, _) => {
                let line = RemarkLine { schema: "bvhc.remark.v1", reason, text: line, facts: [], help: None };
                // Two strings always serialise.
                self.stderr(&serde_json::to_string(&line).unwrap_or_default());
            }
            (false, false, "warning") => {
                self.stderr(&format!("{} {line}", self.paint_err(Paint::Yellow, "warning:")));
            }
            (false, false, _) => self.stderr(line),
        }
    }

    /// An error on stderr, as text or as one line of JSON. An interruption is told once: the handler of signals and the work that it stops both
    /// come to know of it.
    pub fn error(&self, failure: &Failure) {
        if failure.exit == Exit::Interrupted && INTERRUPTION_IS_TOLD.swap(true, Ordering::SeqCst) {
            return;
        }
        let text = if self.json { failure.to_json() } else { failure.to_text(|w| self.paint_err(Paint::Red, w)) };
        self.stderr(&text);
    }

    pub fn paint(&self, paint: Paint, text: &str) -> String {
        if self.color_out { sgr(paint, text) } else { text.to_string() }
    }

    fn paint_err(&self, paint: Paint, text: &str) -> String {
        if self.color_err { sgr(paint, text) } else { text.to_string() }
    }

    /// Whoever closed stderr does not want to hear that it is closed.
    fn stderr(&self, line: &str) {
        let is_held = HELD.with_borrow_mut(|held| held.as_mut().map(|held| held.push(line.to_owned())).is_some());
        if is_held {
            return;
        }
        let _ = writeln!(io::stderr().lock(), "{line}");
    }
}

thread_local! {
    /// What this thread has to say, where that is held back.
    static HELD: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Do what is done on this thread alone, and hold back the lines that it has for stderr.
pub fn holding_back<R>(work: impl FnOnce() -> R) -> (R, Vec<String>) {
    /// A panic is told as well.
    struct Release;
    impl Drop for Release {
        fn drop(&mut self) {
            HELD.take();
        }
    }
    HELD.set(Some(Vec::new()));
    let _release = Release;
    let done = work();
    (done, HELD.take().unwrap_or_default())
}

fn sgr(paint: Paint, text: &str) -> String {
    let code = match paint {
        Paint::Red => "1;31",
        Paint::Green => "32",
        Paint::Yellow => "33",
    };
    format!("\x1b[{code}m{text}\x1b[0m")
}
