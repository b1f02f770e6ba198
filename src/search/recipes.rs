//! What a search can try, each a recipe that a user could ask for by its flags.

use crate::build::{BuildOptions, Method, Preset};

/// Most rounds of reinsertion: the eighth still gains a little, later ones next to nothing.
const ROUNDS: u32 = 8;

/// Trees are adapted to so many times as many rays as judge them: of most families only a part is used, so that all weigh the same.
const FORMING: u32 = 2;

/// Where a recipe starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    Sweep,
    SweepMoved,
    Sbvh,
    SbvhMoved,
    CoarseMoved,
}

/// A recipe: where it starts, and whether its tree is adapted to rays in the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rung {
    pub start: Start,
    pub adapted: bool,
}

use Start as S;

impl Start {
    pub const ALL: [Start; 5] = [S::Sbvh, S::SbvhMoved, S::CoarseMoved, S::Sweep, S::SweepMoved];

    pub const fn plain(self) -> Rung {
        Rung { start: self, adapted: false }
    }

    pub const fn adapted(self) -> Rung {
        Rung { start: self, adapted: true }
    }
}

impl Rung {
    pub fn name(self) -> &'static str {
        match (self.start, self.adapted) {
            (S::Sweep, false) => "sweep",
            (S::Sweep, true) => "sweep, adapted",
            (S::SweepMoved, false) => "sweep + 8 rounds",
            (S::SweepMoved, true) => "sweep + 8 rounds, adapted",
            (S::Sbvh, false) => "sbvh",
            (S::Sbvh, true) => "sbvh, adapted",
            (S::SbvhMoved, false) => "sbvh + 8 rounds",
            (S::SbvhMoved, true) => "sbvh + 8 rounds, adapted",
            (S::CoarseMoved, false) => "coarse sbvh + 8 rounds",
            (S::CoarseMoved, true) => "coarse sbvh + 8 rounds, adapted",
        }
    }

    /// The recipe for a mesh that is worth so many rays of each family, with what the user may set for a search: costs, leaves, the budget for duplicates, levels.
    pub fn options(self, asked: &BuildOptions, rays: usize) -> BuildOptions {
        let (preset, method, reinsert) = match self.start {
            S::Sweep => (Preset::Auto, Method::Sweep, 0),
            S::SweepMoved => (Preset::Auto, Method::Sweep, ROUNDS),
            S::Sbvh => (Preset::Auto, Method::Sbvh, 0),
            S::SbvhMoved => (Preset::Auto, Method::Sbvh, ROUNDS),
            S::CoarseMoved => (Preset::Balanced, Method::Sbvh, ROUNDS),
        };
        let recipe = BuildOptions::preset(preset);
        BuildOptions {
            method,
            reinsert,
            adapt: if self.adapted { FORMING * rays as u32 } else { 0 },
            max_leaf: asked.max_leaf,
            traversal_cost: asked.traversal_cost,
            intersection_cost: asked.intersection_cost,
            split_budget: if preset == Preset::Auto {
                asked.split_budget
            } else {
                asked.split_budget.min(recipe.split_budget)
            },
            levels: asked.levels,
            purpose: asked.purpose,
            ..recipe
        }
    }
}
