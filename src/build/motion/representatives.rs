//! A few frames that stand for all: those that others resemble.

use super::frames::Motion;
use super::medoids::choose;
use crate::build::passes::{MOST_POSES, bytes_per_node};
use crate::exec::Executor;

/// Triangles whose place tells poses from each other.
const ASKED: usize = 64;
/// Bytes that boxes of all poses may take, about.
const MOST_BYTES: usize = 256 << 20;
/// Frames of longer animations are thinned out evenly to so many before they are compared, since each is compared with each.
const MOST_COMPARED: usize = 512;

/// A frame and for how much of the animation it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The frame.
    pub frame: usize,
    /// How often it counts. Only ratios matter.
    pub weight: f64,
}

/// How many poses a mesh of so many triangles can be fitted to at once, within the memory that is set aside for it: 256 MiB, or what two poses take.
pub(super) fn most_poses(triangles: usize) -> usize {
    let nodes = triangles.saturating_mul(2).max(1);
    (2..=MOST_POSES).rev().find(|&n| nodes.saturating_mul(bytes_per_node(n)) <= MOST_BYTES).unwrap_or(2)
}

/// At most `most` of the given frames, each with the number of frames that resemble it most. They are medoids by how far some corners stand from where they stand in
/// other frames, so that frames which are alike share one. Ascending. All frames where they are few enough.
pub fn representatives(motion: &Motion, frames: &[usize], most: usize, exec: &Executor) -> Vec<Pose> {
    if frames.len() <= most {
        return standing_for(frames, most, Vec::new);
    }
    let frames: Vec<usize> = thinned(frames.len()).into_iter().map(|i| frames[i]).collect();
    standing_for(&frames, most, || distances(motion, &frames, exec))
}

/// The same of frames that are this far from each other, which is asked where they are too many.
pub(super) fn standing_for(frames: &[usize], most: usize, apart: impl FnOnce() -> Vec<Vec<f64>>) -> Vec<Pose> {
    if frames.len() <= most {
        return frames.iter().map(|&frame| Pose { frame, weight: 1.0 }).collect();
    }
    let choice = choose(&apart(), most);
    let mut poses: Vec<Pose> = choice.kept.iter().map(|&i| Pose { frame: frames[i], weight: 0.0 }).collect();
    choice.serves.iter().for_each(|&i| poses[i].weight += 1.0);
    poses
}

/// The numbers below `count`, or evenly some of them.
pub(super) fn thinned(count: usize) -> Vec<usize> {
    (0..count).step_by(count.div_ceil(MOST_COMPARED).max(1)).collect()
}

/// How far each frame is from each.
pub(super) fn distances(motion: &Motion, frames: &[usize], exec: &Executor) -> Vec<Vec<f64>> {
    let poses = exec.map(frames.to_vec(), |_, frame| corners(motion, frame));
    exec.map_range(frames.len(), |a| poses.iter().map(|b| distance(&poses[a], b)).collect())
}

/// Some corners, about the middle of the frame's box and as shares of its longest edge.
fn corners(motion: &Motion, frame: usize) -> Vec<[f64; 3]> {
    let bounds = motion.bounds(frame);
    let edge = |k: usize| f64::from(bounds.max[k]) - f64::from(bounds.min[k]);
    let longest = [0, 1, 2].map(edge).into_iter().fold(0.0, |a: f64, b| if b > a { b } else { a });
    let step = motion.triangles().len().div_ceil(ASKED).max(1);
    let place = |triangle: usize| {
        let corner = motion.corners(frame, triangle)[0];
        [0, 1, 2].map(|k| {
            let middle = 0.5 * (f64::from(bounds.max[k]) + f64::from(bounds.min[k]));
            if longest > 0.0 { (f64::from(corner[k]) - middle) / longest } else { 0.0 }
        })
    };
    (0..motion.triangles().len()).step_by(step).map(place).collect()
}

fn distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let apart = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|k| (a[k] - b[k]).abs()).sum::<f64>();
    a.iter().zip(b).map(apart).sum()
}
