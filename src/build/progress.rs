/// How a build is watched and stopped.
pub trait Progress: Sync {
    /// Asked about a thousand times a second; a build that sees `true` ends with
    /// [`BuildError::Cancelled`](super::BuildError).
    fn is_cancelled(&self) -> bool {
        false
    }

    /// So many more of the scene's primitives are finished. The calls of a build sum up to the triangles of all trees.
    fn advance(&self, _primitives: u64) {}
}

/// Nobody watches.
pub struct NoProgress;

impl Progress for NoProgress {}
