//! How searches decide.

use super::choice::{Choice, Trial};
use super::gauge::Gauge;
use super::recipes::Rung;
use crate::build::compile_tree;
use crate::build::error::BuildError;
use crate::build::exec::Executor;
use crate::build::passes;
use crate::build::progress::Progress;
use crate::build::recipe::options::BuildOptions;
use crate::scene::Mesh;
use crate::tree::Tree;

/// Where less than this share of the SAH is end-point overlap, boxes hardly reach over foreign surface, as on scans: moving has next to
/// nothing to repair.
const LITTLE_OVERLAP: f64 = 0.09;
/// Above it, moving alone does not repair it and is not tried.
const MUCH_OVERLAP: f64 = 0.35;
/// With fewer duplicates than this share of the triangles, cutting found next to nothing to do.
const FEW_DUPLICATES: f64 = 0.03;
/// `auto` takes the plainer of two trees whose costs differ by no more than this share.
const INDIFFERENT: f64 = 0.01;

/// In small meshes a few large nodes decide what rays cost, and each recipe has its own luck with them: under this number of triangles
/// searches draw once more …
const SMALL: usize = 100_000;
/// … and under this `auto` tries everything, which takes a few milliseconds.
const TINY: usize = 1 << 13;

/// Trees that either search builds from the ground at most.
pub const MOST_BUILDS: u64 = 3;

/// `auto`: up from the cheapest recipe, until what is measured says that the rest cannot pay more than the margin. The reason is why it
/// stopped.
pub fn climb(contest: &mut Contest<'_>) -> Result<String, BuildError> {
    let count = contest.mesh.triangles.len();
    if count < TINY {
        try_all(contest)?;
        return Ok(format!("under {TINY} triangles the whole list costs next to nothing"));
    }
    contest.indifferent = INDIFFERENT;
    let sweep = contest.build(Rung::Sweep)?;
    let overlap = contest.gauge.overlap_share(&sweep);
    contest.overlap = Some(overlap);
    contest.judge(Rung::Sweep, sweep);

    let sbvh = contest.build(Rung::Sbvh)?;
    let duplicates = sbvh.refs.len() as f64 / count as f64 - 1.0;
    let lost = contest.judge(Rung::Sbvh, sbvh);
    if overlap < LITTLE_OVERLAP {
        return Ok(format!("overlap under {} % leaves nothing to move", percent(LITTLE_OVERLAP)));
    }
    if overlap < MUCH_OVERLAP && duplicates < FEW_DUPLICATES {
        drop(lost);
        contest.try_one(Rung::SweepMoved)?;
        return Ok(format!("cutting found under {} % of the triangles worth it", percent(FEW_DUPLICATES)));
    }
    contest.judge_moved(Rung::SbvhMoved, lost)?;
    if count < SMALL {
        contest.try_one(Rung::CoarseMoved)?;
    }
    Ok("that was the last rung".to_string())
}

/// `best`: every recipe of the list, the last one in small meshes alone.
pub fn try_all(contest: &mut Contest<'_>) -> Result<String, BuildError> {
    for [plain, moved] in [[Rung::Sbvh, Rung::SbvhMoved], [Rung::Sweep, Rung::SweepMoved]] {
        let tree = contest.build(plain)?;
        let lost = contest.judge(plain, tree);
        contest.judge_moved(moved, lost)?;
    }
    if contest.mesh.triangles.len() < SMALL {
        contest.try_one(Rung::CoarseMoved)?;
    }
    Ok("the whole list was tried".to_string())
}

pub(super) fn percent(share: f64) -> f64 {
    (share * 1e4).round() / 1e2
}

/// Trees of one mesh against each other.
pub struct Contest<'a> {
    pub mesh: &'a Mesh,
    pub gauge: Gauge<'a>,
    options: &'a BuildOptions,
    exec: &'a Executor,
    progress: &'a dyn Progress,
    /// By how much of its cost a later tree must be cheaper to take the lead.
    indifferent: f64,
    leader: Option<Leader>,
    overlap: Option<f64>,
    trials: Vec<Trial>,
}

struct Leader {
    trial: usize,
    tree: Tree,
}

impl<'a> Contest<'a> {
    pub fn new(
        mesh: &'a Mesh,
        options: &'a BuildOptions,
        exec: &'a Executor,
        progress: &'a dyn Progress,
    ) -> Contest<'a> {
        let gauge = Gauge::new(mesh, exec);
        Contest {
            mesh,
            gauge,
            options,
            exec,
            progress,
            indifferent: 0.0,
            leader: None,
            overlap: None,
            trials: Vec::new(),
        }
    }

    fn build(&self, rung: Rung) -> Result<Tree, BuildError> {
        compile_tree(self.mesh, &rung.options(self.options), self.exec, self.progress)
    }

    fn try_one(&mut self, rung: Rung) -> Result<(), BuildError> {
        let tree = self.build(rung)?;
        self.judge(rung, tree);
        Ok(())
    }

    /// Measure a tree. The one that does not lead afterwards is given up: the old leader at once, the new tree by handing it back.
    fn judge(&mut self, rung: Rung, tree: Tree) -> Option<Tree> {
        let cost = self.gauge.cost(&tree);
        let references = tree.refs.len() as u64;
        self.trials.push(Trial { rung, cost, references });
        let leads = match &self.leader {
            Some(leader) => cost < self.trials[leader.trial].cost * (1.0 - self.indifferent),
            None => true,
        };
        if !leads {
            return Some(tree);
        }
        self.leader = Some(Leader { trial: self.trials.len() - 1, tree });
        None
    }

    /// Measure what reinsertion makes of a tree that was judged last: `lost`, or the leader.
    fn judge_moved(&mut self, rung: Rung, lost: Option<Tree>) -> Result<(), BuildError> {
        let options = rung.options(self.options);
        let Some(plain) = lost.as_ref().or(self.leader.as_ref().map(|l| &l.tree)) else { return Ok(()) };
        let moved = passes::improved(plain, &options, self.exec, &Silent(self.progress))?;
        drop(lost);
        if let Some(moved) = moved {
            self.judge(rung, moved);
        }
        Ok(())
    }

    pub fn end(self, reason: String) -> (Tree, Choice) {
        let (taken, tree) = self.leader.map_or((0, Tree::default()), |leader| (leader.trial, leader.tree));
        let flags = self.trials.get(taken).map_or_else(String::new, |t| t.rung.options(self.options).as_flags());
        let choice = Choice {
            method: self.options.method,
            triangles: self.mesh.triangles.len() as u64,
            rays: self.gauge.rays() as u64,
            overlap: self.overlap,
            trials: self.trials,
            taken,
            flags,
            reason,
        };
        (tree, choice)
    }
}

/// Cancels as the other does and reports nothing.
struct Silent<'a>(&'a dyn Progress);

impl Progress for Silent<'_> {
    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }

    fn phase(&self, name: &'static str) {
        self.0.phase(name);
    }
}
