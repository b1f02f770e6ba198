use std::borrow::Cow;
use std::sync::OnceLock;
use std::sync::atomic::Ordering;

use super::Frames;
use crate::cache::Validation;
use crate::cache::check::{self, Limits};
use crate::cache::container::First;
use crate::cache::decode::{Decoded, check_stored, unpack};
use crate::cache::error::{CacheError, Fault};
use crate::cache::open::is_of_frames;
use crate::cache::poses::{PoseRows, Posed};
use crate::cache::records_by_id::RecordsById;
use crate::cache::report::{Finding, Place};
use crate::cache::rules::{self, Rule};
use crate::exec::Executor;
use crate::layout::{
    BlasRecord, FrameRecord, GeomRecord, InstanceRecord, Node, SectionKind, TriangleRecord, View, tree_flags,
};

/// One frame of a sequence: what a still file of two levels holds.
///
/// Its trees, parts and instances are numbered anew, as if there were no other frame: [`Frame::poses`] and [`Frame::parts`] lead back to the file.
#[derive(Clone, Debug)]
pub struct Frame<'s> {
    record: FrameRecord,
    nodes: Cow<'s, [Node]>,
    triangles: Vec<TriangleRecord>,
    geoms: Vec<GeomRecord>,
    blases: Vec<BlasRecord>,
    tlas_nodes: Cow<'s, [Node]>,
    instances: Vec<InstanceRecord>,
    poses: Vec<u32>,
    parts: Vec<u32>,
    by_id: OnceLock<RecordsById>,
}

impl Frame<'_> {
    /// Number and time.
    pub fn record(&self) -> &FrameRecord {
        &self.record
    }

    /// Everything that traversal reads.
    pub fn view(&self) -> View<'_> {
        View {
            nodes: &self.nodes,
            triangles: &self.triangles,
            geoms: &self.geoms,
            blases: &self.blases,
            tlas_nodes: &self.tlas_nodes,
            instances: &self.instances,
        }
    }

    /// For each tree of the frame its row in [`Sequence::poses`](Frames::poses), ascending.
    pub fn poses(&self) -> &[u32] {
        &self.poses
    }

    /// For each part of the frame its row in [`Sequence::geoms`](Frames::geoms).
    pub fn parts(&self) -> &[u32] {
        &self.parts
    }

    /// The row in [`Sequence::geoms`](Frames::geoms) of the part that a hit in this frame numbers: by it the file tells the part's name, material and side.
    pub fn part(&self, geom: u32) -> Option<u32> {
        self.parts.get(geom as usize).copied()
    }

    /// The index among the frame's records of the instance that it numbers so, as hits do.
    pub fn instance_record(&self, id: u32) -> Option<usize> {
        self.by_id.get_or_init(|| RecordsById::new(&self.instances)).record(id)
    }

    /// The tree flags that a still file of this frame has.
    pub fn tree_flags(&self) -> u32 {
        let split = self.blases.iter().any(|b| b.flags & tree_flags::DUP_REFS != 0);
        let kind = if split { tree_flags::DUP_REFS } else { tree_flags::REFITTABLE };
        tree_flags::CANONICAL_DFS | tree_flags::TWO_LEVEL | kind
    }
}

/// What a frame shows, in records.
#[derive(Default)]
struct Total {
    trees: usize,
    nodes: usize,
    triangles: usize,
    parts: usize,
    /// Bytes of the largest of its blocks that is packed: one is held at a time.
    block: u128,
}

impl Frames<'_> {
    /// One frame, counted from 0, as the sequence was opened: at [`Validation::Hash`] the bytes that it needs are hashed when the first frame needs
    /// them, at [`Validation::Tree`] the frame's records are checked.
    ///
    /// Nodes of a frame that shows a single pose are borrowed from the file; those of several poses, and all triangles, are put together.
    ///
    /// # Errors
    /// Where there is no such frame, or what it shows is damaged.
    pub fn frame(&self, index: usize) -> Result<Frame<'_>, CacheError> {
        self.frame_on(index, &Executor::current())
    }

    /// [`Sequence::frame`](Frames::frame) with the threads of `exec`.
    ///
    /// # Errors
    /// As [`Sequence::frame`](Frames::frame).
    pub fn frame_on(&self, index: usize, exec: &Executor) -> Result<Frame<'_>, CacheError> {
        let frames = self.frame_count();
        let Some(record) = self.frames().get(index) else { return Err(CacheError::NoFrame { frame: index, frames }) };
        self.assemble(index, *record, exec).map_err(|fault| fault.of(&format!("frame {}", record.number)))
    }

    /// The sections `TNOD` and `INST` of what a frame shows.
    fn placed(&self, index: usize, record: &FrameRecord) -> Result<[usize; 2], Fault> {
        self.placements.get(record.placement as usize).copied().ok_or_else(|| {
            let expected = format!("a placement < {}", self.placements.len());
            let place = Place::record(SectionKind::FRAM, index as u64);
            Finding::new(&rules::E0703, place, expected, record.placement.to_string()).into()
        })
    }

    /// The tree over a frame's instances, and these, with rows of `POSE` in the place of trees.
    pub(super) fn placement(
        &self,
        index: usize,
        record: &FrameRecord,
        exec: &Executor,
    ) -> Result<(Cow<'_, [Node]>, Vec<InstanceRecord>), Fault> {
        let [tnod, inst] = self.placed(index, record)?;
        let tlas_nodes = match self.content(tnod, exec)? {
            Decoded::InFile(bytes) => Cow::Borrowed(records(bytes)),
            Decoded::Owned(bytes) => Cow::Owned(records(bytes.as_slice()).to_vec()),
        };
        Ok((tlas_nodes, records(self.content(inst, exec)?.as_slice()).to_vec()))
    }

    fn assemble(&self, index: usize, record: FrameRecord, exec: &Executor) -> Result<Frame<'_>, Fault> {
        let refuse = |rule: &'static Rule, place, expected: String, actual: String| {
            Fault::from(Finding::new(rule, place, expected, actual))
        };
        let (tlas_nodes, mut instances) = self.placement(index, &record, exec)?;

        // Which poses it shows, each once.
        let all = self.poses();
        let mut poses: Vec<u32> = instances.iter().map(|instance| instance.blas).collect();
        poses.sort_unstable();
        poses.dedup();
        if let Some(last) = poses.last().filter(|last| **last as usize >= all.len()) {
            return Err(refuse(
                &rules::E0503,
                Place::section(SectionKind::INST),
                all.len().to_string(),
                last.to_string(),
            ));
        }
        for instance in &mut instances {
            instance.blas = poses.partition_point(|pose| *pose < instance.blas) as u32;
        }

        let total = self.total(&poses);
        let needed = self.bytes_needed(&total, self.placed(index, &record)?);
        if needed > u128::from(self.max_memory) {
            return Err(Fault::Memory { needed, limit: self.max_memory });
        }
        let mut frame = Frame {
            record,
            nodes: Cow::Borrowed(&[]),
            triangles: Vec::with_capacity(total.triangles),
            geoms: Vec::with_capacity(total.parts),
            blases: Vec::with_capacity(poses.len()),
            tlas_nodes,
            instances,
            poses,
            parts: Vec::with_capacity(total.parts),
            by_id: OnceLock::new(),
        };
        // A block holds several poses, which follow each other: it is fetched once.
        let mut block: Option<(u32, [Decoded<'_>; 2])> = None;
        for (number, pose) in frame.poses.iter().map(|pose| &all[*pose as usize]).enumerate() {
            if block.as_ref().is_none_or(|(of, _)| *of != pose.block) {
                if pose.block as usize >= self.blocks.len() {
                    let place = Place::record(SectionKind::POSE, frame.poses[number].into());
                    return Err(refuse(
                        &rules::E0702,
                        place,
                        format!("a block < {}", self.blocks.len()),
                        pose.block.to_string(),
                    ));
                }
                block = Some((pose.block, self.block(pose.block, exec)?));
            }
            let Some((_, [nodes, vertices])) = &block else { continue };
            let posed = self.posed(pose, records(nodes.as_slice()), records(vertices.as_slice()))?;
            let first_part = frame.geoms.len() as u32;
            frame.blases.push(posed.blas(frame.nodes.len() as u64, frame.triangles.len() as u64));
            let parts = self.parts.get(pose.topology as usize).cloned().unwrap_or_default();
            frame.geoms.extend(posed.parts(&parts, number as u32));
            frame.parts.extend(parts.clone());
            let mut first = First::default();
            _ = posed.triangles(&parts, first_part, &mut frame.triangles, &mut first);
            first.result()?;
            let (starts, len) = (pose.node_offset as usize, posed.nodes.len());
            match &block {
                // The only pose, where the file has it.
                Some((_, [Decoded::InFile(bytes), _])) if frame.poses.len() == 1 => {
                    frame.nodes = Cow::Borrowed(records(bytes).get(starts..starts + len).unwrap_or_default());
                }
                _ => {
                    let nodes = frame.nodes.to_mut();
                    nodes.reserve_exact(total.nodes - nodes.len());
                    nodes.extend_from_slice(posed.nodes);
                }
            }
        }
        if self.validation() >= Validation::Tree {
            let limits = Limits { max_issues: 1, ..Limits::default() };
            let of = check::RecordsOf::Frame;
            Fault::of_report(&check::check_records(&frame.view(), frame.tree_flags(), of, &limits, exec))?;
        }
        Ok(frame)
    }

    /// What poses come to, each shown once. Rows that lead nowhere count for nothing.
    fn total(&self, poses: &[u32]) -> Total {
        let mut total = Total { trees: poses.len(), ..Total::default() };
        for pose in poses.iter().filter_map(|pose| self.poses().get(*pose as usize)) {
            let number = pose.topology as usize;
            let Some((topology, parts)) = self.topologies().get(number).zip(self.parts.get(number)) else { continue };
            total.nodes = total.nodes.saturating_add(topology.node_count as usize);
            total.triangles = total.triangles.saturating_add(topology.ref_count as usize);
            total.parts = total.parts.saturating_add(parts.len());
            let block = self.blocks.get(pose.block as usize).map_or(0, |entries| self.unpacked(*entries));
            total.block = total.block.max(block);
        }
        total
    }

    /// Bytes that two sections take once they are decoded, where they are packed.
    pub(super) fn unpacked(&self, entries: [usize; 2]) -> u128 {
        let entries = entries.iter().filter_map(|i| self.sections().get(*i));
        entries.filter(|e| e.is_packed()).map(|e| u128::from(e.raw_len)).sum()
    }

    /// Bytes that a frame takes while it is put together, with those that are held already. Poses of a few bytes may show many triangles, so this does
    /// not follow from the file's length.
    fn bytes_needed(&self, total: &Total, placement: [usize; 2]) -> u128 {
        let trees = total.trees * size_of::<BlasRecord>() + total.parts.saturating_mul(size_of::<GeomRecord>() + 4);
        let nodes = total.nodes.saturating_mul(size_of::<Node>());
        let triangles = total.triangles.saturating_mul(size_of::<TriangleRecord>());
        let instances = self.sections().get(placement[1]).map_or(0, |e| u128::from(e.raw_len));
        let shown = [trees, nodes, triangles].map(|bytes| bytes as u128).iter().sum::<u128>();
        self.file.held() + shown + total.block + instances + self.unpacked(placement)
    }

    /// A pose and its parts of a block that was fetched.
    pub(in crate::cache) fn posed<'b>(
        &'b self,
        pose: &'b crate::layout::PoseRecord,
        nodes: &'b [Node],
        vertices: &'b [[f32; 3]],
    ) -> Result<Posed<'b>, Fault> {
        let rows = PoseRows { topologies: self.topologies(), corners: self.indexed_triangles(), geoms: self.geoms() };
        // Opening asked the rows, so that this finds nothing.
        rows.posed(pose, nodes, vertices).ok_or_else(|| {
            let (expected, actual) = ("records of its block and its topology", "it reaches beyond them");
            Finding::new(&rules::E0702, Place::section(SectionKind::POSE), expected.into(), actual.into()).into()
        })
    }

    /// The decoded bytes of section `index` of [`Sequence::sections`](Frames::sections), as [`Opened::section_bytes`](crate::cache::Opened::section_bytes) has
    /// them for a still file; those of blocks and placements are hashed and decoded when they are asked for.
    ///
    /// # Errors
    /// Where they are damaged, or do not fit the memory limit.
    pub fn section_bytes(&self, index: usize, exec: &Executor) -> Result<Option<Cow<'_, [u8]>>, CacheError> {
        let Some(entry) = self.sections().get(index) else { return Ok(None) };
        if !is_of_frames(entry.kind) {
            return Ok(self.file.section_bytes(index).map(Cow::Borrowed));
        }
        let content =
            self.content(index, exec).map_err(|fault| fault.of(&format!("{} {}", entry.kind, entry.ordinal)))?;
        Ok(Some(match content {
            Decoded::InFile(bytes) => Cow::Borrowed(bytes),
            Decoded::Owned(bytes) => Cow::Owned(bytes.as_slice().to_vec()),
        }))
    }

    /// The bytes of section `index` as they stand in the file; empty beyond the table.
    pub fn stored_bytes(&self, index: usize) -> &[u8] {
        self.file.stored_bytes(index)
    }

    /// A section's decoded bytes, held against its hash as the level asks: the stored ones once, those that are decoded each time.
    pub(in crate::cache) fn content(&self, index: usize, exec: &Executor) -> Result<Decoded<'_>, Fault> {
        let Some(entry) = self.sections().get(index) else { return Ok(Decoded::InFile(&[])) };
        #[cfg(feature = "zstd")]
        if entry.codec == crate::layout::SectionEntry::DELTA {
            return self.moved_section(index, exec);
        }
        let stored = self.hashed_bytes(index, exec)?;
        if !entry.is_packed() {
            return Ok(Decoded::InFile(stored));
        }
        let too_large = || Fault::Memory { needed: entry.raw_len.into(), limit: self.max_memory };
        let raw_len = usize::try_from(entry.raw_len).map_err(|_| too_large())?;
        if entry.raw_len > self.max_memory {
            return Err(too_large());
        }
        Ok(Decoded::Owned(unpack(entry, stored, raw_len, exec)?))
    }

    /// A section's bytes as they are stored, held against their hash once as the level asks. Nothing is decoded that was not hashed.
    pub(super) fn hashed_bytes(&self, index: usize, exec: &Executor) -> Result<&[u8], Fault> {
        let Some(entry) = self.sections().get(index) else { return Ok(&[]) };
        let (stored, hashed) = (self.file.stored_bytes(index), &self.hashed[index]);
        if (entry.is_packed() || self.validation() >= Validation::Hash) && !hashed.load(Ordering::Acquire) {
            check_stored(entry, stored, exec)?;
            hashed.store(true, Ordering::Release);
        }
        Ok(stored)
    }

    /// `NODE` and `VPOS` of a block: this build of the crate decodes nothing.
    #[cfg(not(feature = "zstd"))]
    pub(super) fn block(&self, block: u32, exec: &Executor) -> Result<[Decoded<'_>; 2], Fault> {
        let Some([nodes, vertices]) = self.blocks.get(block as usize).copied() else {
            return Ok([Decoded::InFile(&[]), Decoded::InFile(&[])]);
        };
        Ok([self.content(nodes, exec)?, self.content(vertices, exec)?])
    }
}

/// The container's rules made the length a multiple of the record's, and the bytes are aligned.
pub(super) fn records<T: bytemuck::Pod>(bytes: &[u8]) -> &[T] {
    bytemuck::try_cast_slice(bytes).unwrap_or_default()
}
