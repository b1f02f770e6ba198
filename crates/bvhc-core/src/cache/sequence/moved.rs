//! Blocks that are stored as differences: of the poses that theirs are relative to, only those on the way from the first are decoded.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use super::Frames;
use super::frame::records;
use crate::cache::aligned::AlignedBytes;
use crate::cache::decode::{Decoded, check_raw, undecoded, unpack_delta};
use crate::cache::delta::{Base, Blocks, Link, Ranks, Weights, shape_of};
use crate::cache::error::Fault;
use crate::exec::Executor;
use crate::geom::Point;
use crate::layout::SectionEntry;

/// What decoding differences takes, kept from frame to frame.
pub struct Moved {
    ranks: Ranks,
    /// For each topology.
    weights: Vec<OnceLock<Arc<Weights>>>,
    /// Bytes of the weights that are kept.
    held: AtomicU64,
}

/// The sections of one block.
pub type Block<'f> = [Decoded<'f>; 2];

impl Frames<'_> {
    /// Prepare for sections of codec 2, if there are any.
    pub(super) fn moved(&self) -> Option<Moved> {
        let any = self.sections().iter().any(|entry| entry.codec == SectionEntry::DELTA);
        any.then(|| Moved {
            ranks: Ranks::new(self.poses(), self.topologies().len()),
            weights: self.topologies().iter().map(|_| OnceLock::new()).collect(),
            held: AtomicU64::new(0),
        })
    }

    /// `NODE` and `VPOS` of a block, decoded.
    pub(super) fn block(&self, block: u32, exec: &Executor) -> Result<Block<'_>, Fault> {
        let Some([nodes, vertices]) = self.blocks.get(block as usize).copied() else {
            return Ok([Decoded::InFile(&[]), Decoded::InFile(&[])]);
        };
        let is_moved = |index: usize| self.sections()[index].codec == SectionEntry::DELTA;
        let Some(moved) = self.moved.as_ref().filter(|_| is_moved(nodes) || is_moved(vertices)) else {
            return Ok([self.content(nodes, exec)?, self.content(vertices, exec)?]);
        };
        let mut walk = Walk::new(self, moved, exec);
        let positions = match is_moved(vertices) {
            true => Decoded::Owned(walk.vertex_section(block, vertices)?),
            false => self.content(vertices, exec)?,
        };
        let boxes = match is_moved(nodes) {
            true => Decoded::Owned(walk.node_section(block, nodes, records(positions.as_slice()))?),
            false => self.content(nodes, exec)?,
        };
        Ok([boxes, positions])
    }

    /// One of these sections by itself.
    pub(super) fn moved_section(&self, index: usize, exec: &Executor) -> Result<Decoded<'_>, Fault> {
        let found = self.blocks.iter().enumerate().find_map(|(block, entries)| {
            entries.iter().position(|entry| *entry == index).map(|which| (block as u32, which))
        });
        // Both sections that may have the codec are of blocks.
        let Some((block, which)) = found else { return Ok(Decoded::InFile(&[])) };
        let [nodes, vertices] = self.block(block, exec)?;
        Ok(if which == 0 { nodes } else { vertices })
    }
}

/// One way through the poses, and what was met on it.
struct Walk<'f, 'a> {
    frames: &'f Frames<'a>,
    moved: &'f Moved,
    blocks: Blocks<'f>,
    exec: &'f Executor,
    /// By entry of the table.
    unpacked: BTreeMap<usize, AlignedBytes>,
    /// By row of `POSE`.
    poses: BTreeMap<u32, Vec<Point>>,
    /// Bytes of both.
    held: u64,
}

impl<'f, 'a> Walk<'f, 'a> {
    fn new(frames: &'f Frames<'a>, moved: &'f Moved, exec: &'f Executor) -> Walk<'f, 'a> {
        let blocks = Blocks {
            topologies: frames.topologies(),
            poses: frames.poses(),
            triangles: frames.indexed_triangles(),
            ranks: &moved.ranks,
        };
        Walk { frames, moved, blocks, exec, unpacked: BTreeMap::new(), poses: BTreeMap::new(), held: 0 }
    }

    /// Claim memory before it is allocated.
    fn hold(&mut self, bytes: u64) -> Result<(), Fault> {
        self.held = self.held.saturating_add(bytes);
        let (needed, limit) = (u128::from(self.held) + self.frames.file.held(), self.frames.max_memory);
        if needed > u128::from(limit) { Err(Fault::Memory { needed, limit }) } else { Ok(()) }
    }

    fn entry(&self, index: usize) -> &'f SectionEntry {
        &self.frames.sections()[index]
    }

    /// What a section of codec 2 unpacks to, before it is decoded.
    fn unpack(&mut self, index: usize, len: u64) -> Result<(), Fault> {
        if !self.unpacked.contains_key(&index) {
            self.hold(len)?;
            let stored = self.frames.hashed_bytes(index, self.exec)?;
            let unpacked = unpack_delta(self.entry(index), stored, len, self.exec)?;
            self.unpacked.insert(index, unpacked);
        }
        Ok(())
    }

    /// The `VPOS` of a block, which has the codec.
    fn vertex_section(&mut self, block: u32, index: usize) -> Result<AlignedBytes, Fault> {
        let entry = *self.entry(index);
        let mut raw = self.section(&entry)?;
        for row in self.blocks.rows(block) {
            self.visit(row as u32)?;
            let [_, place] = self.blocks.places(row).map_err(|why| undecoded(&entry, why))?;
            let to = raw.records_mut().get_mut(place);
            let from =
                self.poses.get(&(row as u32)).filter(|from| to.as_ref().is_some_and(|to| to.len() == from.len()));
            let (Some(to), Some(from)) = (to, from) else { continue }; // the rows were asked when the file was opened
            to.copy_from_slice(from);
        }
        check_raw(&entry, raw.as_slice(), self.exec)?;
        Ok(raw)
    }

    /// The `NODE` of a block, which has the codec, over the block's vertices.
    fn node_section(&mut self, block: u32, index: usize, vertices: &[Point]) -> Result<AlignedBytes, Fault> {
        let entry = *self.entry(index);
        let mut raw = self.section(&entry)?;
        for row in self.blocks.rows(block) {
            let refuse = |why: String| undecoded(&entry, why);
            let [nodes, mine] = self.blocks.places(row).map_err(refuse)?;
            let shape = self.shape(self.blocks.poses[row].topology)?;
            let (to, vertices) = (raw.records_mut().get_mut(nodes), vertices.get(mine));
            let (Some(to), Some(vertices)) = (to, vertices) else { continue };
            self.blocks.nodes(row, &shape, vertices, to).map_err(refuse)?;
        }
        check_raw(&entry, raw.as_slice(), self.exec)?;
        Ok(raw)
    }

    /// Room for a decoded section.
    fn section(&mut self, entry: &SectionEntry) -> Result<AlignedBytes, Fault> {
        self.hold(entry.raw_len)?;
        let too_large = || Fault::Memory { needed: entry.raw_len.into(), limit: self.frames.max_memory };
        let len = usize::try_from(entry.raw_len).map_err(|_| too_large())?;
        AlignedBytes::zeroed(len).map_err(|_| too_large())
    }

    /// The shape of a topology's tree.
    fn shape(&mut self, topology: u32) -> Result<Vec<Link>, Fault> {
        let Some(first) = self.moved.ranks.first(topology) else { return Ok(Vec::new()) };
        let block = self.blocks.poses[first as usize].block;
        let Some([index, _]) = self.frames.blocks.get(block as usize).copied() else { return Ok(Vec::new()) };
        let entry = *self.entry(index);
        if entry.codec != SectionEntry::DELTA {
            let nodes = self.frames.content(index, self.exec)?;
            let [place, _] = self.blocks.places(first as usize).map_err(|why| undecoded(&entry, why))?;
            return Ok(shape_of(records(nodes.as_slice()).get(place).unwrap_or_default()));
        }
        self.unpack(index, self.blocks.packed_nodes(block))?;
        let packed = self.unpacked.get(&index).map_or(&[][..], AlignedBytes::as_slice);
        Ok(self.blocks.shape(topology, packed).map_err(|why| undecoded(&entry, why))?)
    }

    /// Decode a pose and those on the way to it.
    fn visit(&mut self, row: u32) -> Result<(), Fault> {
        let topology = self.blocks.poses[row as usize].topology;
        let mut way = vec![row];
        while let Some(base) = way.last().and_then(|row| self.moved.ranks.base(*row, topology)) {
            if self.poses.contains_key(&base) {
                break;
            }
            way.push(base);
        }
        while let Some(row) = way.pop() {
            if !self.poses.contains_key(&row) {
                let vertices = self.pose(row, topology)?;
                self.poses.insert(row, vertices);
            }
        }
        Ok(())
    }

    /// The vertices of a pose whose base was decoded.
    fn pose(&mut self, row: u32, topology: u32) -> Result<Vec<Point>, Fault> {
        let Some([_, index]) = self.frames.blocks.get(self.blocks.poses[row as usize].block as usize).copied() else {
            return Ok(Vec::new());
        };
        let entry = *self.entry(index);
        let refuse = |why: String| undecoded(&entry, why);
        let [_, place] = self.blocks.places(row as usize).map_err(refuse)?;
        self.hold(12 * place.len() as u64)?;
        if entry.codec != SectionEntry::DELTA {
            let all = self.frames.content(index, self.exec)?;
            return Ok(records::<Point>(all.as_slice()).get(place).unwrap_or_default().to_vec());
        }
        self.unpack(index, self.blocks.packed_vertices(self.blocks.poses[row as usize].block))?;
        let base = self.moved.ranks.base(row, topology);
        let weights = base.and_then(|_| self.weights(topology)).transpose()?;
        let base = base.and_then(|base| self.poses.get(&base)).zip(weights.as_deref());
        let base = base.map(|(vertices, weights)| Base { vertices, weights });
        let packed = self.unpacked.get(&index).map_or(&[][..], AlignedBytes::as_slice);
        let mut out = vec![[0.0; 3]; place.len()];
        self.blocks.pose(row as usize, packed, base, &mut out).map_err(refuse)?;
        Ok(out)
    }

    /// The weights of a topology whose first pose was decoded or is fetched again. They are kept as long as they fit.
    fn weights(&mut self, topology: u32) -> Option<Result<Arc<Weights>, Fault>> {
        let kept = self.moved.weights.get(topology as usize)?;
        if let Some(weights) = kept.get() {
            return Some(Ok(weights.clone()));
        }
        let first = self.moved.ranks.first(topology)?;
        if let Err(fault) = self.visit(first) {
            return Some(Err(fault));
        }
        let vertices = self.poses.get(&first)?;
        let bytes = Weights::bytes(vertices.len() as u64);
        let weights = Arc::new(Weights::of(vertices));
        // All that is kept stays below the limit; what does not fit is computed again by the next frame.
        if self.moved.held.fetch_add(bytes, Ordering::Relaxed) <= self.frames.max_memory.saturating_sub(bytes) {
            _ = kept.set(weights.clone());
        } else {
            self.moved.held.fetch_sub(bytes, Ordering::Relaxed);
        }
        Some(Ok(weights))
    }
}
