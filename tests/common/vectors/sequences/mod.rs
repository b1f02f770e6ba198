//! Files of many frames, put together record by record.

mod made;

pub use made::*;

use bvhc::cache::parts::{Block, Encoder, encode_names, frames_of, pack, pack_triangles, unpack_frames};
use bvhc::cache::{
    DELTA_MIN_MINOR, FrameRecord, GeomRecord, Header, IndexedTriangleRecord, InstanceRecord, KINDS, MAGIC, MAJOR,
    PoseRecord, SEQUENCE_MIN_MINOR, SectionEntry, SectionKind, TopologyRecord, required_features, tree_flags,
};
use bvhc::exec::Executor;
use bvhc::geom::{Aabb, Affine, Point};
use bvhc::scene::{Instance, Mesh, Part};
use bvhc::tree::{Node, Tree, max_depth, quality, refit};
use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};

use super::bytes::put_together;
use super::scenes::{self, one_level, pile, tree, with_top};

/// The content of a file of many frames.
#[derive(Clone, Default)]
pub struct Sequence {
    pub topologies: Vec<TopologyRecord>,
    pub triangles: Vec<IndexedTriangleRecord>,
    pub geoms: Vec<GeomRecord>,
    pub poses: Vec<PoseRecord>,
    pub frames: Vec<FrameRecord>,
    /// `NODE` and `VPOS`.
    pub blocks: Vec<(Vec<Node>, Vec<Point>)>,
    /// `TNOD` and `INST`.
    pub placements: Vec<(Vec<Node>, Vec<InstanceRecord>)>,
    pub names: Vec<String>,
    pub materials: Vec<String>,
    pub sides: Vec<u32>,
    pub vertices: Vec<[u32; 3]>,
    /// For each topology its mesh and tree, and which vertex of the mesh each of its own is.
    built: Vec<(Mesh, Tree, Vec<u32>)>,
    /// For each pose its mesh as it stands, and its tree.
    posed: Vec<(Mesh, Tree)>,
}

impl Sequence {
    /// A tree over a mesh. Vertices are numbered as the leaves first use them.
    pub fn add_topology(&mut self, mesh: &Mesh, tree: &Tree) -> u32 {
        let number = self.topologies.len() as u32;
        let image = one_level(mesh.clone(), tree.clone());
        let first = self.geoms.len() as u32;
        let mut sources: Vec<u32> = Vec::new();
        let ref_offset = self.triangles.len() as u64;
        for (record, r) in image.triangles.iter().zip(&tree.refs) {
            let corners = mesh.triangles[*r as usize].map(|v| {
                let known = sources.iter().position(|s| *s == v);
                known.unwrap_or_else(|| {
                    sources.push(v);
                    sources.len() - 1
                }) as u32
            });
            let (prim, flags) = (record.prim, record.flags);
            self.triangles.push(IndexedTriangleRecord { corners, prim, geom: record.geom + first, flags });
        }
        self.topologies.push(TopologyRecord {
            ref_offset,
            ref_count: tree.refs.len() as u32,
            node_count: tree.nodes.len() as u32,
            vertex_count: sources.len() as u32,
            prim_count: image.blases[0].prim_count,
            max_depth: max_depth(&tree.nodes),
            flags: image.blases[0].flags,
            reserved: [0; 8],
        });
        self.geoms.extend(image.geoms.iter().map(|geom| GeomRecord { blas: number, ..*geom }));
        self.names.extend(image.names);
        self.built.push((mesh.clone(), tree.clone(), sources));
        number
    }

    /// A topology where its mesh's vertices stand: with the boxes that it was built with where `key`, otherwise refitted.
    pub fn add_pose(&mut self, topology: u32, positions: &[Point], key: bool) -> u32 {
        let (mesh, tree, sources) = &self.built[topology as usize];
        let (mut mesh, mut tree) = (mesh.clone(), tree.clone());
        mesh.positions = positions.to_vec();
        if !key {
            refit(&mut tree.nodes, |slot| mesh.corners(tree.refs[slot] as usize)).unwrap();
        }
        if self.blocks.is_empty() {
            self.blocks.push(Default::default());
        }
        let block = self.blocks.len() as u32 - 1;
        let (nodes, vertices) = &mut self.blocks[block as usize];
        self.poses.push(PoseRecord {
            min: tree.nodes[0].min,
            topology,
            max: tree.nodes[0].max,
            block,
            node_offset: nodes.len() as u64,
            vertex_offset: vertices.len() as u64,
            sah: quality::sah(&tree.nodes),
            flags: if key { PoseRecord::KEY } else { 0 },
            reserved: [0; 2],
        });
        nodes.extend(&tree.nodes);
        vertices.extend(sources.iter().map(|v| positions[*v as usize]));
        self.posed.push((mesh, tree));
        self.poses.len() as u32 - 1
    }

    /// The next poses stand in a block of their own.
    pub fn next_block(&mut self) {
        self.blocks.push(Default::default());
    }

    /// What stands where. Its number.
    pub fn add_placement(&mut self, shown: &[(u32, Affine)]) -> u32 {
        let (meshes, trees): (Vec<Mesh>, Vec<Tree>) =
            shown.iter().map(|(pose, _)| self.posed[*pose as usize].clone()).unzip();
        let place = |(i, (_, transform)): (usize, &(u32, Affine))| Instance {
            mesh: i as u32,
            transform: *transform,
            node: i as u32,
            name: String::new(),
        };
        let instances = shown.iter().enumerate().map(place).collect();
        let image = bvhc::cache::Image::new(&with_top(meshes, trees, instances), &Executor::current()).unwrap();
        let named = |i: &InstanceRecord| InstanceRecord { blas: shown[i.blas as usize].0, ..*i };
        self.placements.push((image.tlas_nodes, image.instances.iter().map(named).collect()));
        self.placements.len() as u32 - 1
    }

    pub fn add_frame(&mut self, number: i32, time: Option<f32>, placement: u32) {
        let flags = if time.is_some() { FrameRecord::TIMED } else { 0 };
        self.frames.push(FrameRecord { number, placement, time: time.unwrap_or(0.0), flags, reserved: [0; 4] });
    }

    /// State the SAH of each pose anew after its nodes were edited.
    pub fn restate_sah(&mut self) {
        for pose in &mut self.poses {
            let start = pose.node_offset as usize;
            let count = self.topologies[pose.topology as usize].node_count as usize;
            pose.sah = quality::sah(&self.blocks[pose.block as usize].0[start..start + count]);
        }
    }

    /// The file, with every vector's META, and all hashes right.
    pub fn file(&self) -> Vec<u8> {
        put_together(self.header(), self.sections())
    }

    /// The file with every section packed that gains by it.
    pub fn packed(&self) -> Vec<u8> {
        let mut sections = self.sections();
        for (entry, data) in &mut sections {
            if let Ok(Some(packed)) = pack(data, 3, &Executor::current()) {
                (entry.codec, entry.raw_hash) = (SectionEntry::ZSTD, *blake3::hash(data).as_bytes());
                *data = packed;
            }
        }
        put_together(self.header(), sections)
    }

    /// The file with blocks and triangles as differences, where those are smaller.
    pub fn differences(&self) -> Vec<u8> {
        self.differences_edited(|_, _| {})
    }

    /// The same with the planes of each section edited before they go into frames. The raw hashes are those of the unedited file.
    pub fn differences_edited(&self, edit: impl Fn(SectionKind, &mut Vec<u8>)) -> Vec<u8> {
        let (exec, level) = (Executor::current(), 3);
        let mut encoder = Encoder::new(level);
        let block = |(i, (nodes, vertices)): (u32, &(Vec<Node>, Vec<Point>))| {
            let until = |block: u32| self.poses.partition_point(|pose| pose.block < block);
            let block = Block { poses: &self.poses[until(i)..until(i + 1)], nodes, vertices };
            encoder.block(&self.topologies, &self.triangles, block, &exec).unwrap()
        };
        let blocks: Vec<[Option<Vec<u8>>; 2]> = (0..).zip(&self.blocks).map(block).collect();
        let mut sections = self.sections();
        for (entry, data) in &mut sections {
            let packed = match entry.kind {
                SectionKind::NODE => blocks[entry.ordinal as usize][0].clone(),
                SectionKind::VPOS => blocks[entry.ordinal as usize][1].clone(),
                SectionKind::TRIX => Some(pack_triangles(data, level, &exec).unwrap()),
                _ => None,
            };
            if let Some(packed) = packed {
                let mut planes =
                    unpack_frames(&packed, self.planes(entry, data.len()), &exec).unwrap().as_slice().to_vec();
                edit(entry.kind, &mut planes);
                let packed = frames_of(&planes, level, &exec).unwrap();
                (entry.codec, entry.raw_hash) = (SectionEntry::DELTA, *blake3::hash(data).as_bytes());
                *data = packed;
            }
        }
        let header = Header { minor: DELTA_MIN_MINOR, min_minor: DELTA_MIN_MINOR, ..self.header() };
        put_together(header, sections)
    }

    /// Bytes of a section's planes.
    fn planes(&self, entry: &SectionEntry, raw_len: usize) -> usize {
        let mut seen = std::collections::BTreeSet::new();
        let of = |pose: &PoseRecord| {
            let topology = &self.topologies[pose.topology as usize];
            let is_first = seen.insert(pose.topology);
            match entry.kind {
                _ if pose.block != entry.ordinal => 0,
                SectionKind::VPOS => 8 + 12 * topology.vertex_count as usize,
                _ if is_first => 5 * topology.node_count as usize,
                _ => 0,
            }
        };
        if entry.kind == SectionKind::TRIX { raw_len } else { self.poses.iter().map(of).sum() }
    }

    fn header(&self) -> Header {
        let live = |records: usize| records.saturating_sub(1) as u64;
        let roots = self.placements.iter().filter_map(|(nodes, _)| nodes.first());
        let bounds = roots.map(Node::bounds).reduce(Aabb::union).unwrap_or(Aabb { min: [0.0; 3], max: [0.0; 3] });
        let nodes_of = |pose: &PoseRecord| self.topologies.get(pose.topology as usize).map_or(0, |t| t.node_count);
        let split = self.topologies.iter().any(|t| t.flags & tree_flags::DUP_REFS != 0);
        let kind = if split { tree_flags::DUP_REFS } else { tree_flags::REFITTABLE };
        let tops = || self.placements.iter().map(|(nodes, _)| nodes);
        let depths = self.topologies.iter().map(|t| t.max_depth).chain(tops().map(|nodes| max_depth(nodes)));
        Header {
            magic: MAGIC,
            major: MAJOR,
            minor: SEQUENCE_MIN_MINOR,
            min_minor: SEQUENCE_MIN_MINOR,
            header_len: Header::LEN as u16,
            features_required: required_features::SEQUENCE,
            section_entry_len: SectionEntry::LEN as u32,
            section_table_off: Header::LEN as u64,
            tree_flags: tree_flags::CANONICAL_DFS | tree_flags::SEQUENCE | tree_flags::TWO_LEVEL | kind,
            builder_id: 1,
            build_key: scenes::meta().build_key(),
            prim_count: self.topologies.iter().map(|t| u64::from(t.prim_count)).sum(),
            ref_count: self.triangles.len() as u64,
            node_count: self.poses.iter().map(|p| live(nodes_of(p) as usize)).sum::<u64>()
                + tops().map(|nodes| live(nodes.len())).sum::<u64>(),
            blas_count: self.topologies.len() as u32,
            instance_count: self.placements.iter().map(|(_, instances)| instances.len() as u32).sum(),
            frame_count: self.frames.len() as u32,
            max_depth: depths.max().unwrap_or(0),
            scene_min: bounds.min,
            scene_max: bounds.max,
            ..Header::zeroed()
        }
    }

    fn sections(&self) -> Vec<(SectionEntry, Vec<u8>)> {
        fn all<'a, T: Pod>(of: impl Iterator<Item = &'a Vec<T>>) -> Vec<(u64, Vec<u8>)> {
            of.map(|records| (records.len() as u64, cast_slice(records).to_vec())).collect()
        }
        let one = |bytes: &[u8], count: usize| vec![(count as u64, bytes.to_vec())];
        let texts = |names: &[String]| match names.iter().all(String::is_empty) {
            true => Vec::new(),
            false => one(&encode_names(names).unwrap(), names.len()),
        };
        let empty = || std::iter::once((Vec::new(), Vec::new()));
        let empty_block: Vec<(Vec<Node>, Vec<Point>)> = empty().collect();
        let blocks = if self.blocks.is_empty() { &empty_block } else { &self.blocks };
        let mut sections = Vec::new();
        for rule in &KINDS {
            let data = match rule.kind {
                SectionKind::NODE => all(blocks.iter().map(|(nodes, _)| nodes)),
                SectionKind::VPOS => all(blocks.iter().map(|(_, vertices)| vertices)),
                SectionKind::TNOD => all(self.placements.iter().map(|(nodes, _)| nodes)),
                SectionKind::INST => all(self.placements.iter().map(|(_, instances)| instances)),
                SectionKind::GEOM => one(cast_slice(&self.geoms), self.geoms.len()),
                SectionKind::TOPO => one(cast_slice(&self.topologies), self.topologies.len()),
                SectionKind::TRIX => one(cast_slice(&self.triangles), self.triangles.len()),
                SectionKind::POSE => one(cast_slice(&self.poses), self.poses.len()),
                SectionKind::FRAM => one(cast_slice(&self.frames), self.frames.len()),
                SectionKind::VERT if !self.vertices.is_empty() => one(cast_slice(&self.vertices), self.vertices.len()),
                SectionKind::SIDE if !self.sides.is_empty() => one(cast_slice(&self.sides), self.sides.len()),
                SectionKind::NAMS => texts(&self.names),
                SectionKind::MATS => texts(&self.materials),
                SectionKind::META => one(&scenes::meta().encode().unwrap(), 0),
                _ => Vec::new(),
            };
            for (ordinal, (elem_count, data)) in (0..).zip(data) {
                let entry = SectionEntry {
                    kind: rule.kind,
                    ordinal,
                    flags: rule.flags,
                    schema: rule.schema,
                    align_log2: SectionEntry::MIN_ALIGN_LOG2,
                    raw_len: data.len() as u64,
                    elem_count,
                    elem_size: rule.elem_size,
                    ..SectionEntry::zeroed()
                };
                sections.push((entry, data));
            }
        }
        sections
    }
}

/// A section of a file by kind and number.
pub fn with_section_of<T: Pod>(
    file: &[u8],
    kind: SectionKind,
    ordinal: u32,
    edit: impl FnOnce(&mut Vec<T>),
) -> Vec<u8> {
    let (header, mut sections) = super::bytes::take_apart(file);
    let (_, data) = sections.iter_mut().find(|(e, _)| (e.kind, e.ordinal) == (kind, ordinal)).unwrap();
    let mut records: Vec<T> = data.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect();
    edit(&mut records);
    *data = records.iter().flat_map(|record| bytes_of(record).to_vec()).collect();
    put_together(header, sections)
}
