//! The bytes of each section: hashed as stored, decoded, hashed again.

#[cfg(feature = "zstd")]
use std::borrow::Cow;

use super::Limits;
use super::container::{Layout, hex};
use super::report::{Place, Report};
use crate::cache::aligned::AlignedBytes;
use crate::cache::rules;
use crate::exec::Executor;
use crate::layout::SectionEntry;

/// A section's decoded bytes, aligned for its records.
pub enum Decoded<'a> {
    InFile(&'a [u8]),
    Owned(AlignedBytes),
}

impl Decoded<'_> {
    pub fn as_slice(&self) -> &[u8] {
        match self {
            Decoded::InFile(bytes) => bytes,
            Decoded::Owned(bytes) => bytes.as_slice(),
        }
    }
}

/// Check every section's hashes and decode what is compressed. `None` for a section whose content is not to be had.
pub fn check<'a>(layout: &Layout<'a>, limits: &Limits, out: &mut Report, exec: &Executor) -> Vec<Option<Decoded<'a>>> {
    // Hold what decoding would take against the limit before anything is allocated.
    let sections = || layout.entries.iter().zip(&layout.stored);
    let packed = sections().filter(|(e, stored)| stored.is_some() && e.codec == SectionEntry::ZSTD);
    let total: u128 = packed.map(|(e, _)| u128::from(e.raw_len)).sum();
    let fits = total <= u128::from(limits.max_memory);
    if !fits {
        out.add(&rules::E0127, Place::file(), || (limits.max_memory.to_string(), total.to_string()));
        out.skip("The compressed sections: they are larger than the memory limit.");
    }
    let parts = exec.map(sections().collect(), |_, (entry, stored)| {
        let mut part = Report::new(limits.max_issues);
        let decoded = stored.and_then(|stored| check_section(entry, stored, fits, &mut part, exec));
        (part, decoded)
    });
    parts
        .into_iter()
        .map(|(part, decoded)| {
            out.append(part);
            decoded
        })
        .collect()
}

fn check_section<'a>(
    entry: &SectionEntry,
    stored: &'a [u8],
    fits: bool,
    out: &mut Report,
    exec: &Executor,
) -> Option<Decoded<'a>> {
    let at = Place { offset: Some(entry.offset), ..Place::section(entry.kind) };
    let found = exec.hash(stored);
    if found != entry.stored_hash {
        out.add(&rules::E0201, at, || (hex(&entry.stored_hash), hex(&found)));
        out.skip(format!("Section {}: it is damaged.", entry.kind));
        return None;
    }
    match entry.codec {
        SectionEntry::RAW => Some(Decoded::InFile(stored)),
        #[cfg(not(feature = "zstd"))]
        SectionEntry::ZSTD if fits => {
            out.skip(format!("Section {}: bvhc-core was built without its feature `zstd`.", entry.kind));
            None
        }
        #[cfg(feature = "zstd")]
        SectionEntry::ZSTD if fits => {
            let decoded = match decode(entry, stored, exec) {
                Ok(decoded) => decoded,
                Err(detail) => {
                    out.add(&rules::E0205, at, || ("it must decode as its entry says".into(), detail.into_owned()));
                    out.skip(format!("Section {}: it cannot be decoded.", entry.kind));
                    return None;
                }
            };
            let found = exec.hash(decoded.as_slice());
            if found != entry.raw_hash {
                out.add(&rules::E0202, at, || (hex(&entry.raw_hash), hex(&found)));
                out.skip(format!("Section {}: it decodes to something else.", entry.kind));
                return None;
            }
            Some(Decoded::Owned(decoded))
        }
        _ => None,
    }
}

/// The frames are held against `raw_len` before it sizes anything.
#[cfg(feature = "zstd")]
fn decode(entry: &SectionEntry, stored: &[u8], exec: &Executor) -> Result<AlignedBytes, Cow<'static, str>> {
    let len = usize::try_from(entry.raw_len).map_err(|_| "it is too large for this machine")?;
    crate::cache::pack::unpack(stored, len, exec).map_err(|fault| fault.detail.into())
}
