//! An open file, handed out as slices.

use std::ops::Range;
use std::sync::OnceLock;

use bytemuck::Pod;

use super::aligned::AlignedBytes;
use super::container::Container;
use super::file_bytes::{FileBytes, to_usize};
use super::options::Validation;
use super::records_by_id::RecordsById;
use super::{Header, Meta, View};
use crate::layout::{
    BlasRecord, CompactNode, GeomRecord, InstanceRecord, Node, SectionEntry, SectionKind, TriangleRecord, TurnRecord,
    WideRow, marks_of,
};

/// An open cache file that owns or maps its bytes.
pub type Cache = Opened<'static>;

/// An open cache file. [`Cache`] is the form that owns or maps its bytes; [`Cache::from_slice`] gives one that borrows them.
pub struct Opened<'a> {
    pub(super) bytes: FileBytes<'a>,
    pub(super) container: Container,
    /// The decoded bytes of each packed section, parallel to the section table.
    pub(super) decoded: Vec<Option<AlignedBytes>>,
    pub(super) places: Places,
    /// For each instance of the scene its record; filled when it is first asked for.
    pub(super) by_id: OnceLock<RecordsById>,
    /// For each pair of nodes whether it is turned; filled when it is first asked for.
    pub(super) marks: OnceLock<Vec<u64>>,
    pub(super) meta: Option<Meta>,
    pub(super) meta_error: Option<String>,
    pub(super) validation: Validation,
}

/// Index of each kind's table entry, number 0.
#[derive(Clone, Copy)]
pub(super) struct Places {
    pub node: Option<usize>,
    pub tris: Option<usize>,
    pub geom: Option<usize>,
    pub blas: Option<usize>,
    pub tnod: Option<usize>,
    pub inst: Option<usize>,
    pub crow: Option<usize>,
    pub cnod: Option<usize>,
    pub cref: Option<usize>,
    pub orow: Option<usize>,
    pub onod: Option<usize>,
    pub vert: Option<usize>,
    pub side: Option<usize>,
    pub nams: Option<usize>,
    pub mats: Option<usize>,
}

impl Opened<'_> {
    /// The file's first 256 bytes. Not every count in it is held against the records below [`Validation::Tree`].
    pub fn header(&self) -> &Header {
        &self.container.header
    }

    /// The section table, unknown sections included.
    pub fn sections(&self) -> &[SectionEntry] {
        &self.container.entries
    }

    /// The index in [`Cache::sections`] of the section of this kind and number, if this version can read it.
    pub fn find(&self, kind: SectionKind, ordinal: u32) -> Option<usize> {
        self.container.find(kind, ordinal)
    }

    /// Bytes that are held in memory: the file's own where it is not mapped, and decoded sections.
    pub(super) fn held(&self) -> u128 {
        let decoded = self.decoded.iter().flatten().map(|section| section.as_slice().len() as u128);
        self.bytes.owned_len() as u128 + decoded.sum::<u128>()
    }

    /// The level at which the file was opened.
    pub fn validation(&self) -> Validation {
        self.validation
    }

    /// Provenance; `None` for a file without META, and for one whose META cannot be read: [`Cache::meta_error`].
    pub fn meta(&self) -> Option<&Meta> {
        self.meta.as_ref()
    }

    /// Why [`Cache::meta`] is `None` although the file has a META: it is of a later layout, or breaks its own. Traversal does not
    /// need it, so such a file is opened all the same.
    pub fn meta_error(&self) -> Option<&str> {
        self.meta_error.as_deref()
    }

    /// Everything that traversal reads.
    pub fn view(&self) -> View<'_> {
        View {
            nodes: self.nodes(),
            triangles: self.triangles(),
            geoms: self.geoms(),
            blases: self.blases(),
            tlas_nodes: self.tlas_nodes(),
            instances: self.instances(),
        }
    }

    /// `NODE`: the nodes of all BLASes, tree after tree; where each begins, [`BlasRecord::node_offset`] says.
    pub fn nodes(&self) -> &[Node] {
        self.records(self.places.node)
    }

    /// `TRIS`: the triangles of all BLASes in leaf order; where each begins, [`BlasRecord::ref_offset`] says. With spatial splits a
    /// triangle may stand there several times.
    pub fn triangles(&self) -> &[TriangleRecord] {
        self.records(self.places.tris)
    }

    /// `GEOM`: the source parts, which [`Hit::geom`](crate::Hit::geom) and [`TriangleRecord::geom`] index.
    pub fn geoms(&self) -> &[GeomRecord] {
        self.records(self.places.geom)
    }

    /// `BLAS`: one record for each tree; none in an empty scene.
    pub fn blases(&self) -> &[BlasRecord] {
        self.records(self.places.blas)
    }

    /// Empty in a one-level file.
    pub fn tlas_nodes(&self) -> &[Node] {
        self.records(self.places.tnod)
    }

    /// The instances in the order of the top-level tree's leaves; empty in a one-level file. Hits name them by their `id`:
    /// see [`Cache::instance_record`](Opened::instance_record).
    pub fn instances(&self) -> &[InstanceRecord] {
        self.records(self.places.inst)
    }

    /// `CROW`: one row for each compact tree. Empty in a file without them, as are the nodes and the order.
    pub fn compact_rows(&self) -> &[WideRow] {
        self.records(self.places.crow)
    }

    /// `CNOD`: the nodes of all compact trees; where each begins, [`WideRow::node_offset`] says.
    pub fn compact_nodes(&self) -> &[CompactNode] {
        self.records(self.places.cnod)
    }

    /// `CREF`: for each reference of a compact tree the triangle of the tree that it is; those of a tree stand where its triangles do.
    pub fn compact_order(&self) -> &[u32] {
        self.records(self.places.cref)
    }

    /// `OROW`: the turned subtrees. Empty in a file without them, as are their nodes.
    pub fn turns(&self) -> &[TurnRecord] {
        self.records(self.places.orow)
    }

    /// `ONOD`: the nodes below turned subtrees, with boxes along the axes that `OROW` states; where those of each begin,
    /// [`TurnRecord::node_offset`] says.
    pub fn turned_nodes(&self) -> &[Node] {
        self.records(self.places.onod)
    }

    /// A bit for each pair of nodes that a turned subtree begins with.
    pub(crate) fn turn_marks(&self) -> &[u64] {
        self.marks.get_or_init(|| marks_of(self.turns(), self.nodes().len()))
    }

    /// The decoded bytes of section `index` of [`Cache::sections`]; `None` for an unknown codec, for a section that may be ignored and
    /// cannot be decoded, and at [`Validation::Quick`] for packed sections of unknown kinds.
    pub fn section_bytes(&self, index: usize) -> Option<&[u8]> {
        match self.sections().get(index)?.codec {
            SectionEntry::RAW => Some(self.stored_bytes(index)),
            _ => self.decoded.get(index)?.as_ref().map(AlignedBytes::as_slice),
        }
    }

    /// The bytes of section `index` as they stand in the file; empty beyond the table.
    pub fn stored_bytes(&self, index: usize) -> &[u8] {
        let range = self.sections().get(index).and_then(|e| Some(to_usize(e.offset)?..to_usize(e.end()?)?));
        // The container checks found every range inside the file, so this finds it there too.
        range.and_then(|range: Range<usize>| self.bytes.as_slice().get(range)).unwrap_or_default()
    }

    pub(super) fn records<T: Pod>(&self, place: Option<usize>) -> &[T] {
        let bytes = place.and_then(|i| self.section_bytes(i)).unwrap_or_default();
        // Offsets are multiples of 64 in memory that starts at one, and lengths are multiples of the record's: both were checked.
        bytemuck::try_cast_slice(bytes).unwrap_or_default()
    }
}

/// Renderers share one cache between threads.
const _: fn() = || {
    fn shared<T: Send + Sync>() {}
    shared::<Cache>();
};

impl std::fmt::Debug for Opened<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cache")
            .field("header", self.header())
            .field("sections", &self.sections())
            .finish_non_exhaustive()
    }
}
