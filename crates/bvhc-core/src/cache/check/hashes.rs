//! The bytes of each section: hashed as stored, decoded, hashed again.

#[cfg(feature = "zstd")]
use std::borrow::Cow;

use super::{Limits, check_rows};
#[cfg(feature = "zstd")]
use crate::cache::aligned::AlignedBytes;
use crate::cache::container::{Container, hex};
use crate::cache::decode::Decoded;
use crate::cache::report::{Place, Report};
use crate::cache::rules;
use crate::exec::Executor;
use crate::layout::{BlasRecord, SectionEntry, SectionKind, section_flags};

/// What became of the sections.
pub struct Sections<'a> {
    /// For each entry of the table its decoded bytes; `None` where the content is not to be had.
    pub decoded: Vec<Option<Decoded<'a>>>,
    /// What the rows of BLAS contradict. They are asked here where something is compressed, and with the records once more: whoever does not
    /// go on to those tells this.
    pub rows: Report,
}

/// Check every section's hashes and decode what is compressed.
///
/// `agree`: the counts of header and table agree. Where they or the rows of BLAS do not, no records are decoded.
pub fn check<'a>(
    container: &Container,
    file: &'a [u8],
    agree: bool,
    limits: &Limits,
    out: &mut Report,
    exec: &Executor,
) -> Sections<'a> {
    // Hold what decoding would take against the limit before anything is allocated.
    let sections: Vec<_> = (0..container.entries.len()).map(|i| (i, container.stored(file, i))).collect();
    let packed =
        |(i, stored): &&(usize, Option<&[u8]>)| stored.is_some() && container.entries[*i].codec == SectionEntry::ZSTD;
    let total: u128 = sections.iter().filter(packed).map(|(i, _)| u128::from(container.entries[*i].raw_len)).sum();
    let fits = total <= u128::from(limits.max_memory);
    if !fits {
        out.add(&rules::E0127, Place::file(), || {
            (format!("{} bytes", limits.max_memory), format!("the sections decode to {total} bytes"))
        });
        out.skip("The compressed sections: they are larger than the memory limit.");
    }
    let look = |i: usize, stored: Option<&'a [u8]>, may: May| {
        let mut part = Report::new(limits.max_issues);
        let decoded = stored.and_then(|stored| check_section(&container.entries[i], stored, may, &mut part, exec));
        (part, decoded)
    };

    // The rows of BLAS come first: what they contradict is not worth decoding.
    let blas = container.find(SectionKind::BLAS, 0);
    let mut first = blas.map(|i| look(i, container.stored(file, i), May::new(fits, agree)));
    let mut rows = Report::new(limits.max_issues);
    if total > 0
        && let Some((_, Some(decoded))) = &first
    {
        let count = |kind| container.find(kind, 0).map_or(0, |i| container.entries[i].elem_count);
        // Bytes that start anywhere are looked at row by row.
        let blases: Vec<BlasRecord> =
            decoded.as_slice().chunks_exact(size_of::<BlasRecord>()).map(bytemuck::pod_read_unaligned).collect();
        _ = check_rows(&blases, count(SectionKind::NODE), count(SectionKind::TRIS), &mut rows);
    }
    let may = May::new(fits, agree && rows.is_clean());
    let others = sections.into_iter().filter(|(i, _)| Some(*i) != blas).collect();
    let mut parts = exec.map(others, |_, (i, stored)| look(i, stored, may)).into_iter();
    let mut decoded = Vec::with_capacity(container.entries.len());
    for i in 0..container.entries.len() {
        let taken = if Some(i) == blas { first.take() } else { parts.next() };
        decoded.push(taken.and_then(|(part, bytes)| {
            out.append(part);
            bytes
        }));
    }
    Sections { decoded, rows }
}

/// Whether compressed sections may be decoded.
#[derive(Clone, Copy, PartialEq, Eq)]
enum May {
    Decode,
    /// The counts contradict each other: only what is not records.
    OnlyOthers,
    /// They are larger than the limit, which has been said.
    Nothing,
}

impl May {
    fn new(fits: bool, agree: bool) -> May {
        match (fits, agree) {
            (true, true) => May::Decode,
            (true, false) => May::OnlyOthers,
            (false, _) => May::Nothing,
        }
    }
}

/// Why a section is not to be had that was compressed so, if it is its own fault.
pub fn check_packed(entry: &SectionEntry, stored: &[u8], out: &mut Report, exec: &Executor) {
    _ = check_section(entry, stored, May::Decode, out, exec);
}

fn check_section<'a>(
    entry: &SectionEntry,
    stored: &'a [u8],
    may: May,
    out: &mut Report,
    exec: &Executor,
) -> Option<Decoded<'a>> {
    let at = Place { offset: Some(entry.offset), ..Place::of(entry) };
    let found = exec.hash(stored);
    if found != entry.stored_hash {
        out.add(&rules::E0201, at, || (hex(&entry.stored_hash), hex(&found)));
        out.skip(format!("Section {}: it is damaged.", entry.kind));
        return None;
    }
    match entry.codec {
        SectionEntry::RAW => Some(Decoded::InFile(stored)),
        SectionEntry::ZSTD if may == May::OnlyOthers && entry.is(section_flags::CONTENT) => {
            out.skip(format!("Section {}: it is not decoded, for the counts contradict each other.", entry.kind));
            None
        }
        #[cfg(not(feature = "zstd"))]
        SectionEntry::ZSTD if may != May::Nothing => {
            if entry.is(section_flags::CRITICAL) {
                let known = "codec 0 (raw), since it was built without its feature `zstd`";
                out.add(&rules::E0115, at, || (known.into(), "codec 1 (zstd)".into()));
            }
            out.skip(format!("Section {}: bvhc-core was built without its feature `zstd`.", entry.kind));
            None
        }
        #[cfg(feature = "zstd")]
        SectionEntry::ZSTD if may != May::Nothing => {
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
