//! Compressed sections: what is decoded is what an independent decoder gives, within the bytes that the table promised.
//!
//! An input is the kind of section (one byte), its decoded length (four), and its bytes in the file.

use super::{Target, limit};
use crate::guard::within;
use crate::mutate::packed;
use crate::planted::Seen;
use crate::vectors::{bytes, valid};
use bvhc::cache::check::{Level, Limits, check_bytes};
use bvhc::cache::{Cache, Header, OpenOptions, SectionEntry, SectionKind, Validation};
use bvhc::exec::Executor;
use std::sync::OnceLock;

pub const TARGET: Target = Target {
    name: "decoding",
    run,
    change: packed::change,
    faults: &["uses a window", "does not state its content size", "uses a dictionary"],
};

/// The file's own bytes, what it decodes to within the limit, and what is told of it.
fn allowance(file: &[u8], input: &[u8]) -> usize {
    limit(input) as usize + 8 * file.len() + (64 << 10)
}

/// Most decoded bytes; three frames and a bit.
const MOST: u32 = 3 << 20 | 0xff;

fn run(input: &[u8]) -> Seen {
    let Some((head, stored)) = input.split_at_checked(5) else { return Seen::new() };
    let raw_len = u32::from_le_bytes([head[1], head[2], head[3], head[4]]) % MOST;
    let decoded = independent(stored, raw_len as usize);
    let (file, place) = file_of(head[0], stored, raw_len, decoded.as_deref());

    let options = OpenOptions { validation: Validation::Hash, max_memory: limit(input), ..OpenOptions::default() };
    let mut seen = Seen::new();
    match within(allowance(&file, input), || Cache::from_bytes(&file, &options)) {
        Ok(cache) => match cache.section_bytes(place) {
            Some(raw) => {
                assert_eq!(raw.len(), raw_len as usize);
                assert!(decoded.as_deref() == Some(raw), "two decoders of the same bytes differ");
            }
            None => seen.extend(cache.meta_error().map(str::to_owned)),
        },
        Err(error) => seen.push(error.to_string()),
    }
    let limits = Limits { max_memory: limit(input), ..Limits::default() };
    let report =
        within(allowance(&file, input), || check_bytes(&file, Level::Hash, None, &limits, &Executor::sequential()));
    seen.extend(report.findings.iter().map(ToString::to_string));
    seen
}

/// A file's header, and its sections with their bytes.
type TakenApart = (Header, Vec<(SectionEntry, Vec<u8>)>);

/// A small file with such a section: one that is not known, the provenance, or the names.
fn file_of(kind: u8, stored: &[u8], raw_len: u32, decoded: Option<&[u8]>) -> (Vec<u8>, usize) {
    static BASE: OnceLock<TakenApart> = OnceLock::new();
    let (header, sections) = BASE.get_or_init(|| bytes::take_apart(&valid::unknown_ancillary()));
    let mut sections = sections.clone();
    let wanted = [SectionKind(*b"XTRA"), SectionKind::META, SectionKind::NAMS][usize::from(kind) % 3];
    let place = sections.iter().position(|(e, _)| e.kind == wanted).unwrap_or(sections.len() - 1);
    let (entry, data) = &mut sections[place];
    entry.codec = SectionEntry::ZSTD;
    entry.raw_len = u64::from(raw_len);
    entry.raw_hash = decoded.map_or([0; 32], |raw| *blake3::hash(raw).as_bytes());
    *data = stored.to_vec();
    (bytes::put_together(*header, sections), place)
}

/// The frames, each by itself, by the specification alone.
fn independent(stored: &[u8], raw_len: usize) -> Option<Vec<u8>> {
    const BLOCK: usize = 1 << 20;
    let word = |at: usize| stored.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let count = raw_len.div_ceil(BLOCK);
    let mut at = 8 + 4 * count;
    let mut raw = Vec::new();
    for i in 0..count {
        let len = word(8 + 4 * i)?;
        let frame = stored.get(at..at.checked_add(len)?)?;
        raw.extend(zstd::bulk::decompress(frame, BLOCK.min(raw_len - i * BLOCK)).ok()?);
        at += len;
    }
    (raw.len() == raw_len).then_some(raw)
}
