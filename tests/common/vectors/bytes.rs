//! Editing a file's bytes and making its hashes right again.

use bvhc::cache::{Header, Image, SectionEntry, SectionKind, WriteOptions, keys, to_bytes};
use bvhc::exec::Executor;
use bytemuck::{bytes_of, pod_read_unaligned};

use super::scenes;

/// The file of an image, with every vector's META.
pub fn file(image: &Image) -> Vec<u8> {
    to_bytes(image, &scenes::meta(), &WriteOptions { check: false, ..WriteOptions::default() }, &Executor::current())
        .unwrap()
}

pub fn header(file: &[u8]) -> Header {
    pod_read_unaligned(&file[..Header::LEN])
}

pub fn set_header(file: &mut [u8], header: &Header) {
    file[..Header::LEN].copy_from_slice(bytes_of(header));
}

/// The table stands behind the header, however long that says it is.
fn table_start(file: &[u8]) -> usize {
    usize::from(header(file).header_len).clamp(Header::LEN, file.len())
}

pub fn entries(file: &[u8]) -> Vec<SectionEntry> {
    let at = |i: usize| table_start(file) + i * SectionEntry::LEN;
    (0..header(file).section_count as usize).map_while(|i| file.get(at(i)..at(i + 1)).map(pod_read_unaligned)).collect()
}

pub fn set_entry(file: &mut [u8], i: usize, entry: &SectionEntry) {
    let at = table_start(file) + i * SectionEntry::LEN;
    file[at..at + SectionEntry::LEN].copy_from_slice(bytes_of(entry));
}

pub fn position(file: &[u8], kind: SectionKind) -> usize {
    entries(file).iter().position(|e| e.kind == kind).expect("the file has such a section")
}

/// The bytes of a section in the file.
pub fn stored(file: &mut [u8], kind: SectionKind) -> &mut [u8] {
    let entry = entries(file)[position(file, kind)];
    &mut file[entry.offset as usize..][..entry.stored_len as usize]
}

/// Edit the header and sign it.
pub fn with_header(mut file: Vec<u8>, edit: impl FnOnce(&mut Header)) -> Vec<u8> {
    let mut h = header(&file);
    edit(&mut h);
    set_header(&mut file, &h);
    refix(file)
}

/// Edit a section's table entry and sign it.
pub fn with_entry(mut file: Vec<u8>, kind: SectionKind, edit: impl FnOnce(&mut SectionEntry)) -> Vec<u8> {
    let i = position(&file, kind);
    let mut entry = entries(&file)[i];
    edit(&mut entry);
    set_entry(&mut file, i, &entry);
    refix(file)
}

/// Recompute every hash of sections that lie in the file: a raw section's both hashes, a packed one's stored hash (its raw hash
/// needs the decoder), then `content_id` and `file_id`.
pub fn refix(mut file: Vec<u8>) -> Vec<u8> {
    for (i, mut entry) in entries(&file).into_iter().enumerate() {
        let range = entry.offset as usize..entry.offset.saturating_add(entry.stored_len) as usize;
        let Some(bytes) = file.get(range) else { continue };
        entry.stored_hash = *blake3::hash(bytes).as_bytes();
        if entry.codec == SectionEntry::RAW {
            entry.raw_hash = entry.stored_hash;
        }
        set_entry(&mut file, i, &entry);
    }
    let mut h = header(&file);
    h.content_id = keys::content_id(&entries(&file));
    set_header(&mut file, &h);
    sign(file)
}

/// Recompute `file_id` alone.
pub fn sign(mut file: Vec<u8>) -> Vec<u8> {
    let mut h = header(&file);
    let start = table_start(&file);
    let end = (start + entries(&file).len() * SectionEntry::LEN).min(file.len());
    h.file_id = keys::file_id(&h, &file[Header::LEN..start], &file[start..end]);
    set_header(&mut file, &h);
    file
}

/// Cut a file into its header and sections.
pub fn take_apart(file: &[u8]) -> (Header, Vec<(SectionEntry, Vec<u8>)>) {
    let sections =
        entries(file).into_iter().map(|e| (e, file[e.offset as usize..][..e.stored_len as usize].to_vec())).collect();
    (header(file), sections)
}

/// Lay a file out again and sign it: lengths and offsets follow from the sections' bytes, records from `elem_size`.
pub fn put_together(mut header: Header, sections: Vec<(SectionEntry, Vec<u8>)>) -> Vec<u8> {
    // A longer header keeps its length, and zeros behind what is known of it.
    header.header_len = header.header_len.max(Header::LEN as u16);
    let mut end = usize::from(header.header_len) + sections.len() * SectionEntry::LEN;
    let mut entries = Vec::new();
    for (mut entry, data) in sections.iter().map(|(e, d)| (*e, d)) {
        entry.offset = end.next_multiple_of(1 << entry.align_log2) as u64;
        entry.stored_len = data.len() as u64;
        if entry.codec == SectionEntry::RAW {
            entry.raw_len = data.len() as u64;
            if entry.elem_size != 0 {
                entry.elem_count = entry.raw_len / u64::from(entry.elem_size);
            }
        }
        end = entry.offset as usize + data.len();
        entries.push(entry);
    }
    header.section_count = entries.len() as u32;
    header.file_len = end.next_multiple_of(64) as u64;
    let mut file = vec![0; header.file_len as usize];
    set_header(&mut file, &header);
    for (i, (entry, (_, data))) in entries.iter().zip(&sections).enumerate() {
        set_entry(&mut file, i, entry);
        file[entry.offset as usize..][..data.len()].copy_from_slice(data);
    }
    refix(file)
}

/// Add a section behind the others.
pub fn with_section(file: &[u8], kind: [u8; 4], flags: u32, data: &[u8]) -> Vec<u8> {
    let (header, mut sections) = take_apart(file);
    let (mut entry, _) = sections[0].clone();
    entry.kind = SectionKind(kind);
    (entry.flags, entry.schema, entry.elem_size, entry.elem_count, entry.codec) = (flags, 1, 0, 0, SectionEntry::RAW);
    entry.align_log2 = 6;
    sections.push((entry, data.to_vec()));
    put_together(header, sections)
}

/// The same file with every section raw.
pub fn unpack(file: &[u8]) -> Vec<u8> {
    let cache = bvhc::cache::Cache::from_bytes(file, &Default::default()).unwrap();
    let (header, mut sections) = take_apart(file);
    for (i, (entry, data)) in sections.iter_mut().enumerate() {
        *data = cache.section_bytes(i).unwrap().to_vec();
        entry.codec = SectionEntry::RAW;
    }
    put_together(header, sections)
}
