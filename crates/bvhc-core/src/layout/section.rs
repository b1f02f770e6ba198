use std::fmt;

use super::header::{DELTA_MIN_MINOR, MAX_SECTIONS};

/// One entry of the section table, 128 bytes. Every field and its rule: `format-spec/SPEC.md`, section 3.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionEntry {
    /// What the section holds.
    pub kind: SectionKind,
    /// Tells sections of one kind apart: 0 in a still file, in a sequence the number of a block or a placement.
    pub ordinal: u32,
    /// Bits of [`section_flags`].
    pub flags: u32,
    /// Layout version of this kind.
    pub schema: u16,
    /// [`SectionEntry::RAW`], [`SectionEntry::ZSTD`] or [`SectionEntry::DELTA`].
    pub codec: u8,
    /// `offset` is a multiple of `1 << align_log2`; 6 ..= 16.
    pub align_log2: u8,
    /// First byte in the file.
    pub offset: u64,
    /// Bytes in the file.
    pub stored_len: u64,
    /// Bytes after decoding; equal to `stored_len` for codec raw.
    pub raw_len: u64,
    /// Records; `elem_count · elem_size = raw_len` unless `elem_size` is 0.
    pub elem_count: u64,
    /// Bytes a record, 0 for opaque content.
    pub elem_size: u32,
    /// All zero.
    pub reserved: [u8; 12],
    /// BLAKE3 of the decoded bytes.
    pub raw_hash: [u8; 32],
    /// BLAKE3 of the bytes in the file, checked before any decoder sees them.
    pub stored_hash: [u8; 32],
}

impl SectionEntry {
    /// Bytes of version 1.0's entry.
    pub const LEN: usize = 128;
    /// [`SectionEntry::codec`]: the bytes are stored as they are.
    pub const RAW: u8 = 0;
    /// [`SectionEntry::codec`]: zstd frames of 1 MiB each (`format-spec/SPEC.md`, section 8).
    pub const ZSTD: u8 = 1;
    /// [`SectionEntry::codec`] of `NODE`, `VPOS` and `TRIX` in sequences: what remains once the content was predicted, in such frames (section 8.1).
    /// Since version 1.3.
    pub const DELTA: u8 = 2;
    /// Every section starts at a cache line.
    pub const MIN_ALIGN_LOG2: u8 = 6;
    /// 64 KiB: the largest alignment that an entry may state.
    pub const MAX_ALIGN_LOG2: u8 = 16;
    /// Sections of at least [`SectionEntry::PAGE_ALIGN_FROM`] stored bytes start at a page.
    pub const PAGE_ALIGN_LOG2: u8 = 12;
    /// 64 KiB.
    pub const PAGE_ALIGN_FROM: u64 = 64 << 10;

    /// Whether a bit of [`section_flags`] is set.
    pub fn is(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    /// Whether the bytes in the file are other than the decoded ones.
    pub fn is_packed(&self) -> bool {
        self.codec != SectionEntry::RAW
    }

    /// The lowest minor version that knows the section's kind and codec; 0 for a kind that this version does not know.
    pub fn since(&self) -> u16 {
        let of_codec = if self.codec == SectionEntry::DELTA { DELTA_MIN_MINOR } else { 0 };
        self.kind.rule().map_or(0, |rule| rule.since.max(of_codec))
    }

    /// First byte behind the section, or `None` where the sum does not fit in 64 bits.
    pub fn end(&self) -> Option<u64> {
        self.offset.checked_add(self.stored_len)
    }
}

const _: () = assert!(size_of::<SectionEntry>() == SectionEntry::LEN);
const _: () = assert!(std::mem::offset_of!(SectionEntry, raw_hash) == 64);

crate::pod::plain! {
    SectionKind = [[u8; 4]];
    SectionEntry = [SectionKind, u32, u32, u16, u8, u8, [u64; 4], u32, [u8; 12], [[u8; 32]; 2]];
}

/// Four ASCII bytes that say what a section holds.
#[repr(transparent)]
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SectionKind(pub [u8; 4]);

impl SectionKind {
    /// BLAS nodes, tree after tree: [`Node`](crate::layout::Node).
    pub const NODE: SectionKind = SectionKind(*b"NODE");
    /// Leaf-ordered triangles, tree after tree: [`TriangleRecord`](super::TriangleRecord).
    pub const TRIS: SectionKind = SectionKind(*b"TRIS");
    /// Source parts: [`GeomRecord`](super::GeomRecord).
    pub const GEOM: SectionKind = SectionKind(*b"GEOM");
    /// Trees: [`BlasRecord`](super::BlasRecord).
    pub const BLAS: SectionKind = SectionKind(*b"BLAS");
    /// TLAS nodes: [`Node`](crate::layout::Node).
    pub const TNOD: SectionKind = SectionKind(*b"TNOD");
    /// Instances in TLAS leaf order: [`InstanceRecord`](super::InstanceRecord).
    pub const INST: SectionKind = SectionKind(*b"INST");
    /// Rows of compact trees, one for each of `BLAS`: [`WideRow`](super::WideRow). Since version 1.4.
    pub const CROW: SectionKind = SectionKind(*b"CROW");
    /// Nodes of compact trees, tree after tree: [`CompactNode`](super::CompactNode). Since version 1.4.
    pub const CNOD: SectionKind = SectionKind(*b"CNOD");
    /// For each reference of compact trees the record of `TRIS` that it is, counted from the tree's own start. Since version 1.4.
    pub const CREF: SectionKind = SectionKind(*b"CREF");
    /// Turned subtrees of a tree: [`TurnRecord`](super::TurnRecord). Since version 1.5.
    pub const OROW: SectionKind = SectionKind(*b"OROW");
    /// Their nodes, with boxes along axes of their own: [`Node`](crate::layout::Node). Since version 1.5.
    pub const ONOD: SectionKind = SectionKind(*b"ONOD");
    /// Which vertices of the source each triangle has: three numbers for each record of `TRIS`. Since version 1.1.
    pub const VERT: SectionKind = SectionKind(*b"VERT");
    /// Which parts were mirrored when they were baked: a word of [`side_flags`](super::side_flags) for each row of `GEOM`. Since version 1.1.
    pub const SIDE: SectionKind = SectionKind(*b"SIDE");
    /// The names of the parts in `GEOM`.
    pub const NAMS: SectionKind = SectionKind(*b"NAMS");
    /// The names of their materials. Since version 1.1.
    pub const MATS: SectionKind = SectionKind(*b"MATS");
    /// Topologies of a sequence: [`TopologyRecord`](super::TopologyRecord). Since version 1.2.
    pub const TOPO: SectionKind = SectionKind(*b"TOPO");
    /// Their leaf-ordered triangles, topology after topology: [`IndexedTriangleRecord`](super::IndexedTriangleRecord). Since version 1.2.
    pub const TRIX: SectionKind = SectionKind(*b"TRIX");
    /// Poses of a sequence: [`PoseRecord`](super::PoseRecord). Since version 1.2.
    pub const POSE: SectionKind = SectionKind(*b"POSE");
    /// Vertices of the poses of a block, `[f32; 3]`. Since version 1.2.
    pub const VPOS: SectionKind = SectionKind(*b"VPOS");
    /// Frames of a sequence: [`FrameRecord`](super::FrameRecord). Since version 1.2.
    pub const FRAM: SectionKind = SectionKind(*b"FRAM");
    /// Provenance: `Meta`.
    pub const META: SectionKind = SectionKind(*b"META");

    /// What this version says about this kind, or `None` for an unknown one.
    pub fn rule(self) -> Option<&'static KindRule> {
        KINDS.iter().find(|rule| rule.kind == self)
    }
}

/// Shows printable bytes as they are and the others as `\xNN`, so that a hostile name cannot reach a terminal.
impl fmt::Display for SectionKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.escape_ascii())
    }
}

impl fmt::Debug for SectionKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// Bits of [`SectionEntry::flags`].
pub mod section_flags {
    /// A reader that does not know this kind, schema or codec must refuse the file.
    pub const CRITICAL: u32 = 1;
    /// A tool that changes only the container may copy this section unread.
    pub const COPY_SAFE: u32 = 2;
    /// The section is part of `content_id`.
    pub const CONTENT: u32 = 4;
    /// Every bit that this version assigns.
    pub const ALL: u32 = 7;
}

/// The fixed properties of a known kind.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KindRule {
    /// The kind that this is about.
    pub kind: SectionKind,
    /// The layout version that this library knows.
    pub schema: u16,
    /// What [`SectionEntry::flags`] must be.
    pub flags: u32,
    /// Bytes a record, 0 for opaque content.
    pub elem_size: u32,
    /// In which files the kind stands.
    pub presence: Presence,
    /// Sections of this kind have the numbers below this one: 1, or [`MAX_SECTIONS`](super::MAX_SECTIONS) for what a sequence has several of.
    pub ordinals: u32,
    /// The minor version that brought it.
    pub since: u16,
}

/// When a known kind stands in a file. No kind and number stand there twice.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// In every file, with zero records if need be.
    Always,
    /// In every still file, and in no sequence.
    Still,
    /// Exactly in files with the tree flag `TWO_LEVEL`, which sequences have.
    TwoLevel,
    /// In every sequence, and in no still file.
    Sequence,
    /// Wherever the writer has something to say.
    Optional,
    /// In still files alone, wherever the writer has something to say.
    StillOptional,
}

/// The kinds of this version, in the order in which this crate writes them.
pub const KINDS: [KindRule; 21] = {
    use section_flags::{CONTENT, COPY_SAFE, CRITICAL};
    const fn rule(kind: SectionKind, flags: u32, elem_size: u32, presence: Presence) -> KindRule {
        KindRule { kind, schema: 1, flags, elem_size, presence, ordinals: 1, since: 0 }
    }
    const fn since(minor: u16, rule: KindRule) -> KindRule {
        KindRule { since: minor, ..rule }
    }
    const fn several(rule: KindRule) -> KindRule {
        KindRule { ordinals: MAX_SECTIONS, ..rule }
    }
    const RECORDS: u32 = CRITICAL | CONTENT;
    [
        several(rule(SectionKind::NODE, RECORDS, 32, Presence::Always)),
        rule(SectionKind::TRIS, RECORDS, 48, Presence::Still),
        rule(SectionKind::GEOM, RECORDS, 64, Presence::Always),
        rule(SectionKind::BLAS, RECORDS, 64, Presence::Still),
        several(rule(SectionKind::TNOD, RECORDS, 32, Presence::TwoLevel)),
        several(rule(SectionKind::INST, RECORDS, 128, Presence::TwoLevel)),
        since(2, rule(SectionKind::TOPO, RECORDS, 64, Presence::Sequence)),
        since(2, rule(SectionKind::TRIX, RECORDS, 24, Presence::Sequence)),
        since(2, rule(SectionKind::POSE, RECORDS, 64, Presence::Sequence)),
        since(2, several(rule(SectionKind::VPOS, RECORDS, 12, Presence::Sequence))),
        since(2, rule(SectionKind::FRAM, RECORDS, 32, Presence::Sequence)),
        since(4, rule(SectionKind::CROW, COPY_SAFE, 16, Presence::StillOptional)),
        since(4, rule(SectionKind::CNOD, COPY_SAFE, 80, Presence::StillOptional)),
        since(4, rule(SectionKind::CREF, COPY_SAFE, 4, Presence::StillOptional)),
        since(5, rule(SectionKind::OROW, COPY_SAFE, 64, Presence::StillOptional)),
        since(5, rule(SectionKind::ONOD, COPY_SAFE, 32, Presence::StillOptional)),
        since(1, rule(SectionKind::VERT, COPY_SAFE | CONTENT, 12, Presence::Optional)),
        since(1, rule(SectionKind::SIDE, COPY_SAFE | CONTENT, 4, Presence::Optional)),
        rule(SectionKind::NAMS, COPY_SAFE, 0, Presence::Optional),
        since(1, rule(SectionKind::MATS, COPY_SAFE | CONTENT, 0, Presence::Optional)),
        rule(SectionKind::META, COPY_SAFE, 0, Presence::Optional),
    ]
};

/// The lowest minor version that knows all of these sections: what a file with them states. Kinds that this version does not know do not count.
pub fn minor_of(entries: &[SectionEntry]) -> u16 {
    entries.iter().map(SectionEntry::since).max().unwrap_or(0)
}
