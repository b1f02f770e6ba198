//! What the front of a file says, read without touching the trees.

use std::path::Path;

use super::container::{self, Container};
use super::decode::unpack;
use super::error::{CacheError, Fault};
use super::file_bytes::FileBytes;
use super::options::OpenOptions;
use super::{MAX_META_LEN, Meta};
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
        Head::parse(bytes.as_slice()).map_err(|fault| fault.of(&path.display().to_string()))
    }

    fn parse(file: &[u8]) -> Result<Head, Fault> {
        let container = Container::parse(file)?;
        container.check_head()?;
        let meta = container.find(SectionKind::META, 0);
        let Container { header, entries, .. } = container;
        let (meta, meta_error) = match meta.and_then(|i| entries.get(i)) {
            Some(entry) => match read_meta(file, entry)? {
                Ok(meta) => (Some(meta), None),
                Err(fault) => (None, Some(fault.to_string())),
            },
            None => (None, container::later_meta(&entries)),
        };
        Ok(Head { header, sections: entries, meta, meta_error })
    }
}

/// The outer error is damage; the inner one is a META that its writer made so.
fn read_meta(file: &[u8], entry: &SectionEntry) -> Result<Result<Meta, Fault>, Fault> {
    // The container's rules put every section inside the file.
    let range = usize::try_from(entry.offset).ok().zip(entry.end().and_then(|end| usize::try_from(end).ok()));
    let stored = range.and_then(|(start, end)| file.get(start..end)).unwrap_or_default();
    if Executor::sequential().hash(stored) != entry.stored_hash {
        return Err(Fault::invalid(
            "E0201",
            "the bytes of META do not have the hash of the section table: the file is damaged",
        ));
    }
    Ok(decode(stored, entry))
}

fn decode(stored: &[u8], entry: &SectionEntry) -> Result<Meta, Fault> {
    match (entry.codec, usize::try_from(entry.raw_len)) {
        (SectionEntry::RAW, _) => Meta::decode(stored),
        (_, Ok(raw_len)) if raw_len <= MAX_META_LEN => {
            Meta::decode(unpack(entry, stored, raw_len, &Executor::sequential())?.as_slice())
        }
        _ => Err(Fault::invalid("E0206", format!("META may have {MAX_META_LEN} bytes and has {}", entry.raw_len))),
    }
}
