//! The container checks, which every file passes before anything in it is used: header, table, tiling.
//!
//! They stop at the first broken rule; [`check`](super::check) is the twin that collects all of them. Their cost depends on the
//! number of sections, not on the length of the file.

use bytemuck::{Zeroable, bytes_of_mut, cast_slice_mut};

use super::error::Fault;
use super::keys;
use super::meta::MAX_META_LEN;
use crate::layout::{
    Header, KINDS, KNOWN_REQUIRED_FEATURES, MAGIC, MAJOR, MAX_SECTIONS, MINOR, Presence, SectionEntry, SectionKind,
    section_flags, tree_flags,
};

/// A file's header and table, held against each other, the file's length and its padding.
#[derive(Debug)]
pub struct Container {
    pub header: Header,
    pub entries: Vec<SectionEntry>,
}

impl Container {
    pub fn parse(file: &[u8]) -> Result<Container, Fault> {
        let header = parse_header(file)?;
        let entries = parse_table(file, &header)?;
        check_tiling(file, &header, &entries)?;
        entries.iter().try_for_each(check_entry)?;
        check_unique(&entries)?;
        check_presence(&header, &entries)?;
        Ok(Container { header, entries })
    }
}

/// Does this version know the kind, its layout and its codec?
pub fn is_understood(entry: &SectionEntry) -> bool {
    let known = entry.kind.rule().is_some_and(|rule| rule.schema == entry.schema && entry.ordinal == 0);
    known && is_known_codec(entry.codec)
}

/// Why the META of a file cannot be read by this version, if there is one that cannot.
pub fn later_meta(entries: &[SectionEntry]) -> Option<String> {
    let entry = entries.iter().find(|e| e.kind == SectionKind::META && e.ordinal == 0 && !is_understood(e))?;
    let (schema, codec) = (entry.schema, entry.codec);
    Some(format!("META has schema {schema} and codec {codec}, which this bvhc does not know (W0101)"))
}

pub fn is_known_codec(codec: u8) -> bool {
    matches!(codec, SectionEntry::RAW | SectionEntry::ZSTD)
}

/// The file may be sound, but this build of the crate decodes no compressed sections.
#[cfg(not(feature = "zstd"))]
pub fn no_zstd(entry: &SectionEntry) -> Fault {
    let kind = entry.kind;
    Fault::unsupported(
        "E0115",
        format!("section {kind} is compressed by zstd, and bvhc-core was built without its feature `zstd`"),
    )
}

fn parse_header(file: &[u8]) -> Result<Header, Fault> {
    // Say what kind of file it is before anything else is believed.
    let mut header = Header::zeroed();
    if !file.starts_with(&MAGIC) {
        let start = file[..file.len().min(8)].escape_ascii();
        let detail = match file.len() {
            0 => "it is empty".to_string(),
            _ => format!("it does not start as a .bvhc file does but with \"{start}\""),
        };
        return Err(Fault::invalid("E0102", detail));
    }
    match file.get(..Header::LEN) {
        Some(bytes) => bytes_of_mut(&mut header).copy_from_slice(bytes),
        None => {
            return Err(Fault::invalid(
                "E0101",
                format!("a header has {} bytes and the file {}", Header::LEN, file.len()),
            ));
        }
    }
    if header.major != MAJOR {
        let detail =
            format!("it has format version {}.{} and this bvhc reads version {MAJOR}", header.major, header.minor);
        return Err(Fault::unsupported("E0103", detail));
    }
    if header.min_minor > header.minor {
        let detail = format!(
            "it needs a reader of version {MAJOR}.{} and says that version {MAJOR}.{} wrote it",
            header.min_minor, header.minor
        );
        return Err(Fault::unsupported("E0128", detail));
    }
    if header.min_minor > MINOR {
        let detail =
            format!("it needs a reader of version {MAJOR}.{} and this one is {MAJOR}.{MINOR}", header.min_minor);
        return Err(Fault::unsupported("E0104", detail));
    }
    let unknown = header.features_required & !KNOWN_REQUIRED_FEATURES;
    if unknown != 0 {
        let detail = format!(
            "it requires feature {} (bits {unknown:#x}), which this bvhc does not know",
            unknown.trailing_zeros()
        );
        return Err(Fault::unsupported("E0107", detail));
    }

    // Hold the rest of the header against the file and its own rules.
    let rule = |holds: bool, id, detail: String| if holds { Ok(()) } else { Err(Fault::invalid(id, detail)) };
    let header_len = usize::from(header.header_len);
    rule(
        header_len == Header::LEN
            || header.minor > MINOR
                && header_len > Header::LEN
                && header_len.is_multiple_of(64)
                && header_len <= file.len(),
        "E0105",
        format!(
            "header_len must be {}, or in a later version a larger multiple of 64 within the file, and is {header_len}",
            Header::LEN
        ),
    )?;
    rule(
        header.file_len == file.len() as u64 && header.file_len.is_multiple_of(64),
        "E0106",
        format!("the header states {} bytes, a multiple of 64, and the file has {}", header.file_len, file.len()),
    )?;
    let reserved_is_zero = header.reserved == [0; 32];
    rule(reserved_is_zero, "E0111", "bytes 224 to 255 of the header must be zero and are not".into())?;
    check_tree_flags(header.tree_flags)?;
    Ok(header)
}

pub fn check_tree_flags(flags: u32) -> Result<(), Fault> {
    use tree_flags::{CANONICAL_DFS, DUP_REFS, REFITTABLE, TWO_LEVEL};
    let unknown = flags & !(CANONICAL_DFS | DUP_REFS | REFITTABLE | TWO_LEVEL);
    let either = (flags & REFITTABLE != 0) != (flags & DUP_REFS != 0);
    if unknown == 0 && either && flags & CANONICAL_DFS != 0 {
        return Ok(());
    }
    let detail = format!(
        "tree_flags must be CANONICAL_DFS, one of REFITTABLE and DUP_REFS, and perhaps TWO_LEVEL, and are {flags:#x}"
    );
    Err(Fault::invalid("E0126", detail))
}

fn parse_table(file: &[u8], header: &Header) -> Result<Vec<SectionEntry>, Fault> {
    if header.section_count > MAX_SECTIONS {
        let detail =
            format!("a file has at most {MAX_SECTIONS} sections and the header states {}", header.section_count);
        return Err(Fault::invalid("E0108", detail));
    }
    if header.section_entry_len as usize != SectionEntry::LEN {
        let detail = format!("section_entry_len must be {} and is {}", SectionEntry::LEN, header.section_entry_len);
        return Err(Fault::invalid("E0109", detail));
    }
    let start = usize::from(header.header_len);
    let len = header.section_count as usize * SectionEntry::LEN;
    let table = match file.get(start..).and_then(|rest| rest.get(..len)) {
        Some(table) if header.section_table_off == start as u64 => table,
        _ => {
            let at = header.section_table_off;
            let detail =
                format!("{len} bytes of table must stand at byte {start} and the header puts them at byte {at}");
            return Err(Fault::invalid("E0110", detail));
        }
    };

    // Header and table are believed only together: everything that follows is covered by their hash.
    let found = keys::file_id(header, &file[Header::LEN..start], table);
    if found != header.file_id {
        let detail = "header and table do not have the stated file_id: the file is damaged".to_owned();
        return Err(Fault::invalid("E0203", detail));
    }
    let mut entries = vec![SectionEntry::zeroed(); header.section_count as usize];
    cast_slice_mut::<_, u8>(&mut entries).copy_from_slice(table);
    Ok(entries)
}

fn check_tiling(file: &[u8], header: &Header, entries: &[SectionEntry]) -> Result<(), Fault> {
    let mut end = header.section_table_off + entries.len() as u64 * SectionEntry::LEN as u64;
    for entry in entries {
        let kind = entry.kind;
        if !(SectionEntry::MIN_ALIGN_LOG2..=SectionEntry::MAX_ALIGN_LOG2).contains(&entry.align_log2) {
            return Err(Fault::invalid(
                "E0116",
                format!("align_log2 of {kind} must be 6 to 16 and is {}", entry.align_log2),
            ));
        }
        let align = 1u64 << entry.align_log2;
        if !entry.offset.is_multiple_of(align) {
            return Err(Fault::invalid(
                "E0116",
                format!("{kind} must start at a multiple of {align} and starts at {}", entry.offset),
            ));
        }
        if entry.offset < end {
            return Err(Fault::invalid(
                "E0118",
                format!("{kind} must start at byte {end} or later and starts at {}", entry.offset),
            ));
        }
        let section_end = match entry.end() {
            Some(section_end) if section_end <= header.file_len => section_end,
            _ => {
                let (at, len) = (entry.offset, entry.stored_len);
                let detail = format!("{kind}, {len} bytes at byte {at}, must end by byte {}", header.file_len);
                return Err(Fault::invalid("E0117", detail));
            }
        };
        check_gap(file, end, entry.offset, align)?;
        end = section_end;
    }
    check_gap(file, end, header.file_len, 64)
}

/// Bytes between two regions: fewer than the next region's alignment, all zero.
fn check_gap(file: &[u8], from: u64, to: u64, align: u64) -> Result<(), Fault> {
    if to - from >= align {
        return Err(Fault::invalid(
            "E0120",
            format!("padding at byte {from} must be under {align} bytes and has {}", to - from),
        ));
    }
    // Both ends are at most the file's length, so they fit.
    match file[from as usize..to as usize].iter().position(|&b| b != 0) {
        Some(i) => Err(Fault::invalid("E0119", format!("padding must be zero and byte {} is not", from + i as u64))),
        None => Ok(()),
    }
}

fn check_entry(entry: &SectionEntry) -> Result<(), Fault> {
    let (kind, critical) = (entry.kind, entry.is(section_flags::CRITICAL));
    if entry.reserved != [0; 12] {
        return Err(Fault::invalid("E0112", format!("bytes 52 to 63 of the entry of {kind} must be zero and are not")));
    }

    // Refuse by name what must be understood and is not; let the rest pass.
    let rule = kind.rule().filter(|_| entry.ordinal == 0);
    if rule.is_none() && critical {
        let detail = format!("section {kind} {} must be understood and this bvhc does not know it", entry.ordinal);
        return Err(Fault::unsupported("E0113", detail));
    }
    if let Some(rule) = rule
        && rule.schema != entry.schema
        && critical
    {
        let detail = format!("section {kind} has schema {} and this bvhc knows schema {}", entry.schema, rule.schema);
        return Err(Fault::unsupported("E0114", detail));
    }
    if !is_known_codec(entry.codec) && critical {
        let detail = format!("section {kind} has codec {} and this bvhc knows 0 (raw) and 1 (zstd)", entry.codec);
        return Err(Fault::unsupported("E0115", detail));
    }

    // What every version's sections obey.
    if entry.flags & !section_flags::ALL != 0 {
        return Err(Fault::invalid(
            "E0124",
            format!("flags of {kind} may use bits {:#x} and are {:#x}", section_flags::ALL, entry.flags),
        ));
    }
    let raw = entry.codec == SectionEntry::RAW;
    if raw && entry.stored_len != entry.raw_len {
        let detail = format!(
            "{kind} is raw and must have as many stored bytes as raw ones, not {} and {}",
            entry.stored_len, entry.raw_len
        );
        return Err(Fault::invalid("E0123", detail));
    }
    if raw && entry.stored_hash != entry.raw_hash {
        return Err(Fault::invalid("E0123", format!("{kind} is raw and must have one hash, not two")));
    }
    let product = entry.elem_count.checked_mul(u64::from(entry.elem_size));
    if entry.elem_size != 0 && product != Some(entry.raw_len) {
        let detail = format!(
            "{kind} has {} records of {} bytes and states {} bytes",
            entry.elem_count, entry.elem_size, entry.raw_len
        );
        return Err(Fault::invalid("E0123", detail));
    }
    check_known(entry)
}

/// What this version fixes for the kinds that it knows.
fn check_known(entry: &SectionEntry) -> Result<(), Fault> {
    let kind = entry.kind;
    let Some(rule) = kind.rule().filter(|rule| entry.ordinal == 0 && rule.schema == entry.schema) else {
        return Ok(());
    };
    if entry.elem_size != rule.elem_size {
        return Err(Fault::invalid(
            "E0122",
            format!("records of {kind} have {} bytes and the entry states {}", rule.elem_size, entry.elem_size),
        ));
    }
    if entry.flags != rule.flags {
        return Err(Fault::invalid(
            "E0124",
            format!("flags of {kind} must be {:#x} and are {:#x}", rule.flags, entry.flags),
        ));
    }
    let (what, value, most) = match kind {
        SectionKind::META => ("bytes", entry.raw_len, MAX_META_LEN as u64),
        SectionKind::INST => ("records", entry.elem_count, 1 << 24),
        SectionKind::BLAS | SectionKind::GEOM => ("records", entry.elem_count, u64::from(u32::MAX)),
        _ => return Ok(()),
    };
    if value > most {
        return Err(Fault::invalid("E0129", format!("{kind} may have {most} {what} and has {value}")));
    }
    Ok(())
}

/// Sorted, because a hostile table has 65 536 entries.
fn check_unique(entries: &[SectionEntry]) -> Result<(), Fault> {
    let mut names: Vec<(SectionKind, u32)> = entries.iter().map(|e| (e.kind, e.ordinal)).collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(&[(kind, ordinal), _]) => {
            Err(Fault::invalid("E0121", format!("a file has one section {kind} {ordinal} and this one has two")))
        }
        _ => Ok(()),
    }
}

fn check_presence(header: &Header, entries: &[SectionEntry]) -> Result<(), Fault> {
    let two_level = header.has(tree_flags::TWO_LEVEL);
    for rule in &KINDS {
        let present = entries.iter().any(|e| e.kind == rule.kind && is_understood(e));
        let wanted = match rule.presence {
            Presence::Always => true,
            Presence::TwoLevel => two_level,
            Presence::Optional => continue,
        };
        if present != wanted {
            let (kind, verb) = (rule.kind, if wanted { "lacks" } else { "has" });
            let kind_of_file = if two_level { "a two-level file" } else { "a file without TWO_LEVEL" };
            let must = if wanted { "must have" } else { "has no" };
            return Err(Fault::invalid(
                "E0125",
                format!("{kind_of_file} {must} a section {kind} and this one {verb} it"),
            ));
        }
    }
    Ok(())
}
