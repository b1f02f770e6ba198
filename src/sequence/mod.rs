//! Many frames become one file: what a frame shares with those before it is stored once.
//!
//! ```text
//! Scene of a frame ─ compile::lay_out ─▶ meshes and instances
//!   each mesh: seen before ─▶ the pose of then · moved ─ refit ─▶ a pose · other triangles, or moved too far ─ build ─▶ a topology
//!   instances ─ top level ─▶ a placement
//! ```
//!
//! Trees may be made for the whole animation first ([`SequenceBuilder::survey`]). They are refitted bottom-up to where their triangles stand, and built anew where that has become too dear ([`RefitPolicy`]). The top level is built for
//! every frame.

mod cuts;
mod drive;
mod prior;
mod shape;
mod survey;
mod take;
mod weld;

pub use crate::build::motion::{Refit, RefitPolicy, Trees};
pub use cuts::{Cuts, Faces};
pub use drive::{Incoming, PreparedFrame, Preparer, TOGETHER};
pub use prior::{FrameModel, Prior};

use std::collections::BTreeMap;
use std::path::Path;

use crate::build::{BuildError, BuildOptions, Levels, Progress, tlas};
use crate::cache::{CacheError, Codec, FrameRecord, Meta, PoseRecord, SequenceWriter, WriteSummary, instance_record};
use crate::compile::{self, LaidOut, Placing};
use crate::exec::Executor;
use crate::geom::{Aabb, Affine};
use crate::scene::{Mesh, Scene};
use shape::{Shape, geometry_hash, topology_hash};
use survey::Survey;
use take::Taking;

/// Why a sequence could not be built.
#[derive(Debug)]
#[non_exhaustive]
pub enum SequenceError {
    /// A frame could not be built.
    Build(BuildError),
    /// The file could not be written.
    Cache(CacheError),
}

impl From<BuildError> for SequenceError {
    fn from(error: BuildError) -> SequenceError {
        SequenceError::Build(error)
    }
}

impl From<CacheError> for SequenceError {
    fn from(error: CacheError) -> SequenceError {
        SequenceError::Cache(error)
    }
}

impl std::fmt::Display for SequenceError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            SequenceError::Build(error) => error.fmt(f),
            SequenceError::Cache(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SequenceError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            SequenceError::Build(error) => error.source(),
            SequenceError::Cache(error) => error.source(),
        }
    }
}

/// Which frame it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameLabel {
    /// Its number; those of a sequence ascend.
    pub number: i32,
    /// Its time in seconds, where it has one.
    pub time: Option<f32>,
    /// The source has no such frame: the one before it stands in for it.
    pub held: bool,
}

impl FrameLabel {
    fn record(&self) -> FrameRecord {
        let mut flags = if self.held { FrameRecord::HELD } else { 0 };
        flags |= self.time.map_or(0, |_| FrameRecord::TIMED);
        let time = self.time.unwrap_or(0.0) + 0.0; // -0.0 becomes +0.0
        FrameRecord { number: self.number, placement: 0, time, flags, reserved: [0; 4] }
    }
}

/// What became of a frame's meshes.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct FrameOutcome {
    /// The frame's number.
    pub number: i32,
    /// Meshes that stand as in a frame before: nothing is stored.
    pub same: u64,
    /// Meshes whose tree was refitted.
    pub refitted: u64,
    /// Meshes whose tree was built for this frame.
    pub built: u64,
    /// Meshes that stand as in the file that was there before, and were taken from it.
    pub taken: u64,
    /// Meshes whose faces are cut into triangles otherwise than in the first frame that shows them, since that cut would leave them: their trees are others.
    pub own_cuts: u64,
    /// Instances.
    pub instances: u64,
    /// Triangles that rays can hit, those of every instance counted.
    pub instanced_triangles: u64,
    /// Largest of the meshes' SAH costs, as they are or over what the triangles alone cost, relative to those in the poses that the tree was made for; 0 where
    /// nothing was refitted.
    pub worst_ratio: f32,
    /// Bytes that the file grew by, its tables apart.
    pub bytes: u64,
    /// What putting the meshes where they stand cost.
    pub placing: Placing,
}

/// A sequence that is being built, frame after frame.
pub struct SequenceBuilder<'a> {
    options: BuildOptions,
    policy: RefitPolicy,
    exec: &'a Executor,
    progress: &'a dyn Progress,
    writer: SequenceWriter<'a>,
    /// By what the poses share.
    shapes: BTreeMap<[u8; 32], Shape>,
    /// Poses by topology and geometry.
    poses: BTreeMap<([u8; 32], [u8; 32]), u32>,
    cuts: Cuts,
    /// Trees that were made for the whole animation.
    surveyed: u64,
    /// Frames that were added.
    added: usize,
    /// What is taken from an earlier build.
    taking: Option<Taking>,
}

impl<'a> SequenceBuilder<'a> {
    /// Begin a file at `path`. Trees are built as `options` say, always with a top level.
    ///
    /// # Errors
    /// Where the options contradict each other, or no file can be made beside `path`.
    pub fn new(
        path: &Path,
        options: &BuildOptions,
        policy: RefitPolicy,
        codec: Codec,
        exec: &'a Executor,
        progress: &'a dyn Progress,
    ) -> Result<SequenceBuilder<'a>, SequenceError> {
        options.validate()?;
        Ok(SequenceBuilder {
            options: BuildOptions { levels: Levels::Two, ..options.clone() },
            policy,
            exec,
            progress,
            writer: SequenceWriter::new(path, codec, exec)?,
            shapes: BTreeMap::new(),
            poses: BTreeMap::new(),
            cuts: Cuts::default(),
            surveyed: 0,
            added: 0,
            taking: None,
        })
    }

    /// Make trees for the whole animation out of some of its frames, before the first one is [added](SequenceBuilder::add). Meshes that move in these get at
    /// most so many trees, of which each frame takes the best; they are those of [`keyed`](crate::build::motion::keyed).
    ///
    /// A tree that is made so costs less on average than that of any frame. About 20 frames, spread evenly, are enough: all of them are held in memory.
    ///
    /// # Errors
    /// Where a scene cannot be built.
    pub fn survey(&mut self, frames: Vec<Scene>, trees: Trees) -> Result<(), SequenceError> {
        let mut survey = Survey::default();
        for laid in self.exec.map(frames, |_, scene| compile::lay_out(scene, &self.options, self.exec)) {
            let mut meshes = laid?.meshes;
            meshes.iter_mut().for_each(|mesh| _ = self.cuts.apply(mesh));
            survey.add(meshes);
        }
        for (topology, shape, trees) in survey.shapes(trees, &self.options, self.policy, self.exec, self.progress)? {
            self.shapes.insert(topology, shape);
            self.surveyed += trees;
        }
        Ok(())
    }

    /// How many trees [`SequenceBuilder::survey`] made.
    pub fn surveyed(&self) -> u64 {
        self.surveyed
    }

    /// Add the next frame.
    ///
    /// Triangles without area in this frame may have one in another: a scene that is read to become a frame should keep them
    /// ([`Degenerate::Keep`](crate::scene::Degenerate::Keep)), or its triangles are others than the frames' before.
    ///
    /// # Errors
    /// Where the scene cannot be built, or the file cannot be written.
    pub fn add(&mut self, scene: Scene, label: FrameLabel) -> Result<FrameOutcome, SequenceError> {
        let laid = compile::lay_out(scene, &self.options, self.exec)?;
        let index = self.added;
        self.added += 1;
        self.add_laid(index, laid, label)
    }

    /// What prepares frames for this file.
    pub fn preparer(&self) -> Preparer<'a> {
        Preparer { options: self.options.clone(), exec: self.exec }
    }

    /// [`SequenceBuilder::add`] of a frame that was prepared before; `None` where its model is to be read after all.
    ///
    /// # Errors
    /// As [`SequenceBuilder::add`].
    fn add_prepared(&mut self, frame: PreparedFrame, label: FrameLabel) -> Result<Option<FrameOutcome>, SequenceError> {
        let index = self.added;
        let outcome = match frame.0 {
            Some(laid) => Some(self.add_laid(index, laid, label)?),
            None => self.take(index, label)?,
        };
        self.added += usize::from(outcome.is_some());
        Ok(outcome)
    }

    fn add_laid(&mut self, index: usize, mut laid: LaidOut, label: FrameLabel) -> Result<FrameOutcome, SequenceError> {
        let faces: Vec<Faces> = laid.meshes.iter_mut().map(|mesh| self.cuts.apply(mesh)).collect();
        let mut outcome = FrameOutcome { number: label.number, placing: laid.placing, ..FrameOutcome::default() };
        let mut poses = Vec::with_capacity(laid.meshes.len());
        outcome.own_cuts = faces.iter().filter(|faces| **faces == Faces::OwnCut).count() as u64;
        for (mesh, faces) in laid.meshes.iter().zip(faces) {
            let topology = topology_hash(mesh);
            let pose = self.pose(mesh, topology, &mut outcome)?;
            self.learn(index, pose, topology, mesh, faces == Faces::First);
            poses.push(pose);
        }
        let instances = laid.instances.unwrap_or_default();
        outcome.instances = instances.len() as u64;
        outcome.instanced_triangles =
            instances.iter().map(|i| laid.meshes[i.mesh as usize].triangles.len() as u64).sum();

        // Each instance's box in the world, by the transform as the file holds it.
        let mut boxes = Vec::with_capacity(instances.len());
        for (index, instance) in instances.iter().enumerate() {
            let PoseRecord { min, max, .. } = self.writer.poses()[poses[instance.mesh as usize] as usize];
            let world = Affine::from_f32(&instance.transform.to_f32()).transform_box(&Aabb { min, max });
            if !world.is_valid() {
                return Err(BuildError::OutOfRange { instance: index, mesh: instance.mesh }.into());
            }
            boxes.push(world);
        }
        let top = tlas::build(&boxes, self.exec);
        let records: Vec<_> = top
            .refs
            .iter()
            .map(|&id| {
                let instance = &instances[id as usize];
                instance_record(instance, poses[instance.mesh as usize], id)
            })
            .collect();
        outcome.bytes = self.writer.frame(label.record(), &top.nodes, &records)?;
        Ok(outcome)
    }

    /// The number of the pose in which a mesh stands.
    fn pose(&mut self, mesh: &Mesh, topology: [u8; 32], outcome: &mut FrameOutcome) -> Result<u32, SequenceError> {
        let key = (topology, geometry_hash(mesh));
        if let Some(pose) = self.poses.get(&key) {
            outcome.same += 1;
            return Ok(*pose);
        }
        let shape = self.shapes.entry(topology).or_insert_with(|| Shape::new(self.policy));
        let fitted = match shape.refit(mesh, self.exec) {
            Some(fitted) => Ok(fitted),
            None => {
                let (tree, _) = compile::decide_sound(mesh, &self.options, self.exec, self.progress)?;
                shape.judge(mesh, tree, self.exec)
            }
        };
        let pose = match fitted {
            Ok(fitted) => {
                outcome.refitted += 1;
                outcome.worst_ratio = outcome.worst_ratio.max(fitted.ratio);
                shape.write_refit(mesh, fitted, &mut self.writer, self.exec)
            }
            Err(built) => {
                outcome.built += 1;
                shape.write_built(mesh, built, &mut self.writer, self.exec)
            }
        };
        self.poses.insert(key, pose);
        Ok(pose)
    }

    /// Write the file.
    ///
    /// # Errors
    /// Where it cannot be written, or holds more than a file may.
    pub fn finish(self, meta: &Meta) -> Result<WriteSummary, SequenceError> {
        // Some systems do not put a file in the place of one that is open.
        drop(self.taking);
        Ok(self.writer.finish(meta)?)
    }
}
