//! One tree for several frames: its subtrees are moved to where they cost least on average.

use super::cost::{cost, half_area};
use super::motion::Motion;
use super::representatives::Pose;
use crate::build::error::BuildError;
use crate::build::passes::{MOST_POSES, ScaledPose, over_poses};
use crate::build::progress::Progress;
use crate::build::recipe::options::BuildOptions;
use crate::exec::Executor;
use crate::tree::{Tree, refit};

/// Move a tree's subtrees, in at most `options.reinsert` rounds, so that the mean of its SAH over the poses falls, and make leaves of subtrees where that
/// is cheaper on average (Bittner and Meister, "T-SAH: Animation Optimized Bounding Volume Hierarchies", 2015).
///
/// A pose counts by its weight. At most the first 16 poses are heeded, each of which costs bytes and time in proportion. The tree must be one over the
/// triangles of `motion`. The result is never worse by that mean; its boxes are fitted to the first pose. It depends on no number of threads.
///
/// # Errors
/// Where `progress` cancels.
pub fn optimise(
    tree: &Tree,
    motion: &Motion,
    poses: &[Pose],
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Tree, BuildError> {
    let poses = &poses[..poses.len().min(MOST_POSES)];
    let mut start = tree.clone();
    if let Some(pose) = poses.first() {
        fit(&mut start, motion, pose.frame);
    }
    let scaled: Vec<(usize, ScaledPose)> =
        exec.map(poses.to_vec(), |_, pose| scaled(motion, pose)).into_iter().flatten().collect();
    let (frames, scaled): (Vec<usize>, Vec<ScaledPose>) = scaled.into_iter().unzip();
    let Some(&first) = frames.first() else { return Ok(start) };
    // The tree is taken apart where it has an area.
    fit(&mut start, motion, first);
    let moved = over_poses(&start, motion.triangles(), &scaled, options, exec, progress)?;
    fit(&mut start, motion, poses[0].frame);
    let Some(mut moved) = moved else { return Ok(start) };
    let mean = |tree: &Tree| {
        let each = exec.map(poses.to_vec(), |_, pose| {
            pose.weight * cost(tree, |t| motion.corners(pose.frame, t), options)
        });
        each.into_iter().sum::<f64>()
    };
    if !(mean(&moved) < mean(&start)) {
        return Ok(start);
    }
    fit(&mut moved, motion, poses[0].frame);
    Ok(moved)
}

/// Fit a tree's boxes to a frame.
pub(super) fn fit(tree: &mut Tree, motion: &Motion, frame: usize) {
    let refs = &tree.refs;
    refit(&mut tree.nodes, |slot| motion.corners(frame, refs[slot] as usize));
}

/// A pose with the root's area as the unit; `None` where that is none, or where the pose weighs nothing.
fn scaled<'a>(motion: &Motion<'a>, pose: Pose) -> Option<(usize, ScaledPose<'a>)> {
    let bounds = motion.bounds(pose.frame);
    let scale = (pose.weight / half_area(&bounds)).sqrt();
    let positions = motion.positions(pose.frame);
    (scale.is_finite() && scale > 0.0).then_some((pose.frame, ScaledPose { positions, scale, origin: bounds.min }))
}
