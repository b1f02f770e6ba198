//! Whether two paths lead to one file.

use std::path::Path;
#[cfg(not(unix))]
use std::path::PathBuf;

/// What tells existing files apart, whatever path leads to them. Links are followed.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
pub enum Identity {
    #[cfg(unix)]
    Inode(u64, u64),
    #[cfg(not(unix))]
    Path(PathBuf),
}

impl Identity {
    #[cfg(unix)]
    pub fn of(path: &Path) -> Option<Identity> {
        use std::os::unix::fs::MetadataExt;
        path.metadata().ok().map(|file| Identity::Inode(file.dev(), file.ino()))
    }

    #[cfg(not(unix))]
    pub fn of(path: &Path) -> Option<Identity> {
        path.canonicalize().ok().map(Identity::Path)
    }
}

/// Do two paths lead to one existing file?
pub fn same_file(a: &Path, b: &Path) -> bool {
    matches!((Identity::of(a), Identity::of(b)), (Some(a), Some(b)) if a == b)
}
