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
