use std::ops::{ControlFlow, Range};

use crate::cache::container::Sink;
use crate::cache::report::Place;
use crate::cache::rules;
use crate::layout::{FrameRecord, GeomRecord, MAX_LEAF, PoseRecord, SectionKind, TopologyRecord};

/// The rows of a sequence and how much there is of what they point into.
pub struct Rows<'a> {
    pub topologies: &'a [TopologyRecord],
    pub poses: &'a [PoseRecord],
    pub frames: &'a [FrameRecord],
    pub geoms: &'a [GeomRecord],
    /// Records of `TRIX`.
    pub triangles: u64,
    /// For each block the records of its `NODE` and `VPOS`.
    pub blocks: &'a [[u64; 2]],
    pub placements: usize,
}

impl Rows<'_> {
    /// Every row leads where it says, and nothing is left over: what every reader of a sequence asks before it follows a row.
    pub fn check(&self, out: &mut impl Sink) -> ControlFlow<()> {
        self.check_topologies(out)?;
        self.check_poses(out)?;
        self.check_frames(out)?;
        self.check_geoms(out)?;
        self.check_sizes(out)
    }

    fn check_topologies(&self, out: &mut impl Sink) -> ControlFlow<()> {
        let mut end = 0u64;
        for (i, row) in self.topologies.iter().enumerate() {
            let place = Place::record(SectionKind::TOPO, i as u64);
            let stop = row.ref_offset.saturating_add(row.ref_count.into());
            if row.ref_offset != end || stop > self.triangles {
                let found = format!("{} and {} records", row.ref_offset, row.ref_count);
                out.breach(&rules::E0701, place, || (end.to_string(), found))?;
            }
            end = stop;
            reserved(row.reserved.iter().all(|word| *word == 0), place, out)?;
        }
        if end < self.triangles {
            let last = Place::record(SectionKind::TOPO, (self.topologies.len() as u64).saturating_sub(1));
            let ends =
                (format!("(all topologies) 0 and end at {}", self.triangles), format!("that the last ends at {end}"));
            out.breach(&rules::E0701, last, || ends)?;
        }
        ControlFlow::Continue(())
    }

    /// A pose takes bytes for its nodes and vertices alone, and a frame repeats the triangles and parts of its topology for each pose. So these are held
    /// against the nodes: what is made of a file stays linear in its length.
    fn check_sizes(&self, out: &mut impl Sink) -> ControlFlow<()> {
        let parts = parts_of(self.geoms, self.topologies.len());
        for (i, (row, parts)) in self.topologies.iter().zip(&parts).enumerate() {
            // A root, an unused record and pairs: half of the records are leaves.
            let most = u64::from(row.node_count / 2) * u64::from(MAX_LEAF);
            let fits = |count: u64| (1..=most).contains(&count);
            let even = row.node_count.is_multiple_of(2) && row.node_count < 1 << 31;
            let (refs, parts) = (u64::from(row.ref_count), u64::from(parts.end - parts.start));
            if !even || !fits(refs) || !fits(parts) {
                let expected = format!("an even number of nodes, and 1 to {most} triangles and parts");
                let actual = format!("{} nodes, {refs} triangles and {parts} parts", row.node_count);
                out.breach(&rules::E0708, Place::record(SectionKind::TOPO, i as u64), || (expected, actual))?;
            }
        }
        ControlFlow::Continue(())
    }

    fn check_poses(&self, out: &mut impl Sink) -> ControlFlow<()> {
        let mut posed = vec![false; self.topologies.len()]; // as many as there are rows in the file
        // The block that is being filled, and how far.
        let (mut block, mut ends) = (0usize, [0u64; 2]);
        for (i, pose) in self.poses.iter().enumerate() {
            let place = Place::record(SectionKind::POSE, i as u64);
            reserved(pose.reserved == [0; 2] && pose.flags & !PoseRecord::KEY == 0, place, out)?;
            let Some(topology) = self.topologies.get(pose.topology as usize) else {
                let expected = format!("a topology < {}", self.topologies.len());
                out.breach(&rules::E0702, place, || (expected, pose.topology.to_string()))?;
                continue;
            };
            posed[pose.topology as usize] = true;
            // The next block begins when this one is full, and no block is empty.
            if pose.block as usize == block + 1 && self.blocks.get(block) == Some(&ends) && ends != [0; 2] {
                (block, ends) = (block + 1, [0; 2]);
            }
            let starts = [pose.node_offset, pose.vertex_offset];
            let counts = [topology.node_count, topology.vertex_count].map(u64::from);
            let stops = [0, 1].map(|k| starts[k].saturating_add(counts[k]));
            let fits = self.blocks.get(block).is_some_and(|lens| stops[0] <= lens[0] && stops[1] <= lens[1]);
            if pose.block as usize != block || starts != ends || !fits {
                let expected = format!("node {} and vertex {} of block {block}", ends[0], ends[1]);
                let end = format!("up to {} and {}", stops[0], stops[1]);
                let actual = format!("node {} and vertex {} of block {}, {end}", starts[0], starts[1], pose.block);
                return out.breach(&rules::E0702, place, || (expected, actual));
            }
            ends = stops;
        }
        if block + 1 != self.blocks.len().max(1) || self.blocks.get(block).is_some_and(|lens| *lens != ends) {
            let last = Place::record(SectionKind::POSE, (self.poses.len() as u64).saturating_sub(1));
            let expected = format!("the end of block {}", self.blocks.len().saturating_sub(1));
            let actual = format!("that the last ends at node {} and vertex {} of block {block}", ends[0], ends[1]);
            out.breach(&rules::E0702, last, || (expected, actual))?;
        }
        match posed.iter().position(|posed| !posed) {
            Some(i) => {
                let place = Place::record(SectionKind::TOPO, i as u64);
                out.breach(&rules::E0707, place, || ("one".into(), i.to_string()))
            }
            None => ControlFlow::Continue(()),
        }
    }

    fn check_frames(&self, out: &mut impl Sink) -> ControlFlow<()> {
        let mut shown = vec![false; self.placements]; // as many as there are sections in the file
        let mut before: Option<&FrameRecord> = None;
        for (i, frame) in self.frames.iter().enumerate() {
            let place = Place::record(SectionKind::FRAM, i as u64);
            let known = FrameRecord::TIMED | FrameRecord::HELD;
            reserved(frame.reserved == [0; 4] && frame.flags & !known == 0, place, out)?;
            if let Some(before) = before.filter(|before| before.number >= frame.number) {
                let expected = format!("a number > {}", before.number);
                out.breach(&rules::E0703, place, || (expected, frame.number.to_string()))?;
            }
            if frame.flags & FrameRecord::HELD != 0 && before.map(|b| b.placement) != Some(frame.placement) {
                let expected = before.map_or("a frame before it to hold".into(), |b| {
                    format!("placement {}, which it holds", b.placement)
                });
                out.breach(&rules::E0703, place, || (expected, format!("placement {}", frame.placement)))?;
            }
            if let Some(before) = before.filter(|before| !follows(before, frame)) {
                let timed = |frame: &FrameRecord| match frame.flags & FrameRecord::TIMED {
                    0 => "no time".to_owned(),
                    _ => format!("time {}", frame.time),
                };
                let expected = match timed(before) {
                    time if before.flags & FrameRecord::TIMED == 0 => format!("{time}, like the one before"),
                    time => format!("{time} or a later one"),
                };
                out.breach(&rules::W0702, place, || (expected, timed(frame)))?;
            }
            before = Some(frame);
            match shown.get_mut(frame.placement as usize) {
                Some(shown) => *shown = true,
                None => {
                    let expected = format!("a placement < {}", self.placements);
                    out.breach(&rules::E0703, place, || (expected, format!("placement {}", frame.placement)))?;
                }
            }
            let untimed = frame.flags & FrameRecord::TIMED == 0;
            if !frame.time.is_finite() || untimed && frame.time.to_bits() != 0 {
                let expected = if untimed { "time 0 without TIMED" } else { "a finite time" };
                out.breach(&rules::E0703, place, || (expected.into(), format!("time {}", frame.time)))?;
            }
        }
        if self.frames.is_empty() {
            out.breach(&rules::E0703, Place::section(SectionKind::FRAM), || {
                ("one frame at least".into(), "none".into())
            })?;
        }
        if let Some(i) = shown.iter().position(|shown| !shown) {
            out.breach(&rules::W0701, Place::section(SectionKind::FRAM), || ("one".into(), i.to_string()))?;
        }
        ControlFlow::Continue(())
    }

    fn check_geoms(&self, out: &mut impl Sink) -> ControlFlow<()> {
        let mut low = 0;
        for (i, geom) in self.geoms.iter().enumerate() {
            let place = Place::record(SectionKind::GEOM, i as u64);
            let high = self.topologies.len();
            if geom.blas < low || geom.blas as usize >= high {
                out.breach(&rules::E0314, place, || (format!("in {low} .. {high}"), geom.blas.to_string()))?;
                continue;
            }
            low = geom.blas;
        }
        ControlFlow::Continue(())
    }
}

/// A frame has a time like the one before it, and none before that one's.
fn follows(before: &FrameRecord, frame: &FrameRecord) -> bool {
    (before.flags ^ frame.flags) & FrameRecord::TIMED == 0 && !(frame.time < before.time)
}

fn reserved(holds: bool, place: Place, out: &mut impl Sink) -> ControlFlow<()> {
    if holds {
        return ControlFlow::Continue(());
    }
    out.breach(&rules::E0706, place, || ("zero".into(), "they are not".into()))
}

/// For each topology its rows of `GEOM`, which stand in the order of the topologies.
pub fn parts_of(geoms: &[GeomRecord], topologies: usize) -> Vec<Range<u32>> {
    let mut parts = vec![0..0; topologies];
    for (row, geom) in geoms.iter().enumerate() {
        let Some(part) = parts.get_mut(geom.blas as usize) else { continue };
        let row = row as u32;
        *part = if part.start == part.end { row..row + 1 } else { part.start..row + 1 };
    }
    parts
}
