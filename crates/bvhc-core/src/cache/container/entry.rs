use std::ops::ControlFlow;

use super::Sink;
use crate::cache::meta::MAX_META_LEN;
use crate::cache::report::Place;
use crate::cache::rules;
use crate::layout::{DELTA_MIN_MINOR, Header, KINDS, KindRule, SectionEntry, SectionKind, section_flags, tree_flags};

/// Does this version know the kind, its layout and its codec?
pub fn is_understood(entry: &SectionEntry) -> bool {
    known(entry).is_some_and(|rule| rule.schema == entry.schema) && is_known_codec(entry)
}

/// What this version says about sections of this kind and number.
fn known(entry: &SectionEntry) -> Option<&'static KindRule> {
    entry.kind.rule().filter(|rule| entry.ordinal < rule.ordinals)
}

/// A codec that is assigned to sections of this kind, whether or not this build can decode it.
pub fn is_known_codec(entry: &SectionEntry) -> bool {
    match entry.codec {
        SectionEntry::RAW | SectionEntry::ZSTD => true,
        SectionEntry::DELTA => matches!(entry.kind, SectionKind::NODE | SectionKind::VPOS | SectionKind::TRIX),
        _ => false,
    }
}

/// The values of W0101 for a section that may be skipped and cannot be read: what is known, and what this is.
pub fn unread(entry: &SectionEntry) -> (String, String) {
    let known_kinds = KINDS.map(|rule| rule.kind.to_string()).join(", ");
    let SectionEntry { kind, ordinal, schema, codec, .. } = entry;
    (known_kinds, format!("{kind} {ordinal} schema {schema} codec {codec}"))
}

/// The values of E0115: the codecs that this build of the crate decodes, and the entry's.
pub fn undecodable(entry: &SectionEntry) -> (String, String) {
    let known = match cfg!(feature = "zstd") {
        true => "codec 0 (raw) and codec 1 (zstd), for NODE, VPOS and TRIX of a sequence also codec 2 (delta)",
        false => "codec 0 (raw), and was built without its feature `zstd`",
    };
    let name = match entry.codec {
        SectionEntry::ZSTD => " (zstd)",
        SectionEntry::DELTA => " (delta)",
        _ => "",
    };
    (known.into(), format!("codec {}{name}", entry.codec))
}

/// What one entry says by itself; whether its section may be read.
pub fn check(entry: &SectionEntry, at: Place, out: &mut impl Sink) -> ControlFlow<(), bool> {
    let mut sound = true;
    let mut refuse = |rule, expected: String, actual: String| {
        sound = false;
        out.breach(rule, at, || (expected, actual))
    };
    if let Some(i) = entry.reserved.iter().position(|b| *b != 0) {
        refuse(&rules::E0112, "zero".into(), format!("{} is not", 52 + i))?;
    }

    // Refuse by name what must be understood and is not; say what is left out.
    let critical = entry.is(section_flags::CRITICAL);
    match known(entry) {
        None if critical => {
            let (known_kinds, name) = unread(entry);
            refuse(&rules::E0113, known_kinds, name)?;
        }
        Some(rule) if critical && rule.schema != entry.schema => {
            refuse(&rules::E0114, format!("schema {}", rule.schema), format!("schema {}", entry.schema))?;
        }
        _ if critical && !is_known_codec(entry) => {
            let (known_codecs, codec) = undecodable(entry);
            refuse(&rules::E0115, known_codecs, codec)?;
        }
        _ if !is_understood(entry) => out.breach(&rules::W0101, at, || unread(entry))?,
        _ => {}
    }
    sound &= check_lengths(entry, at, out)?;
    if let Some(rule) = known(entry).filter(|rule| rule.schema == entry.schema) {
        sound &= check_known(entry, rule, at, out)?;
    }
    ControlFlow::Continue(sound)
}

/// Differences between poses stand in sequences alone, whose readers know them.
pub fn check_delta(entry: &SectionEntry, header: &Header, at: Place, out: &mut impl Sink) -> ControlFlow<(), bool> {
    if entry.codec != SectionEntry::DELTA || !is_known_codec(entry) {
        return ControlFlow::Continue(true);
    }
    if !header.has(tree_flags::SEQUENCE) {
        let known = "codec 0 (raw) and codec 1 (zstd) in a still file";
        out.breach(&rules::E0115, at, || (known.into(), undecodable(entry).1))?;
        return ControlFlow::Continue(false);
    }
    if header.min_minor < DELTA_MIN_MINOR {
        let (expected, actual) = (DELTA_MIN_MINOR.to_string(), header.min_minor.to_string());
        out.breach(&rules::E0130, Place::byte(12), || (expected, actual))?;
    }
    ControlFlow::Continue(true)
}

/// What every version's sections obey.
fn check_lengths(entry: &SectionEntry, at: Place, out: &mut impl Sink) -> ControlFlow<(), bool> {
    let mut sound = true;
    let mut refuse = |rule, expected: String, actual: String| {
        sound = false;
        out.breach(rule, at, || (expected, actual))
    };
    if entry.flags & !section_flags::ALL != 0 {
        refuse(&rules::E0124, format!("within {:#x}", section_flags::ALL), format!("{:#x}", entry.flags))?;
    }
    if entry.codec == SectionEntry::RAW {
        if entry.stored_len != entry.raw_len {
            let (stored, raw) = (entry.stored_len, entry.raw_len);
            let expected = "a raw section must be stored in as many bytes as it has";
            refuse(&rules::E0123, expected.into(), format!("they are {stored} and {raw}"))?;
        }
        if entry.stored_hash != entry.raw_hash {
            refuse(&rules::E0123, "a raw section must have one hash".into(), "it has two".into())?;
        }
    }
    let product = entry.elem_count.checked_mul(u64::from(entry.elem_size));
    if entry.elem_size != 0 && product != Some(entry.raw_len) {
        let expected = format!("{} records of {} bytes", entry.elem_count, entry.elem_size);
        refuse(&rules::E0123, expected, format!("{} bytes", entry.raw_len))?;
    }
    ControlFlow::Continue(sound)
}

/// What this version fixes for a kind that it knows.
fn check_known(entry: &SectionEntry, rule: &KindRule, at: Place, out: &mut impl Sink) -> ControlFlow<(), bool> {
    let mut sound = true;
    let mut refuse = |rule, expected: String, actual: String| {
        sound = false;
        out.breach(rule, at, || (expected, actual))
    };
    if entry.elem_size != rule.elem_size {
        refuse(&rules::E0122, rule.elem_size.to_string(), entry.elem_size.to_string())?;
    }
    if entry.flags != rule.flags && entry.flags & !section_flags::ALL == 0 {
        refuse(&rules::E0124, format!("{:#x}", rule.flags), format!("{:#x}", entry.flags))?;
    }
    let (what, value, most) = match entry.kind {
        SectionKind::META => ("bytes", entry.raw_len, MAX_META_LEN as u64),
        SectionKind::INST => ("records", entry.elem_count, 1 << 24),
        SectionKind::BLAS | SectionKind::GEOM | SectionKind::TOPO | SectionKind::POSE | SectionKind::FRAM => {
            ("records", entry.elem_count, u64::from(u32::MAX))
        }
        _ => ("records", 0, 0),
    };
    if value > most {
        refuse(&rules::E0129, format!("{most} {what}"), format!("it has {value}"))?;
    }
    if entry.kind == SectionKind::META && entry.elem_count != 0 {
        refuse(&rules::E0123, "META must have 0 records".into(), format!("it has {}", entry.elem_count))?;
    }
    ControlFlow::Continue(sound)
}
