use std::ops::Range;

use super::links::{self, Link};
use super::ranks::Ranks;
use super::residuals::{self, Base};
use crate::geom::Point;
use crate::layout::{IndexedTriangleRecord, Node, PoseRecord, TopologyRecord};

/// The rows of a file, by which the sections of its blocks are decoded: they lead where they say, which was asked before.
#[derive(Clone, Copy)]
pub struct Blocks<'a> {
    pub topologies: &'a [TopologyRecord],
    pub poses: &'a [PoseRecord],
    pub triangles: &'a [IndexedTriangleRecord],
    pub ranks: &'a Ranks,
}

impl<'a> Blocks<'a> {
    /// The rows of `POSE` of a block. They stand in the order of the blocks.
    pub fn rows(&self, block: u32) -> Range<usize> {
        let until = |block: u64| self.poses.partition_point(|pose| u64::from(pose.block) < block);
        until(block.into())..until(u64::from(block) + 1)
    }

    pub fn topology(&self, row: usize) -> Result<&'a TopologyRecord, String> {
        let pose = self.poses.get(row).ok_or("there is no such pose")?;
        self.topologies.get(pose.topology as usize).ok_or_else(|| format!("pose {row} has no topology"))
    }

    /// Bytes that the block's `VPOS` unpacks to, before it is decoded.
    pub fn packed_vertices(&self, block: u32) -> u64 {
        let of = |row| self.topology(row).map_or(0, |topology| residuals::packed_len(topology.vertex_count.into()));
        self.rows(block).map(of).fold(0, u64::saturating_add)
    }

    /// The same for its `NODE`: shapes of the topologies whose first pose is in the block.
    pub fn packed_nodes(&self, block: u32) -> u64 {
        self.shapes(block).map(|(_, len)| len).fold(0, u64::saturating_add)
    }

    /// The topologies whose first pose is in a block, and the bytes of their shapes.
    fn shapes(&self, block: u32) -> impl Iterator<Item = (u32, u64)> {
        let is_first = |row: &usize| self.ranks.first(self.poses[*row].topology) == Some(*row as u32);
        let len = |row: usize| self.topology(row).map_or(0, |topology| links::packed_len(topology.node_count.into()));
        self.rows(block).filter(is_first).map(move |row| (self.poses[row].topology, len(row)))
    }

    /// The vertices of one pose, from what the `VPOS` of its block unpacks to.
    ///
    /// # Errors
    /// What is wrong with the bytes.
    pub fn pose(&self, row: usize, packed: &[u8], base: Option<Base<'_>>, out: &mut [Point]) -> Result<(), String> {
        let (pose, topology) = (self.poses.get(row).ok_or("there is no such pose")?, self.topology(row)?);
        // Each pose before it in the block has a head and its vertices.
        let before = (row - self.rows(pose.block).start.min(row)) as u64;
        let start = pose.vertex_offset.saturating_mul(12).saturating_add(before * residuals::HEAD as u64);
        let end = start.saturating_add(residuals::packed_len(topology.vertex_count.into()));
        let bytes = usize::try_from(start).ok().zip(usize::try_from(end).ok()).and_then(|(s, e)| packed.get(s..e));
        residuals::decode(bytes.ok_or_else(|| format!("pose {row} is beyond {} bytes", packed.len()))?, base, out)
    }

    /// The shape of a topology, from what the `NODE` of its first pose's block unpacks to.
    ///
    /// # Errors
    /// Where it is not there.
    pub fn shape(&self, topology: u32, packed: &[u8]) -> Result<Vec<Link>, String> {
        let first = self.ranks.first(topology).ok_or_else(|| format!("topology {topology} has no pose"))?;
        let count = self.topology(first as usize)?.node_count as usize;
        let mut start = 0u64;
        for (number, len) in self.shapes(self.poses[first as usize].block) {
            if number == topology {
                let (start, end) = (start as usize, start.saturating_add(len) as usize);
                let bytes =
                    packed.get(start..end).ok_or_else(|| format!("the shape of topology {topology} is cut short"))?;
                return links::decode(bytes, count);
            }
            start = start.saturating_add(len);
        }
        Err(format!("the shape of topology {topology} is in another block"))
    }

    /// The nodes of one pose.
    ///
    /// # Errors
    /// Where its shape leads to nothing.
    pub fn nodes(&self, row: usize, shape: &[Link], vertices: &[Point], out: &mut [Node]) -> Result<(), String> {
        let topology = self.topology(row)?;
        let start =
            usize::try_from(topology.ref_offset).map_err(|_| "its triangles are beyond this machine's memory")?;
        let end = start.saturating_add(topology.ref_count as usize);
        let triangles = self.triangles.get(start..end).ok_or("its triangles are not there")?;
        links::fit(shape, triangles, vertices, out).map_err(|why| format!("pose {row}: {why}"))
    }

    /// Where a pose's records are in its block's `NODE` and `VPOS`.
    pub fn places(&self, row: usize) -> Result<[Range<usize>; 2], String> {
        let (pose, topology) = (self.poses.get(row).ok_or("there is no such pose")?, self.topology(row)?);
        let range = |offset: u64, count: u32| {
            let start = usize::try_from(offset).map_err(|_| "it is beyond this machine's memory")?;
            Ok::<_, String>(start..start.saturating_add(count as usize))
        };
        Ok([range(pose.node_offset, topology.node_count)?, range(pose.vertex_offset, topology.vertex_count)?])
    }
}

/// The shape that nodes have.
pub fn shape_of(nodes: &[Node]) -> Vec<Link> {
    nodes.iter().map(|node| [node.first, node.count]).collect()
}
