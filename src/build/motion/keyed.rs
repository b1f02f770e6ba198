//! Trees for a whole animation: one for all frames, or a few of which each frame takes the one that suits it best.
//!
//! ```text
//! frames ─ medoids of poses ─▶ a tree of each ─ optimised over the frames around it ─▶ candidates
//!                                              costs of each candidate in each frame ─▶ the set with the least mean
//! ```

use super::cost::costs;
use super::frames::Motion;
use super::medoids::{Choice, choose};
use super::optimise::optimise;
use super::representatives::{Pose, distances, most_poses, representatives, thinned};
use crate::build::error::BuildError;
use crate::build::initial_tree;
use crate::build::progress::Progress;
use crate::build::recipe::options::{BuildOptions, Method, Preset};
use crate::exec::Executor;
use crate::scene::Mesh;
use crate::tree::Tree;

/// Frames whose trees are tried as the start of a tree for all.
const STARTS: usize = 3;
/// Poses that a tree for all frames is fitted to. More gain next to nothing.
const POSES: usize = 8;
/// Poses of a tree that serves a part of the frames, which resemble each other.
const POSES_OF_PART: usize = 4;
/// Rounds of reinsertion: six are one per cent worse, sixteen gain a tenth of one.
const ROUNDS: u32 = 8;
/// Parts that [`Trees::Auto`] tries.
const MOST_PARTS: usize = 3;
/// A further tree must lower the mean cost by this share, since a file has to hold it.
const LEAST_GAIN: f64 = 0.01;

/// How many trees an animation gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Trees {
    /// At most so many; 0 is taken for 1.
    AtMost(usize),
    /// One to three: a further one only if it lowers the mean cost by one per cent.
    Auto,
}

/// Trees and which of them serves each frame.
#[derive(Clone, Debug, Default)]
pub struct Keyed {
    /// The trees. Each serves some frame, and its boxes are fitted to some frame.
    pub trees: Vec<Tree>,
    /// By frame, the number of its tree.
    pub serves: Vec<usize>,
    /// By frame, the SAH of that tree fitted to the frame, with the options' costs.
    pub costs: Vec<f64>,
}

/// Trees for all frames, such that the mean over the frames of the SAH is low. Of `options` the costs and `max_leaf` are read; the trees have no duplicates.
///
/// All positions must be in memory. Where they do not fit, take [`representatives`] of what fits, [`optimise`] over these, ask [`cost`](super::cost) frame by
/// frame, and [`choose`] by what it says.
///
/// # Errors
/// Where the tree would have more references than there are numbers for, or `progress` cancels.
pub fn keyed(
    motion: &Motion,
    trees: Trees,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Keyed, BuildError> {
    let parts = match trees {
        Trees::AtMost(most) => most.max(1),
        Trees::Auto => MOST_PARTS,
    };
    let frames = thinned(motion.frames());
    if frames.is_empty() {
        return Ok(Keyed::default());
    }
    let builder = Builder { motion, options, exec, progress };
    progress.phase("motion: poses");
    let apart = distances(motion, &frames, exec);
    let mut candidates = Vec::new();
    if parts == 1 || trees == Trees::Auto {
        let starts = choose(&apart, STARTS).kept.into_iter().map(|i| builder.start(frames[i]));
        let starts = starts.collect::<Result<Vec<Tree>, BuildError>>()?;
        candidates.push(builder.fitted(&starts, &frames, POSES)?);
    }
    if parts > 1 {
        let choice = choose(&apart, parts);
        for (part, &medoid) in choice.kept.iter().enumerate() {
            let served = frames.iter().zip(&choice.serves).filter(|(_, serves)| **serves == part);
            let served: Vec<usize> = served.map(|(frame, _)| *frame).collect();
            candidates.push(builder.fitted(&[builder.start(frames[medoid])?], &served, POSES_OF_PART)?);
        }
    }
    progress.phase("motion: costs");
    let costs = costs(&candidates, motion, options, exec);
    let choice = match trees {
        Trees::AtMost(most) => choose(&costs, most.max(1)),
        Trees::Auto => worthwhile(&costs, MOST_PARTS),
    };
    Ok(Keyed::of(candidates, &costs, choice))
}

/// The choice with the fewest candidates that another one does not make better by [`LEAST_GAIN`].
fn worthwhile(costs: &[Vec<f64>], most: usize) -> Choice {
    let mut best = choose(costs, 1);
    for count in 2..=most {
        let next = choose(costs, count);
        if next.mean > best.mean * (1.0 - LEAST_GAIN) {
            break;
        }
        best = next;
    }
    best
}

impl Keyed {
    fn of(candidates: Vec<Tree>, costs: &[Vec<f64>], choice: Choice) -> Keyed {
        // One that is the cheapest nowhere is left out.
        let is_used = |i: &usize| choice.serves.contains(i);
        let used: Vec<usize> = (0..choice.kept.len()).filter(is_used).map(|i| choice.kept[i]).collect();
        let choice = Choice::of(costs, used);
        let by_frame = costs.iter().zip(&choice.serves).map(|(row, &i)| row[choice.kept[i]]).collect();
        let kept = candidates.into_iter().enumerate().filter(|(i, _)| choice.kept.contains(i));
        Keyed { trees: kept.map(|(_, tree)| tree).collect(), serves: choice.serves, costs: by_frame }
    }
}

struct Builder<'a> {
    motion: &'a Motion<'a>,
    options: &'a BuildOptions,
    exec: &'a Executor,
    progress: &'a dyn Progress,
}

impl Builder<'_> {
    /// A tree of one frame to start from, with one triangle in each leaf, so that every one can be moved.
    fn start(&self, frame: usize) -> Result<Tree, BuildError> {
        let BuildOptions { traversal_cost, intersection_cost, .. } = *self.options;
        let preset = BuildOptions::preset(Preset::Draft);
        let options = BuildOptions { method: Method::Sweep, max_leaf: 1, traversal_cost, intersection_cost, ..preset };
        let (positions, triangles) = (self.motion.positions(frame).to_vec(), self.motion.triangles().to_vec());
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        initial_tree(&mesh, &options, self.exec, self.progress)
    }

    /// The start that costs least over the frames, optimised for them.
    fn fitted(&self, starts: &[Tree], frames: &[usize], most: usize) -> Result<Tree, BuildError> {
        let most = most.min(most_poses(self.motion.triangles().len()));
        let poses = representatives(self.motion, frames, most, self.exec);
        let options = BuildOptions { reinsert: ROUNDS, ..self.options.clone() };
        let Some(start) = self.cheapest(starts, &poses) else { return Ok(Tree::default()) };
        optimise(start, self.motion, &poses, &options, self.exec, self.progress)
    }

    fn cheapest<'t>(&self, trees: &'t [Tree], poses: &[Pose]) -> Option<&'t Tree> {
        if let [only] = trees {
            return Some(only);
        }
        let rows = costs(trees, &self.motion.of(poses.iter().map(|pose| pose.frame)), self.options, self.exec);
        let sum = |t: usize| rows.iter().zip(poses).map(|(row, pose)| row[t] * pose.weight).sum::<f64>();
        let sums = (0..trees.len()).map(|t| (t, sum(t)));
        sums.reduce(|a, b| if b.1 < a.1 { b } else { a }).map(|(t, _)| &trees[t])
    }
}
