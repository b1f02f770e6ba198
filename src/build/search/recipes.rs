//! What a search can try, each a recipe that a user could ask for by its flags.

use crate::build::recipe::options::{BuildOptions, Method, Preset};

/// Most rounds of reinsertion: the eighth still gains a little, later ones next to nothing.
const ROUNDS: u32 = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rung {
    Sweep,
    SweepMoved,
    Sbvh,
    SbvhMoved,
    CoarseMoved,
}

impl Rung {
    pub const ALL: [Rung; 5] = [Rung::Sbvh, Rung::SbvhMoved, Rung::CoarseMoved, Rung::Sweep, Rung::SweepMoved];

    pub fn name(self) -> &'static str {
        match self {
            Rung::Sweep => "sweep",
            Rung::SweepMoved => "sweep + 8 rounds",
            Rung::Sbvh => "sbvh",
            Rung::SbvhMoved => "sbvh + 8 rounds",
            Rung::CoarseMoved => "coarse sbvh + 8 rounds",
        }
    }

    /// The recipe, with what the user may set for a search: costs, leaves, the budget for duplicates, levels.
    pub fn options(self, asked: &BuildOptions) -> BuildOptions {
        let (preset, method, reinsert) = match self {
            Rung::Sweep => (Preset::Auto, Method::Sweep, 0),
            Rung::SweepMoved => (Preset::Auto, Method::Sweep, ROUNDS),
            Rung::Sbvh => (Preset::Auto, Method::Sbvh, 0),
            Rung::SbvhMoved => (Preset::Auto, Method::Sbvh, ROUNDS),
            Rung::CoarseMoved => (Preset::Balanced, Method::Sbvh, ROUNDS),
        };
        let recipe = BuildOptions::preset(preset);
        BuildOptions {
            method,
            reinsert,
            max_leaf: asked.max_leaf,
            traversal_cost: asked.traversal_cost,
            intersection_cost: asked.intersection_cost,
            split_budget: if preset == Preset::Auto {
                asked.split_budget
            } else {
                asked.split_budget.min(recipe.split_budget)
            },
            levels: asked.levels,
            ..recipe
        }
    }
}
