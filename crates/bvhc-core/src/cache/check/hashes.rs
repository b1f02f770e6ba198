//! The bytes of each section: hashed as stored, decoded, hashed again.

#[cfg(feature = "zstd")]
use super::moved;
use super::{Limits, check_rows};
use crate::cache::container::{Container, is_known_codec};
use crate::cache::decode::{Decoded, check_stored, unpack};
use crate::cache::report::{Place, Report};
#[cfg(feature = "zstd")]
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
    let packed = |(i, stored): &&(usize, Option<&[u8]>)| {
        stored.is_some() && container.entries[*i].is_packed() && is_known_codec(&container.entries[*i])
    };
    let total: u128 = sections.iter().filter(packed).map(|(i, _)| u128::from(container.entries[*i].raw_len)).sum();
    let fits = total <= u128::from(limits.max_memory);
    if !fits {
        out.exceed(total, limits.max_memory, |total| format!("the sections decode to {total}"));
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
    #[cfg(feature = "zstd")]
    if may == May::Decode && container.entries.iter().any(is_of_blocks) {
        moved::decode(container, file, &mut decoded, limits, out, exec);
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
    if let Err(damage) = check_stored(entry, stored, exec) {
        out.add_finding(damage);
        out.skip(format!("Section {}: it is damaged.", Place::of(entry)));
        return None;
    }
    match entry.codec {
        SectionEntry::RAW => Some(Decoded::InFile(stored)),
        SectionEntry::ZSTD | SectionEntry::DELTA if may == May::OnlyOthers && entry.is(section_flags::CONTENT) => {
            out.skip(format!("Section {}: it is not decoded, for the counts contradict each other.", Place::of(entry)));
            None
        }
        #[cfg(not(feature = "zstd"))]
        SectionEntry::ZSTD | SectionEntry::DELTA if may != May::Nothing => {
            if let (true, Err(found)) = (entry.is(section_flags::CRITICAL), unpack(entry, stored, 0, exec)) {
                out.add_finding(found);
            }
            out.skip(format!("Section {}: bvhc-core was built without its feature `zstd`.", Place::of(entry)));
            None
        }
        #[cfg(feature = "zstd")]
        SectionEntry::ZSTD | SectionEntry::DELTA if may != May::Nothing && !is_of_blocks(entry) => {
            // A length beyond this machine's is refused as one that it has not got the memory for.
            let raw_len = usize::try_from(entry.raw_len).unwrap_or(usize::MAX);
            match unpack(entry, stored, raw_len, exec) {
                Ok(decoded) => Some(Decoded::Owned(decoded)),
                Err(found) => {
                    let why =
                        if found.rule == &rules::E0202 { "decodes to something else" } else { "cannot be decoded" };
                    out.add_finding(found);
                    out.skip(format!("Section {}: it {why}.", Place::of(entry)));
                    None
                }
            }
        }
        // What is of blocks is decoded when all others are.
        _ => None,
    }
}

/// Whether a section is decoded with others of its kind, and not by itself.
#[cfg(feature = "zstd")]
fn is_of_blocks(entry: &SectionEntry) -> bool {
    entry.codec == SectionEntry::DELTA && entry.kind != SectionKind::TRIX
}
