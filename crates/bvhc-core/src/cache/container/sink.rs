use std::ops::ControlFlow;

use crate::cache::report::{Finding, Place, Report};
use crate::cache::rules::{Rule, Severity};

/// What becomes of the breaches that the walk over a container finds.
///
/// The walk ends where [`Sink::breach`] breaks, and where nothing behind a breach could be read.
pub trait Sink {
    /// A rule is broken: `values` gives the expected and the actual value for its detail line.
    fn breach(
        &mut self,
        rule: &'static Rule,
        place: Place,
        values: impl FnOnce() -> (String, String),
    ) -> ControlFlow<()>;

    /// Part of the file is not looked into, and why.
    fn skip(&mut self, what: &'static str);
}

/// The reader's sink: the first error ends the walk, and warnings are no matter.
#[derive(Default)]
pub struct First(Option<Finding>);

impl First {
    /// The error, if there was one.
    pub fn result(self) -> Result<(), Finding> {
        self.0.map_or(Ok(()), Err)
    }
}

impl Sink for First {
    fn breach(
        &mut self,
        rule: &'static Rule,
        place: Place,
        values: impl FnOnce() -> (String, String),
    ) -> ControlFlow<()> {
        if rule.severity() == Severity::Warning {
            return ControlFlow::Continue(());
        }
        let (expected, actual) = values();
        self.0 = Some(Finding::new(rule, place, expected, actual));
        ControlFlow::Break(())
    }

    fn skip(&mut self, _what: &'static str) {}
}

/// The checker's sink: everything is collected.
impl Sink for Report {
    fn breach(
        &mut self,
        rule: &'static Rule,
        place: Place,
        values: impl FnOnce() -> (String, String),
    ) -> ControlFlow<()> {
        self.add(rule, place, values);
        ControlFlow::Continue(())
    }

    fn skip(&mut self, what: &'static str) {
        Report::skip(self, what);
    }
}
