//! Since when a driver has been at work. A call into a driver cannot be ended from outside, so whoever has waited for one too long can only give the process up.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// When the call began that is not over yet. One device is asked at a time; where several threads ask, the latest call counts.
static BEGAN: Mutex<Option<Instant>> = Mutex::new(None);

/// A call into a driver, until it is dropped.
pub(super) struct Call(());

impl Call {
    pub fn begin() -> Call {
        note(Some(Instant::now()));
        Call(())
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        note(None);
    }
}

fn note(began: Option<Instant>) {
    // Each value is whole, so that a panic elsewhere leaves no half of one.
    *BEGAN.lock().unwrap_or_else(PoisonError::into_inner) = began;
}

/// How long the process has waited for a driver to come back from one call; `None` where it waits for none. A launch is made to take about
/// [`OpenCl::LAUNCH`](super::OpenCl::LAUNCH), a compilation of kernels may take many seconds.
pub fn waiting() -> Option<Duration> {
    let began = *BEGAN.lock().unwrap_or_else(PoisonError::into_inner);
    began.map(|began| began.elapsed())
}
