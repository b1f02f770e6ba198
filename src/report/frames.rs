//! What the frames of a sequence are like: their trees, what those cost there, and what each frame added to the file.

use crate::cache::{CacheError, FrameRecord, Frames, PoseRecord};
use crate::exec::Executor;
use crate::geom::Aabb;
use serde::Serialize;
use std::collections::BTreeMap;

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
    pub triangles: u64,
    /// Trees that it shows.
    pub trees: u64,
    /// Those that were built over the pose in which they are shown.
    pub built: u64,
    /// SAH cost, the mean over its trees weighted by the areas of their roots.
    pub sah: f64,
    /// That cost relative to what the same trees cost in the frames where each is cheapest.
    pub ratio: f64,
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

impl SequenceReport {
    /// Look at each frame once.
    ///
    /// # Errors
    /// Where a frame cannot be opened.
    pub fn of(path: String, sequence: &Frames<'_>, exec: &Executor) -> Result<SequenceReport, CacheError> {
        // What each topology costs where it costs least.
        let mut least: BTreeMap<u32, f32> = BTreeMap::new();
        for pose in sequence.poses() {
            let cost = least.entry(pose.topology).or_insert(pose.sah);
            *cost = cost.min(pose.sah);
        }
        let mut blocks_seen = 0;
        let frames = (0..sequence.frame_count()).map(|index| {
            let frame = sequence.frame_on(index, exec)?;
            let view = frame.view();
            let poses: Vec<&PoseRecord> =
                frame.poses().iter().filter_map(|pose| sequence.poses().get(*pose as usize)).collect();
            let area = |pose: &PoseRecord| f64::from(Aabb { min: pose.min, max: pose.max }.half_area());
            let weight: f64 = poses.iter().map(|pose| area(pose)).sum();
            let mean = |cost: &dyn Fn(&PoseRecord) -> f64| {
                let sum: f64 = poses.iter().map(|pose| area(pose) * cost(pose)).sum();
                if weight > 0.0 { sum / weight } else { 0.0 }
            };
            let sah = mean(&|pose| f64::from(pose.sah));
            let cheapest = mean(&|pose| least.get(&pose.topology).map_or(0.0, |sah| f64::from(*sah)));
            let FrameRecord { number, time, flags, .. } = *frame.record();
            let last = poses.iter().map(|pose| pose.block as usize + 1).max().unwrap_or(0);
            let bytes = (blocks_seen..last).map(|block| sequence.block_bytes(block)).sum();
            blocks_seen = blocks_seen.max(last);
            let triangles = view.instances.iter().map(|i| u64::from(view.blases[i.blas as usize].prim_count));
            Ok(FrameReport {
                number,
                time: (flags & FrameRecord::TIMED != 0).then_some(time),
                held: flags & FrameRecord::HELD != 0,
                instances: view.instances.len() as u64,
                triangles: triangles.sum(),
                trees: poses.len() as u64,
                built: poses.iter().filter(|pose| pose.flags & PoseRecord::KEY != 0).count() as u64,
                sah,
                ratio: if cheapest > 0.0 { sah / cheapest } else { 1.0 },
                bytes,
            })
        });
        Ok(SequenceReport {
            path,
            file_len: sequence.header().file_len,
            topologies: sequence.topologies().len() as u64,
            poses: sequence.poses().len() as u64,
            frames: frames.collect::<Result<_, CacheError>>()?,
        })
    }
}
