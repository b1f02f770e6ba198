use crate::geom::Aabb;

#[cfg(target_endian = "big")]
compile_error!(
    "bvhc maps its little-endian records as they are; a big-endian host needs a byte-swapping reader, which does not exist yet"
);

/// First eight bytes of every file. The high bit catches 7-bit transfer, CR LF and LF catch newline conversion, and 1A ends a
/// listing on DOS: the reasoning of the PNG specification.
pub const MAGIC: [u8; 8] = *b"\x89BVH\r\n\x1A\n";
/// Format major version: a reader of one major reads no other.
pub const MAJOR: u16 = 1;
/// Format minor version that this crate fully understands. What it writes states the lowest one that has all of the file's sections:
/// [`minor_of`](super::minor_of).
pub const MINOR: u16 = 5;
/// Smallest reader minor that can read still files.
pub const MIN_MINOR: u16 = 0;
/// Smallest reader minor that can read files of many frames.
pub const SEQUENCE_MIN_MINOR: u16 = 2;
/// Smallest reader minor that can read files with sections of [`SectionEntry::DELTA`](super::SectionEntry::DELTA).
pub const DELTA_MIN_MINOR: u16 = 3;
/// Bits of [`Header::features_required`] that this crate understands: [`required_features::SEQUENCE`].
pub const KNOWN_REQUIRED_FEATURES: u64 = required_features::SEQUENCE;
/// Bits of [`Header::features_required`].
pub mod required_features {
    /// The file has many frames. Since version 1.2.
    pub const SEQUENCE: u64 = 1;
}
/// A file holds at most this many sections.
pub const MAX_SECTIONS: u32 = 65_536;

/// The first 256 bytes of a file, little-endian. Every field and its rule: `format-spec/SPEC.md`, section 2.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// [`MAJOR`] of the writer.
    pub major: u16,
    /// The lowest minor version that has all sections of the file, at most [`MINOR`] of the writer.
    pub minor: u16,
    /// The smallest minor of a reader of the same major that can read the file.
    pub min_minor: u16,
    /// 256; a later minor may grow the header, and readers skip what they do not know.
    pub header_len: u16,
    /// Exact length of the file, a multiple of 64.
    pub file_len: u64,
    /// Bits of which a reader must know every one that is set; see [`KNOWN_REQUIRED_FEATURES`].
    pub features_required: u64,
    /// Bits that a reader may ignore. None is assigned yet.
    pub features_optional: u64,
    /// Entries of the section table, at most [`MAX_SECTIONS`].
    pub section_count: u32,
    /// Bytes from one entry to the next: [`SectionEntry::LEN`](super::SectionEntry::LEN).
    pub section_entry_len: u32,
    /// First byte of the table in the file.
    pub section_table_off: u64,
    /// Bits of [`tree_flags`](super::tree_flags).
    pub tree_flags: u32,
    /// Information that nothing may depend on: 1 where `binned` and 2 where `sbvh` built the trees, 0 for every other method. META
    /// names the method.
    pub builder_id: u32,
    /// BLAKE3 over header and table; see [`keys::file_id`](crate::cache::keys::file_id).
    pub file_id: [u8; 32],
    /// Identity of the tree data, the same raw or compressed; see [`keys::content_id`](crate::cache::keys::content_id).
    pub content_id: [u8; 32],
    /// What the file was built from; see [`keys::Recipe::build_key`](crate::cache::keys::Recipe::build_key).
    pub build_key: [u8; 32],
    /// Distinct triangles over all BLASes.
    pub prim_count: u64,
    /// Records of `TRIS`; in a sequence of `TRIX`.
    pub ref_count: u64,
    /// Live nodes: every record of `NODE` and `TNOD` but the unused record 1 of each tree. In a sequence those of all poses and placements.
    pub node_count: u64,
    /// Records of `BLAS`; in a sequence of `TOPO`.
    pub blas_count: u32,
    /// Records of `INST`; 0 in a one-level file. In a sequence those of all placements.
    pub instance_count: u32,
    /// Records of `FRAM`; 0 in a still file.
    pub frame_count: u32,
    /// Depth of the deepest leaf of any single tree, BLAS or TLAS; the root has depth 0.
    pub max_depth: u32,
    /// World bounds, in a sequence over all frames; all zero for an empty scene.
    pub scene_min: [f32; 3],
    /// The far corner of those bounds.
    pub scene_max: [f32; 3],
    /// All zero.
    pub reserved: [u8; 32],
}

impl Header {
    /// Bytes of version 1.0's header.
    pub const LEN: usize = 256;

    /// World bounds; a point at the origin for an empty scene.
    #[inline]
    pub fn scene_bounds(&self) -> Aabb {
        Aabb { min: self.scene_min, max: self.scene_max }
    }

    /// Is a bit of [`tree_flags`](super::tree_flags) set?
    #[inline]
    pub fn has(&self, flag: u32) -> bool {
        self.tree_flags & flag != 0
    }
}

const _: () = assert!(size_of::<Header>() == Header::LEN);
const _: () = assert!(std::mem::offset_of!(Header, file_id) == 64);
const _: () = assert!(std::mem::offset_of!(Header, prim_count) == 160);
const _: () = assert!(std::mem::offset_of!(Header, scene_min) == 200);

crate::pod::plain! {
    Header = [
        [u8; 8], [u16; 4], [u64; 3], [u32; 2], u64, [u32; 2], [[u8; 32]; 3], [u64; 3], [u32; 4], [[f32; 3]; 2], [u8; 32],
    ];
}
