//! Files of many frames: opened once, and each frame handed out as the slices that traversal reads.
//!
//! ```text
//! open: front, and the rows of TOPO, TRIX, POSE, FRAM and GEOM     open
//! frame(n): placement ─▶ poses ─▶ triangles with corners           frame
//! at(time): which two frames                                       moment
//! between(n, m): placements ─▶ pairs of poses                      between
//! ```
//!
//! What a frame does not show is neither hashed, decoded nor touched when it is opened.

mod between;
mod frame;
mod moment;
#[cfg(feature = "zstd")]
mod moved;
mod open;

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use super::reader::Opened;
use super::{Header, Meta, Validation};
use crate::layout::{
    FrameRecord, GeomRecord, IndexedTriangleRecord, Names, PoseRecord, SectionEntry, TopologyRecord, side_flags,
};

pub use between::{Between, BetweenInstance, BetweenTree};
pub use frame::Frame;
pub use moment::Moment;

/// An open file of many frames that owns or maps its bytes.
pub type Sequence = Frames<'static>;

/// An open file of many frames. [`Sequence`] is the form that owns or maps its bytes; [`Sequence::from_slice`] gives one that borrows them.
pub struct Frames<'a> {
    file: Opened<'a>,
    topologies: Option<usize>,
    corners: Option<usize>,
    poses: Option<usize>,
    frames: Option<usize>,
    /// For each block its entries `NODE` and `VPOS`.
    blocks: Vec<[usize; 2]>,
    /// For each placement its entries `TNOD` and `INST`.
    placements: Vec<[usize; 2]>,
    /// For each topology its rows of `GEOM`.
    parts: Vec<Range<u32>>,
    /// For each entry whether its stored bytes had their hash when a frame first needed them.
    hashed: Vec<AtomicBool>,
    max_memory: u64,
    /// Where blocks are stored as differences.
    #[cfg(feature = "zstd")]
    moved: Option<moved::Moved>,
}

impl Frames<'_> {
    /// How many frames there are, at least one.
    pub fn frame_count(&self) -> usize {
        self.frames().len()
    }

    /// `FRAM`: the frames, in ascending order of their numbers.
    pub fn frames(&self) -> &[FrameRecord] {
        self.file.records(self.frames)
    }

    /// The frame of the source that has this number: an index into [`Sequence::frames`](Frames::frames).
    pub fn numbered(&self, number: i32) -> Option<usize> {
        self.frames().binary_search_by_key(&number, |frame| frame.number).ok()
    }

    /// `POSE`: the poses of the topologies, block after block.
    pub fn poses(&self) -> &[PoseRecord] {
        self.file.records(self.poses)
    }

    /// `TOPO`: what the poses share.
    pub fn topologies(&self) -> &[TopologyRecord] {
        self.file.records(self.topologies)
    }

    /// `TRIX`: the triangles of all topologies in leaf order.
    pub fn indexed_triangles(&self) -> &[IndexedTriangleRecord] {
        self.file.records(self.corners)
    }

    /// `GEOM`: the source parts; [`GeomRecord::blas`] is a topology.
    pub fn geoms(&self) -> &[GeomRecord] {
        self.file.geoms()
    }

    /// The names of the parts, parallel to [`Sequence::geoms`](Frames::geoms); empty where the file has none.
    pub fn names(&self) -> Names<'_> {
        self.file.names()
    }

    /// The names of the parts' materials, parallel to [`Sequence::geoms`](Frames::geoms); empty where the file has none.
    pub fn materials(&self) -> Names<'_> {
        self.file.materials()
    }

    /// For each row of [`Sequence::geoms`](Frames::geoms) bits of [`side_flags`](crate::layout::side_flags); empty where none has any.
    pub fn sides(&self) -> &[u32] {
        let all: &[u32] = self.file.records(self.file.places.side);
        if all.len() == self.geoms().len() { all } else { &[] }
    }

    /// Whether the transform that was baked into a part's positions mirrors.
    pub fn is_mirrored(&self, geom: u32) -> bool {
        self.sides().get(geom as usize).is_some_and(|side| side & side_flags::MIRRORED != 0)
    }

    /// Which vertices of the source each of [`Sequence::indexed_triangles`](Frames::indexed_triangles) has; empty where the file was built without them.
    pub fn vertices(&self) -> &[[u32; 3]] {
        let all: &[[u32; 3]] = self.file.records(self.file.places.vert);
        if all.len() == self.indexed_triangles().len() { all } else { &[] }
    }

    /// The file's first 256 bytes.
    pub fn header(&self) -> &Header {
        self.file.header()
    }

    /// The section table, unknown sections included.
    pub fn sections(&self) -> &[SectionEntry] {
        self.file.sections()
    }

    /// The level at which the file was opened, and at which each frame is handed out.
    pub fn validation(&self) -> Validation {
        self.file.validation()
    }

    /// Provenance; `None` for a file without META, and for one whose META cannot be read.
    pub fn meta(&self) -> Option<&Meta> {
        self.file.meta()
    }

    /// Why [`Sequence::meta`](Frames::meta) is `None` although the file has a META.
    pub fn meta_error(&self) -> Option<&str> {
        self.file.meta_error()
    }

    /// Bytes in the file of what was first stored with a block: nodes and vertices of poses that no frame before it has.
    pub fn block_bytes(&self, block: usize) -> u64 {
        let lens = |entries: &[usize; 2]| entries.iter().map(|i| self.sections()[*i].stored_len).sum();
        self.blocks.get(block).map_or(0, lens)
    }

    /// How many blocks there are.
    pub fn block_count(&self) -> usize {
        self.blocks.len()
    }
}

impl std::fmt::Debug for Frames<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Sequence")
            .field("header", self.header())
            .field("frames", &self.frames())
            .finish_non_exhaustive()
    }
}

/// Renderers share one file between threads.
const _: fn() = || {
    fn shared<T: Send + Sync>() {}
    shared::<Sequence>();
};
