//! How searches decide.

use super::choice::{Choice, Lead, Refusal, Trial};
use super::gauge::{Gauge, Measure, rays_for};
use super::progress::Silent;
use super::recipes::{Rung, Start, Start as S};
use super::tree::{guide_for, recipe_tree};
use super::verdict::{Alike, Costs, Regret, difference, harm, preferred, regrets};
use crate::build::passes::{self, Outcome};
use crate::build::{BuildError, BuildOptions, Progress};
use crate::exec::Executor;
use crate::scene::Mesh;
use crate::trace::probe::{Family, FamilyRays};
use crate::tree::Tree;

/// Where less than this share of the SAH is end-point overlap, boxes hardly reach over foreign surface, as on scans: moving has next to
/// nothing to repair.
const LITTLE_OVERLAP: f64 = 0.09;
/// Above it, moving alone does not repair it and is not tried.
const MUCH_OVERLAP: f64 = 0.35;
/// With fewer duplicates than this share of the triangles, cutting found next to nothing to do.
const FEW_DUPLICATES: f64 = 0.03;
/// `auto` takes the plainer of two trees whose regrets differ by no more than this. Where no tree suits everybody, the mean says more than who
/// has the worst …
const INDIFFERENT: Alike = Alike { worst: 0.02, mean: 0.01 };
/// … and `best` the one that its list names first, by less: that much is the luck of where rays start.
const ALIKE: Alike = Alike { worst: 0.01, mean: 0.005 };

/// Where the leader has no more regret than this, it is the best tree so far for everybody, and `auto` looks no further.
const NO_REGRET: f64 = 0.02;

/// A tree that costs so many times as much as the leader is not adapted: that gains a seventh where it gains much.
const HOPELESS: f64 = 1.15;

/// In small meshes a few large nodes decide what rays cost, and each recipe has its own luck with them: under this number of triangles
/// searches draw once more, `auto` only where some family would rather have another tree …
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
    let sweep = contest.build(S::Sweep)?;
    let overlap = contest.gauge.overlap_share(&sweep);
    contest.overlap = Some(overlap);
    contest.judge(S::Sweep.plain(), sweep);

    let sbvh = contest.build(S::Sbvh)?;
    let duplicates = sbvh.refs.len() as f64 / count as f64 - 1.0;
    let lost = contest.judge(S::Sbvh.plain(), sbvh);
    if overlap < LITTLE_OVERLAP {
        return Ok(format!("overlap under {} % leaves nothing to move or to adapt", percent(LITTLE_OVERLAP)));
    }
    let reason = if overlap < MUCH_OVERLAP && duplicates < FEW_DUPLICATES {
        drop(lost);
        contest.try_one(S::SweepMoved)?;
        format!("cutting found under {} % of the triangles worth it", percent(FEW_DUPLICATES))
    } else {
        let lost = contest.move_subtrees(S::SbvhMoved, lost)?;
        contest.adapt(S::SbvhMoved, lost)?;
        if count >= SMALL {
            "that was the last rung".to_string()
        } else if contest.regret() > NO_REGRET {
            contest.try_one(S::CoarseMoved)?;
            "that was the last rung".to_string()
        } else {
            format!("no family of rays is more than {} % better off in another tree", percent(NO_REGRET))
        }
    };
    contest.adapt_leader()?;
    Ok(reason)
}

/// `best`: every recipe of the list, the coarse one in small meshes alone.
pub fn try_all(contest: &mut Contest<'_>) -> Result<String, BuildError> {
    for [plain, moved] in [[S::Sbvh, S::SbvhMoved], [S::Sweep, S::SweepMoved]] {
        let tree = contest.build(plain)?;
        let lost = contest.judge(plain.plain(), tree);
        let lost = contest.move_subtrees(moved, lost)?;
        contest.adapt(moved, lost)?;
    }
    if contest.mesh.triangles.len() < SMALL {
        let lost = contest.try_one(S::CoarseMoved)?;
        contest.adapt(S::CoarseMoved, lost)?;
    }
    contest.adapt_leader()?;
    Ok("the whole list was tried".to_string())
}

pub(super) fn percent(share: f64) -> f64 {
    (share * 1e4).round() / 1e2
}

/// Trees of one mesh against each other.
pub struct Contest<'a> {
    pub mesh: &'a Mesh,
    pub gauge: Gauge<'a>,
    /// How many rays of each set the mesh is worth.
    rays: usize,
    /// What trees are adapted to, once one has been.
    forming: Option<FamilyRays>,
    /// By trial.
    measures: Vec<Measure>,
    refused: Vec<Refusal>,
    options: &'a BuildOptions,
    exec: &'a Executor,
    progress: &'a dyn Progress,
    indifferent: Alike,
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
        let rays = rays_for(mesh, exec);
        let gauge = Gauge::new(mesh, rays, exec).serving(options.purpose);
        Contest {
            mesh,
            gauge,
            rays,
            forming: None,
            measures: Vec::new(),
            refused: Vec::new(),
            options,
            exec,
            progress,
            indifferent: ALIKE,
            leader: None,
            overlap: None,
            trials: Vec::new(),
        }
    }

    fn recipe(&self, rung: Rung) -> BuildOptions {
        rung.options(self.options, self.rays)
    }

    fn build(&self, start: Start) -> Result<Tree, BuildError> {
        recipe_tree(self.mesh, &self.recipe(start.plain()), self.exec, self.progress)
    }

    fn try_one(&mut self, start: Start) -> Result<Option<Tree>, BuildError> {
        let tree = self.build(start)?;
        Ok(self.judge(start.plain(), tree))
    }

    /// Measure a tree. The one that does not lead afterwards is given up: the old leader at once, the new tree by handing it back.
    fn judge(&mut self, rung: Rung, tree: Tree) -> Option<Tree> {
        let measure = self.gauge.measure(&tree);
        self.enter(rung, measure, tree)
    }

    fn enter(&mut self, rung: Rung, measure: Measure, tree: Tree) -> Option<Tree> {
        let mean = |family| measure.cost.as_ref().and_then(|cost| cost.mean(family)).unwrap_or(f64::NAN);
        let families = Family::ALL.map(mean);
        self.trials.push(Trial { rung, cost: measure.mean(), families, references: tree.refs.len() as u64 });
        self.measures.push(measure);
        let last = self.trials.len() - 1;
        if self.leader.is_some() && preferred(&self.regrets(), self.indifferent) != last {
            return Some(tree);
        }
        self.leader = Some(Leader { trial: last, tree });
        None
    }

    /// The worst regret of the leader.
    fn regret(&self) -> f64 {
        self.leader.as_ref().map_or(0.0, |leader| self.regrets()[leader.trial].worst)
    }

    fn regrets(&self) -> Vec<Regret> {
        let costs: Vec<Costs> = self.trials.iter().map(|trial| (trial.families, trial.cost)).collect();
        regrets(&costs)
    }

    /// Measure what reinsertion makes of a tree that was judged last: `lost`, or the leader. Hands back what was judged last, unless it leads.
    fn move_subtrees(&mut self, to: Start, lost: Option<Tree>) -> Result<Option<Tree>, BuildError> {
        let options = self.recipe(to.plain());
        self.improve(to.plain(), &options, lost)
    }

    /// The same for what adaptation makes of a tree that the recipe otherwise ends with, if there is hope for it.
    fn adapt(&mut self, start: Start, lost: Option<Tree>) -> Result<(), BuildError> {
        let Some(leader) = &self.leader else { return Ok(()) };
        let (tree, before) = match &lost {
            Some(tree) => (tree, self.trials.len() - 1),
            None => (&leader.tree, leader.trial),
        };
        if self.trials[before].cost > HOPELESS * self.trials[leader.trial].cost {
            return Ok(());
        }
        let options = BuildOptions { reinsert: 0, ..self.recipe(start.adapted()) };
        let paid = &self.measures[before];
        let guide = guide_for(self.mesh, tree, paid, &mut self.forming, &options, self.exec, self.progress);
        let silent = Silent(self.progress);
        // What lost is given away, so that it need not be held beside what is made of it.
        let adapted = match lost {
            Some(lost) => match passes::run(lost, guide, &options, self.exec, &silent)? {
                Outcome::Same(_) => None,
                Outcome::Better(tree) => Some(tree),
            },
            None => passes::improved(&leader.tree, guide, &options, self.exec, &silent)?,
        };
        let Some(adapted) = adapted else { return Ok(()) };
        let measure = self.gauge.measure(&adapted);
        match harm(&self.measures[before], &measure) {
            Some(why) => self.refused.push(Refusal { rung: start.plain(), why }),
            None => drop(self.enter(start.adapted(), measure, adapted)),
        }
        Ok(())
    }

    /// Adapt the leader, unless that was tried or it is adapted.
    fn adapt_leader(&mut self) -> Result<(), BuildError> {
        let Some(leader) = &self.leader else { return Ok(()) };
        let Rung { start, adapted } = self.trials[leader.trial].rung;
        let is_refused = self.refused.iter().any(|refusal| refusal.rung.start == start);
        if adapted || is_refused || self.trials.iter().any(|trial| trial.rung == start.adapted()) {
            return Ok(());
        }
        self.adapt(start, None)
    }

    /// Hands back what was judged last, unless it leads.
    fn improve(&mut self, rung: Rung, options: &BuildOptions, lost: Option<Tree>) -> Result<Option<Tree>, BuildError> {
        let silent = Silent(self.progress);
        // What lost is given away, so that it need not be held beside what is made of it.
        let improved = match (lost, &self.leader) {
            (Some(lost), _) => match passes::run(lost, None, options, self.exec, &silent)? {
                Outcome::Same(lost) => return Ok(Some(lost)),
                Outcome::Better(tree) => Some(tree),
            },
            (None, Some(leader)) => passes::improved(&leader.tree, None, options, self.exec, &silent)?,
            (None, None) => None,
        };
        Ok(improved.and_then(|tree| self.judge(rung, tree)))
    }

    /// The tree to take, and the record. A tree that was given up may be the best after all, as what is best for each family is known in the
    /// end alone: then it is built anew.
    pub fn end(self, reason: String) -> Result<(Tree, Choice), BuildError> {
        let all = self.regrets();
        let taken = preferred(&all, self.indifferent);
        let recipe = self.trials.get(taken).map(|trial| self.recipe(trial.rung));
        drop(self.forming);
        let leader = self.leader.filter(|leader| leader.trial == taken);
        let tree = match (leader, &recipe) {
            (Some(leader), _) => leader.tree,
            (None, Some(recipe)) => recipe_tree(self.mesh, recipe, self.exec, &Silent(self.progress))?,
            (None, None) => Tree::default(),
        };
        let others = all.iter().enumerate().filter(|(i, _)| *i != taken);
        let next = others.min_by(|a, b| a.1.worst.total_cmp(&b.1.worst).then(a.0.cmp(&b.0))).map(|(i, _)| i);
        let lead = next.and_then(|trial| {
            let (over, error) = difference(&self.measures[trial], &self.measures[taken])?;
            Some(Lead { trial, over, error })
        });
        let (rays, families) = self.gauge.rays();
        let choice = Choice {
            method: self.options.method,
            triangles: self.mesh.triangles.len() as u64,
            rays: rays as u64,
            families,
            overlap: self.overlap,
            regrets: all,
            trials: self.trials,
            taken,
            lead,
            refused: self.refused,
            options: recipe.unwrap_or_else(|| self.options.clone()),
            reason,
        };
        Ok((tree, choice))
    }
}
