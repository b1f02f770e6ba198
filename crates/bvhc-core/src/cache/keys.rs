//! The three identities of a file, each a BLAKE3 hash in key-derivation mode under its own context, so that none can ever be
//! confused with another or with a plain hash of a section.
//!
//! A hash proves that bytes are the ones that were written, not who wrote them: anyone can recompute it. That is why the check
//! validates structure even where every hash matches.

use bytemuck::bytes_of;

use crate::layout::{Header, MAJOR, SectionEntry, section_flags};

const FILE_ID_CONTEXT: &str = "bvhc v1 file id";
const CONTENT_ID_CONTEXT: &str = "bvhc v1 content id";
const BUILD_KEY_CONTEXT: &str = "bvhc v1 build key";

/// Commits to every byte of a file: the table holds each section's hash, and sections and zero padding tile the file.
///
/// `header_tail` is what a header longer than 256 bytes has behind them, `table` the section table's bytes.
pub fn file_id(header: &Header, header_tail: &[u8], table: &[u8]) -> [u8; 32] {
    let mut blanked = *header;
    blanked.file_id = [0; 32];
    let mut hasher = blake3::Hasher::new_derive_key(FILE_ID_CONTEXT);
    hasher.update(bytes_of(&blanked)).update(header_tail).update(table);
    *hasher.finalize().as_bytes()
}

/// Identity of the tree data alone: independent of codec, alignment, section order and provenance.
pub fn content_id(entries: &[SectionEntry]) -> [u8; 32] {
    let mut content: Vec<&SectionEntry> = entries.iter().filter(|e| e.is(section_flags::CONTENT)).collect();
    content.sort_by_key(|e| (e.kind, e.ordinal));
    let mut hasher = blake3::Hasher::new_derive_key(CONTENT_ID_CONTEXT);
    for entry in content {
        hasher
            .update(&entry.kind.0)
            .update(&entry.ordinal.to_le_bytes())
            .update(&entry.schema.to_le_bytes())
            .update(&[0; 2])
            .update(&entry.elem_size.to_le_bytes())
            .update(&entry.raw_len.to_le_bytes())
            .update(&entry.raw_hash);
    }
    *hasher.finalize().as_bytes()
}

/// Everything that decides what a build writes, apart from the bytes of its inputs.
///
/// Threads, verbosity, codec, paths and times are not part of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recipe {
    /// Name of the build method.
    pub method: String,
    /// Raised when the method's output changes for any reason, the reading of models included, and only then.
    pub builder_revision: u32,
    /// Every build and read option that changes the output, after defaulting, in a fixed order: name and value as text that
    /// two different values never share (shortest round-trip form for floats).
    pub options: Vec<(String, String)>,
}

/// What a build key knows about an input file: not its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputHash {
    /// See `Dependency::role`.
    pub role: u32,
    /// Bytes of the whole file.
    pub len: u64,
    /// BLAKE3 of the whole file.
    pub blake3: [u8; 32],
}

impl Recipe {
    /// What a file was built from: equal keys promise equal tree data. `inputs` stand in the order of first use.
    pub fn build_key(&self, inputs: impl IntoIterator<Item = InputHash>) -> [u8; 32] {
        let mut stream = Tlv(blake3::Hasher::new_derive_key(BUILD_KEY_CONTEXT));
        stream.item(1, &MAJOR.to_le_bytes());
        stream.item(2, self.method.as_bytes());
        stream.item(3, &self.builder_revision.to_le_bytes());
        for (name, value) in &self.options {
            stream.item(4, name.as_bytes());
            stream.item(5, value.as_bytes());
        }
        for input in inputs {
            let mut value = [0; 44];
            value[..4].copy_from_slice(&input.role.to_le_bytes());
            value[4..12].copy_from_slice(&input.len.to_le_bytes());
            value[12..].copy_from_slice(&input.blake3);
            stream.item(6, &value);
        }
        *stream.0.finalize().as_bytes()
    }
}

/// Tag, length, value: no two lists of items give the same bytes.
struct Tlv(blake3::Hasher);

impl Tlv {
    fn item(&mut self, tag: u8, value: &[u8]) {
        self.0.update(&[tag]).update(&(value.len() as u64).to_le_bytes()).update(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::SectionKind;
    use bytemuck::Zeroable;

    fn recipe(options: &[(&str, &str)]) -> Recipe {
        let options = options.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
        Recipe { method: "sbvh".into(), builder_revision: 1, options }
    }

    #[test]
    fn build_key_depends_on_every_part_and_on_where_the_parts_end() {
        let input = InputHash { role: 0, len: 3, blake3: [7; 32] };
        let base = recipe(&[("bins", "32")]).build_key([input]);
        assert_eq!(base, recipe(&[("bins", "32")]).build_key([input]));
        assert_ne!(base, recipe(&[("bin", "s32")]).build_key([input]));
        assert_ne!(base, recipe(&[("bins", "32")]).build_key([input, input]));
        assert_ne!(base, recipe(&[("bins", "32")]).build_key([InputHash { len: 4, ..input }]));
        assert_ne!(base, Recipe { builder_revision: 2, ..recipe(&[("bins", "32")]) }.build_key([input]));
    }

    #[test]
    fn content_id_ignores_codec_place_and_unhashed_sections() {
        let node = SectionEntry { kind: SectionKind::NODE, flags: 5, schema: 1, raw_len: 64, ..SectionEntry::zeroed() };
        let tris = SectionEntry { kind: SectionKind::TRIS, ..node };
        let meta = SectionEntry { kind: SectionKind::META, flags: 2, ..node };
        let id = content_id(&[node, tris, meta]);
        assert_eq!(id, content_id(&[tris, SectionEntry { codec: 1, offset: 4096, stored_len: 9, ..node }]));
        assert_ne!(id, content_id(&[node, SectionEntry { raw_hash: [1; 32], ..tris }]));
    }
}
