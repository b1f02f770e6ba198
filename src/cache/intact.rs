//! Is every byte of a file still the one that was written? [`Head::read`] answers for header, table and padding; this for the rest.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use super::freshness::hash_reader;
use super::{CacheError, Head};
use crate::exec::Executor;

/// Hash the bytes of every section as they stand in the file, and hold them against the table of `head`, which was read from it.
///
/// Nothing is decoded and no record is looked at. Costs what hashing the file costs, on all threads.
///
/// # Errors
/// Where the file cannot be read or a section has another hash (E0201).
pub fn intact(path: &Path, head: &Head, exec: &Executor) -> Result<(), CacheError> {
    let io_error = |action| move |source| CacheError::Io { action, path: path.to_owned(), source };
    let mut file = File::open(path).map_err(io_error("open"))?;
    for entry in &head.sections {
        let mut of_section = || -> io::Result<[u8; 32]> {
            file.seek(SeekFrom::Start(entry.offset))?;
            Ok(hash_reader((&mut file).take(entry.stored_len), entry.stored_len, exec)?.1)
        };
        if of_section().map_err(io_error("read"))? != entry.stored_hash {
            let detail =
                format!("the bytes of {} do not have the hash of the section table: the file is damaged", entry.kind);
            return Err(CacheError::Invalid { name: path.display().to_string(), rule: "E0201", detail });
        }
    }
    Ok(())
}
