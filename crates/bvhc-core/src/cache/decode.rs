//! One section's bytes: decoded, and hashed before and after.

use super::aligned::AlignedBytes;
#[cfg(not(feature = "zstd"))]
use super::container;
use super::error::Fault;
#[cfg(feature = "zstd")]
use super::pack;
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

/// The content of a packed section, which has the hash that its entry states.
#[cfg(feature = "zstd")]
pub fn unpack(entry: &SectionEntry, stored: &[u8], raw_len: usize, exec: &Executor) -> Result<AlignedBytes, Fault> {
    let raw = pack::unpack(stored, raw_len, exec)
        .map_err(|fault| Fault { detail: format!("{}: {}", entry.kind, fault.detail), ..fault })?;
    check_hash("E0202", entry, raw.as_slice(), &entry.raw_hash, exec)?;
    Ok(raw)
}

/// This build of the crate decodes nothing.
#[cfg(not(feature = "zstd"))]
pub fn unpack(entry: &SectionEntry, _stored: &[u8], _raw_len: usize, _exec: &Executor) -> Result<AlignedBytes, Fault> {
    Err(container::no_zstd(entry))
}

/// Hold bytes against the hash that a section's entry states: E0201 as they are stored, E0202 as they decode.
pub fn check_hash(
    rule: &'static str,
    entry: &SectionEntry,
    bytes: &[u8],
    want: &[u8; 32],
    exec: &Executor,
) -> Result<(), Fault> {
    if exec.hash(bytes) == *want {
        return Ok(());
    }
    let form = if rule == "E0201" { "stored" } else { "decoded" };
    Err(Fault::invalid(
        rule,
        format!("the {form} bytes of {} do not have the hash of the section table: the file is damaged", entry.kind),
    ))
}
