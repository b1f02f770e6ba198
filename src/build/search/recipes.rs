//! What a search can try, each a recipe that a user could ask for by its flags.

use crate::build::recipe::options::{BuildOptions, Method, Preset};

/// Most rounds of reinsertion: the eighth still gains a little, later ones next to nothing.
const ROUNDS: u32 = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rung {
    Sweep,
    SweepMoved,
    AgglomerativeMoved,
    Sbvh,
    SbvhMoved,
}

impl Rung {
    pub fn of(method: Method) -> &'static [Rung] {
        match method {
            Method::Auto => &[Rung::Sweep, Rung::SweepMoved, Rung::Sbvh, Rung::SbvhMoved],
            _ => &[Rung::Sbvh, Rung::SbvhMoved, Rung::Sweep, Rung::SweepMoved, Rung::AgglomerativeMoved],
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Rung::Sweep => "sweep",
            Rung::SweepMoved => "sweep + 8 rounds",
            Rung::AgglomerativeMoved => "agglomerative + 8 rounds",
            Rung::Sbvh => "sbvh",
            Rung::SbvhMoved => "sbvh + 8 rounds",
        }
    }

    /// The recipe, with what the user may set for a search: costs, leaves, the budget for duplicates, levels.
    pub fn options(self, asked: &BuildOptions) -> BuildOptions {
        let (method, reinsert) = match self {
            Rung::Sweep => (Method::Sweep, 0),
            Rung::SweepMoved => (Method::Sweep, ROUNDS),
            Rung::AgglomerativeMoved => (Method::Agglomerative, ROUNDS),
            Rung::Sbvh => (Method::Sbvh, 0),
            Rung::SbvhMoved => (Method::Sbvh, ROUNDS),
        };
        BuildOptions {
            method,
            reinsert,
            max_leaf: asked.max_leaf,
            traversal_cost: asked.traversal_cost,
            intersection_cost: asked.intersection_cost,
            split_budget: asked.split_budget,
            levels: asked.levels,
            ..BuildOptions::preset(Preset::Auto)
        }
    }
}
