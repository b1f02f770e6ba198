use std::io;

use super::links::{self, Link};
use super::planes::Planes;
use super::ranks::base_of;
use super::residuals::{self, Base};
use super::weights::Kept;
use crate::cache::pack;
use crate::exec::Executor;
use crate::geom::Point;
use crate::layout::{IndexedTriangleRecord, Node, PoseRecord, TopologyRecord};

/// Packs the blocks of a sequence in their order.
#[derive(Debug, Default)]
pub struct Encoder {
    topologies: Vec<Track>,
    kept: Kept,
    level: i32,
}

/// What is kept of a topology: the poses that others will be stored relative to, as many as the number of poses has bits.
#[derive(Debug, Default)]
struct Track {
    /// How many poses there were.
    count: u32,
    /// Rank and vertices, ascending; the first is that of rank 0.
    bases: Vec<(u32, Vec<Point>)>,
    /// Shape of the tree in the first pose.
    shape: Vec<Link>,
}

/// What a file has of a block.
#[derive(Clone, Copy)]
pub struct Block<'a> {
    /// The rows of the block.
    pub poses: &'a [PoseRecord],
    /// Its `NODE`.
    pub nodes: &'a [Node],
    /// Its `VPOS`.
    pub vertices: &'a [Point],
}

impl Encoder {
    /// zstd at this level packs what is left.
    pub fn new(level: i32) -> Encoder {
        Encoder { level, ..Encoder::default() }
    }

    /// The stored bytes of the block's `NODE` and `VPOS`; `None` where a section does not decode to what it is, or is not smaller by enough: trees
    /// with spatial splits have boxes that do not follow from the vertices.
    ///
    /// # Errors
    /// Where zstd cannot be had.
    pub fn block(
        &mut self,
        topologies: &[TopologyRecord],
        triangles: &[IndexedTriangleRecord],
        block: Block<'_>,
        exec: &Executor,
    ) -> io::Result<[Option<Vec<u8>>; 2]> {
        let (mut shapes, mut residuals) = (Some(Planes::default()), Planes::default());
        for pose in block.poses {
            let Some(topology) = topologies.get(pose.topology as usize) else { return Ok([None, None]) };
            let piece = |offset: u64, count: u32| offset as usize..(offset as usize).saturating_add(count as usize);
            let nodes = block.nodes.get(piece(pose.node_offset, topology.node_count));
            let vertices = block.vertices.get(piece(pose.vertex_offset, topology.vertex_count));
            let mine = triangles.get(piece(topology.ref_offset, topology.ref_count));
            let (Some(nodes), Some(vertices), Some(mine)) = (nodes, vertices, mine) else { return Ok([None, None]) };
            let links = super::blocks::shape_of(nodes);
            let follows = follows(nodes, &links, mine, vertices);
            let shape = self.shape(pose.topology, nodes, links);
            shapes = shapes.zip(shape).filter(|_| follows).map(|(mut all, shape)| {
                all.push(&shape, 0, links::PLANES);
                all
            });
            residuals.push(&self.pose(pose.topology, vertices), residuals::HEAD, residuals::PLANES);
        }
        let smaller = |packed: Vec<u8>, raw: usize| (packed.len() <= raw - raw / pack::WORTHWHILE).then_some(packed);
        let vertices = residuals.pack(self.level, exec)?;
        let nodes = shapes.map(|shapes| shapes.pack(self.level, exec)).transpose()?;
        Ok([
            nodes.and_then(|packed| smaller(packed, size_of_val(block.nodes))),
            smaller(vertices, size_of_val(block.vertices)),
        ])
    }

    /// The bytes of a pose's shape, none if its topology has one; `None` where it is another than that.
    fn shape(&mut self, topology: u32, nodes: &[Node], shape: Vec<Link>) -> Option<Vec<u8>> {
        let track = self.track(topology);
        if track.count == 0 {
            let packed = links::encode(nodes);
            track.shape = if packed.is_some() { shape } else { Vec::new() };
            return packed;
        }
        (track.shape == shape).then(Vec::new)
    }

    /// The bytes of a pose's vertices.
    fn pose(&mut self, topology: u32, vertices: &[Point]) -> Vec<u8> {
        self.track(topology);
        let Encoder { topologies, kept, .. } = self;
        let track = &mut topologies[topology as usize];
        let rank = track.count;
        track.count += 1;
        if rank == 0 {
            track.bases.push((0, vertices.to_vec()));
            return residuals::encode(vertices, None);
        }
        let first = track.bases.first().map_or(&[][..], |(_, vertices)| vertices);
        let weights = kept.weights(topology, first);
        let base = base_of(rank);
        // Those above the base follow no more.
        track.bases.retain(|(of, _)| *of <= base);
        let packed = track.bases.last().map_or_else(
            || residuals::encode(vertices, None),
            |(_, base)| residuals::encode(vertices, Some(Base { vertices: base, weights: &weights })),
        );
        track.bases.push((rank, vertices.to_vec()));
        packed
    }

    fn track(&mut self, topology: u32) -> &mut Track {
        let topology = topology as usize;
        if self.topologies.len() <= topology {
            self.topologies.resize_with(topology + 1, Track::default);
        }
        &mut self.topologies[topology]
    }
}

/// Whether the nodes are those that are fitted to the vertices.
fn follows(nodes: &[Node], shape: &[Link], triangles: &[IndexedTriangleRecord], vertices: &[Point]) -> bool {
    let mut fitted = nodes.to_vec();
    links::fit(shape, triangles, vertices, &mut fitted).is_ok()
        && bytemuck::cast_slice::<_, u8>(&fitted) == bytemuck::cast_slice::<_, u8>(nodes)
}
