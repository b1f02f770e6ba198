//! What is tried, and in which order.

use crate::build::{BuildOptions, HullBasis, Method};
use serde::Serialize;

/// One way to build the trees of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Unique among the recipes of a run.
    pub name: String,
    /// Who asked for it.
    pub origin: Origin,
    /// What a user types for it; for people alone.
    pub flags: String,
    /// What it is.
    pub options: BuildOptions,
}

/// Who asked for a recipe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// It is a preset.
    Preset,
    /// It is a method of the registry, without a preset.
    Method,
    /// The caller.
    Given,
    /// A search ended with it: the same trees without the search.
    Choice,
    /// A builder of someone else's made it.
    Peer,
}

impl Origin {
    /// In the order of legends.
    pub const ALL: [Origin; 5] = [Origin::Preset, Origin::Method, Origin::Given, Origin::Choice, Origin::Peer];
}

impl Recipe {
    /// Whether both build the same trees.
    pub fn builds_as(&self, other: &BuildOptions) -> bool {
        self.options.method == other.method && self.options.effective() == other.effective()
    }

    /// About how long a build takes beside `binned`. It decides the order in which recipes are first tried and nothing else, so that a short run has
    /// the quick ones.
    pub(super) fn weight(&self) -> f64 {
        let options = &self.options;
        let method = match options.method {
            Method::Agglomerative => 0.7,
            Method::Binned => 1.0,
            Method::Bonsai => 2.0,
            Method::Sweep => 2.5,
            Method::Oabb => match options.basis {
                HullBasis::Leaf => 5.0,
                HullBasis::Fit => 12.0,
            },
            Method::Sbvh => 4.0,
            Method::Auto => 14.0,
            Method::Best => 20.0,
        };
        let bins = if options.method.is_search() { 1.0 } else { f64::from(options.bins) / 32.0 };
        let passes = 0.5 * f64::from(options.reinsert) + if options.adapt > 0 { 3.0 } else { 0.0 };
        method + bins + if options.method.is_search() { 0.0 } else { passes }
    }
}
