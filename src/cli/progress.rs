//! The bar on a terminal. Elsewhere nothing moves: one line per finished file is all that a log needs.

use super::interrupt;
use super::terminal::Terminal;
use crate::build::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::atomic::Ordering;
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

impl Progress for Bar {
    fn is_cancelled(&self) -> bool {
        interrupt::flag().load(Ordering::Relaxed)
    }

    fn advance(&self, primitives: u64) {
        self.bar.inc(primitives);
    }
}
