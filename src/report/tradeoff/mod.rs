//! What trees take to build against what rays cost in them: the recipes of one scene beside each other.
//!
//! `recipe` says what is tried and in which order, `measure` builds in rounds and traces, `times` sums rounds up and tells which recipes they cannot
//! tell apart, `chart` draws. `peer` lets builders of others take part. `forms` compares the forms that the same trees can have, and `predict` asks which
//! figure of a tree tells its time.
//!
//! Ray cost is a count, the same on every machine for any number of threads. Build time is what a clock says: the median of rounds that
//! alternate over the recipes, so that whatever else the machine does meets all alike.

mod chart;
mod forms;
mod measure;
mod peer;
mod predict;
mod recipe;
mod times;

pub use chart::panel;
pub use forms::{FormRow, forms};
pub use measure::{Contest, Effort, Watch};
pub use peer::{PEERS, Pipe, Worker};
pub use predict::{PREDICTORS, Prediction, Predictor, predictions};
pub use recipe::{Origin, Recipe};
pub use times::{Times, indistinct};

use crate::report::rays::RayReport;
use serde::Serialize;

/// What was measured of one scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TradeOff {
    /// In the order of trying, the quickest first.
    pub recipes: Vec<Row>,
    /// Recipes without a figure, or a builder of someone else's that failed in a later round.
    pub left_out: Vec<LeftOut>,
    /// Groups of recipes whose build times the rounds cannot tell apart, by their names.
    pub indistinct: Vec<Vec<String>>,
}

/// One recipe.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Unique among the rows.
    pub name: String,
    /// Who asked for it.
    pub origin: Origin,
    /// What a user types for it.
    pub flags: String,
    /// Searches that end with this recipe, by their names.
    pub chosen_by: Vec<String>,
    /// No other recipe is at least as good in both quantities and better in one, by the median build time.
    pub front: bool,
    /// How long its trees take to build.
    pub build: Times,
    /// What rays do in them.
    pub rays: RayReport,
    /// Nodes of all trees.
    pub nodes: u64,
    /// Triangles in leaves, over all trees.
    pub references: u64,
    /// Deepest leaf.
    pub depth: u32,
    /// SAH, the mean over the trees weighted by the areas of their roots.
    pub sah: f64,
    /// End-point overlap of all trees, at so many points as need a short time.
    pub epo: f64,
    /// What the rays of [`Row::rays`] take on one thread: the least of a few times.
    pub trace_seconds: f64,
    /// What the builder wrote down of its choices, for people.
    pub notes: Vec<String>,
}

/// A recipe without a figure.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Of the recipe.
    pub name: String,
    /// Who asked for it.
    pub origin: Origin,
    /// What a user types for it.
    pub flags: String,
    /// Why.
    #[serde(flatten)]
    pub reason: Reason,
}

/// Why a recipe has no figure.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "reason", content = "detail", rename_all = "snake_case")]
pub enum Reason {
    /// There was no time left for it.
    Budget,
    /// The run was interrupted.
    Interrupted,
    /// Its build failed, with this message.
    Failed(String),
}

#[cfg(test)]
mod tests;
