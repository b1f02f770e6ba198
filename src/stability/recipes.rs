//! What is judged on every scene: each preset, each method and each pass.

use crate::build::{Axes, BuildOptions, HullBasis, Method, Preset};
use serde::Serialize;

/// One way to build trees.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Unique among [`recipes`].
    pub name: &'static str,
    /// What of it is judged.
    pub kind: Kind,
    /// What it is.
    pub options: BuildOptions,
}

/// What of a recipe is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// A preset.
    Preset,
    /// A method, with the options of the preset `best` where it reads them.
    Method,
    /// A pass, after or before `sweep`.
    Pass,
}

impl Kind {
    /// In the order of legends.
    pub const ALL: [Kind; 3] = [Kind::Preset, Kind::Method, Kind::Pass];

    /// For people, in the plural.
    pub fn words(self) -> &'static str {
        match self {
            Kind::Preset => "presets",
            Kind::Method => "methods",
            Kind::Pass => "passes",
        }
    }
}

/// The search that is the default, by its name among [`recipes`].
pub const AUTO: &str = "auto";

/// Every preset, every method with the options of a preset, and every pass; the presets first.
pub fn recipes() -> Vec<Recipe> {
    let (draft, best) = (BuildOptions::preset(Preset::Draft), BuildOptions::preset(Preset::Best));
    let method = |method| BuildOptions { method, ..best.clone() };
    let sweep = method(Method::Sweep);
    let all = [
        ("draft", Kind::Preset, draft.clone()),
        ("balanced", Kind::Preset, BuildOptions::preset(Preset::Balanced)),
        (AUTO, Kind::Preset, BuildOptions::preset(Preset::Auto)),
        ("best", Kind::Preset, best.clone()),
        ("longest axis", Kind::Method, BuildOptions { axes: Axes::Longest, ..draft }),
        ("binned", Kind::Method, method(Method::Binned)),
        ("sbvh", Kind::Method, method(Method::Sbvh)),
        ("bonsai", Kind::Method, method(Method::Bonsai)),
        ("sweep", Kind::Method, sweep.clone()),
        ("agglomerative", Kind::Method, method(Method::Agglomerative)),
        ("oabb", Kind::Method, method(Method::Oabb)),
        ("oabb along leaves", Kind::Method, BuildOptions { basis: HullBasis::Leaf, ..method(Method::Oabb) }),
        ("presplit", Kind::Pass, BuildOptions { presplit: 0.3, ..sweep.clone() }),
        ("reinsert", Kind::Pass, BuildOptions { reinsert: 4, ..sweep.clone() }),
        ("adapt", Kind::Pass, BuildOptions { adapt: 128, ..sweep.clone() }),
        ("collapse", Kind::Pass, BuildOptions { collapse: true, ..sweep }),
    ];
    all.into_iter().map(|(name, kind, options)| Recipe { name, kind, options }).collect()
}
