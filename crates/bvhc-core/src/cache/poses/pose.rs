use std::ops::{ControlFlow, Range};

use crate::cache::container::Sink;
use crate::cache::report::Place;
use crate::cache::rules;
use crate::layout::{
    BlasRecord, GeomRecord, IndexedTriangleRecord, Node, PoseRecord, SectionKind, TopologyRecord, TriangleRecord,
};

/// One pose and all that it consists of.
#[derive(Clone, Copy)]
pub struct Posed<'a> {
    pub pose: &'a PoseRecord,
    pub topology: &'a TopologyRecord,
    pub nodes: &'a [Node],
    pub vertices: &'a [[f32; 3]],
    /// The topology's part of `TRIX`.
    pub corners: &'a [IndexedTriangleRecord],
    /// All rows of `GEOM`.
    pub geoms: &'a [GeomRecord],
}

/// The rows of a sequence that say which records a pose consists of.
#[derive(Clone, Copy)]
pub struct PoseRows<'a> {
    pub topologies: &'a [TopologyRecord],
    /// All of `TRIX`.
    pub corners: &'a [IndexedTriangleRecord],
    /// All rows of `GEOM`.
    pub geoms: &'a [GeomRecord],
}

impl<'a> PoseRows<'a> {
    /// A pose out of the nodes and vertices of its block; `None` where it reaches beyond them.
    pub fn posed(self, pose: &'a PoseRecord, nodes: &'a [Node], vertices: &'a [[f32; 3]]) -> Option<Posed<'a>> {
        let PoseRows { topologies, corners, geoms } = self;
        let topology = topologies.get(pose.topology as usize)?;
        Some(Posed {
            pose,
            topology,
            nodes: nodes.get(piece(pose.node_offset, topology.node_count)?)?,
            vertices: vertices.get(piece(pose.vertex_offset, topology.vertex_count)?)?,
            corners: corners.get(piece(topology.ref_offset, topology.ref_count)?)?,
            geoms,
        })
    }
}

/// `count` records from `offset` on.
fn piece(offset: u64, count: u32) -> Option<Range<usize>> {
    let start = usize::try_from(offset).ok()?;
    Some(start..start.checked_add(count as usize)?)
}

impl Posed<'_> {
    /// The triangles as a still file has them. `parts` are the topology's rows of `GEOM`; rows are numbered from `first` on, as they stand
    /// where the triangles go.
    ///
    /// Up to the first breach, the corners that are not there, or a part that is another topology's.
    pub fn triangles(
        &self,
        parts: &Range<u32>,
        first: u32,
        to: &mut Vec<TriangleRecord>,
        out: &mut impl Sink,
    ) -> ControlFlow<()> {
        to.reserve(self.corners.len());
        for (slot, triangle) in self.corners.iter().enumerate() {
            let IndexedTriangleRecord { corners: [a, b, c], prim, geom, flags } = *triangle;
            let vertex = |v: u32| self.vertices.get(v as usize).copied();
            let place = || Place::record(SectionKind::TRIX, self.topology.ref_offset + slot as u64);
            let (Some(v0), Some(v1), Some(v2)) = (vertex(a), vertex(b), vertex(c)) else {
                let found = format!("{}", a.max(b).max(c));
                return out.breach(&rules::E0704, place(), || (self.vertices.len().to_string(), found));
            };
            if !parts.contains(&geom) {
                let expected = format!("in {} .. {}", parts.start, parts.end);
                return out.breach(&rules::E0416, place(), || (expected, geom.to_string()));
            }
            to.push(TriangleRecord { v0, prim, v1, geom: geom - parts.start + first, v2, flags });
        }
        ControlFlow::Continue(())
    }

    /// The rows of `GEOM` for the tree with this number.
    pub fn parts(&self, parts: &Range<u32>, blas: u32) -> impl Iterator<Item = GeomRecord> {
        let rows = self.geoms.get(parts.start as usize..parts.end as usize).unwrap_or_default();
        rows.iter().map(move |row| GeomRecord { blas, ..*row })
    }

    /// The row of `BLAS` for its tree, which begins there.
    pub fn blas(&self, node_offset: u64, ref_offset: u64) -> BlasRecord {
        let (pose, topology) = (self.pose, self.topology);
        BlasRecord {
            min: pose.min,
            node_count: topology.node_count,
            max: pose.max,
            ref_count: topology.ref_count,
            node_offset,
            ref_offset,
            prim_count: topology.prim_count,
            max_depth: topology.max_depth,
            sah: pose.sah,
            flags: topology.flags,
        }
    }
}
