//! What the frames of a sequence are like: their trees, what those cost there, and what each frame added to the file.

#[cfg(feature = "cli")]
pub mod chart;
mod rays;

pub use rays::FrameRays;

use crate::build::{BuildError, BuildOptions, Progress};
use crate::cache::{CacheError, FrameRecord, Frames, PoseRecord};
use crate::exec::Executor;
use rays::Gauge;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// One frame of a sequence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameReport {
    /// Its number in the source.
    pub number: i32,
    /// Seconds; `None` where the frames have no times.
    pub time: Option<f32>,
    /// The source has no such frame: the one before it is shown.
    pub held: bool,
    /// Instances.
    pub instances: u64,
    /// Triangles that a ray can hit: each mesh counted as often as it stands in the frame.
    pub instanced_triangles: u64,
    /// Trees that it shows.
    pub trees: u64,
    /// Those that were built over the pose in which they are shown.
    pub built: u64,
    /// Counted from 0: a segment ends where a frame shows other topologies than the one before it.
    pub segment: u64,
    /// SAH cost, the mean over its trees weighted by the areas of their roots.
    pub sah: f64,
    /// That cost relative to what the same trees cost in the frames where each is cheapest.
    pub ratio: f64,
    /// What a ray costs ([`FrameRays::stored`]); `None` where none were traced.
    pub ray_cost: Option<f64>,
    /// What the same rays cost in trees that are built for the frame; `None` where none were.
    pub fresh_ray_cost: Option<f64>,
    /// How many times as much rays cost as in those; 1 where nothing is hit.
    pub ray_ratio: Option<f64>,
    /// Bytes of nodes and vertices that are stored for this frame first.
    pub bytes: u64,
}

/// All frames of a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SequenceReport {
    /// As it was given.
    pub path: String,
    /// Bytes.
    pub file_len: u64,
    /// Trees with different topologies.
    pub topologies: u64,
    /// Different poses of them.
    pub poses: u64,
    /// In ascending order of their numbers.
    pub frames: Vec<FrameReport>,
}

/// What is asked of each frame beside what the file says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Measure {
    /// Rays in each of three sets, about; 0 traces none.
    pub rays: usize,
    /// Whether trees are built for each frame, by the recipe that META has, and the same rays traced in them.
    pub fresh: bool,
}

/// Why there is no report.
#[derive(Debug)]
#[non_exhaustive]
pub enum FramesError {
    /// A frame could not be opened.
    Cache(CacheError),
    /// A frame's trees could not be built anew, or META's recipe is none that this version knows.
    Build(BuildError),
    /// There is no META, so nobody knows how the trees were built.
    NoRecipe,
}

impl From<CacheError> for FramesError {
    fn from(error: CacheError) -> FramesError {
        FramesError::Cache(error)
    }
}

impl From<BuildError> for FramesError {
    fn from(error: BuildError) -> FramesError {
        FramesError::Build(error)
    }
}

impl std::fmt::Display for FramesError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            FramesError::Cache(error) => error.fmt(f),
            FramesError::Build(error) => error.fmt(f),
            FramesError::NoRecipe => {
                f.write_str("cannot build frames anew: the file has no META, which has the recipe")
            }
        }
    }
}

impl std::error::Error for FramesError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            FramesError::Cache(error) => error.source(),
            FramesError::Build(error) => error.source(),
            FramesError::NoRecipe => None,
        }
    }
}

impl SequenceReport {
    /// Look at each frame once. `done` is told how many are.
    ///
    /// # Errors
    /// Where a frame cannot be opened, or its trees cannot be built anew.
    pub fn of(
        path: String,
        sequence: &Frames<'_>,
        measure: &Measure,
        exec: &Executor,
        progress: &dyn Progress,
        mut done: impl FnMut(u64),
    ) -> Result<SequenceReport, FramesError> {
        let fresh = match (measure.fresh, sequence.meta()) {
            (false, _) => None,
            (true, Some(meta)) => Some(BuildOptions::recorded(&meta.method, &meta.options)?),
            (true, None) => return Err(FramesError::NoRecipe),
        };
        let mut gauge = (measure.rays > 0).then(|| Gauge::new(measure.rays, fresh, exec, progress));
        // What was measured, by placement: frames that show the same are measured once.
        let mut measured: BTreeMap<u32, FrameRays> = BTreeMap::new();
        let mut shown: Option<BTreeSet<u32>> = None;
        let mut segment = 0;
        // What each topology costs where it costs least.
        let mut least: BTreeMap<u32, f32> = BTreeMap::new();
        for pose in sequence.poses() {
            let cost = least.entry(pose.topology).or_insert(pose.sah);
            *cost = cost.min(pose.sah);
        }
        let mut blocks_seen = 0;
        let frames = (0..sequence.frame_count()).map(|index| {
            if progress.is_cancelled() {
                return Err(BuildError::Cancelled.into());
            }
            let frame = sequence.frame_on(index, exec)?;
            let view = frame.view();
            let poses: Vec<&PoseRecord> =
                frame.poses().iter().filter_map(|pose| sequence.poses().get(*pose as usize)).collect();
            // In f64, where no area overflows.
            let area = |pose: &PoseRecord| {
                let [x, y, z] = [0, 1, 2].map(|a| f64::from(pose.max[a]) - f64::from(pose.min[a]));
                x * y + y * z + z * x
            };
            let weight: f64 = poses.iter().map(|pose| area(pose)).sum();
            let mean = |cost: &dyn Fn(&PoseRecord) -> f64| {
                let sum: f64 = poses.iter().map(|pose| area(pose) * cost(pose)).sum();
                if weight > 0.0 { sum / weight } else { 0.0 }
            };
            let sah = mean(&|pose| f64::from(pose.sah));
            let cheapest = mean(&|pose| least.get(&pose.topology).map_or(0.0, |sah| f64::from(*sah)));
            let FrameRecord { number, placement, time, flags, .. } = *frame.record();
            let rays = gauge.as_mut().map(|gauge| match measured.get(&placement) {
                Some(known) => Ok(*known),
                None => gauge.ask(&frame).inspect(|rays| _ = measured.insert(placement, *rays)),
            });
            let rays = rays.transpose()?;
            let topologies: BTreeSet<u32> = poses.iter().map(|pose| pose.topology).collect();
            if shown.as_ref().is_some_and(|before| *before != topologies) {
                segment += 1;
            }
            shown = Some(topologies);
            let last = poses.iter().map(|pose| pose.block as usize + 1).max().unwrap_or(0);
            let bytes = (blocks_seen..last).map(|block| sequence.block_bytes(block)).sum();
            blocks_seen = blocks_seen.max(last);
            let triangles = view.instances.iter().map(|i| u64::from(view.blases[i.blas as usize].prim_count));
            done(index as u64 + 1);
            Ok(FrameReport {
                number,
                time: (flags & FrameRecord::TIMED != 0).then_some(time),
                held: flags & FrameRecord::HELD != 0,
                instances: view.instances.len() as u64,
                instanced_triangles: triangles.sum(),
                trees: poses.len() as u64,
                built: poses.iter().filter(|pose| pose.flags & PoseRecord::KEY != 0).count() as u64,
                segment,
                sah,
                ratio: ratio(sah, cheapest),
                ray_cost: rays.map(|rays| rays.stored),
                fresh_ray_cost: rays.and_then(|rays| rays.fresh),
                ray_ratio: rays.and_then(|rays| Some(ratio(rays.stored, rays.fresh?))),
                bytes,
            })
        });
        Ok(SequenceReport {
            path,
            file_len: sequence.header().file_len,
            topologies: sequence.topologies().len() as u64,
            poses: sequence.poses().len() as u64,
            frames: frames.collect::<Result<_, FramesError>>()?,
        })
    }
}

fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 1.0 }
}
