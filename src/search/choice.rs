//! The record of a search: what was tried, what was seen, what was taken and why, for META's notes.

use super::recipes::Rung;
use crate::build::{BuildOptions, Method};

/// One recipe that was tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    pub(super) rung: Rung,
    /// What a probe ray costs in its tree: 1.2 · nodes + triangles.
    pub cost: f64,
    /// Its tree's references.
    pub references: u64,
}

impl Trial {
    /// The recipe's name, as META's notes have it.
    pub fn name(&self) -> &'static str {
        self.rung.name()
    }
}

/// What a search did for one mesh.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Choice {
    /// The search that was asked for: `auto` or `best`.
    pub method: Method,
    /// Of the mesh.
    pub triangles: u64,
    /// Probe rays that every tree was asked with; 0 if none were, because the mesh is small or the cameras saw nothing of it.
    pub rays: u64,
    /// End-point overlap of the first tree as a share of its SAH, if that was looked at.
    pub overlap: Option<f64>,
    /// In the order of trying; one without figures if nothing was measured.
    pub trials: Vec<Trial>,
    /// Which of the trials was taken.
    pub taken: usize,
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
            overlap: None,
            trials: vec![Trial { rung, cost: f64::NAN, references: 0 }],
            taken: 0,
            options: rung.options(options, 0),
            reason,
        }
    }

    /// The name of the recipe that was taken.
    pub fn recipe(&self) -> &'static str {
        self.trials.get(self.taken).map_or("nothing", Trial::name)
    }

    fn sentences(&self) -> Vec<String> {
        let mut out = vec![format!("took {} for {} triangles ({})", self.recipe(), self.triangles, self.reason)];
        if self.trials.iter().any(|t| t.cost.is_finite()) {
            let unit = if self.rays > 0 { format!("cost of {} probe rays", self.rays) } else { "SAH".to_string() };
            let per_triangle = |t: &Trial| t.references as f64 / self.triangles.max(1) as f64;
            let tried = |t: &Trial| match per_triangle(t) {
                copies if copies > 1.0 => format!("{} {:.2} at {copies:.3} references a triangle", t.name(), t.cost),
                _ => format!("{} {:.2}", t.name(), t.cost),
            };
            let overlap = self.overlap.map_or_else(String::new, |share| {
                format!("; overlap {:.1} % of the SAH after {}", share * 100.0, self.trials[0].name())
            });
            let trials: Vec<String> = self.trials.iter().map(tried).collect();
            out.push(format!("tried, by {unit}: {}{overlap}", trials.join(", ")));
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
