//! The facts that a file's first kilobyte tells, in the shape that `bvhc info --json` prints.
//!
//! Fields may be added, never renamed or removed. Counts are plain numbers (all below 2⁵³), identities are lower-case hex,
//! flag words are given as numbers and as the names of their known bits.

use crate::cache::{Dependency, Header, Meta, SectionEntry, section_flags, tree_flags};
use serde::Serialize;

/// Header, section table and, where present, META of one file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FileInfo {
    /// Exact size in bytes.
    pub file_len: u64,
    pub format: FormatVersion,
    pub features_required: u64,
    pub features_optional: u64,
    pub tree_flags: FlagSet,
    pub builder: BuilderInfo,
    /// Root hash: commits to every byte of the file.
    pub file_id: String,
    /// Identity of the content whatever the codec.
    pub content_id: String,
    /// Identity of inputs, options and builder revision.
    pub build_key: String,
    pub prim_count: u64,
    pub ref_count: u64,
    pub node_count: u64,
    pub blas_count: u32,
    pub instance_count: u32,
    pub frame_count: u32,
    pub max_depth: u32,
    pub scene_bounds: Bounds,
    pub sections: Vec<SectionInfo>,
    /// `None` where the file has no META or one of an unknown schema: a file is usable without.
    pub meta: Option<MetaInfo>,
    /// Why it is `None` although there is a META.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub meta_error: Option<String>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FormatVersion {
    pub major: u16,
    /// The writer's minor.
    pub minor: u16,
    /// The smallest reader minor that can read the file.
    pub min_minor: u16,
}

/// A flag word with the names of the bits that this version knows, lowest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FlagSet {
    pub bits: u32,
    pub names: Vec<&'static str>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct BuilderInfo {
    /// `builder_id` of the header: information that nothing may depend on.
    pub id: u32,
    /// The build method as META names it; `None` without META.
    pub name: Option<String>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Bounds {
    pub min: [f32; 3],
    pub max: [f32; 3],
}

/// One entry of the section table.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SectionInfo {
    /// Four characters; bytes outside printable ASCII are written `\xNN`.
    #[serde(rename = "type")]
    pub kind: String,
    pub ordinal: u32,
    pub flags: FlagSet,
    pub schema: u16,
    /// `raw`, `zstd`, or the number of an unknown codec.
    pub codec: String,
    pub align: u64,
    pub offset: u64,
    pub stored_len: u64,
    pub raw_len: u64,
    pub elem_count: u64,
    /// 0 for an opaque section.
    pub elem_size: u32,
    pub raw_hash: String,
    pub stored_hash: String,
}

/// Provenance, as META records it; the fields are those of `format-spec/SPEC.md`, section 6.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MetaInfo {
    pub tool: String,
    pub tool_version: String,
    pub method: String,
    /// Raised whenever the builder's output changes.
    pub builder_revision: u32,
    /// Every effective option, in the build key's order.
    pub options: Vec<OptionInfo>,
    /// The files that the trees were made from, in the order of first use.
    pub inputs: Vec<InputInfo>,
    /// What reading dropped or repaired.
    pub read_counts: Vec<CountInfo>,
    pub notes: Vec<String>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct OptionInfo {
    pub name: String,
    pub value: String,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct InputInfo {
    /// 0: the model; 1: a file that the model names.
    pub role: u32,
    /// Relative to the model's folder.
    pub name: String,
    pub len: u64,
    pub blake3: String,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CountInfo {
    pub name: String,
    pub count: u64,
}

/// Names of the tree flags, lowest bit first.
const TREE_FLAG_NAMES: [(u32, &str); 5] = [
    (tree_flags::REFITTABLE, "REFITTABLE"),
    (tree_flags::DUP_REFS, "DUP_REFS"),
    (tree_flags::CANONICAL_DFS, "CANONICAL_DFS"),
    (tree_flags::SEQUENCE, "SEQUENCE"),
    (tree_flags::TWO_LEVEL, "TWO_LEVEL"),
];

/// Names of the section flags, lowest bit first.
const SECTION_FLAG_NAMES: [(u32, &str); 3] = [
    (section_flags::CRITICAL, "CRITICAL"),
    (section_flags::COPY_SAFE, "COPY_SAFE"),
    (section_flags::CONTENT, "CONTENT"),
];

impl FileInfo {
    /// The facts of a header and its section table, which together are one small read.
    pub fn new(header: &Header, sections: &[SectionEntry], meta: Option<MetaInfo>) -> FileInfo {
        FileInfo {
            file_len: header.file_len,
            format: FormatVersion { major: header.major, minor: header.minor, min_minor: header.min_minor },
            features_required: header.features_required,
            features_optional: header.features_optional,
            tree_flags: FlagSet::new(header.tree_flags, &TREE_FLAG_NAMES),
            builder: BuilderInfo { id: header.builder_id, name: meta.as_ref().map(|m| m.method.clone()) },
            file_id: hex(&header.file_id),
            content_id: hex(&header.content_id),
            build_key: hex(&header.build_key),
            prim_count: header.prim_count,
            ref_count: header.ref_count,
            node_count: header.node_count,
            blas_count: header.blas_count,
            instance_count: header.instance_count,
            frame_count: header.frame_count,
            max_depth: header.max_depth,
            scene_bounds: Bounds { min: header.scene_min, max: header.scene_max },
            sections: sections.iter().map(SectionInfo::from).collect(),
            meta,
            meta_error: None,
        }
    }
}

impl From<&SectionEntry> for SectionInfo {
    fn from(e: &SectionEntry) -> SectionInfo {
        SectionInfo {
            kind: e.kind.to_string(),
            ordinal: e.ordinal,
            flags: FlagSet::new(e.flags, &SECTION_FLAG_NAMES),
            schema: e.schema,
            codec: match e.codec {
                SectionEntry::RAW => "raw".to_string(),
                SectionEntry::ZSTD => "zstd".to_string(),
                other => other.to_string(),
            },
            align: 1u64.checked_shl(u32::from(e.align_log2)).unwrap_or(0),
            offset: e.offset,
            stored_len: e.stored_len,
            raw_len: e.raw_len,
            elem_count: e.elem_count,
            elem_size: e.elem_size,
            raw_hash: hex(&e.raw_hash),
            stored_hash: hex(&e.stored_hash),
        }
    }
}

impl From<&Meta> for MetaInfo {
    fn from(m: &Meta) -> MetaInfo {
        let option = |(name, value): &(String, String)| OptionInfo { name: name.clone(), value: value.clone() };
        let count = |(name, count): &(String, u64)| CountInfo { name: name.clone(), count: *count };
        MetaInfo {
            tool: m.tool.clone(),
            tool_version: m.tool_version.clone(),
            method: m.method.clone(),
            builder_revision: m.builder_revision,
            options: m.options.iter().map(option).collect(),
            inputs: m.dependencies.iter().map(InputInfo::from).collect(),
            read_counts: m.read_counts.iter().map(count).collect(),
            notes: m.notes.clone(),
        }
    }
}

impl From<&Dependency> for InputInfo {
    fn from(d: &Dependency) -> InputInfo {
        InputInfo { role: d.role, name: d.name.clone(), len: d.len, blake3: hex(&d.blake3) }
    }
}

impl FlagSet {
    pub fn new(bits: u32, known: &[(u32, &'static str)]) -> FlagSet {
        FlagSet { bits, names: known.iter().filter(|(bit, _)| bits & bit != 0).map(|(_, name)| *name).collect() }
    }
}

/// Lower-case hexadecimal, two digits a byte.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_named_lowest_bit_first_and_unknown_bits_stay_in_the_number() {
        let set = FlagSet::new(0x8000_0016, &TREE_FLAG_NAMES);
        assert_eq!(set.names, ["DUP_REFS", "CANONICAL_DFS", "TWO_LEVEL"]);
        assert_eq!(set.bits, 0x8000_0016);
    }
}
