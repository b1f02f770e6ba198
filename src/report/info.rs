//! The facts that a file's first kilobyte tells, as data.
//!
//! Fields may be added, never renamed or removed. Counts are plain numbers (all below 2⁵³), identities are lower-case hex,
//! flag words are given as numbers and as the names of their known bits.

use crate::cache::{Dependency, Header, Meta, SectionEntry, SectionKind, section_flags, tree_flags};
use crate::scene::{AnimationChoice, Moment, ReadOptions};
use serde::Serialize;

/// Header, section table and, where present, META of one file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FileInfo {
    /// Exact size in bytes.
    pub file_len: u64,
    /// The version of the format, as the header states it.
    pub format: FormatVersion,
    /// Bits that a reader must know; 0 in version 1.0.
    pub features_required: u64,
    /// Bits that a reader may ignore; 0 in version 1.0.
    pub features_optional: u64,
    /// [`tree_flags`].
    pub tree_flags: FlagSet,
    /// Who built the trees.
    pub builder: BuilderInfo,
    /// Root hash: commits to every byte of the file.
    pub file_id: String,
    /// Identity of the content whatever the codec.
    pub content_id: String,
    /// Identity of inputs, options and builder revision.
    pub build_key: String,
    /// Distinct triangles over all BLASes.
    pub triangles: u64,
    /// Records of `TRIS`, duplicates included.
    pub references: u64,
    /// Live nodes of all trees over triangles.
    pub nodes: u64,
    /// Live nodes of the trees over instances.
    pub top_nodes: u64,
    /// Trees over meshes.
    pub trees: u32,
    /// 0 in a one-level file.
    pub instances: u32,
    /// 0: no sequence.
    pub frames: u32,
    /// Of the deepest leaf of any one tree; the root has depth 0.
    pub max_depth: u32,
    /// World bounds; all zero for an empty scene.
    pub scene_bounds: Bounds,
    /// The section table in file order, unknown kinds included.
    pub sections: Vec<SectionInfo>,
    /// `None` where the file has no META or one of an unknown schema: a file is usable without.
    pub meta: Option<MetaInfo>,
    /// Why it is `None` although there is a META.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub meta_error: Option<String>,
}

/// See `format-spec/SPEC.md`, section 12.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FormatVersion {
    /// Readers of one major read no other.
    pub major: u16,
    /// The writer's minor.
    pub minor: u16,
    /// The smallest reader minor that can read the file.
    pub min_minor: u16,
}

/// A flag word with the names of the bits that this version knows, lowest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FlagSet {
    /// The whole word, unknown bits included.
    pub bits: u32,
    /// Of its known bits, as `format-spec/SPEC.md` writes them.
    pub names: Vec<&'static str>,
}

/// Which method built the trees, twice: as the header and as META say it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct BuilderInfo {
    /// `builder_id` of the header: information that nothing may depend on.
    pub id: u32,
    /// The build method as META names it; `None` without META.
    pub name: Option<String>,
}

/// An axis-aligned box.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Bounds {
    /// Near corner.
    pub min: [f32; 3],
    /// Far corner.
    pub max: [f32; 3],
}

/// One entry of the section table.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SectionInfo {
    /// Four characters; bytes outside printable ASCII are written `\xNN`.
    #[serde(rename = "type")]
    pub kind: String,
    /// Tells sections of one kind apart; 0 in version 1.0.
    pub ordinal: u32,
    /// [`section_flags`].
    pub flags: FlagSet,
    /// Layout version of the kind.
    pub schema: u16,
    /// `raw`, `zstd`, or the number of an unknown codec.
    pub codec: String,
    /// Bytes: `offset` is a multiple of it.
    pub align: u64,
    /// First byte in the file.
    pub offset: u64,
    /// Bytes in the file.
    pub stored_len: u64,
    /// Bytes after decoding.
    pub raw_len: u64,
    /// Records; of an opaque section what SPEC says of its kind.
    pub elem_count: u64,
    /// 0 for an opaque section.
    pub elem_size: u32,
    /// BLAKE3 of the decoded bytes.
    pub raw_hash: String,
    /// BLAKE3 of the bytes in the file.
    pub stored_hash: String,
}

/// Provenance, as META records it; the fields are those of `format-spec/SPEC.md`, section 6.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MetaInfo {
    /// Name of the writing program.
    pub tool: String,
    /// Its version.
    pub tool_version: String,
    /// Name of the build method.
    pub method: String,
    /// Raised whenever the builder's output changes.
    pub builder_revision: u32,
    /// Every effective option, in the build key's order.
    pub options: Vec<OptionInfo>,
    /// The moment of an animation that the model stands at, as its options say; `None` for one at rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moment: Option<MomentInfo>,
    /// The files that the trees were made from, in the order of first use.
    pub inputs: Vec<InputInfo>,
    /// What reading dropped or repaired.
    pub read_counts: Vec<CountInfo>,
    /// Why the writer chose what it chose, for people.
    pub notes: Vec<String>,
}

/// An option of the build.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct OptionInfo {
    /// As the build key has it.
    pub name: String,
    /// Text that two different values never share.
    pub value: String,
}

/// What a build asked of a model's animations.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MomentInfo {
    /// Name of the animation, where it was chosen by that.
    pub animation: Option<String>,
    /// Its number, where it was chosen by that. Where neither is there, it is the model's only animation.
    pub animation_number: Option<u32>,
    /// Seconds; `None` for its first key.
    pub time: Option<f64>,
}

/// A file that the trees were made from.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct InputInfo {
    /// 0: the model; 1: a file that the model names.
    pub role: u32,
    /// Relative to the model's folder.
    pub name: String,
    /// Bytes.
    pub len: u64,
    /// Of the whole file.
    pub blake3: String,
}

/// What reading dropped or repaired of one kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct CountInfo {
    /// The field of [`ReadReport`](crate::scene::ReadReport).
    pub name: String,
    /// How many.
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
        // All records of `TNOD` but the unused one of each tree.
        let of_top = sections.iter().filter(|section| section.kind == SectionKind::TNOD);
        let top_nodes = of_top.map(|section| section.elem_count.saturating_sub(1)).fold(0, u64::saturating_add);
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
            triangles: header.prim_count,
            references: header.ref_count,
            nodes: header.node_count.saturating_sub(top_nodes),
            top_nodes,
            trees: header.blas_count,
            instances: header.instance_count,
            frames: header.frame_count,
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
                SectionEntry::DELTA => "delta".to_string(),
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
            moment: ReadOptions::recorded(&m.options).moment.map(Into::into),
            options: m.options.iter().map(option).collect(),
            inputs: m.dependencies.iter().map(InputInfo::from).collect(),
            read_counts: m.read_counts.iter().map(count).collect(),
            notes: m.notes.clone(),
        }
    }
}

impl From<Moment> for MomentInfo {
    fn from(m: Moment) -> MomentInfo {
        let (animation, animation_number) = match m.animation {
            AnimationChoice::Only => (None, None),
            AnimationChoice::Number(number) => (None, Some(number)),
            AnimationChoice::Name(name) => (Some(name), None),
        };
        MomentInfo { animation, animation_number, time: m.time.map(|time| time.get()) }
    }
}

impl From<&Dependency> for InputInfo {
    fn from(d: &Dependency) -> InputInfo {
        InputInfo { role: d.role, name: d.name.clone(), len: d.len, blake3: hex(&d.blake3) }
    }
}

impl FlagSet {
    /// The word `bits` with the names of those bits of `known` that are set.
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
