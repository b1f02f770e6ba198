//! Header, section table and tiling, collected. The reader's own checks of the same rules stop at the first.

use bytemuck::{Zeroable, bytes_of_mut, cast_slice_mut};

use super::report::{Place, Report};
use crate::cache::meta::MAX_META_LEN;
use crate::cache::rules::{self, Rule};
use crate::cache::{
    Header, KINDS, KNOWN_REQUIRED_FEATURES, MAGIC, MAJOR, MAX_SECTIONS, MINOR, Presence, SectionEntry, SectionKind,
    keys, section_flags, tree_flags,
};

/// A header and a table that could be read.
pub struct Layout<'a> {
    pub header: Header,
    pub entries: Vec<SectionEntry>,
    /// For each entry its bytes in the file, if they lie in it and no rule keeps them from being read.
    pub stored: Vec<Option<&'a [u8]>>,
}

impl Layout<'_> {
    /// The entry of a known kind that deeper levels may read.
    pub fn find(&self, kind: SectionKind) -> Option<usize> {
        (0..self.entries.len()).find(|&i| self.entries[i].kind == kind && is_understood(&self.entries[i]))
    }
}

/// Does this version know the kind, its layout and its codec?
fn is_understood(entry: &SectionEntry) -> bool {
    let known = entry.kind.rule().is_some_and(|rule| rule.schema == entry.schema && entry.ordinal == 0);
    known && is_known_codec(entry.codec)
}

fn is_known_codec(codec: u8) -> bool {
    matches!(codec, SectionEntry::RAW | SectionEntry::ZSTD)
}

/// Read header and table; `None` where there is nothing that deeper levels could start from.
pub fn read<'a>(file: &'a [u8], out: &mut Report) -> Option<Layout<'a>> {
    let header = read_header(file, out)?;
    let entries = read_table(file, &header, out)?;
    let mut readable = vec![true; entries.len()]; // as many as there are entries in the file
    check_tiling(file, &header, &entries, &mut readable, out);
    for (i, entry) in entries.iter().enumerate() {
        readable[i] &= check_entry(entry, place(&header, entry, i), out);
    }
    check_unique(&header, &entries, &mut readable, out);
    check_presence(&header, &entries, out);
    if keys::content_id(&entries) != header.content_id {
        let found = keys::content_id(&entries);
        out.add(&rules::E0204, Place::byte(96), || (hex(&found), hex(&header.content_id)));
    }
    let bytes = |entry: &SectionEntry| {
        let start = usize::try_from(entry.offset).ok()?;
        file.get(start..start.checked_add(usize::try_from(entry.stored_len).ok()?)?)
    };
    let stored = entries.iter().zip(&readable).map(|(entry, ok)| bytes(entry).filter(|_| *ok)).collect();
    Some(Layout { header, entries, stored })
}

fn read_header(file: &[u8], out: &mut Report) -> Option<Header> {
    let start = &file[..file.len().min(MAGIC.len())];
    if start != &MAGIC[..start.len()] {
        out.add(&rules::E0102, Place::byte(0), || (hex(&MAGIC), hex(start)));
        out.skip("Everything behind the signature: this is another kind of file.");
        return None;
    }
    let Some(bytes) = file.get(..Header::LEN) else {
        out.add(&rules::E0101, Place::file(), || (Header::LEN.to_string(), file.len().to_string()));
        out.skip("Everything: the header is not complete.");
        return None;
    };
    let mut header = Header::zeroed();
    bytes_of_mut(&mut header).copy_from_slice(bytes);

    // Stop where the bytes may mean something else.
    let before = out.errors();
    if header.major != MAJOR {
        out.add(&rules::E0103, Place::byte(8), || (MAJOR.to_string(), header.major.to_string()));
    } else {
        if header.min_minor > header.minor {
            out.add(&rules::E0128, Place::byte(10), || (header.min_minor.to_string(), header.minor.to_string()));
        } else if header.min_minor > MINOR {
            out.add(&rules::E0104, Place::byte(12), || (MINOR.to_string(), header.min_minor.to_string()));
        }
        let unknown = header.features_required & !KNOWN_REQUIRED_FEATURES;
        if unknown != 0 {
            out.add(&rules::E0107, Place::byte(24), || {
                let bits: Vec<String> = (0..64).filter(|b| unknown >> b & 1 != 0).map(|b: u32| b.to_string()).collect();
                (format!("{KNOWN_REQUIRED_FEATURES:#x}"), format!("{unknown:#x}: bit {}", bits.join(", bit ")))
            });
        }
    }
    if out.errors() > before {
        out.skip("Everything behind the version: this reader might misread it.");
        return None;
    }

    // Hold the fields against the file and each other.
    if header.file_len != file.len() as u64 || !header.file_len.is_multiple_of(64) {
        let stated = || format!("{} (a multiple of 64)", header.file_len);
        out.add(&rules::E0106, Place::byte(16), || (stated(), file.len().to_string()));
    }
    if let Some(i) = header.reserved.iter().position(|b| *b != 0) {
        out.add(&rules::E0111, Place::byte(224 + i as u64), || ("zero".into(), format!("{} is not", 224 + i)));
    }
    check_tree_flags(header.tree_flags, out);
    Some(header)
}

fn check_tree_flags(flags: u32, out: &mut Report) {
    use tree_flags::{CANONICAL_DFS, DUP_REFS, REFITTABLE, TWO_LEVEL};
    let mut refuse = |expected: &str| {
        out.add(&rules::E0126, Place::byte(56), || (expected.into(), format!("{flags:#x}")));
    };
    if flags & !(CANONICAL_DFS | DUP_REFS | REFITTABLE | TWO_LEVEL) != 0 {
        refuse("only bits 0x17 are known");
    }
    if (flags & REFITTABLE != 0) == (flags & DUP_REFS != 0) {
        refuse("exactly one of REFITTABLE (0x1) and DUP_REFS (0x2) must be set");
    }
    if flags & CANONICAL_DFS == 0 {
        refuse("CANONICAL_DFS (0x4) must be set");
    }
}

fn read_table(file: &[u8], header: &Header, out: &mut Report) -> Option<Vec<SectionEntry>> {
    let before = out.errors();
    let header_len = usize::from(header.header_len);
    let grown = header_len > Header::LEN && header.minor > MINOR;
    if !(header_len == Header::LEN || grown && header_len.is_multiple_of(64)) {
        out.add(&rules::E0105, Place::byte(14), || (Header::LEN.to_string(), header_len.to_string()));
    }
    if header.section_count > MAX_SECTIONS {
        out.add(&rules::E0108, Place::byte(40), || (MAX_SECTIONS.to_string(), header.section_count.to_string()));
    }
    if header.section_entry_len as usize != SectionEntry::LEN {
        let actual = header.section_entry_len;
        out.add(&rules::E0109, Place::byte(44), || (SectionEntry::LEN.to_string(), actual.to_string()));
    }
    if out.errors() == before {
        let len = header.section_count as usize * SectionEntry::LEN; // at most 8 MiB
        let end = header_len + len;
        if header.section_table_off != header_len as u64 || end > file.len() {
            let expected = format!("at byte {header_len} and end by byte {}", file.len());
            let actual = format!("at byte {} with {len} bytes", header.section_table_off);
            out.add(&rules::E0110, Place::byte(48), || (expected, actual));
        } else {
            let table = &file[header_len..end];
            let found = keys::file_id(header, &file[Header::LEN..header_len], table);
            if found != header.file_id {
                out.add(&rules::E0203, Place::byte(64), || (hex(&header.file_id), hex(&found)));
            }
            let mut entries = vec![SectionEntry::zeroed(); header.section_count as usize];
            cast_slice_mut::<_, u8>(&mut entries).copy_from_slice(table);
            return Some(entries);
        }
    }
    out.skip("Everything behind the header: the section table cannot be read.");
    None
}

fn place(header: &Header, entry: &SectionEntry, i: usize) -> Place {
    let offset = u64::from(header.header_len) + (i * SectionEntry::LEN) as u64;
    Place { offset: Some(offset), ..Place::section(entry.kind) }
}

/// Sections stand in order, on their boundaries, inside the file, and only short zero padding stands between them.
fn check_tiling(file: &[u8], header: &Header, entries: &[SectionEntry], readable: &mut [bool], out: &mut Report) {
    let len = file.len() as u64;
    let mut end = u64::from(header.header_len) + (entries.len() * SectionEntry::LEN) as u64;
    for (i, entry) in entries.iter().enumerate() {
        let at = Place { offset: Some(entry.offset), ..Place::section(entry.kind) };
        let mut refuse = |rule: &'static Rule, expected: String, actual: String| {
            readable[i] = false;
            out.add(rule, at, || (expected, actual));
        };
        let align = match entry.align_log2 {
            log2 @ SectionEntry::MIN_ALIGN_LOG2..=SectionEntry::MAX_ALIGN_LOG2 => Some(1u64 << log2),
            log2 => {
                refuse(&rules::E0116, "align_log2 must be 6 to 16".into(), format!("it is {log2}"));
                None
            }
        };
        if let Some(align) = align.filter(|align| !entry.offset.is_multiple_of(*align)) {
            refuse(
                &rules::E0116,
                format!("it must start at a multiple of {align}"),
                format!("it starts at {}", entry.offset),
            );
        }
        let section_end = match entry.end() {
            Some(section_end) if section_end <= len => section_end,
            other => {
                let actual = other.map_or("beyond 64 bits".into(), |end| end.to_string());
                refuse(&rules::E0117, len.to_string(), actual);
                // Whatever follows cannot be placed relative to a section without an end.
                if entry.offset >= end && entry.offset <= len { entry.offset } else { end }
            }
        };
        if entry.offset < end {
            refuse(&rules::E0118, end.to_string(), entry.offset.to_string());
            end = end.max(section_end);
            continue;
        }
        if entry.offset <= len {
            check_gap(file, end, entry.offset, align.unwrap_or(1 << SectionEntry::MAX_ALIGN_LOG2), out);
        }
        end = section_end;
    }
    // A file of another length has been told so.
    let length_is_right = header.file_len == len && len.is_multiple_of(64);
    if length_is_right && end <= len && entries.iter().all(|e| e.end().is_some_and(|end| end <= len)) {
        check_gap(file, end, len, 64, out);
    }
}

/// Bytes between two regions, both inside the file: fewer than the next region's alignment, all zero.
fn check_gap(file: &[u8], from: u64, to: u64, align: u64, out: &mut Report) {
    if to - from >= align {
        let actual = format!("there are {}", to - from);
        out.add(&rules::E0120, Place::byte(from), || (format!("fewer than {align} bytes of padding"), actual));
    } else if let Some(i) = file[from as usize..to as usize].iter().position(|b| *b != 0) {
        let at = from + i as u64;
        out.add(&rules::E0119, Place::byte(at), || ("zero".into(), format!("{at} is not")));
    }
}

/// What one entry says by itself; whether its section may be read.
fn check_entry(entry: &SectionEntry, at: Place, out: &mut Report) -> bool {
    let before = out.errors();
    let critical = entry.is(section_flags::CRITICAL);
    if let Some(i) = entry.reserved.iter().position(|b| *b != 0) {
        out.add(&rules::E0112, at, || ("zero".into(), format!("{} is not", 52 + i)));
    }

    // Refuse by name what must be understood and is not; say what is left out.
    let rule = entry.kind.rule().filter(|_| entry.ordinal == 0);
    let name = || format!("{} {} schema {} codec {}", entry.kind, entry.ordinal, entry.schema, entry.codec);
    let known_kinds = || KINDS.map(|k| k.kind.to_string()).join(", ");
    match rule {
        None if critical => out.add(&rules::E0113, at, || (known_kinds(), name())),
        Some(rule) if critical && rule.schema != entry.schema => {
            out.add(&rules::E0114, at, || (rule.schema.to_string(), entry.schema.to_string()));
        }
        _ if critical && !is_known_codec(entry.codec) => {
            out.add(&rules::E0115, at, || ("0 (raw) or 1 (zstd)".into(), entry.codec.to_string()));
        }
        _ if !is_understood(entry) => out.add(&rules::W0101, at, || (known_kinds(), name())),
        _ => {}
    }

    // Hold the lengths against each other.
    if entry.flags & !section_flags::ALL != 0 {
        out.add(&rules::E0124, at, || (format!("within {:#x}", section_flags::ALL), format!("{:#x}", entry.flags)));
    }
    let mut sizes = |expected: String, actual: String| out.add(&rules::E0123, at, || (expected, actual));
    if entry.codec == SectionEntry::RAW {
        if entry.stored_len != entry.raw_len {
            let (stored, raw) = (entry.stored_len, entry.raw_len);
            sizes(
                "a raw section must be stored in as many bytes as it has".into(),
                format!("they are {stored} and {raw}"),
            );
        }
        if entry.stored_hash != entry.raw_hash {
            sizes("a raw section must have one hash".into(), "it has two".into());
        }
    }
    let product = entry.elem_count.checked_mul(u64::from(entry.elem_size));
    if entry.elem_size != 0 && product != Some(entry.raw_len) {
        let expected = format!("{} records of {} bytes", entry.elem_count, entry.elem_size);
        sizes(expected, format!("{} bytes", entry.raw_len));
    }

    // Hold a known kind against what this version fixes for it.
    if let Some(rule) = rule.filter(|rule| rule.schema == entry.schema) {
        if entry.elem_size != rule.elem_size {
            out.add(&rules::E0122, at, || (rule.elem_size.to_string(), entry.elem_size.to_string()));
        }
        if entry.flags != rule.flags && entry.flags & !section_flags::ALL == 0 {
            out.add(&rules::E0124, at, || (format!("{:#x}", rule.flags), format!("{:#x}", entry.flags)));
        }
        let (what, value, most) = match entry.kind {
            SectionKind::META => ("bytes", entry.raw_len, MAX_META_LEN as u64),
            SectionKind::INST => ("records", entry.elem_count, 1 << 24),
            SectionKind::BLAS | SectionKind::GEOM => ("records", entry.elem_count, u64::from(u32::MAX)),
            _ => ("records", 0, 0),
        };
        if value > most {
            out.add(&rules::E0129, at, || (format!("{most} {what}"), format!("it has {value}")));
        }
    }
    out.errors() == before
}

fn check_unique(header: &Header, entries: &[SectionEntry], readable: &mut [bool], out: &mut Report) {
    let mut order: Vec<usize> = (0..entries.len()).collect();
    order.sort_by_key(|&i| (entries[i].kind, entries[i].ordinal));
    let mut first = 0;
    for k in 1..order.len() {
        let (a, b) = (&entries[order[first]], &entries[order[k]]);
        if (a.kind, a.ordinal) != (b.kind, b.ordinal) {
            first = k;
            continue;
        }
        (readable[order[first]], readable[order[k]]) = (false, false);
        out.add(&rules::E0121, place(header, b, order[k]), || {
            (order[first].to_string(), format!("{} {} in entry {}", b.kind, b.ordinal, order[k]))
        });
    }
}

fn check_presence(header: &Header, entries: &[SectionEntry], out: &mut Report) {
    let two_level = header.has(tree_flags::TWO_LEVEL);
    for rule in &KINDS {
        // A section that is there but cannot be understood has been refused by its own rule.
        let present = entries.iter().any(|e| e.kind == rule.kind && e.ordinal == 0);
        let wanted = match rule.presence {
            Presence::Always => true,
            Presence::TwoLevel => two_level,
            Presence::Optional => continue,
        };
        if present != wanted {
            let kind = rule.kind;
            let (expected, actual) = if wanted {
                (format!("a section {kind}"), "none".into())
            } else {
                (format!("no section {kind} without TWO_LEVEL"), "one".into())
            };
            out.add(&rules::E0125, Place::byte(40), || (expected, actual));
        }
    }
}

/// Lower-case hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}
