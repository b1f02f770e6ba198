use std::borrow::Cow;
use std::collections::BTreeMap;

use super::fit::{fit, fit_whole};
use super::{Between, BetweenInstance, Content, Pair};
use crate::cache::Validation;
use crate::cache::decode::Decoded;
use crate::cache::error::{CacheError, Fault, Unlike};
use crate::cache::report::{Finding, Place};
use crate::cache::rules;
use crate::cache::sequence::Frames;
use crate::cache::sequence::frame::records;
use crate::exec::Executor;
use crate::geom::{Aabb, Affine, swept_box};
use crate::layout::{FrameRecord, InstanceRecord, Node, PoseRecord, SectionEntry, SectionKind, tree_flags};

/// Why two frames cannot be joined.
enum Stop {
    Fault(Fault),
    Unlike(Unlike),
}

impl<F: Into<Fault>> From<F> for Stop {
    fn from(fault: F) -> Stop {
        Stop::Fault(fault.into())
    }
}

impl Frames<'_> {
    /// The time between two frames, counted from 0, as the sequence was opened. They need not be neighbours, nor in order, and may be one frame.
    ///
    /// Instances of one number in the scene are one instance. What both frames show of it has to be one topology, in one pose or in two: a mesh whose
    /// tree was built anew between the frames cannot be interpolated.
    ///
    /// Trees of the file stay where they are; packed ones are unpacked. A tree with spatial splits gets boxes around whole triangles where its vertices
    /// move, since parts of triangles cannot follow them.
    ///
    /// # Errors
    /// [`CacheError::Unlike`] where the frames do not show the same. Otherwise as [`Sequence::frame`](Frames::frame), for both.
    pub fn between(&self, first: usize, second: usize) -> Result<Between<'_>, CacheError> {
        self.between_on(first, second, &Executor::current())
    }

    /// [`Sequence::between`](Frames::between) with the threads of `exec`.
    ///
    /// # Errors
    /// As [`Sequence::between`](Frames::between).
    pub fn between_on(&self, first: usize, second: usize, exec: &Executor) -> Result<Between<'_>, CacheError> {
        let (frames, all) = ([first, second], self.frames());
        let missing = |frame| CacheError::NoFrame { frame, frames: all.len() };
        let [a, b] = frames.map(|frame| all.get(frame).ok_or(missing(frame)));
        let records = [*a?, *b?];
        if self.validation() >= Validation::Tree {
            for frame in frames {
                self.frame_on(frame, exec)?;
            }
        }
        self.join(frames, records, exec).map_err(|stop| match stop {
            Stop::Fault(fault) => fault.of(&format!("frames {first} and {second}")),
            Stop::Unlike(what) => CacheError::Unlike { frames, what },
        })
    }

    fn join(&self, frames: [usize; 2], records: [FrameRecord; 2], exec: &Executor) -> Result<Between<'_>, Stop> {
        let (tlas_nodes, first) = self.placement(frames[0], &records[0], exec)?;
        let (_, second) = self.placement(frames[1], &records[1], exec)?;
        if first.len() != second.len() {
            return Err(Stop::Unlike(Unlike::Instances { counts: [first.len(), second.len()] }));
        }
        let (by_id, others) = (numbered(&first)?, numbered(&second)?);

        // Each pair of poses is one tree, numbered as the leaves come to it.
        let mut numbers = BTreeMap::new();
        let mut instances = Vec::with_capacity(first.len());
        for instance in first {
            let other = second[others[instance.id as usize] as usize];
            let ends = [instance.blas, other.blas];
            let next = numbers.len() as u32;
            let tree = *numbers.entry(ends).or_insert(next);
            instances.push(BetweenInstance { ends: [instance, other], tree });
            let [a, b] = [self.pose(ends[0])?.topology, self.pose(ends[1])?.topology];
            if a != b {
                let what = Unlike::Topology { instance: instance.id, topologies: [a, b] };
                return Err(Stop::Unlike(what));
            }
        }
        let mut pairs = vec![[0; 2]; numbers.len()];
        numbers.iter().for_each(|(ends, tree)| pairs[*tree as usize] = *ends);

        let mut poses = pairs.concat();
        poses.sort_unstable();
        poses.dedup();
        self.check_room(&poses, tlas_nodes.len(), instances.len())?;
        let mut contents = self.contents(&poses, exec)?;
        let place = |pose: u32| poses.partition_point(|p| *p < pose);

        let mut trees = Vec::with_capacity(pairs.len());
        let mut known = vec![false; self.topologies().len()];
        for ends in pairs {
            let number = self.pose(ends[0])?.topology;
            // Opening asked the rows, so that each is there.
            let Some(topology) = self.topologies().get(number as usize) else { continue };
            if !std::mem::replace(&mut known[number as usize], true) {
                self.check_corners(number as usize)?;
            }
            let start = topology.ref_offset as usize;
            let refs = start..start + topology.ref_count as usize;
            let ends = ends.map(place);
            if self.validation() >= Validation::Tree {
                same_shape(&contents[ends[0]].nodes, &contents[ends[1]].nodes)?;
            }
            if topology.flags & tree_flags::DUP_REFS != 0 && ends[0] != ends[1] {
                let triangles = self.indexed_triangles().get(refs.clone()).unwrap_or_default();
                for end in ends {
                    let Content { nodes, vertices } = &mut contents[end];
                    fit_whole(nodes.to_mut(), triangles, vertices);
                }
            }
            trees.push(Pair { topology: number, ends, refs });
        }

        let mut tlas_nodes = tlas_nodes.into_owned();
        let swept: Vec<Aabb> = instances.iter().map(|instance| sweep(instance, &trees, &contents)).collect();
        fit(&mut tlas_nodes, |first, count| {
            let some = swept.get(first..first.checked_add(count)?)?;
            Some(some.iter().fold(Aabb::EMPTY, |all, one| all.union(*one)))
        });
        let (triangles, sides) = (self.indexed_triangles(), self.sides());
        Ok(Between { records, tlas_nodes, instances, by_id, trees, contents, triangles, sides })
    }

    fn pose(&self, number: u32) -> Result<&PoseRecord, Fault> {
        let all = self.poses();
        all.get(number as usize).ok_or_else(|| {
            let (expected, actual) = (all.len().to_string(), number.to_string());
            Finding::new(&rules::E0503, Place::section(SectionKind::INST), expected, actual).into()
        })
    }

    /// Nodes and vertices of poses, which ascend: where the file has them, or else unpacked. The one place that knows how they are stored.
    fn contents(&self, poses: &[u32], exec: &Executor) -> Result<Vec<Content<'_>>, Fault> {
        // A block holds several poses, which follow each other: it is fetched once.
        let mut block: Option<(u32, [Decoded<'_>; 2])> = None;
        let mut contents = Vec::with_capacity(poses.len());
        for number in poses {
            let pose = self.pose(*number)?;
            let lost = || {
                let (expected, actual) = ("records of its block and its topology", "it reaches beyond them");
                let place = Place::record(SectionKind::POSE, u64::from(*number));
                Fault::from(Finding::new(&rules::E0702, place, expected.into(), actual.into()))
            };
            if block.as_ref().is_none_or(|(of, _)| *of != pose.block) {
                block = Some((pose.block, self.block(pose.block, exec)?));
            }
            // Opening asked the rows, so that this finds them.
            let topology = self.topologies().get(pose.topology as usize).ok_or_else(lost)?;
            let Some((_, [nodes, vertices])) = &block else { continue };
            contents.push(Content {
                nodes: piece(nodes, pose.node_offset, topology.node_count).ok_or_else(lost)?,
                vertices: piece(vertices, pose.vertex_offset, topology.vertex_count).ok_or_else(lost)?,
            });
        }
        Ok(contents)
    }

    /// Whether what is held at once fits the limit: copies of what is packed, with the largest block, and of trees that are fitted anew.
    fn check_room(&self, poses: &[u32], top: usize, instances: usize) -> Result<(), Fault> {
        let is_packed = |entry: usize| self.sections().get(entry).is_some_and(SectionEntry::is_packed);
        let (mut copies, mut block) = (0u128, 0u128);
        for pose in poses.iter().filter_map(|pose| self.poses().get(*pose as usize)) {
            let Some(topology) = self.topologies().get(pose.topology as usize) else { continue };
            let Some(entries) = self.blocks.get(pose.block as usize) else { continue };
            let split = topology.flags & tree_flags::DUP_REFS != 0;
            let nodes = u128::from(topology.node_count) * size_of::<Node>() as u128;
            let vertices = u128::from(topology.vertex_count) * size_of::<[f32; 3]>() as u128;
            copies += if is_packed(entries[0]) || split { nodes } else { 0 };
            copies += if is_packed(entries[1]) { vertices } else { 0 };
            block = block.max(self.unpacked(*entries));
        }
        let each = size_of::<BetweenInstance>() + size_of::<Pair>() + size_of::<Aabb>() + 2 * size_of::<u32>();
        let placed = instances as u128 * (each + 2 * size_of::<InstanceRecord>()) as u128;
        let lists = (top * size_of::<Node>() + poses.len() * size_of::<Content<'_>>()) as u128;
        let needed = self.file.held() + copies + block + placed + lists;
        if needed > u128::from(self.max_memory) {
            Err(Fault::Memory { needed, limit: self.max_memory })
        } else {
            Ok(())
        }
    }

    /// Each triangle of a topology has its corners, and a part of the topology.
    fn check_corners(&self, number: usize) -> Result<(), Fault> {
        let (Some(topology), Some(parts)) = (self.topologies().get(number), self.parts.get(number)) else {
            return Ok(());
        };
        let start = topology.ref_offset as usize;
        let triangles = self.indexed_triangles().get(start..start + topology.ref_count as usize);
        for (slot, triangle) in triangles.unwrap_or_default().iter().enumerate() {
            let place = || Place::record(SectionKind::TRIX, topology.ref_offset + slot as u64);
            let [a, b, c] = triangle.corners;
            let last = a.max(b).max(c);
            if last >= topology.vertex_count {
                let (expected, actual) = (topology.vertex_count.to_string(), last.to_string());
                return Err(Finding::new(&rules::E0704, place(), expected, actual).into());
            }
            if !parts.contains(&triangle.geom) {
                let expected = format!("in {} .. {}", parts.start, parts.end);
                return Err(Finding::new(&rules::E0416, place(), expected, triangle.geom.to_string()).into());
            }
        }
        Ok(())
    }
}

/// Records of a section from an offset on.
fn piece<'s, T: bytemuck::Pod>(section: &Decoded<'s>, offset: u64, count: u32) -> Option<Cow<'s, [T]>> {
    let start = usize::try_from(offset).ok()?;
    let range = start..start.checked_add(count as usize)?;
    match section {
        Decoded::InFile(bytes) => records(bytes).get(range).map(Cow::Borrowed),
        Decoded::Owned(bytes) => records(bytes.as_slice()).get(range).map(|some| Cow::Owned(some.to_vec())),
    }
}

/// For each id the record that has it: the ids are 0, 1, … and each stands there once.
fn numbered(instances: &[InstanceRecord]) -> Result<Vec<u32>, Fault> {
    let mut by_id = vec![u32::MAX; instances.len()];
    for (record, instance) in instances.iter().enumerate() {
        match by_id.get_mut(instance.id as usize) {
            Some(free) if *free == u32::MAX => *free = record as u32,
            _ => {
                let place = Place::record(SectionKind::INST, record as u64);
                let expected = format!("id must be < {} and stand there once", instances.len());
                return Err(Finding::new(&rules::E0504, place, expected, format!("it is {}", instance.id)).into());
            }
        }
    }
    Ok(by_id)
}

/// Two poses refer to the same: E0705.
fn same_shape(first: &[Node], second: &[Node]) -> Result<(), Fault> {
    let differ = first.iter().zip(second).position(|(a, b)| (a.first, a.count) != (b.first, b.count));
    let Some(i) = differ else { return Ok(()) };
    let [expected, actual] = [first[i], second[i]].map(|node| format!("{} and {}", node.first, node.count));
    Err(Finding::new(&rules::E0705, Place::section(SectionKind::NODE), expected, actual).into())
}

/// Where an instance is at any time between.
fn sweep(instance: &BetweenInstance, trees: &[Pair], contents: &[Content<'_>]) -> Aabb {
    let root = |end: usize| {
        let pair = trees.get(instance.tree as usize)?;
        contents.get(pair.ends[end])?.nodes.first().map(Node::bounds)
    };
    let (Some(a), Some(b)) = (root(0), root(1)) else { return Aabb::EMPTY };
    let maps = [0, 1].map(|end| Affine::from_f32(&instance.ends[end].object_to_world));
    swept_box([&maps[0], &maps[1]], [&a, &b])
}
