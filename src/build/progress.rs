use std::sync::atomic::{AtomicU64, Ordering};

/// How a build is watched and stopped.
pub trait Progress: Sync {
    /// Asked about a thousand times a second; a build that sees `true` ends with
    /// [`BuildError::Cancelled`](super::BuildError).
    fn is_cancelled(&self) -> bool {
        false
    }

    /// So many more of the scene's primitives are finished. The calls of a build sum up to the triangles of all trees.
    fn advance(&self, _primitives: u64) {}

    /// A stretch of a tree's build begins, which lasts until the next one does: for those who measure. Trees that are built side by
    /// side all report here.
    fn phase(&self, _name: &'static str) {}
}

/// Nobody watches.
pub struct NoProgress;

impl Progress for NoProgress {}

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
