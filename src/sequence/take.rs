//! Frames are taken from an earlier build where a build of now would come to the same.
//!
//! Trees of a mesh follow from its poses in their order, so what was decided then is decided again, over the vertices that the file has: the costs of the trees
//! are computed, and no model is read and no tree is built. A pose is taken if the tree that serves it now is the one that served it then. Otherwise the
//! frame's model is read, as those are that changed and those for which a tree was built.
//!
//! Meshes whose number of triangles no changed frame has or had are not even asked: nothing that happened to others concerns them.

use std::collections::{BTreeMap, BTreeSet};

use super::prior::Prior;
use super::shape::geometry_hash;
use super::{FrameLabel, FrameOutcome, PreparedFrame, SequenceBuilder, SequenceError};
use crate::cache::{GeomRecord, IndexedTriangleRecord, Parts, PoseRecord};
use crate::layout::FrameRecord;
use crate::scene::Mesh;

/// What was taken so far.
pub(super) struct Taking {
    prior: Prior,
    /// Numbers of triangles of the meshes that a changed frame shows or showed; `None` where that may be any.
    touched: Option<BTreeSet<u32>>,
    /// Numbers of triangles of meshes whose faces may be cut otherwise from here on.
    recut: BTreeSet<u32>,
    /// By topology of the file.
    rows: BTreeMap<u32, Row>,
    /// By pose of the file the pose that is the same now.
    poses: BTreeMap<u32, u32>,
}

/// What a topology of the file is now.
enum Row {
    /// One that was copied.
    Copied(u32),
    /// One that was made again.
    Made {
        topology: u32,
        shape: [u8; 32],
        /// For each vertex of the mesh its vertex in the topology.
        of: Vec<u32>,
        /// The mesh; its positions are those of the last pose that was asked.
        mesh: Box<Mesh>,
    },
}

impl SequenceBuilder<'_> {
    /// Take from an earlier build what is the same now. `changed` are the frames of [`Prior::changed`], for what is to be known of them beforehand; `None` where
    /// they are too many to be held.
    ///
    /// For each frame whether it need not be read, as far as can be told now: [`SequenceBuilder::add_all`] may still ask for it. Call it after the
    /// [survey](SequenceBuilder::survey), and before the first frame.
    pub fn take_from<'f>(
        &mut self,
        prior: Prior,
        changed: Option<impl IntoIterator<Item = &'f PreparedFrame>>,
    ) -> Vec<bool> {
        let triangles = |old: usize| prior.topology_of(old).map(|topology| prior.topology(topology).prim_count);
        let gone = prior.gone();
        let touched = changed.map(|frames| {
            let meshes = frames.into_iter().filter_map(PreparedFrame::laid).flat_map(|laid| &laid.meshes);
            let now = meshes.map(|mesh| mesh.triangles.len() as u32);
            now.chain(gone.iter().filter_map(|old| triangles(*old))).collect::<BTreeSet<u32>>()
        });
        // Who showed a topology first may have been the one that said how its faces are cut.
        let said = gone.iter().filter(|old| prior.introduces[**old].is_some());
        let said: Vec<(usize, Option<u32>)> = said.map(|old| (*old, triangles(*old))).collect();
        let is_recut = |old: usize| said.iter().any(|(of, count)| *of < old && *count == triangles(old));
        let is_touched = |old: usize| {
            triangles(old).is_some_and(|count| touched.as_ref().is_none_or(|touched| touched.contains(&count)))
        };
        let is_read = |old: usize| is_recut(old) || (is_touched(old) && prior.introduces[old].is_some());
        let plan = prior.same.iter().map(|old| old.is_some_and(|old| !is_read(old))).collect();
        let (recut, rows, poses) = (BTreeSet::new(), BTreeMap::new(), BTreeMap::new());
        self.taking = Some(Taking { prior, touched, recut, rows, poses });
        plan
    }

    /// The frame as the earlier build has it; `None` where its model is to be read.
    pub(super) fn take(&mut self, index: usize, label: FrameLabel) -> Result<Option<FrameOutcome>, SequenceError> {
        let Some(mut taking) = self.taking.take() else { return Ok(None) };
        let taken = self.taken_of(&mut taking, index, label);
        self.taking = Some(taking);
        taken
    }

    fn taken_of(
        &mut self,
        taking: &mut Taking,
        index: usize,
        label: FrameLabel,
    ) -> Result<Option<FrameOutcome>, SequenceError> {
        let Some(old) = taking.prior.same.get(index).copied().flatten() else { return Ok(None) };
        let frame: FrameRecord = taking.prior.file().frames()[old];
        // What is damaged is read from its model.
        let Ok((nodes, mut instances)) = taking.prior.placement(&frame, self.exec) else { return Ok(None) };
        let mut outcome = FrameOutcome { number: label.number, ..FrameOutcome::default() };
        if let Some(pose) = taking.prior.shows[old] {
            let Some(now) = self.taken_pose(taking, pose, &mut outcome) else { return Ok(None) };
            instances.iter_mut().for_each(|instance| instance.blas = now);
            outcome.instanced_triangles =
                taking.prior.topology_of(old).map_or(0, |t| taking.prior.topology(t).prim_count.into());
        }
        outcome.instances = instances.len() as u64;
        outcome.bytes = self.writer.frame(label.record(), &nodes, &instances)?;
        Ok(Some(outcome))
    }

    /// The number that a pose of the file has now.
    fn taken_pose(&mut self, taking: &mut Taking, pose: u32, outcome: &mut FrameOutcome) -> Option<u32> {
        if let Some(now) = taking.poses.get(&pose) {
            outcome.same += 1;
            return Some(*now);
        }
        let Taking { prior, touched, recut, rows, poses } = taking;
        let PoseRecord { topology: row, flags, .. } = prior.pose(pose);
        let count = prior.topology(row).prim_count;
        let is_touched = touched.as_ref().is_none_or(|touched| touched.contains(&count));
        if recut.contains(&count) || (is_touched && !rows.contains_key(&row)) {
            return None;
        }
        let (nodes, vertices) = prior.content(pose, self.exec).ok()?;
        let now = match rows.entry(row).or_insert_with(|| Row::Copied(copy(prior, row, &nodes, &mut self.writer))) {
            Row::Copied(topology) => self.writer.pose(*topology, &nodes, &vertices, flags),
            Row::Made { topology, shape, of, mesh } => {
                let place = |(v, of): (usize, &u32)| vertices.get(*of as usize).map(|p| (v, *p));
                of.iter().enumerate().filter_map(place).for_each(|(v, p)| mesh.positions[v] = p);
                let key = (*shape, geometry_hash(mesh));
                if let Some(now) = self.poses.get(&key) {
                    outcome.same += 1;
                    poses.insert(pose, *now);
                    return Some(*now);
                }
                let followed = self.shapes.get_mut(shape)?.follow(mesh, *topology, &nodes, self.exec);
                outcome.worst_ratio = outcome.worst_ratio.max(followed?);
                let now = self.writer.pose(*topology, &nodes, &vertices, 0);
                self.poses.insert(key, now);
                now
            }
        };
        outcome.taken += 1;
        poses.insert(pose, now);
        Some(now)
    }

    /// Note which pose a mesh became in a frame whose model was read. `shape` is the hash of its topology, and `is_first` says that no frame before has its faces.
    pub(super) fn learn(&mut self, index: usize, now: u32, shape: [u8; 32], mesh: &Mesh, is_first: bool) {
        let Some(Taking { prior, touched, recut, rows, poses }) = &mut self.taking else { return };
        let count = mesh.triangles.len() as u32;
        let Some(old) = prior.same.get(index).copied().flatten() else {
            if is_first {
                recut.insert(count);
            }
            return;
        };
        let Some(pose) = prior.shows[old] else { return };
        poses.insert(pose, now);
        let (row, topology) = (prior.pose(pose).topology, self.writer.poses()[now as usize].topology);
        if rows.contains_key(&row) {
            return;
        }
        if !is_copy(prior, row, &self.writer, topology) {
            // Whoever shows the old one now has another.
            touched.iter_mut().for_each(|touched| _ = touched.insert(count));
            return;
        }
        if let Some(of) = self.shapes.get(&shape).and_then(|shape| shape.vertices_of(topology)) {
            let (positions, triangles) = (vec![[0.0; 3]; mesh.positions.len()], mesh.triangles.clone());
            let mesh = Box::new(Mesh { positions, triangles, ..Mesh::default() });
            rows.insert(row, Row::Made { topology, shape, of: of.to_vec(), mesh });
        }
    }
}

/// The triangles and parts of a topology of the file.
fn rows_of(prior: &Prior, row: u32) -> (&[IndexedTriangleRecord], std::ops::Range<usize>) {
    let file = prior.file();
    let topology = prior.topology(row);
    let start = topology.ref_offset as usize;
    let first = file.geoms().partition_point(|geom| geom.blas < row);
    let parts = first..file.geoms().partition_point(|geom| geom.blas <= row);
    (&file.indexed_triangles()[start..start + topology.ref_count as usize], parts)
}

/// Copy a topology.
fn copy(prior: &Prior, row: u32, nodes: &[crate::tree::Node], writer: &mut crate::cache::SequenceWriter) -> u32 {
    let file = prior.file();
    let (triangles, parts) = rows_of(prior, row);
    let named = |names: crate::layout::Names<'_>| -> Vec<String> {
        parts.clone().map(|part| names.get(part).unwrap_or_default().to_owned()).collect()
    };
    let start = prior.topology(row).ref_offset as usize;
    let geoms: Vec<GeomRecord> = file.geoms()[parts.clone()].to_vec();
    let parts = Parts {
        geoms: &geoms,
        names: &named(file.names()),
        materials: &named(file.materials()),
        sides: file.sides().get(parts.clone()).unwrap_or_default(),
        vertices: file.vertices().get(start..start + triangles.len()).unwrap_or_default(),
    };
    let first = rows_of(prior, row).1.start as u32;
    let triangles = triangles.iter().map(|t| IndexedTriangleRecord { geom: t.geom - first, ..*t });
    writer.topology(nodes, prior.topology(row).vertex_count, triangles, &parts)
}

/// Whether a topology that was written has the triangles of one of the file, with the same vertices in the same leaves.
fn is_copy(prior: &Prior, row: u32, writer: &crate::cache::SequenceWriter, topology: u32) -> bool {
    let (now, triangles, first_now) = writer.topology_rows(topology);
    let (then, (before, parts)) = (prior.topology(row), rows_of(prior, row));
    let from = |t: &IndexedTriangleRecord, first: u32| (t.corners, t.prim, t.geom - first, t.flags);
    (now.node_count, now.vertex_count, now.prim_count, now.flags)
        == (then.node_count, then.vertex_count, then.prim_count, then.flags)
        && triangles.iter().map(|t| from(t, first_now)).eq(before.iter().map(|t| from(t, parts.start as u32)))
}
