//! One section's bytes: decoded, and hashed before and after.

use super::aligned::AlignedBytes;
use super::container::hex;
#[cfg(not(feature = "zstd"))]
use super::container::undecodable;
use super::report::{Finding, Place};
use super::rules::{self, Rule};
#[cfg(feature = "zstd")]
use super::{delta, pack};
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

/// The content of a packed section, which has the hash that its entry states: E0205 where it cannot be decoded, E0202 where it decodes to
/// something else.
#[cfg(feature = "zstd")]
pub fn unpack(entry: &SectionEntry, stored: &[u8], raw_len: usize, exec: &Executor) -> Result<AlignedBytes, Finding> {
    let mut raw = pack::unpack(stored, raw_len, exec).map_err(|found| undecoded(entry, found))?;
    if entry.codec == SectionEntry::DELTA {
        // Only the triangles are decoded by themselves.
        let planes = raw;
        raw = AlignedBytes::zeroed(raw_len)
            .map_err(|_| undecoded(entry, format!("{raw_len} decoded bytes are more than this machine can hold")))?;
        delta::decode_triangles(planes.as_slice(), raw.as_mut_slice());
    }
    check_raw(entry, raw.as_slice(), exec)?;
    Ok(raw)
}

/// The frames of a section of codec 2, which hold `len` bytes: what the decoder of poses goes on with.
#[cfg(feature = "zstd")]
pub fn unpack_delta(entry: &SectionEntry, stored: &[u8], len: u64, exec: &Executor) -> Result<AlignedBytes, Finding> {
    let len = usize::try_from(len).unwrap_or(usize::MAX);
    pack::unpack(stored, len, exec).map_err(|found| undecoded(entry, found))
}

/// E0205: why a section does not decode.
#[cfg(feature = "zstd")]
pub fn undecoded(entry: &SectionEntry, found: String) -> Finding {
    Finding::new(&rules::E0205, place(entry), "it must decode as its entry says".into(), found)
}

/// Hold decoded bytes against the hash that the section's entry states: E0202.
#[cfg(feature = "zstd")]
pub fn check_raw(entry: &SectionEntry, raw: &[u8], exec: &Executor) -> Result<(), Finding> {
    check_hash(&rules::E0202, entry, raw, &entry.raw_hash, exec)
}

/// This build of the crate decodes nothing.
#[cfg(not(feature = "zstd"))]
pub fn unpack(
    entry: &SectionEntry,
    _stored: &[u8],
    _raw_len: usize,
    _exec: &Executor,
) -> Result<AlignedBytes, Finding> {
    let (known, found) = undecodable(entry);
    Err(Finding::new(&rules::E0115, place(entry), known, found))
}

/// Hold the bytes as they are stored against the hash that the section's entry states: E0201.
pub fn check_stored(entry: &SectionEntry, stored: &[u8], exec: &Executor) -> Result<(), Finding> {
    check_hash(&rules::E0201, entry, stored, &entry.stored_hash, exec)
}

fn check_hash(
    rule: &'static Rule,
    entry: &SectionEntry,
    bytes: &[u8],
    want: &[u8; 32],
    exec: &Executor,
) -> Result<(), Finding> {
    let found = exec.hash(bytes);
    if found == *want { Ok(()) } else { Err(Finding::new(rule, place(entry), hex(want), hex(&found))) }
}

fn place(entry: &SectionEntry) -> Place {
    Place { offset: Some(entry.offset), ..Place::of(entry) }
}
