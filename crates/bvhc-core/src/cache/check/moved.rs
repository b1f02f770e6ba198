//! The sections of a sequence that are stored as differences: decoded block after block, each over those before it.

use super::Limits;
use crate::cache::aligned::AlignedBytes;
use crate::cache::container::Container;
use crate::cache::decode::{Decoded, check_raw, undecoded, unpack_delta};
use crate::cache::delta::{Base, Blocks, Kept, Ranks, shape_of};
use crate::cache::poses::Rows;
use crate::cache::report::{Finding, Place, Report};
use crate::exec::Executor;
use crate::geom::Point;
use crate::layout::{
    FrameRecord, GeomRecord, IndexedTriangleRecord, Node, PoseRecord, SectionEntry, SectionKind, TopologyRecord,
};

/// Decode what is stored so, in the place of the bytes that are missing in `decoded`.
pub fn decode(
    container: &Container,
    file: &[u8],
    decoded: &mut [Option<Decoded<'_>>],
    limits: &Limits,
    out: &mut Report,
    exec: &Executor,
) {
    let all = |kind| container.find(kind, 0).and_then(|i| decoded.get(i)?.as_ref()).map(Decoded::as_slice);
    let sections = (
        all(SectionKind::TOPO).map(read::<TopologyRecord>),
        all(SectionKind::TRIX).map(read::<IndexedTriangleRecord>),
        all(SectionKind::POSE).map(read::<PoseRecord>),
        all(SectionKind::FRAM).map(read::<FrameRecord>),
        all(SectionKind::GEOM).map(read::<GeomRecord>),
    );
    let (Some(topologies), Some(triangles), Some(poses), Some(frames), Some(geoms)) = sections else {
        out.skip("The blocks: what their differences are decoded by cannot be read.");
        return;
    };
    let pairs = container.pairs(SectionKind::NODE, SectionKind::VPOS);
    let rows = Rows {
        topologies: &topologies,
        poses: &poses,
        frames: &frames,
        geoms: &geoms,
        triangles: triangles.len() as u64,
        blocks: &container.lengths(&pairs),
        placements: container.pairs(SectionKind::TNOD, SectionKind::INST).len(),
    };
    let mut told = Report::new(limits.max_issues);
    _ = rows.check(&mut told);
    if !told.is_valid() {
        out.append(told);
        out.skip("The blocks: the rows of the sequence do not lead where they say.");
        return;
    }
    let ranks = Ranks::new(&poses, topologies.len());
    let blocks = Blocks { topologies: &topologies, poses: &poses, triangles: &triangles, ranks: &ranks };
    let mut decoder = Decoder { container, file, decoded, pairs: &pairs, blocks, kept: Kept::default(), exec };
    for (block, [nodes, vertices]) in pairs.iter().enumerate() {
        for (index, is_nodes) in [(*vertices, false), (*nodes, true)] {
            let entry = container.entries[index];
            if entry.codec != SectionEntry::DELTA || container.stored(file, index).is_none() {
                continue;
            }
            match decoder.section(block as u32, index, is_nodes) {
                Ok(bytes) => decoder.decoded[index] = bytes.map(Decoded::Owned),
                Err(found) => out.add_finding(found),
            }
            if decoder.decoded[index].is_none() {
                out.skip(format!("Section {} and the blocks behind it: it cannot be decoded.", Place::of(&entry)));
                return;
            }
        }
    }
}

struct Decoder<'d, 'f> {
    container: &'d Container,
    file: &'d [u8],
    decoded: &'d mut [Option<Decoded<'f>>],
    /// For each block its entries.
    pairs: &'d [[usize; 2]],
    blocks: Blocks<'d>,
    kept: Kept,
    exec: &'d Executor,
}

impl Decoder<'_, '_> {
    /// One section; `None` where another that it needs could not be had, which was said.
    fn section(&mut self, block: u32, index: usize, is_nodes: bool) -> Result<Option<AlignedBytes>, Finding> {
        let entry = self.container.entries[index];
        let refuse = |why: String| undecoded(&entry, why);
        let packed_len = if is_nodes { self.blocks.packed_nodes(block) } else { self.blocks.packed_vertices(block) };
        let stored = self.container.stored(self.file, index).unwrap_or_default();
        let packed = unpack_delta(&entry, stored, packed_len, self.exec)?;
        let len = usize::try_from(entry.raw_len).unwrap_or(usize::MAX);
        let mut raw = AlignedBytes::zeroed(len)
            .map_err(|_| refuse(format!("{} decoded bytes are more than this machine can hold", entry.raw_len)))?;
        for row in self.blocks.rows(block) {
            let [nodes, vertices] = self.blocks.places(row).map_err(refuse)?;
            if is_nodes {
                let (Some(positions), Some(shape)) = (self.vertices(row, None), self.shape(row, packed.as_slice())?)
                else {
                    return Ok(None);
                };
                let Some(to) = raw.records_mut::<Node>().get_mut(nodes) else { return Ok(None) };
                self.blocks.nodes(row, &shape, &positions, to).map_err(refuse)?;
                continue;
            }
            let topology = self.blocks.poses[row].topology;
            let own = Some((block, raw.as_slice()));
            let base = match self.blocks.ranks.base(row as u32, topology) {
                None => None,
                Some(base) => {
                    let first = self.blocks.ranks.first(topology).unwrap_or(base);
                    let (first, base) = (self.vertices(first as usize, own), self.vertices(base as usize, own));
                    let (Some(first), Some(base)) = (first, base) else { return Ok(None) };
                    Some((base, self.kept.weights(topology, &first)))
                }
            };
            let base = base.as_ref().map(|(vertices, weights)| Base { vertices, weights });
            let mut positions = vec![[0.0; 3]; vertices.len()];
            self.blocks.pose(row, packed.as_slice(), base, &mut positions).map_err(refuse)?;
            let Some(to) = raw.records_mut::<Point>().get_mut(vertices) else { return Ok(None) };
            to.copy_from_slice(&positions);
        }
        check_raw(&entry, raw.as_slice(), self.exec)?;
        Ok(Some(raw))
    }

    /// The vertices of a pose that was decoded, in a block or in the one that is just being decoded.
    fn vertices(&self, row: usize, own: Option<(u32, &[u8])>) -> Option<Vec<Point>> {
        let [_, place] = self.blocks.places(row).ok()?;
        let block = self.blocks.poses.get(row)?.block;
        let bytes = match own.filter(|(of, _)| *of == block) {
            Some((_, bytes)) => bytes,
            None => self.decoded.get(self.pairs.get(block as usize)?[1])?.as_ref()?.as_slice(),
        };
        Some(read(bytes.get(place.start.checked_mul(12)?..place.end.checked_mul(12)?)?))
    }

    /// The shape of a pose's tree; `packed` is what the pose's own block unpacks to.
    fn shape(&self, row: usize, packed: &[u8]) -> Result<Option<Vec<crate::cache::delta::Link>>, Finding> {
        let pose = self.blocks.poses[row];
        let Some(first) = self.blocks.ranks.first(pose.topology) else { return Ok(None) };
        let of = self.blocks.poses[first as usize].block;
        let Some([index, _]) = self.pairs.get(of as usize) else { return Ok(None) };
        if of == pose.block {
            // The block has the codec, so the shape is in it.
            let shape = self.blocks.shape(pose.topology, packed);
            return shape.map(Some).map_err(|why| undecoded(&self.container.entries[*index], why));
        }
        let Some(nodes) = self.decoded.get(*index).and_then(Option::as_ref) else { return Ok(None) };
        let Ok([place, _]) = self.blocks.places(first as usize) else { return Ok(None) };
        let size = size_of::<Node>();
        let bytes = nodes.as_slice().get(place.start * size..place.end.saturating_mul(size));
        Ok(bytes.map(|bytes| shape_of(&read::<Node>(bytes))))
    }
}

/// Records of bytes that start anywhere.
fn read<T: bytemuck::Pod>(bytes: &[u8]) -> Vec<T> {
    bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()
}
