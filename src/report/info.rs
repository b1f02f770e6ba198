//! The facts that a file's first kilobyte tells, in the shape that `bvhc info --json` prints.
//!
//! Fields may be added, never renamed or removed. Counts are plain numbers (all below 2⁵³), identities are lower-case hex,
//! flag words are given as numbers and as the names of their known bits.

use crate::cache::tree_flags;
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
    /// Registry number from the header.
    pub id: u32,
    /// `None` for a number that this version does not know.
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

/// Provenance, as META records it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MetaInfo {
    /// Tool and version that wrote the file.
    pub generator: String,
    pub builder: String,
    /// Raised whenever the builder's output changes.
    pub builder_revision: u32,
    /// Every effective option, in the build key's order.
    pub options: Vec<OptionInfo>,
    pub inputs: Vec<InputInfo>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct OptionInfo {
    pub name: String,
    pub value: String,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct InputInfo {
    /// Relative to the model's folder.
    pub name: String,
    pub len: u64,
    pub blake3: String,
}

/// Names of the tree flags, lowest bit first.
pub const TREE_FLAG_NAMES: [(u32, &str); 5] = [
    (tree_flags::REFITTABLE, "REFITTABLE"),
    (tree_flags::DUP_REFS, "DUP_REFS"),
    (tree_flags::CANONICAL_DFS, "CANONICAL_DFS"),
    (tree_flags::SEQUENCE, "SEQUENCE"),
    (tree_flags::TWO_LEVEL, "TWO_LEVEL"),
];

/// Names of the section flags, lowest bit first.
pub const SECTION_FLAG_NAMES: [(u32, &str); 3] = [(1, "CRITICAL"), (2, "COPY_SAFE"), (4, "CONTENT")];

impl FlagSet {
    pub fn new(bits: u32, known: &[(u32, &'static str)]) -> FlagSet {
        FlagSet { bits, names: known.iter().filter(|(bit, _)| bits & bit != 0).map(|(_, name)| *name).collect() }
    }
}

/// Lower-case hexadecimal, two digits a byte.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// A section type as text; bytes outside printable ASCII are escaped so that a hostile file cannot steer a terminal.
pub fn fourcc(bytes: [u8; 4]) -> String {
    bytes
        .iter()
        .map(|&b| if b.is_ascii_graphic() { char::from(b).to_string() } else { format!("\\x{b:02x}") })
        .collect()
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

    #[test]
    fn a_hostile_section_type_is_escaped() {
        assert_eq!(fourcc(*b"NODE"), "NODE");
        assert_eq!(fourcc([0x1b, b'[', 0xff, b'm']), "\\x1b[\\xffm");
    }
}
