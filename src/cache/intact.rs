//! May a file be vouched for? [`Head::read`] answers for header, table and padding; this for everything else.

use std::io;
use std::path::Path;

use bvhc_core::cache::parts::Fault;

use super::check::{Level, Limits, check_bytes};
use super::{Cache, CacheError, FileBytes, Head, OpenOptions, Validation, tree_flags};
use crate::exec::Executor;

/// Prove that the file whose `head` was read is whole and sound: every byte is the one that was written, and everything that the file says
/// obeys the rules, whether or not a ray needs it. A hash alone proves the first and not the second: anybody can hash anything.
///
/// Costs what opening the file costs at [`Validation::Tree`], and a look at each vertex and name.
///
/// # Errors
/// Where the file cannot be read, is no longer the one of `head`, is damaged, breaks a rule, or does not fit the memory that `open` allows.
pub fn intact(path: &Path, head: &Head, open: &OpenOptions, exec: &Executor) -> Result<(), CacheError> {
    let replaced = || CacheError::io("read", path)(io::Error::other("another file took its place"));
    if head.header.has(tree_flags::SEQUENCE) {
        sound_sequence(path, open, exec)?;
        return if Head::read(path, open)?.header.file_id == head.header.file_id { Ok(()) } else { Err(replaced()) };
    }
    let cache = Cache::open_on(path, &OpenOptions { validation: Validation::Hash, ..*open }, exec)?;
    if cache.header().file_id != head.header.file_id {
        return Err(replaced());
    }
    let limits = Limits { max_issues: 1, ..Limits::default() };
    Fault::of_report(&cache.check(&limits, exec)).map_err(|fault| fault.of(&path.display().to_string()))
}

/// Hold everything in a file of many frames against the rules: every byte, row, pose and placement.
///
/// # Errors
/// Where it cannot be read, breaks a rule, or does not fit the memory that `open` allows.
pub fn sound_sequence(path: &Path, open: &OpenOptions, exec: &Executor) -> Result<(), CacheError> {
    let bytes = FileBytes::open(path, open)?;
    let limits = Limits { max_issues: 1, max_memory: open.max_memory };
    let report = check_bytes(bytes.as_slice(), Level::Tree, None, &limits, exec);
    Fault::of_report(&report).map_err(|fault| fault.of(&path.display().to_string()))
}
