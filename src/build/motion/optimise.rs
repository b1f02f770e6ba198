//! One tree for several frames: its subtrees are moved to where they cost least on average.

use super::cost::half_area;
use super::frames::Motion;
use super::representatives::Pose;
use crate::build::error::BuildError;
use crate::build::passes::{MOST_POSES, ScaledPose, over_poses};
use crate::build::progress::Progress;
use crate::build::recipe::options::BuildOptions;
use crate::exec::Executor;
use crate::tree::{Tree, refit_built};

/// Move a tree's subtrees, in at most `options.reinsert` rounds, so that the mean of its SAH over the poses falls, and make leaves of subtrees where that
/// is cheaper on average (Bittner and Meister, "T-SAH: Animation Optimized Bounding Volume Hierarchies", 2015).
///
/// A pose counts by its weight. At most the first 16 poses are heeded, each of which costs memory and time in proportion. By their mean the result is not
/// worse than the tree. Its boxes are fitted to the first pose, also where nothing could be moved. It does not depend on the number of threads.
///
/// A tree with one triangle in each leaf gives the best result: leaves are then put together anew, `options.max_leaf` triangles at most.
///
/// # Errors
/// Where `progress` cancels.
///
/// # Panics
/// Where a pose names a frame that is not there, or the tree is none over the triangles of `motion`.
pub fn optimise(
    tree: &Tree,
    motion: &Motion,
    poses: &[Pose],
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Tree, BuildError> {
    let Some(first) = poses.first() else { return Ok(tree.clone()) };
    let poses = poses[..poses.len().min(MOST_POSES)].to_vec();
    let scaled: Vec<(usize, ScaledPose)> =
        exec.map(poses, |_, pose| scaled(motion, pose)).into_iter().flatten().collect();
    let (frames, scaled): (Vec<usize>, Vec<ScaledPose>) = scaled.into_iter().unzip();
    let mut start = tree.clone();
    // The tree is taken apart where it has an area; which it is does not matter.
    if !(half_area(&start.bounds()) > 0.0) {
        fit(&mut start, motion, *frames.first().unwrap_or(&first.frame));
    }
    let mut tree = over_poses(&start, motion.triangles(), &scaled, options, exec, progress)?.unwrap_or(start);
    fit(&mut tree, motion, first.frame);
    Ok(tree)
}

/// Fit a tree's boxes to a frame.
pub(super) fn fit(tree: &mut Tree, motion: &Motion, frame: usize) {
    let refs = &tree.refs;
    refit_built(&mut tree.nodes, |slot| motion.corners(frame, refs[slot] as usize), &Executor::sequential());
}

/// A pose with the root's area as the unit; `None` where that is none, or where the pose weighs nothing.
fn scaled<'a>(motion: &Motion<'a>, pose: Pose) -> Option<(usize, ScaledPose<'a>)> {
    let bounds = motion.bounds(pose.frame);
    let scale = (pose.weight / half_area(&bounds)).sqrt();
    let positions = motion.positions(pose.frame);
    (scale.is_finite() && scale > 0.0).then_some((pose.frame, ScaledPose { positions, scale, origin: bounds.min }))
}
