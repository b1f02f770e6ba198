//! Sequences: their rows, then every pose as the tree of a still file, then every placement as its top level.

use std::collections::BTreeMap;

use super::boxes::{bits, show};
use super::content::{RecordsOf, check_records, check_top};
use super::{Bits, Limits, instances, provenance, records, sides, vertices};
use crate::cache::container::{Container, First};
use crate::cache::poses::{PoseRows, Posed, Rows, parts_of};
use crate::cache::report::{Place, Report};
use crate::cache::rules;
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::layout::{
    BlasRecord, FrameRecord, GeomRecord, IndexedTriangleRecord, InstanceRecord, Node, PoseRecord, SectionKind,
    TopologyRecord, View, tree_flags,
};

/// Poses that are looked at before what was found is put together. A constant: findings stand in the same order for any number of threads.
const BATCH: usize = 32;

/// The sections of a sequence as records.
struct Content<'a> {
    topologies: &'a [TopologyRecord],
    corners: &'a [IndexedTriangleRecord],
    poses: &'a [PoseRecord],
    frames: &'a [FrameRecord],
    geoms: &'a [GeomRecord],
    blocks: Vec<(&'a [Node], &'a [[f32; 3]])>,
    placements: Vec<(&'a [Node], &'a [InstanceRecord])>,
}

/// Check everything behind the container and the hashes but META. Whether the records were there to be looked at.
pub fn check<'a>(
    container: &Container,
    bytes: &dyn Fn(usize) -> Option<&'a [u8]>,
    limits: &Limits,
    out: &mut Report,
    exec: &Executor,
) -> bool {
    let Some(content) = content(container, bytes, out) else { return false };
    let lens: Vec<[u64; 2]> = content.blocks.iter().map(|(n, v)| [n.len() as u64, v.len() as u64]).collect();
    let rows = Rows {
        topologies: content.topologies,
        poses: content.poses,
        frames: content.frames,
        geoms: content.geoms,
        triangles: content.corners.len() as u64,
        blocks: &lens,
        placements: content.placements.len(),
    };
    let before = out.errors();
    _ = rows.check(out);
    if out.errors() > before {
        out.skip("All poses and placements: the rows of the sequence do not lead where they say.");
        return true;
    }
    check_flags(container, &content, out);

    let vertices: Option<&[[u32; 3]]> = container.find(SectionKind::VERT, 0).and_then(bytes).map(records);
    if let Some(vertices) = vertices.filter(|vertices| vertices.len() != content.corners.len()) {
        let (expected, actual) = (content.corners.len().to_string(), vertices.len().to_string());
        out.add(&rules::E0321, Place::section(SectionKind::VERT), || (expected, actual));
    }

    content.topologies.iter().enumerate().for_each(|(i, topology)| check_corners(&content, i, topology, out));

    // Poses of small trees share the cores, a large one divides its nodes among them. What was found is put together every few poses: a
    // small file has many, and of each much may be wrong.
    let parts = parts_of(content.geoms, content.topologies.len());
    let mut first_of = BTreeMap::new();
    for (number, pose) in content.poses.iter().enumerate() {
        first_of.entry(pose.topology).or_insert(number);
    }
    let look = |number: usize| {
        let mut part = Report::new(limits.max_issues);
        let Some(posed) = content.posed(number) else { return part };
        if let Some(first) = first_of.get(&posed.pose.topology).filter(|first| **first != number) {
            check_shape(&content, &posed, number, *first, &mut part);
        }
        let start = posed.topology.ref_offset as usize;
        let vertices = vertices.and_then(|all| all.get(start..start + posed.corners.len()));
        check_pose((&posed, vertices), number, &parts[posed.pose.topology as usize], limits, &mut part, exec);
        part
    };
    for start in (0..content.poses.len()).step_by(BATCH) {
        let reports = exec.map_range(BATCH.min(content.poses.len() - start), |k| look(start + k));
        reports.into_iter().for_each(|report| out.append(report));
    }

    let blases: Vec<BlasRecord> =
        (0..content.poses.len()).filter_map(|number| content.posed(number)).map(|posed| posed.blas(0, 0)).collect();
    let mut depth = Some(content.topologies.iter().map(|t| t.max_depth).max().unwrap_or(0));
    for (number, (tlas_nodes, instances)) in content.placements.iter().enumerate() {
        let view = View { nodes: &[], triangles: &[], geoms: &[], blases: &blases, tlas_nodes, instances };
        let mut part = Report::new(limits.max_issues);
        let top = check_top(&view, &[], limits, &mut part, exec);
        depth = depth.zip(top).map(|(a, b)| a.max(b));
        part.findings.iter_mut().for_each(|finding| finding.place.ordinal = number as u16);
        out.append(part);
    }
    let all = content.placements.iter().flat_map(|(_, instances)| instances.iter());
    instances::check_used(all, content.poses.len(), SectionKind::POSE, out);
    check_header(container, &content, depth, out);
    check_origins(container, &content, bytes, out);
    true
}

fn content<'a>(
    container: &Container,
    bytes: &dyn Fn(usize) -> Option<&'a [u8]>,
    out: &mut Report,
) -> Option<Content<'a>> {
    let mut missing = Vec::new();
    let mut single = |kind: SectionKind| {
        let found = container.find(kind, 0).and_then(bytes);
        found.unwrap_or_else(|| {
            missing.push(kind.to_string());
            &[]
        })
    };
    let topologies = records(single(SectionKind::TOPO));
    let corners = records(single(SectionKind::TRIX));
    let poses = records(single(SectionKind::POSE));
    let frames = records(single(SectionKind::FRAM));
    let geoms = records(single(SectionKind::GEOM));
    let mut several = |i: usize| {
        let entry = &container.entries[i];
        bytes(i).unwrap_or_else(|| {
            missing.push(format!("{} {}", entry.kind, entry.ordinal));
            &[]
        })
    };
    let blocks = container.pairs(SectionKind::NODE, SectionKind::VPOS);
    let blocks = blocks.into_iter().map(|[n, v]| (records(several(n)), records(several(v)))).collect();
    let placements = container.pairs(SectionKind::TNOD, SectionKind::INST);
    let placements = placements.into_iter().map(|[t, i]| (records(several(t)), records(several(i)))).collect();
    if !missing.is_empty() {
        missing.truncate(8);
        out.skip(format!("All records: {} cannot be read.", missing.join(", ")));
        return None;
    }
    Some(Content { topologies, corners, poses, frames, geoms, blocks, placements })
}

impl<'a> Content<'a> {
    /// The rows were asked before.
    fn posed(&self, number: usize) -> Option<Posed<'a>> {
        let pose = self.poses.get(number)?;
        let (nodes, vertices) = *self.blocks.get(pose.block as usize)?;
        PoseRows { topologies: self.topologies, corners: self.corners, geoms: self.geoms }.posed(pose, nodes, vertices)
    }
}

/// Every vertex of a topology is a corner. Corners that are no vertex have a rule of their own.
fn check_corners(content: &Content<'_>, number: usize, topology: &TopologyRecord, out: &mut Report) {
    let place = Place::record(SectionKind::TOPO, number as u64);
    let Some(mut used) = Bits::new(topology.vertex_count.into()) else {
        return out.starve(place, &format!("Whether every vertex of topology {number} is a corner"));
    };
    let start = topology.ref_offset as usize; // the rows were asked before
    let mine = content.corners.get(start..start + topology.ref_count as usize).unwrap_or_default();
    mine.iter().flat_map(|triangle| triangle.corners).for_each(|vertex| _ = used.set(vertex.into()));
    for vertex in (0..u64::from(topology.vertex_count)).filter(|vertex| !used.get(*vertex)) {
        out.add(&rules::E0709, place, || ("one".into(), vertex.to_string()));
    }
}

/// Nodes refer to what those of the topology's first pose refer to.
fn check_shape(content: &Content<'_>, posed: &Posed<'_>, number: usize, first: usize, out: &mut Report) {
    let Some(first) = content.posed(first) else { return };
    for (i, (node, like)) in posed.nodes.iter().zip(first.nodes).enumerate() {
        if (node.first, node.count) != (like.first, like.count) {
            let place = Place {
                ordinal: posed.pose.block as u16,
                tree: Some((number as u32, i as u64)),
                ..Place::record(SectionKind::NODE, posed.pose.node_offset + i as u64)
            };
            out.add(&rules::E0705, place, || {
                (format!("{} and {}", like.first, like.count), format!("{} and {}", node.first, node.count))
            });
        }
    }
}

/// A pose by the rules of a still file of one tree; findings then name the record of the sequence.
fn check_pose(
    (posed, vertices): (&Posed<'_>, Option<&[[u32; 3]]>),
    number: usize,
    parts: &std::ops::Range<u32>,
    limits: &Limits,
    out: &mut Report,
    exec: &Executor,
) {
    let mut triangles = Vec::new();
    let mut first = First::default();
    _ = posed.triangles(parts, 0, &mut triangles, &mut first);
    if first.result().is_err() {
        // Said once more, with the place: the sink of the check collects.
        _ = posed.triangles(parts, 0, &mut Vec::new(), out);
        out.skip(format!("Pose {number}: its triangles cannot be put together."));
        return;
    }
    let geoms: Vec<GeomRecord> = posed.parts(parts, 0).collect();
    let blases = [posed.blas(0, 0)];
    let view = View {
        nodes: posed.nodes,
        triangles: &triangles,
        geoms: &geoms,
        blases: &blases,
        tlas_nodes: &[],
        instances: &[],
    };
    let kind = posed.topology.flags & (tree_flags::DUP_REFS | tree_flags::REFITTABLE);
    let mut part = check_records(&view, tree_flags::CANONICAL_DFS | kind, RecordsOf::Frame, limits, exec);
    if let Some(vertices) = vertices {
        part.append(vertices::check(&view, vertices, limits, exec));
    }
    for finding in &mut part.findings {
        let place = &mut finding.place;
        let (section, start, ordinal) = match place.section {
            Some(SectionKind::NODE) => (SectionKind::NODE, posed.pose.node_offset, posed.pose.block as u16),
            Some(SectionKind::TRIS) => (SectionKind::TRIX, posed.topology.ref_offset, 0),
            Some(SectionKind::VERT) => (SectionKind::VERT, posed.topology.ref_offset, 0),
            Some(SectionKind::GEOM) => (SectionKind::GEOM, parts.start.into(), 0),
            Some(SectionKind::BLAS) => (SectionKind::POSE, number as u64, 0),
            _ => continue,
        };
        (place.section, place.ordinal) = (Some(section), ordinal);
        place.index = place.index.map(|index| index + start);
        place.tree = place.tree.map(|(_, record)| (number as u32, record));
    }
    out.append(part);
}

/// The header's flags are those of the topologies.
fn check_flags(container: &Container, content: &Content<'_>, out: &mut Report) {
    let flags = container.header.tree_flags;
    let any_split = content.topologies.iter().any(|t| t.flags & tree_flags::DUP_REFS != 0);
    let kind = if any_split { tree_flags::DUP_REFS } else { tree_flags::REFITTABLE };
    let either = tree_flags::DUP_REFS | tree_flags::REFITTABLE;
    if flags & either != kind {
        out.add(&rules::E0309, Place::file(), || (format!("{:#x}", flags & !either | kind), format!("{flags:#x}")));
    }
}

/// Hold the header against the records; the counts that the table bears out were compared with it before.
fn check_header(container: &Container, content: &Content<'_>, depth: Option<u32>, out: &mut Report) {
    let header = &container.header;
    let mut compare = |rule, offset, expected: u64, actual: u64| {
        if expected != actual {
            out.add(rule, Place::byte(offset), || (expected.to_string(), actual.to_string()));
        }
    };
    let live = |records: u64| records.saturating_sub(1);
    let of_pose = |pose: &PoseRecord| content.topologies.get(pose.topology as usize).map_or(0, |t| t.node_count);
    let nodes: u64 = content.poses.iter().map(|pose| live(of_pose(pose).into())).sum();
    let tops: u64 = content.placements.iter().map(|(nodes, _)| live(nodes.len() as u64)).sum();
    compare(&rules::E0301, 176, nodes + tops, header.node_count);
    compare(&rules::E0303, 160, content.topologies.iter().map(|t| u64::from(t.prim_count)).sum(), header.prim_count);
    if let Some(depth) = depth {
        compare(&rules::E0306, 196, depth.into(), header.max_depth.into());
    }
    let roots = content.placements.iter().filter_map(|(nodes, _)| nodes.first());
    let all = roots.map(Node::bounds).reduce(Aabb::union).unwrap_or(Aabb { min: [0.0; 3], max: [0.0; 3] });
    // Which zero a union takes is nobody's choice.
    let unsigned = |b: &Aabb| Aabb { min: b.min.map(|c| c + 0.0), max: b.max.map(|c| c + 0.0) };
    if bits(&unsigned(&all)) != bits(&unsigned(&header.scene_bounds())) {
        out.add(&rules::E0307, Place::byte(200), || (show(&all), show(&header.scene_bounds())));
    }
}

/// What leads from a hit back to the model.
fn check_origins<'a>(
    container: &Container,
    content: &Content<'_>,
    bytes: &dyn Fn(usize) -> Option<&'a [u8]>,
    out: &mut Report,
) {
    let find = |kind| container.find(kind, 0).and_then(|i| Some((bytes(i)?, &container.entries[i])));
    provenance::check_names_of(container, find(SectionKind::NAMS), content.geoms, out);
    if let Some((bytes, entry)) = find(SectionKind::MATS) {
        provenance::check_materials(bytes, entry.elem_count, content.geoms.len(), out);
    }
    if let Some((bytes, _)) = find(SectionKind::SIDE) {
        sides::check(content.geoms, records(bytes), out);
    }
}
