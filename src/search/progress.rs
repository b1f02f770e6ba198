//! What whoever watches is told of a search, which builds a mesh's tree several times.

use crate::build::Progress;
use std::sync::atomic::{AtomicU64, Ordering};

/// Several builds of the same mesh that count as one.
pub(super) struct Portion<'a> {
    inner: &'a dyn Progress,
    builds: u64,
    /// Primitives finished by all builds together.
    done: AtomicU64,
}

impl<'a> Portion<'a> {
    /// `builds` is how many there will be at most.
    pub fn new(inner: &'a dyn Progress, builds: u64) -> Portion<'a> {
        Portion { inner, builds: builds.max(1), done: AtomicU64::new(0) }
    }

    /// Report what is left of the mesh's `primitives`, as after fewer builds than could have been.
    pub fn finish(&self, primitives: u64) {
        self.inner.advance(primitives.saturating_sub(self.done.load(Ordering::Relaxed) / self.builds));
    }
}

impl Progress for Portion<'_> {
    fn is_cancelled(&self) -> bool {
        self.inner.is_cancelled()
    }

    fn advance(&self, primitives: u64) {
        let before = self.done.fetch_add(primitives, Ordering::Relaxed);
        self.inner.advance((before + primitives) / self.builds - before / self.builds);
    }

    fn phase(&self, name: &'static str) {
        self.inner.phase(name);
    }
}

/// Cancels as the other does and reports no primitives.
pub(super) struct Silent<'a>(pub &'a dyn Progress);

impl Progress for Silent<'_> {
    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }

    fn phase(&self, name: &'static str) {
        self.0.phase(name);
    }
}
