//! Cache files: what is changed is hashed again, so that changes reach the rules behind the hashes.

use super::{Bytes, Dice, word};
use crate::vectors::{bytes, valid};
use bvhc::cache::{Header, SectionEntry};
use std::sync::OnceLock;

/// Valid files, for sections to take from.
fn library() -> &'static [Vec<u8>] {
    static FILES: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    FILES.get_or_init(|| valid::all().into_iter().map(|v| v.bytes).collect())
}

/// Change a file. One in sixteen changes leaves the hashes wrong.
pub fn change(file: &mut Vec<u8>, dice: &mut Dice, raw: &mut Bytes) {
    if !is_sound(file) {
        if dice.one_in(2) {
            raw.change(file);
        } else {
            *file = library()[dice.below(library().len())].clone();
        }
        return;
    }
    match dice.below(16) {
        0 => return raw.change(file),
        1 => of_header(file, dice),
        2 => of_table(file, dice),
        3 | 4 => of_sections(file, dice),
        5 | 6 => of_one_section(file, dice, raw),
        7 if dice.one_in(2) => of_packed(file, dice),
        7 => repack(file, dice),
        _ => of_records(file, dice, raw),
    }
    file.truncate(raw.room);
}

/// Whether it can be cut into sections at all.
fn is_sound(file: &[u8]) -> bool {
    file.len() >= Header::LEN && {
        let header = bytes::header(file);
        let entries = bytes::entries(file);
        let inside = |e: &SectionEntry| {
            e.end().is_some_and(|end| end <= file.len() as u64) && e.align_log2 <= SectionEntry::MAX_ALIGN_LOG2
        };
        header.section_count as usize == entries.len() && entries.len() <= 32 && entries.iter().all(inside)
    }
}

/// Words of the header.
fn of_header(file: &mut Vec<u8>, dice: &mut Dice) {
    for _ in 0..1 + dice.below(2) {
        set_word(file, 8 + 4 * dice.below((Header::LEN - 8) / 4), dice);
    }
    *file = bytes::sign(std::mem::take(file));
}

/// Fields of a section's entry: half of the time its numbers, else any byte of it.
fn of_table(file: &mut Vec<u8>, dice: &mut Dice) {
    let entries = bytes::entries(file);
    if entries.is_empty() {
        return;
    }
    let i = dice.below(entries.len());
    let mut entry = entries[i];
    let any = dice.roll();
    let near = |old: u64, dice: &mut Dice| match dice.below(6) {
        0 => old.wrapping_add(1),
        1 => old.wrapping_sub(1),
        2 => old.wrapping_mul(2),
        3 => old ^ 64,
        4 => u64::MAX - dice.below(64) as u64,
        _ => u64::from(word(old as u32, dice)),
    };
    match dice.below(10) {
        0 => entry.offset = near(entry.offset, dice),
        1 => entry.stored_len = near(entry.stored_len, dice),
        2 => entry.raw_len = near(entry.raw_len, dice),
        3 => entry.elem_count = near(entry.elem_count, dice),
        4 => entry.elem_size = near(entry.elem_size.into(), dice) as u32,
        5 => entry.flags ^= 1 << (any % 8),
        6 => (entry.codec, entry.schema) = ((any % 4) as u8, (any >> 8) as u16 % 3),
        7 => entry.align_log2 = (any % 20) as u8,
        8 => entry.ordinal = near(entry.ordinal.into(), dice) as u32,
        _ => entry.kind.0[any as usize % 4] ^= 1 << (any >> 8 & 7),
    }
    bytes::set_entry(file, i, &entry);
    let new = std::mem::take(file);
    // Hashes over wrong ranges stay as they are.
    *file = if dice.one_in(2) { bytes::sign(new) } else { bytes::refix(new) };
}

/// Sections dropped, doubled, swapped, or taken from another file.
fn of_sections(file: &mut Vec<u8>, dice: &mut Dice) {
    let (mut header, mut sections) = bytes::take_apart(file);
    if sections.is_empty() {
        return;
    }
    let (i, j) = (dice.below(sections.len()), dice.below(sections.len()));
    match dice.below(5) {
        0 => drop(sections.remove(i)),
        1 => sections.insert(i, sections[j].clone()),
        2 => sections.swap(i, j),
        _ => {
            let (other, mut theirs) = bytes::take_apart(&library()[dice.below(library().len())]);
            let (entry, data) = theirs.swap_remove(dice.below(theirs.len()));
            match sections.iter().position(|(e, _)| (e.kind, e.ordinal) == (entry.kind, entry.ordinal)) {
                Some(same) => sections[same] = (entry, data),
                None => sections.push((entry, data)),
            }
            if dice.one_in(2) {
                // And what the header says of it.
                (header.prim_count, header.ref_count, header.node_count) =
                    (other.prim_count, other.ref_count, other.node_count);
                (header.blas_count, header.instance_count, header.tree_flags) =
                    (other.blas_count, other.instance_count, other.tree_flags);
                (header.features_required, header.frame_count) = (other.features_required, other.frame_count);
                (header.minor, header.min_minor) = (other.minor, other.min_minor);
            }
        }
    }
    *file = bytes::put_together(header, sections);
}

/// The bytes of one section, which may become more or fewer.
fn of_one_section(file: &mut Vec<u8>, dice: &mut Dice, raw: &mut Bytes) {
    let (header, mut sections) = bytes::take_apart(file);
    if sections.is_empty() {
        return;
    }
    let i = dice.below(sections.len());
    let (entry, data) = &mut sections[i];
    let size = entry.elem_size as usize;
    if size > 0 && size <= data.len() && dice.one_in(2) {
        // Whole records: doubled, dropped, moved.
        let count = data.len() / size;
        let (from, to) = (dice.below(count) * size, dice.below(count) * size);
        match dice.below(3) {
            0 => drop(data.drain(from..from + size)),
            1 => {
                let record = data[from..from + size].to_vec();
                data.splice(to..to, record);
            }
            _ => data.copy_within(from..from + size, to),
        }
    } else {
        raw.change(data);
    }
    *file = bytes::put_together(header, sections);
}

/// A raw section is packed.
fn repack(file: &mut Vec<u8>, dice: &mut Dice) {
    let (header, mut sections) = bytes::take_apart(file);
    if sections.is_empty() {
        return;
    }
    let i = dice.below(sections.len());
    let (entry, data) = &mut sections[i];
    if entry.codec != SectionEntry::RAW || data.is_empty() || data.len() > 1 << 20 {
        return;
    }
    let Ok(frame) = zstd::bulk::compress(data, 1) else { return };
    entry.codec = SectionEntry::ZSTD;
    entry.raw_hash = *blake3::hash(data).as_bytes();
    entry.raw_len = data.len() as u64;
    *data = [&1u32.to_le_bytes(), &[0; 4], &(frame.len() as u32).to_le_bytes(), &frame[..]].concat();
    *file = bytes::put_together(header, sections);
}

/// What is inside a packed section: words of it, or a piece in another place. What it decodes to then has another hash than the entry states.
fn of_packed(file: &mut Vec<u8>, dice: &mut Dice) {
    let (header, mut sections) = bytes::take_apart(file);
    let packed =
        |(_, (entry, data)): &(usize, &(SectionEntry, Vec<u8>))| entry.codec != SectionEntry::RAW && data.len() > 12;
    let places: Vec<usize> = sections.iter().enumerate().filter(packed).map(|(i, _)| i).collect();
    if places.is_empty() {
        return;
    }
    let (_, data) = &mut sections[places[dice.below(places.len())]];
    // Those of the seeds have one frame.
    let Ok(mut inside) = zstd::bulk::decompress(&data[12..], 1 << 20) else { return };
    for _ in 0..1 + dice.below(4) {
        if inside.len() < 8 {
            break;
        }
        if dice.one_in(4) {
            let (from, to) = (dice.below(inside.len() - 4), dice.below(inside.len() - 4));
            inside.copy_within(from..from + 4, to);
        } else {
            let at = dice.below(inside.len() - 4);
            set_word(&mut inside, at, dice);
        }
    }
    let Ok(frame) = zstd::bulk::compress(&inside, 1) else { return };
    *data = [&1u32.to_le_bytes(), &[0; 4], &(frame.len() as u32).to_le_bytes(), &frame[..]].concat();
    *file = bytes::put_together(header, sections);
}

/// One to four words of records, where they are.
fn of_records(file: &mut Vec<u8>, dice: &mut Dice, raw: &mut Bytes) {
    let entries: Vec<SectionEntry> = bytes::entries(file).into_iter().filter(|e| e.stored_len >= 4).collect();
    if entries.is_empty() {
        return;
    }
    for _ in 0..1 + dice.below(4) {
        let entry = entries[dice.below(entries.len())];
        let range = entry.offset as usize..(entry.offset + entry.stored_len) as usize;
        if dice.one_in(8) {
            // libFuzzer knows what a number is compared with.
            let size = (entry.elem_size as usize).clamp(4, range.len());
            let at = range.start + dice.below(range.len() / size) * size;
            raw.change_in_place(&mut file[at..at + size]);
        } else if dice.one_in(6) {
            // A number that stands elsewhere among the records.
            let from = range.start + 4 * dice.below(range.len() / 4);
            let to = range.start + 4 * dice.below(range.len() / 4);
            file.copy_within(from..from + 4, to);
        } else {
            set_word(file, range.start + 4 * dice.below(range.len() / 4), dice);
        }
    }
    *file = bytes::refix(std::mem::take(file));
}

fn set_word(file: &mut [u8], at: usize, dice: &mut Dice) {
    if let Some(four) = file.get_mut(at..at + 4) {
        let old = u32::from_le_bytes([four[0], four[1], four[2], four[3]]);
        four.copy_from_slice(&word(old, dice).to_le_bytes());
    }
}
