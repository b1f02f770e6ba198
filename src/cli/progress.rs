//! The bar on a terminal. Elsewhere nothing moves: one line per finished file is all that a log needs.

use super::interrupt;
use super::terminal::Terminal;
use crate::build::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// The phases of one build, drawn to stderr if that is a terminal; and the ear that a build has for signals.
pub struct Bar {
    bar: ProgressBar,
    name: String,
    visible: bool,
}

impl Bar {
    pub fn new(terminal: &Terminal, name: &str) -> Bar {
        Bar { bar: ProgressBar::hidden(), name: name.to_string(), visible: terminal.wants_progress() }
    }

    /// Start a phase whose length is known, in `unit`s.
    pub fn phase(&self, verb: &str, length: u64) {
        // The template is a constant of this file; a wrong one shows the plain style instead of stopping a build.
        let style = ProgressStyle::with_template("{msg}  [{bar:30}] {percent:>3} %  {elapsed}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        self.bar.set_style(style.progress_chars("=> "));
        self.bar.set_length(length.max(1));
        self.bar.set_position(0);
        self.bar.set_message(format!("{} {}", verb, self.name));

        // Only now is there something to show; a bar drawn from the start would flash empty.
        if self.visible && self.bar.is_hidden() {
            self.bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
        }
    }

    /// Start a phase whose length nobody knows.
    pub fn spin(&self, verb: &str) {
        self.bar.set_style(ProgressStyle::default_spinner());
        self.bar.set_message(format!("{} {}", verb, self.name));
        self.bar.enable_steady_tick(Duration::from_millis(100));
    }

    pub fn set(&self, done: u64, length: u64) {
        self.bar.set_length(length.max(1));
        self.bar.set_position(done);
    }
}

/// Whatever ends the build, the line is the shell's again.
impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// How many of many files are done, drawn likewise.
pub struct Files {
    bar: ProgressBar,
    done: AtomicUsize,
    count: usize,
}

impl Files {
    /// So many files, which have so many bytes in all.
    pub fn new(terminal: &Terminal, count: usize, bytes: u64) -> Files {
        let bar = ProgressBar::hidden();
        let style = ProgressStyle::with_template("{msg}  [{bar:30}] {bytes} of {total_bytes}, {eta} left")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style.progress_chars("=> "));
        bar.set_length(bytes.max(1));
        if terminal.wants_progress() {
            bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
        }
        Files { bar, done: AtomicUsize::new(0), count }
    }

    /// One more file is done, of so many bytes.
    pub fn advance(&self, bytes: u64) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.bar.set_message(format!("{done} of {} files", self.count));
        self.bar.inc(bytes);
    }

    /// Write to the terminal, where nothing is drawn meanwhile.
    pub fn aside<R>(&self, write: impl FnOnce() -> R) -> R {
        self.bar.suspend(write)
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn is_cancelled(&self) -> bool {
        interrupt::flag().load(Ordering::Relaxed)
    }

    fn advance(&self, primitives: u64) {
        self.bar.inc(primitives);
    }
}
