//! Trees for a whole animation: one for all frames, or a few of which each frame takes the one that suits it best.
//!
//! ```text
//! frames ─ medoids of poses ─▶ a tree of each ─ optimised over the frames around it ─▶ candidates
//!                                              costs of each candidate in each frame ─▶ the set with the least mean
//! ```

use super::cost::{costs, triangle_cost};
use super::frames::Motion;
use super::medoids::{Choice, choose};
use super::optimise::optimise;
use super::representatives::{Pose, distances, most_poses, standing_for, thinned};
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
/// Those of a tree that serves a part: three trees are made in its place, and two rounds more gain two tenths of one per cent.
const ROUNDS_OF_PART: u32 = 6;
/// Parts that [`Trees::Auto`] tries.
const MOST_PARTS: usize = 3;
/// Each further tree must lower the mean cost by about this share, since a file has to hold it.
const PRICE: f64 = 0.005;

/// How many trees an animation gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Trees {
    /// At most so many; 0 is taken for 1.
    AtMost(usize),
    /// One to three: more only if each further one lowers the mean cost by half a per cent.
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

/// Trees for all frames, such that the mean over the frames of the SAH, each divided by what its [triangles alone cost](triangle_cost), is low. So no frame
/// counts for more because its box is small. `progress` is told of phases, not of primitives. Of `options` the costs and `max_leaf` are read; the trees have no duplicates.
///
/// All positions must be in memory. Where they do not fit, take [`representatives`](super::representatives) of what fits, [`optimise`] over these, ask
/// [`cost`](super::cost) frame by frame, and [`choose`] by what it says.
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
    let progress = &Uncounted(progress);
    progress.phase("motion: poses");
    let units = exec.map_range(motion.frames(), |frame| match triangle_cost(motion, frame, options) {
        unit if unit > 0.0 => unit,
        _ => 1.0,
    });
    let apart = distances(motion, &frames, exec);
    let medoids = choose(&apart, if parts > 1 { parts } else { STARTS });
    let builder = Builder { motion, frames, apart, units: &units, options, exec, progress };
    let all: Vec<usize> = (0..builder.frames.len()).collect();
    let starts =
        medoids.kept.iter().map(|&i| builder.start(builder.frames[i])).collect::<Result<Vec<Tree>, BuildError>>()?;
    let mut candidates = Vec::new();
    if parts == 1 || trees == Trees::Auto {
        candidates.push(builder.fitted(&starts, &all, POSES, ROUNDS)?);
    }
    if parts > 1 {
        // A start is not needed any more once its part has a tree.
        for (part, start) in starts.into_iter().enumerate() {
            let served: Vec<usize> = all.iter().copied().filter(|i| medoids.serves[*i] == part).collect();
            candidates.push(builder.fitted(&[start], &served, POSES_OF_PART, ROUNDS_OF_PART)?);
        }
    }
    progress.phase("motion: costs");
    let costs = costs(&candidates, motion, options, exec);
    let in_units = |(row, unit): (&Vec<f64>, &f64)| row.iter().map(|cost| cost / unit).collect();
    let comparable: Vec<Vec<f64>> = costs.iter().zip(&units).map(in_units).collect();
    let choice = match trees {
        Trees::AtMost(most) => choose(&comparable, most.max(1)),
        Trees::Auto => worthwhile(&comparable),
    };
    Ok(Keyed::of(candidates, &costs, choice))
}

/// The choice whose mean cost is lowest once each further tree is paid for.
fn worthwhile(costs: &[Vec<f64>]) -> Choice {
    let paid = |choice: &Choice| choice.mean * (1.0 + PRICE * choice.kept.len() as f64);
    let choices = (1..=MOST_PARTS).map(|most| choose(costs, most));
    choices.reduce(|a, b| if paid(&b) < paid(&a) { b } else { a }).unwrap_or_default()
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

/// Several trees are built of each triangle, so it is not told how many are done.
struct Uncounted<'a>(&'a dyn Progress);

impl Progress for Uncounted<'_> {
    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }

    fn phase(&self, name: &'static str) {
        self.0.phase(name);
    }
}

struct Builder<'a> {
    motion: &'a Motion<'a>,
    /// Those that trees are made for.
    frames: Vec<usize>,
    /// How far each of them is from each.
    apart: Vec<Vec<f64>>,
    /// By frame, what costs are divided by before those of several frames are added.
    units: &'a [f64],
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

    /// The start that costs least over some of the frames, optimised for them in so many rounds.
    fn fitted(&self, starts: &[Tree], some: &[usize], most: usize, rounds: u32) -> Result<Tree, BuildError> {
        let most = most.min(most_poses(self.motion.triangles().len()));
        let frames: Vec<usize> = some.iter().map(|i| self.frames[*i]).collect();
        let apart = || some.iter().map(|a| some.iter().map(|b| self.apart[*a][*b]).collect()).collect();
        let mut poses = standing_for(&frames, most, apart);
        poses.iter_mut().for_each(|pose| pose.weight /= self.units[pose.frame]);
        let options = BuildOptions { reinsert: rounds, ..self.options.clone() };
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
