use std::ops::ControlFlow;

use bytemuck::{Zeroable, cast_slice_mut};

use super::entry::is_understood;
use super::{Sink, hex, place};
use crate::cache::report::Place;
use crate::cache::rules::Rule;
use crate::cache::{keys, rules};
use crate::layout::{
    Header, KINDS, KindRule, MAX_SECTIONS, MINOR, Presence, SectionEntry, SectionKind, section_flags, tree_flags,
};

/// Read the section table. The walk breaks where it cannot be found.
pub fn read(file: &[u8], header: &Header, out: &mut impl Sink) -> ControlFlow<(), Vec<SectionEntry>> {
    let entries = find_and_read(file, header, out)?;
    if entries.is_none() {
        out.skip("Everything behind the header: the section table cannot be read.");
    }
    entries.map_or(ControlFlow::Break(()), ControlFlow::Continue)
}

fn find_and_read(file: &[u8], header: &Header, out: &mut impl Sink) -> ControlFlow<(), Option<Vec<SectionEntry>>> {
    // What must be known before the table's place and length are.
    let header_len = usize::from(header.header_len);
    let grown = header.minor > MINOR && header_len > Header::LEN && header_len.is_multiple_of(64);
    let mut sized = true;
    let mut hold = |holds: bool, rule: &'static Rule, offset: u64, expected: usize, actual: usize| {
        sized &= holds;
        if holds {
            return ControlFlow::Continue(());
        }
        out.breach(rule, Place::byte(offset), || (expected.to_string(), actual.to_string()))
    };
    let (count, entry_len) = (header.section_count, header.section_entry_len as usize);
    hold(header_len == Header::LEN || grown, &rules::E0105, 14, Header::LEN, header_len)?;
    hold(count <= MAX_SECTIONS, &rules::E0108, 40, MAX_SECTIONS as usize, count as usize)?;
    hold(entry_len == SectionEntry::LEN, &rules::E0109, 44, SectionEntry::LEN, entry_len)?;
    if !sized {
        return ControlFlow::Continue(None);
    }

    let len = count as usize * SectionEntry::LEN; // at most 8 MiB
    let end = header_len + len;
    let table = file.get(header_len..end).filter(|_| header.section_table_off == header_len as u64);
    let Some(table) = table else {
        let expected = format!("at byte {header_len} and end by byte {}", file.len());
        let actual = format!("at byte {} with {len} bytes", header.section_table_off);
        out.breach(&rules::E0110, Place::byte(48), || (expected, actual))?;
        return ControlFlow::Continue(None);
    };

    // Header and table are believed only together: everything that follows is covered by their hash.
    let found = keys::file_id(header, file.get(Header::LEN..header_len).unwrap_or_default(), table);
    if found != header.file_id {
        out.breach(&rules::E0203, Place::byte(64), || (hex(&header.file_id), hex(&found)))?;
    }
    let mut entries = vec![SectionEntry::zeroed(); count as usize];
    cast_slice_mut::<_, u8>(&mut entries).copy_from_slice(table);
    ControlFlow::Continue(Some(entries))
}

/// Sections stand in order, on their boundaries, inside the file, and only short zero padding stands between them.
pub fn check_tiling(
    file: &[u8],
    header: &Header,
    entries: &[SectionEntry],
    readable: &mut [bool],
    out: &mut impl Sink,
) -> ControlFlow<()> {
    let len = file.len() as u64;
    let mut end = u64::from(header.header_len) + (entries.len() * SectionEntry::LEN) as u64;
    for (i, entry) in entries.iter().enumerate() {
        let at = Place { offset: Some(entry.offset), ..Place::of(entry) };
        let mut refuse = |rule: &'static Rule, expected: String, actual: String| {
            readable[i] = false;
            out.breach(rule, at, || (expected, actual))
        };
        let align = match entry.align_log2 {
            log2 @ SectionEntry::MIN_ALIGN_LOG2..=SectionEntry::MAX_ALIGN_LOG2 => Some(1u64 << log2),
            log2 => {
                refuse(&rules::E0116, "align_log2 must be 6 to 16".into(), format!("it is {log2}"))?;
                None
            }
        };
        if let Some(align) = align.filter(|align| !entry.offset.is_multiple_of(*align)) {
            let expected = format!("it must start at a multiple of {align}");
            refuse(&rules::E0116, expected, format!("it starts at {}", entry.offset))?;
        }
        let section_end = match entry.end() {
            Some(section_end) if section_end <= len => section_end,
            other => {
                let actual = other.map_or("beyond 64 bits".into(), |end| end.to_string());
                refuse(&rules::E0117, len.to_string(), actual)?;
                // Whatever follows cannot be placed relative to a section without an end.
                if entry.offset >= end && entry.offset <= len { entry.offset } else { end }
            }
        };
        if entry.offset < end {
            refuse(&rules::E0118, end.to_string(), entry.offset.to_string())?;
            end = end.max(section_end);
            continue;
        }
        if entry.offset <= len {
            check_gap(file, end, entry.offset, align.unwrap_or(1 << SectionEntry::MAX_ALIGN_LOG2), out)?;
        }
        end = section_end;
    }
    // A file of another length has been told so.
    let length_is_right = header.file_len == len && len.is_multiple_of(64);
    if length_is_right && end <= len && entries.iter().all(|e| e.end().is_some_and(|end| end <= len)) {
        check_gap(file, end, len, 64, out)?;
    }
    ControlFlow::Continue(())
}

/// Bytes between two regions: fewer than the next region's alignment, all zero.
fn check_gap(file: &[u8], from: u64, to: u64, align: u64, out: &mut impl Sink) -> ControlFlow<()> {
    if to - from >= align {
        let actual = format!("there are {}", to - from);
        return out
            .breach(&rules::E0120, Place::byte(from), || (format!("fewer than {align} bytes of padding"), actual));
    }
    // Both ends lie in the file, so they fit.
    let gap = file.get(from as usize..to as usize).unwrap_or_default();
    match gap.iter().position(|b| *b != 0) {
        Some(i) => {
            let at = from + i as u64;
            out.breach(&rules::E0119, Place::byte(at), || ("zero".into(), format!("{at} is not")))
        }
        None => ControlFlow::Continue(()),
    }
}

/// Sorted, because a hostile table has 65 536 entries.
pub fn check_unique(
    header: &Header,
    entries: &[SectionEntry],
    readable: &mut [bool],
    out: &mut impl Sink,
) -> ControlFlow<()> {
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
        out.breach(&rules::E0121, place(header, b, order[k]), || {
            (order[first].to_string(), format!("{} {} in entry {}", b.kind, b.ordinal, order[k]))
        })?;
    }
    ControlFlow::Continue(())
}

/// Each kind stands in the file exactly as its rule says, and what there is several of is numbered without holes.
pub fn check_presence(header: &Header, entries: &[SectionEntry], out: &mut impl Sink) -> ControlFlow<()> {
    let (two_level, sequence) = (header.has(tree_flags::TWO_LEVEL), header.has(tree_flags::SEQUENCE));
    for rule in &KINDS {
        let wanted = match rule.presence {
            Presence::Always => true,
            Presence::Still => !sequence,
            Presence::Sequence => sequence,
            Presence::TwoLevel => two_level,
            Presence::StillOptional if sequence => false,
            Presence::Optional | Presence::StillOptional => continue,
        };
        // A section that must be understood and is not has been refused by a rule of its own.
        let mine = || entries.iter().filter(|e| e.kind == rule.kind);
        let present = mine().any(is_understood);
        let refused = mine().any(|e| e.is(section_flags::CRITICAL) && !is_understood(e));
        if present != wanted && !(wanted && refused) {
            let (expected, actual) = of_presence(rule, wanted);
            out.breach(&rules::E0125, Place::byte(40), || (expected, actual))?;
        }
    }
    check_numbers(sequence, entries, out)
}

/// A still file has no number but 0. In a sequence each block has nodes and vertices, and each placement a tree and its instances.
fn check_numbers(sequence: bool, entries: &[SectionEntry], out: &mut impl Sink) -> ControlFlow<()> {
    let numbers = |kind: SectionKind| {
        let mine = entries.iter().filter(|e| e.kind == kind && is_understood(e));
        let mut numbers: Vec<u32> = mine.map(|e| e.ordinal).collect();
        numbers.sort_unstable();
        numbers
    };
    for (a, b) in [(SectionKind::NODE, SectionKind::VPOS), (SectionKind::TNOD, SectionKind::INST)] {
        let (numbers_a, numbers_b) = (numbers(a), numbers(b));
        let most = if sequence { numbers_a.len().max(numbers_b.len()) } else { 1 };
        let beyond = |some: &[u32]| some.iter().find(|n| **n as usize >= most).copied();
        for (kind, some) in [(a, &numbers_a), (b, &numbers_b)] {
            if let Some(number) = beyond(some) {
                let expected = format!("sections {kind} with the numbers 0 to {}", most.saturating_sub(1));
                out.breach(&rules::E0125, Place::byte(40), || (expected, format!("number {number}")))?;
            }
        }
        if sequence && numbers_a.len() != numbers_b.len() {
            let expected = format!("as many sections {b} as {a}, {}", numbers_a.len());
            out.breach(&rules::E0125, Place::byte(40), || (expected, numbers_b.len().to_string()))?;
        }
    }
    ControlFlow::Continue(())
}

fn of_presence(rule: &KindRule, wanted: bool) -> (String, String) {
    let kind = rule.kind;
    match (wanted, rule.presence) {
        (true, _) => (format!("a section {kind}"), "none that this version can read".into()),
        (false, Presence::TwoLevel) => (format!("no section {kind} without TWO_LEVEL"), "one".into()),
        (false, Presence::Sequence) => (format!("no section {kind} without SEQUENCE"), "one".into()),
        (false, _) => (format!("no section {kind} in a sequence"), "one".into()),
    }
}
