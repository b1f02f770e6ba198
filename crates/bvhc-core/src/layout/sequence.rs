//! The records that a file of many frames has beside those of a still one: `format-spec/SPEC.md`, section 5.6.
//!
//! ```text
//! FRAM ─▶ placement: TNOD, INST ─▶ POSE ─▶ TOPO ─▶ TRIX, GEOM
//!                                   └────▶ block: NODE, VPOS
//! ```
//!
//! A *topology* is what a tree shares between the frames: which triangles it has, in which order, over how many vertices. A *pose* is a topology
//! at one moment: its vertices and its boxes. A *placement* says which poses stand where, and a *frame* shows one placement.

/// `TOPO`: one topology, 64 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TopologyRecord {
    /// First record in `TRIX`.
    pub ref_offset: u64,
    /// Records in `TRIX`.
    pub ref_count: u32,
    /// Records in `NODE` of each of its poses, the unused record 1 included: 0 for an empty tree, otherwise even.
    pub node_count: u32,
    /// Records in `VPOS` of each of its poses.
    pub vertex_count: u32,
    /// Distinct triangles; `ref_count` is larger only with `DUP_REFS`.
    pub prim_count: u32,
    /// Depth of the tree's deepest leaf; the root has depth 0.
    pub max_depth: u32,
    /// [`tree_flags`](super::tree_flags) of this tree: `REFITTABLE` or `DUP_REFS`.
    pub flags: u32,
    /// All zero.
    pub reserved: [u32; 8],
}

/// `TRIX`: one slot of the leaf order, 24 bytes. With the vertices of a pose it is a [`TriangleRecord`](super::TriangleRecord).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndexedTriangleRecord {
    /// The corners, numbers of vertices of the pose.
    pub corners: [u32; 3],
    /// As [`TriangleRecord::prim`](super::TriangleRecord::prim).
    pub prim: u32,
    /// Row of `GEOM`.
    pub geom: u32,
    /// As [`TriangleRecord::flags`](super::TriangleRecord::flags).
    pub flags: u32,
}

/// `POSE`: a topology at one moment, 64 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseRecord {
    /// Near corner of the root's box; all zero for an empty tree.
    pub min: [f32; 3],
    /// Row of `TOPO`.
    pub topology: u32,
    /// Far corner of the root's box.
    pub max: [f32; 3],
    /// The number of the sections `NODE` and `VPOS` that hold it.
    pub block: u32,
    /// First record in that `NODE`; always even.
    pub node_offset: u64,
    /// First record in that `VPOS`.
    pub vertex_offset: u64,
    /// SAH cost as [`BlasRecord::sah`](super::BlasRecord::sah): what the tree is worth in this pose.
    pub sah: f32,
    /// Bit 0: the topology was built over this pose. Other bits zero.
    pub flags: u32,
    /// All zero.
    pub reserved: [u32; 2],
}

impl PoseRecord {
    /// The bit of [`PoseRecord::flags`].
    pub const KEY: u32 = 1;
}

/// `FRAM`: one frame, 32 bytes, in ascending order of [`FrameRecord::number`].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRecord {
    /// The frame's number in the source: that of an OBJ file's name, or counted from 0.
    pub number: i32,
    /// The number of the sections `TNOD` and `INST` that say what stands where.
    pub placement: u32,
    /// Seconds from the start of the animation; 0 without [`FrameRecord::TIMED`].
    pub time: f32,
    /// Bits of the constants below. Other bits zero.
    pub flags: u32,
    /// All zero.
    pub reserved: [u32; 4],
}

impl FrameRecord {
    /// `time` is the frame's time.
    pub const TIMED: u32 = 1;
    /// The source has no such frame: the one before it is shown.
    pub const HELD: u32 = 2;
}

const _: () = assert!(size_of::<TopologyRecord>() == 64);
const _: () = assert!(size_of::<IndexedTriangleRecord>() == 24);
const _: () = assert!(size_of::<PoseRecord>() == 64);
const _: () = assert!(size_of::<FrameRecord>() == 32);

crate::pod::plain! {
    TopologyRecord = [u64, [u32; 6], [u32; 8]];
    IndexedTriangleRecord = [[u32; 3], u32, u32, u32];
    PoseRecord = [[f32; 3], u32, [f32; 3], u32, [u64; 2], f32, u32, [u32; 2]];
    FrameRecord = [i32, u32, f32, u32, [u32; 4]];
}
