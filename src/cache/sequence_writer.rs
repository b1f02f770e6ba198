//! Writing a sequence: frame by frame, so that no more of it is held in memory than the frame at hand and the rows of all.
//!
//! Blocks and placements go to a spool file beside the output as they come, packed and hashed. At the end the front is laid out, and the spool is
//! copied behind it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};

use bytemuck::{Zeroable, cast_slice};

use bvhc_core::cache::check::check_parts;
use bvhc_core::cache::parts::{Block, Encoder, Fault, encode_names};

use super::check::Limits;
use super::frame_order::misplaced;
use super::sealed::{Data, Form, Piece, Sealed, store, store_delta};
use super::writer::{builder_id, refusal};
use super::{
    CacheError, Codec, FrameRecord, GeomRecord, Header, IndexedTriangleRecord, InstanceRecord, KINDS, MAGIC, MAJOR,
    Meta, PoseRecord, SEQUENCE_MIN_MINOR, SectionEntry, SectionKind, TopologyRecord, WriteSummary, atomic,
    required_features, tree_flags,
};
use crate::exec::Executor;
use crate::geom::{Aabb, Point};
use crate::layout::MAX_LEAF;
use crate::tree::{Node, max_depth, quality};

/// The parts of a topology: rows of `GEOM` and what is parallel to them.
#[derive(Clone, Copy, Debug)]
pub struct Parts<'a> {
    /// The rows; `blas` is set by the writer.
    pub geoms: &'a [GeomRecord],
    /// Names, one for each row; empty where none are known.
    pub names: &'a [String],
    /// Names of materials, one for each row; empty where none are known.
    pub materials: &'a [String],
    /// Bits of [`side_flags`](super::side_flags), one for each row; empty where none has any.
    pub sides: &'a [u32],
    /// For each triangle of the topology its vertices in the source; empty where they were not asked for.
    pub vertices: &'a [[u32; 3]],
}

/// A sequence that is being written. Call [`SequenceWriter::topology`] and [`SequenceWriter::pose`] for what a frame shows for the first time, then
/// [`SequenceWriter::frame`].
#[derive(Debug)]
pub struct SequenceWriter<'e> {
    name: String,
    path: PathBuf,
    codec: Codec,
    /// Packs blocks as differences, where that was asked for.
    encoder: Option<Encoder>,
    exec: &'e Executor,
    spool: Spool,
    topologies: Vec<TopologyRecord>,
    triangles: Vec<IndexedTriangleRecord>,
    poses: Vec<PoseRecord>,
    frames: Vec<FrameRecord>,
    geoms: Vec<GeomRecord>,
    names: Vec<String>,
    materials: Vec<String>,
    sides: Vec<u32>,
    sources: Vec<[u32; 3]>,
    /// The block that the next frame closes.
    nodes: Vec<Node>,
    vertices: Vec<Point>,
    blocks: u32,
    /// Placements by the hash of both sections.
    placements: BTreeMap<[u8; 32], u32>,
    bounds: Aabb,
    live_nodes: u64,
    instances: u64,
    depth: u32,
}

/// Sections that are stored already.
#[derive(Debug)]
struct Spool {
    file: File,
    end: u64,
    entries: Vec<(SectionEntry, u64)>,
}

impl<'e> SequenceWriter<'e> {
    /// Begin a file that [`SequenceWriter::finish`] puts at `path`.
    ///
    /// # Errors
    /// Where no file can be made beside it.
    pub fn new(path: &Path, codec: Codec, exec: &'e Executor) -> Result<SequenceWriter<'e>, CacheError> {
        let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
        let file = tempfile::tempfile_in(folder).map_err(CacheError::io("create a temporary file beside", path))?;
        Ok(SequenceWriter {
            name: path.display().to_string(),
            path: path.to_owned(),
            codec,
            encoder: if let Codec::Compact { level } = codec { Some(Encoder::new(level)) } else { None },
            exec,
            spool: Spool { file, end: 0, entries: Vec::new() },
            topologies: Vec::new(),
            triangles: Vec::new(),
            poses: Vec::new(),
            frames: Vec::new(),
            geoms: Vec::new(),
            names: Vec::new(),
            materials: Vec::new(),
            sides: Vec::new(),
            sources: Vec::new(),
            nodes: Vec::new(),
            vertices: Vec::new(),
            blocks: 0,
            placements: BTreeMap::new(),
            bounds: Aabb::EMPTY,
            live_nodes: 0,
            instances: 0,
            depth: 0,
        })
    }

    /// Add a topology: its triangles in leaf order, whose `geom` counts from the first of `parts`, and how many vertices they name. Its
    /// number.
    pub fn topology(
        &mut self,
        nodes: &[Node],
        vertex_count: u32,
        triangles: impl IntoIterator<Item = IndexedTriangleRecord>,
        parts: &Parts<'_>,
    ) -> u32 {
        let number = self.topologies.len() as u32;
        let (ref_offset, first_geom) = (self.triangles.len() as u64, self.geoms.len() as u32);
        let place = |t: IndexedTriangleRecord| IndexedTriangleRecord { geom: t.geom + first_geom, ..t };
        self.triangles.extend(triangles.into_iter().map(place));
        self.geoms.extend(parts.geoms.iter().map(|geom| GeomRecord { blas: number, ..*geom }));
        let named = |some: &[String], i: usize| some.get(i).cloned().unwrap_or_default();
        let rows = 0..parts.geoms.len();
        self.names.extend(rows.clone().map(|i| named(parts.names, i)));
        self.materials.extend(rows.clone().map(|i| named(parts.materials, i)));
        self.sides.extend(rows.map(|i| parts.sides.get(i).copied().unwrap_or(0)));
        self.sources.extend_from_slice(parts.vertices);
        let mine = &self.triangles[ref_offset as usize..];
        let split = mine.iter().any(|t| t.flags != 0);
        let depth = max_depth(nodes);
        self.depth = self.depth.max(depth);
        self.topologies.push(TopologyRecord {
            ref_offset,
            ref_count: mine.len() as u32,
            node_count: nodes.len() as u32,
            vertex_count,
            prim_count: parts.geoms.iter().map(|geom| geom.kept_count).sum(),
            max_depth: depth,
            flags: if split { tree_flags::DUP_REFS } else { tree_flags::REFITTABLE },
            reserved: [0; 8],
        });
        number
    }

    /// Add a pose of a topology to the block of the next frame. Its number.
    pub fn pose(&mut self, topology: u32, nodes: &[Node], vertices: &[Point], flags: u32) -> u32 {
        let number = self.poses.len() as u32;
        let root = nodes.first().map_or(Aabb { min: [0.0; 3], max: [0.0; 3] }, Node::bounds);
        self.poses.push(PoseRecord {
            min: root.min,
            topology,
            max: root.max,
            block: self.blocks,
            node_offset: self.nodes.len() as u64,
            vertex_offset: self.vertices.len() as u64,
            sah: quality::sah(nodes),
            flags,
            reserved: [0; 2],
        });
        self.live_nodes += (nodes.len() as u64).saturating_sub(1);
        self.nodes.extend_from_slice(nodes);
        self.vertices.extend_from_slice(vertices);
        number
    }

    /// A topology that was added: its row, its triangles, and the first of its rows of `GEOM`, from which their `geom` counts.
    pub(crate) fn topology_rows(&self, topology: u32) -> (&TopologyRecord, &[IndexedTriangleRecord], u32) {
        let record = &self.topologies[topology as usize];
        let start = record.ref_offset as usize;
        let first = self.geoms.partition_point(|geom| geom.blas < topology);
        (record, &self.triangles[start..start + record.ref_count as usize], first as u32)
    }

    /// The poses that were added so far.
    pub fn poses(&self) -> &[PoseRecord] {
        &self.poses
    }

    /// Close a frame: what stands where in it. Of `frame` the placement is set here. Bytes that the file grows by, apart from the tables.
    ///
    /// # Errors
    /// Where the spool cannot be written.
    pub fn frame(
        &mut self,
        frame: FrameRecord,
        tlas_nodes: &[Node],
        instances: &[InstanceRecord],
    ) -> Result<u64, CacheError> {
        let before = self.spool.end;
        if !self.nodes.is_empty() || !self.vertices.is_empty() {
            self.close_block()?;
        }
        let mut hasher = blake3::Hasher::new();
        hasher.update(&(tlas_nodes.len() as u64).to_le_bytes());
        hasher.update(cast_slice(tlas_nodes)).update(cast_slice(instances));
        let next = self.placements.len() as u32;
        let placement = *self.placements.entry(*hasher.finalize().as_bytes()).or_insert(next);
        if placement == next {
            self.spool(SectionKind::TNOD, placement, tlas_nodes.len(), cast_slice(tlas_nodes), None)?;
            self.spool(SectionKind::INST, placement, instances.len(), cast_slice(instances), None)?;
            self.live_nodes += (tlas_nodes.len() as u64).saturating_sub(1);
            self.instances += instances.len() as u64;
            self.depth = self.depth.max(max_depth(tlas_nodes));
            self.bounds = tlas_nodes.first().map_or(self.bounds, |root| self.bounds.union(root.bounds()));
        }
        let frame = FrameRecord { placement, ..frame };
        if let Some(detail) = misplaced(self.frames.last(), &frame) {
            return Err(CacheError::Unwritable { name: self.name.clone(), detail });
        }
        self.frames.push(frame);
        Ok(self.spool.end - before)
    }

    /// Spool the nodes and vertices of the poses that were added since the last block.
    fn close_block(&mut self) -> Result<(), CacheError> {
        let (nodes, vertices) = (std::mem::take(&mut self.nodes), std::mem::take(&mut self.vertices));
        let first = self.poses.partition_point(|pose| pose.block < self.blocks);
        let block = Block { poses: &self.poses[first..], nodes: &nodes, vertices: &vertices };
        let packed = match &mut self.encoder {
            Some(encoder) => encoder.block(&self.topologies, &self.triangles, block, self.exec),
            None => Ok([None, None]),
        };
        let [packed_nodes, packed_vertices] = packed.map_err(CacheError::io("compress", &self.path))?;
        self.spool(SectionKind::NODE, self.blocks, nodes.len(), cast_slice(&nodes), packed_nodes)?;
        self.spool(SectionKind::VPOS, self.blocks, vertices.len(), cast_slice(&vertices), packed_vertices)?;
        self.blocks += 1;
        Ok(())
    }

    /// Store a section; `packed` are its bytes as differences, where it has them.
    fn spool(
        &mut self,
        kind: SectionKind,
        ordinal: u32,
        count: usize,
        bytes: &[u8],
        packed: Option<Vec<u8>>,
    ) -> Result<(), CacheError> {
        let mut entry = SectionEntry { elem_count: count as u64, ordinal, ..entry_of(kind) };
        let stored = match packed {
            Some(packed) => {
                store_delta(&mut entry, bytes, &packed, self.exec);
                Ok(packed.into())
            }
            None => store(&mut entry, Cow::Borrowed(bytes), self.codec, self.exec),
        };
        let written = stored.and_then(|stored| self.spool.file.write_all(&stored).map(|()| stored.len() as u64));
        entry.stored_len = written.map_err(CacheError::io("write a temporary file beside", &self.path))?;
        self.spool.entries.push((entry, self.spool.end));
        self.spool.end += entry.stored_len;
        Ok(())
    }

    /// Write the file and put it in the place of its path in one step.
    ///
    /// # Errors
    /// Where it cannot be written, has no frame, or holds more than a file may.
    pub fn finish(mut self, meta: &Meta) -> Result<WriteSummary, CacheError> {
        let name = self.name.clone();
        let unwritable = |detail: String| CacheError::Unwritable { name: name.clone(), detail };
        let too_large = |limit| CacheError::Limit { name: name.clone(), limit };
        if self.frames.is_empty() {
            return Err(unwritable("a sequence has one frame at least".into()));
        }
        let meta_bytes = meta.encode().map_err(too_large)?;
        if let Some((number, parts, most)) = self.overfull() {
            return Err(unwritable(format!("topology {number} has {parts} parts, and its tree has room for {most}")));
        }
        let limits = Limits { max_issues: 1, ..Limits::default() };
        let report = check_parts(&self.geoms, self.topologies.len(), &limits);
        Fault::of_report(&report).map_err(|fault| refusal(fault, &name))?;
        // A file has at least one block and one placement, empty where no frame shows anything.
        if self.blocks == 0 {
            self.spool(SectionKind::NODE, 0, 0, &[], None)?;
            self.spool(SectionKind::VPOS, 0, 0, &[], None)?;
        }
        self.spool.file.rewind().map_err(CacheError::io("read a temporary file beside", &self.path))?;
        let count = |what: &str, n: u64| {
            u32::try_from(n).map_err(|_| unwritable(format!("it has {n} {what}, more than 32 bits hold")))
        };
        let split = self.topologies.iter().any(|t| t.flags & tree_flags::DUP_REFS != 0);
        let kind = if split { tree_flags::DUP_REFS } else { tree_flags::REFITTABLE };
        let bounds = if self.bounds.is_empty() { Aabb { min: [0.0; 3], max: [0.0; 3] } } else { self.bounds };
        let header = Header {
            magic: MAGIC,
            major: MAJOR,
            min_minor: SEQUENCE_MIN_MINOR,
            header_len: Header::LEN as u16,
            features_required: required_features::SEQUENCE,
            section_entry_len: SectionEntry::LEN as u32,
            section_table_off: Header::LEN as u64,
            tree_flags: tree_flags::CANONICAL_DFS | tree_flags::SEQUENCE | tree_flags::TWO_LEVEL | kind,
            builder_id: builder_id(&meta.method),
            build_key: meta.build_key(),
            prim_count: self.topologies.iter().map(|t| u64::from(t.prim_count)).sum(),
            ref_count: self.triangles.len() as u64,
            node_count: self.live_nodes,
            blas_count: count("topologies", self.topologies.len() as u64)?,
            instance_count: count("instances", self.instances)?,
            frame_count: count("frames", self.frames.len() as u64)?,
            max_depth: self.depth,
            scene_min: bounds.min,
            scene_max: bounds.max,
            ..Header::zeroed()
        };
        let pieces = self.pieces(&meta_bytes);
        let most = super::MAX_SECTIONS as usize;
        if pieces.len() > most {
            return Err(unwritable(format!("it has {} sections, and a file has at most {most}", pieces.len())));
        }
        let sealed =
            Sealed::new(header, pieces, self.codec, self.exec).map_err(CacheError::io("compress", &self.path))?;
        atomic::replace(&self.path, |file| sealed.write_to(std::io::BufWriter::new(file)))?;
        Ok(sealed.summary())
    }

    /// The first topology that has more parts than the format allows, with their number and what is allowed.
    fn overfull(&self) -> Option<(usize, usize, usize)> {
        let mut parts = vec![0; self.topologies.len()];
        self.geoms.iter().for_each(|geom| parts[geom.blas as usize] += 1);
        let most = |topology: &TopologyRecord| topology.node_count as usize / 2 * MAX_LEAF as usize;
        let mut all = self.topologies.iter().zip(parts).enumerate();
        all.find_map(|(i, (topology, parts))| (parts > most(topology)).then_some((i, parts, most(topology))))
    }

    /// The sections in the registry's order, those of one kind by their numbers.
    fn pieces<'a>(&'a self, meta: &'a [u8]) -> Vec<Piece<'a>> {
        let any = |some: &[String]| some.iter().any(|name| !name.is_empty());
        let names = if any(&self.names) { encode_names(&self.names) } else { None };
        let materials = if any(&self.materials) { encode_names(&self.materials) } else { None };
        let mut pieces = Vec::new();
        for rule in &KINDS {
            let (count, data): (usize, Cow<'a, [u8]>) = match rule.kind {
                SectionKind::TOPO => (self.topologies.len(), cast_slice(&self.topologies).into()),
                SectionKind::TRIX => (self.triangles.len(), cast_slice(&self.triangles).into()),
                SectionKind::POSE => (self.poses.len(), cast_slice(&self.poses).into()),
                SectionKind::FRAM => (self.frames.len(), cast_slice(&self.frames).into()),
                SectionKind::GEOM => (self.geoms.len(), cast_slice(&self.geoms).into()),
                SectionKind::VERT if !self.sources.is_empty() && self.sources.len() == self.triangles.len() => {
                    (self.sources.len(), cast_slice(&self.sources).into())
                }
                SectionKind::SIDE if self.sides.iter().any(|side| *side != 0) => {
                    (self.sides.len(), cast_slice(&self.sides).into())
                }
                SectionKind::NAMS => match &names {
                    Some(bytes) => (self.names.len(), bytes.clone().into()),
                    None => continue,
                },
                SectionKind::MATS => match &materials {
                    Some(bytes) => (self.materials.len(), bytes.clone().into()),
                    None => continue,
                },
                SectionKind::META => (0, meta.into()),
                // Blocks and placements, in the order of their numbers as they were spooled.
                kind => {
                    pieces.extend(self.spool.entries.iter().filter(|(entry, _)| entry.kind == kind).map(
                        |(entry, offset)| Piece {
                            entry: *entry,
                            data: Data::Spooled { file: &self.spool.file, offset: *offset, len: entry.stored_len },
                            form: Form::Stored,
                        },
                    ));
                    continue;
                }
            };
            let entry = SectionEntry { elem_count: count as u64, ..entry_of(rule.kind) };
            pieces.push(Piece { entry, data: Data::Memory(data), form: Form::Decoded });
        }
        pieces
    }
}

/// What the format fixes for a kind.
fn entry_of(kind: SectionKind) -> SectionEntry {
    let rule = kind.rule();
    SectionEntry {
        kind,
        flags: rule.map_or(0, |rule| rule.flags),
        schema: rule.map_or(0, |rule| rule.schema),
        elem_size: rule.map_or(0, |rule| rule.elem_size),
        ..SectionEntry::zeroed()
    }
}
