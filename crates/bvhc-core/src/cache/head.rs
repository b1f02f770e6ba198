//! What the front of a file says, read without touching the trees.

use std::path::Path;

use super::Meta;
use super::container::{self, Container};
use super::decode::{check_stored, unpack};
use super::error::{Brief, CacheError, Fault};
use super::file_bytes::FileBytes;
use super::options::OpenOptions;
use super::report::Finding;
use crate::exec::Executor;
use crate::layout::{Header, SectionEntry, SectionKind};

/// A file's header, table and provenance, held against the container's rules.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Head {
    /// Magic, versions, length and flags are checked; counts are what the file says of itself.
    pub header: Header,
    /// The section table, unknown sections included.
    pub sections: Vec<SectionEntry>,
    /// `None` for a file without META, and for one whose META cannot be read.
    pub meta: Option<Meta>,
    /// Why it cannot, as [`Cache::meta_error`](super::Cache::meta_error).
    pub meta_error: Option<String>,
}

impl Head {
    /// Read the head of a file; no other section is read or decoded, so it takes the same time for any size.
    ///
    /// # Errors
    /// As [`Cache::open_with`](super::Cache::open_with) at [`Validation::Quick`](super::Validation::Quick).
    pub fn read(path: &Path, options: &OpenOptions) -> Result<Head, CacheError> {
        let bytes = FileBytes::open(path, options)?;
        Head::parse(bytes.as_slice()).map_err(|breach| Fault::from(breach).of(&path.display().to_string()))
    }

    fn parse(file: &[u8]) -> Result<Head, Finding> {
        let container = Container::parse(file)?;
        container.check_head()?;
        let meta = container.find(SectionKind::META, 0);
        let Container { header, entries, .. } = container;
        let (meta, meta_error) = match meta.and_then(|i| entries.get(i)) {
            Some(entry) => match read_meta(file, entry)? {
                Ok(meta) => (Some(meta), None),
                Err(breach) => (None, Some(Brief(&breach).to_string())),
            },
            None => (None, container::later_meta(&entries).map(|unread| Brief(&unread).to_string())),
        };
        Ok(Head { header, sections: entries, meta, meta_error })
    }
}

/// The outer error is damage; the inner one is a META that its writer made so.
fn read_meta(file: &[u8], entry: &SectionEntry) -> Result<Result<Meta, Finding>, Finding> {
    // The container's rules put every section inside the file.
    let range = usize::try_from(entry.offset).ok().zip(entry.end().and_then(|end| usize::try_from(end).ok()));
    let stored = range.and_then(|(start, end)| file.get(start..end)).unwrap_or_default();
    let exec = Executor::sequential();
    check_stored(entry, stored, &exec)?;
    Ok(decode(stored, entry, &exec))
}

fn decode(stored: &[u8], entry: &SectionEntry, exec: &Executor) -> Result<Meta, Finding> {
    match entry.codec {
        SectionEntry::RAW => Meta::decode(stored),
        // A rule of the container bounds the decoded length (E0129).
        _ => Meta::decode(unpack(entry, stored, entry.raw_len as usize, exec)?.as_slice()),
    }
}
