//! The record of a search: what was tried, what was seen, what was taken and why, for META's notes.

use super::recipes::Rung;
use super::verdict::Regret;
use crate::build::{BuildOptions, Method};
use crate::trace::probe::{FAMILIES, Family};

/// One recipe that was tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    pub(super) rung: Rung,
    /// What a ray costs in its tree, the mean of the families: 1.2 · nodes + triangles.
    pub cost: f64,
    /// The same by family, in the order of [`Family::ALL`]; NaN where the family has no rays.
    pub families: [f64; FAMILIES],
    /// Its tree's references.
    pub references: u64,
}

impl Trial {
    /// The recipe's name, as META's notes have it.
    pub fn name(&self) -> &'static str {
        self.rung.name()
    }
}

/// A tree whose adaptation was not taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    pub(super) rung: Rung,
    /// Who would pay.
    pub why: String,
}

/// The tree that comes next to the one that was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lead {
    /// Which of the trials it is.
    pub trial: usize,
    /// By how much of its cost a ray pays more in it, the mean over the families; negative where another family's regret decided.
    pub over: f64,
    /// The standard error of that.
    pub error: f64,
}

/// What a search did for one mesh.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Choice {
    /// The search that was asked for: `auto` or `best`.
    pub method: Method,
    /// Of the mesh.
    pub triangles: u64,
    /// Rays that every tree was asked with; 0 if none were, because the mesh is small or has no surface.
    pub rays: u64,
    /// Families that they are of.
    pub families: usize,
    /// End-point overlap of the first tree as a share of its SAH, if that was looked at.
    pub overlap: Option<f64>,
    /// In the order of trying; one without figures if nothing was measured.
    pub trials: Vec<Trial>,
    /// What the rays of each trial pay beyond the best trial for them.
    pub regrets: Vec<Regret>,
    /// Which of the trials was taken.
    pub taken: usize,
    /// What came next to it; `None` if nothing was measured beside it.
    pub lead: Option<Lead>,
    /// Trees whose adaptation was not taken.
    pub refused: Vec<Refusal>,
    /// The recipe that was taken: it builds the same tree without a search.
    pub options: BuildOptions,
    /// Why nothing further was tried.
    pub reason: String,
}

/// Before the options of [`Choice::options`] in a note, which follow as `name=value`, the method first, with a space between them.
pub(crate) const NAMED_RECIPE: &str = "without the search: ";

/// Decisions that are written out; of more trees than that the largest.
const WRITTEN: usize = 4;

impl Choice {
    pub(super) fn unmeasured(rung: Rung, options: &BuildOptions, triangles: usize, reason: String) -> Choice {
        Choice {
            method: options.method,
            triangles: triangles as u64,
            rays: 0,
            families: 0,
            overlap: None,
            trials: vec![Trial { rung, cost: f64::NAN, families: [f64::NAN; FAMILIES], references: 0 }],
            regrets: Vec::new(),
            taken: 0,
            lead: None,
            refused: Vec::new(),
            options: rung.options(options, 0),
            reason,
        }
    }

    /// The name of the recipe that was taken.
    pub fn recipe(&self) -> &'static str {
        self.trials.get(self.taken).map_or("nothing", Trial::name)
    }

    /// What was measured, in sentences.
    fn measured(&self) -> Vec<String> {
        let unit = match self.rays {
            0 => "SAH".to_string(),
            rays => format!("{rays} rays of {} families, worst and mean regret", self.families),
        };
        let per_triangle = |t: &Trial| t.references as f64 / self.triangles.max(1) as f64;
        let figures = |trial: &Trial, regret: &Regret| match regret.family {
            None => format!("{} {:.2}", trial.name(), trial.cost),
            Some(family) => {
                let [worst, mean] = [regret.worst, regret.mean].map(|share| share * 100.0);
                format!("{} {worst:.1} % ({}) {mean:.1} %", trial.name(), family.name())
            }
        };
        let tried = |(trial, regret): (&Trial, &Regret)| match per_triangle(trial) {
            copies if copies > 1.0 => format!("{} at {copies:.3} references a triangle", figures(trial, regret)),
            _ => figures(trial, regret),
        };
        let overlap = self.overlap.map_or_else(String::new, |share| {
            format!("; overlap {:.1} % of the SAH after {}", share * 100.0, self.trials[0].name())
        });
        let trials: Vec<String> = self.trials.iter().zip(&self.regrets).map(tried).collect();
        let mut out = vec![format!("tried, by {unit}: {}{overlap}", trials.join(", "))];
        let refused = |r: &Refusal| format!("adaptation of {} was not taken: {}", r.rung.name(), r.why);
        out.extend(self.refused.iter().map(refused));
        if let Some(Lead { trial, over, error }) = self.lead {
            let [over, error] = [over, error].map(|share| share * 100.0);
            let name = self.trials[trial].name();
            out.push(format!("{name} comes next: its rays pay {over:+.1} ± {error:.1} % on average"));
        }
        let paid = self.trials[self.taken].families;
        let paid = Family::ALL.into_iter().zip(paid).filter(|(_, cost)| cost.is_finite());
        let paid: Vec<String> = paid.map(|(family, cost)| format!("{} {cost:.2}", family.name())).collect();
        if !paid.is_empty() {
            out.push(format!("a ray pays: {}", paid.join(", ")));
        }
        out
    }

    fn sentences(&self) -> Vec<String> {
        let mut out = vec![format!("took {} for {} triangles ({})", self.recipe(), self.triangles, self.reason)];
        if self.trials.iter().any(|t| t.cost.is_finite()) {
            out.extend(self.measured());
        }
        let named = self.options.effective().into_iter().map(|(name, value)| format!(" {name}={value}"));
        out.push(format!("{NAMED_RECIPE}method={}{}", self.options.method, named.collect::<String>()));
        out
    }
}

/// What META says about the choices for a scene's meshes, which stand in the order of the meshes.
pub fn notes(choices: &[Choice]) -> Vec<String> {
    let Some(first) = choices.first() else { return Vec::new() };
    let method = first.method;
    if let [only] = choices {
        return only.sentences().into_iter().map(|s| format!("{method}: {s}")).collect();
    }

    // How often each recipe was taken, in the order of first use, and the largest trees one by one.
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for choice in choices {
        match counts.iter_mut().find(|(name, _)| *name == choice.recipe()) {
            Some((_, n)) => *n += 1,
            None => counts.push((choice.recipe(), 1)),
        }
    }
    let counts: Vec<String> = counts.iter().map(|(name, n)| format!("{name} for {n}")).collect();
    let mut notes = vec![format!("{method}: of {} trees took {}", choices.len(), counts.join(", "))];
    let mut order: Vec<usize> = (0..choices.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(choices[i].triangles), i));
    for &i in order.iter().take(WRITTEN) {
        notes.extend(choices[i].sentences().into_iter().map(|s| format!("{method}, tree {i}: {s}")));
    }
    notes
}
