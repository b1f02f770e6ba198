//! The table of build methods: one row each, which feeds `--help`, META and the build key.

use super::options::{BuildOptions, Method};

/// What there is to say about a method.
#[derive(Clone, Copy, Debug)]
pub struct MethodInfo {
    pub method: Method,
    /// What users type and files name.
    pub name: &'static str,
    /// Raised when the same input and options give another tree, and only then: old caches are out of date from there
    /// on. [`Method::revision`] is what files name.
    pub revision: u32,
    /// One line for `--help`.
    pub summary: &'static str,
    /// The options that the method looks at. Only these are part of the build key.
    pub options: &'static [OptionName],
}

/// The fields of [`BuildOptions`] but for the method, by the names of their command-line flags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OptionName {
    Axes,
    Bins,
    SpatialBins,
    Radius,
    Presplit,
    MaxLeaf,
    TraversalCost,
    IntersectionCost,
    Clip,
    SplitAlpha,
    SplitBudget,
    Unsplit,
    Prune,
    Reinsert,
    Adapt,
    Collapse,
    Levels,
}

use OptionName as O;

pub const METHODS: &[MethodInfo] = &[
    MethodInfo {
        method: Method::Binned,
        name: "binned",
        revision: 1,
        summary: "object splits only, chosen among equal bins on three axes; quickest",
        options: &[O::Axes, O::Bins, O::MaxLeaf, O::TraversalCost, O::IntersectionCost, O::Presplit, O::Levels],
    },
    MethodInfo {
        method: Method::Sbvh,
        name: "sbvh",
        revision: 3,
        summary: "object and spatial splits compete; best where triangles are large or thin",
        options: &[
            O::Axes,
            O::Bins,
            O::SpatialBins,
            O::MaxLeaf,
            O::TraversalCost,
            O::IntersectionCost,
            O::Clip,
            O::SplitAlpha,
            O::SplitBudget,
            O::Unsplit,
            O::Levels,
        ],
    },
    MethodInfo {
        method: Method::Bonsai,
        name: "bonsai",
        revision: 2,
        summary: "object splits only: sweep trees of small groups, pruned, under one over them; quicker than sweep, better on architecture",
        options: &[O::MaxLeaf, O::TraversalCost, O::IntersectionCost, O::Prune, O::Presplit, O::Levels],
    },
    MethodInfo {
        method: Method::Sweep,
        name: "sweep",
        revision: 1,
        summary: "object splits only, chosen among all planes on three axes; the measure of the others",
        options: &[O::MaxLeaf, O::TraversalCost, O::IntersectionCost, O::Presplit, O::Levels],
    },
    MethodInfo {
        method: Method::Agglomerative,
        name: "agglomerative",
        revision: 2,
        summary: "from the triangles up: neighbours on a Morton curve merge with their best match",
        options: &[O::Radius, O::MaxLeaf, O::TraversalCost, O::IntersectionCost, O::Presplit, O::Levels],
    },
    MethodInfo {
        method: Method::Auto,
        name: "auto",
        revision: 3,
        summary: "a search: sweep, then spatial splits, then reinsertion and adaptation, as far as measured rays say that they pay",
        options: SEARCHES,
    },
    MethodInfo {
        method: Method::Best,
        name: "best",
        revision: 3,
        summary: "a search: several recipes, of which measured rays decide",
        options: SEARCHES,
    },
];

/// What searches read; to set anything else is to choose a recipe.
const SEARCHES: &[OptionName] = &[O::MaxLeaf, O::TraversalCost, O::IntersectionCost, O::SplitBudget, O::Levels];

/// The options of the passes, which every method's tree can be followed by.
pub const PASSES: &[OptionName] = &[O::Reinsert, O::Adapt, O::Collapse];

impl OptionName {
    pub fn name(self) -> &'static str {
        match self {
            O::Axes => "axes",
            O::Bins => "bins",
            O::SpatialBins => "spatial-bins",
            O::Radius => "radius",
            O::Presplit => "presplit",
            O::MaxLeaf => "max-leaf",
            O::TraversalCost => "sah-trav",
            O::IntersectionCost => "sah-isect",
            O::Clip => "clip",
            O::SplitAlpha => "split-alpha",
            O::SplitBudget => "split-budget",
            O::Unsplit => "unsplit",
            O::Prune => "prune",
            O::Reinsert => "reinsert",
            O::Adapt => "adapt",
            O::Collapse => "collapse",
            O::Levels => "levels",
        }
    }

    /// The option's value as text that two different values never share: floats in the shortest form that reads back to
    /// the same bits.
    pub fn value(self, options: &BuildOptions) -> String {
        // Adding zero turns -0 into +0: they mean the same.
        match self {
            O::Axes => options.axes.to_string(),
            O::Bins => options.bins.to_string(),
            O::SpatialBins => options.spatial_bins.to_string(),
            O::Radius => options.radius.to_string(),
            O::Presplit => (options.presplit + 0.0).to_string(),
            O::MaxLeaf => options.max_leaf.to_string(),
            O::TraversalCost => (options.traversal_cost + 0.0).to_string(),
            O::IntersectionCost => (options.intersection_cost + 0.0).to_string(),
            O::Clip => options.clip.to_string(),
            O::SplitAlpha => (options.split_alpha + 0.0).to_string(),
            O::SplitBudget => (options.split_budget + 0.0).to_string(),
            O::Unsplit => options.unsplit.to_string(),
            O::Prune => (options.prune + 0.0).to_string(),
            O::Reinsert => options.reinsert.to_string(),
            O::Adapt => options.adapt.to_string(),
            O::Collapse => options.collapse.to_string(),
            O::Levels => options.levels.to_string(),
        }
    }
}

impl Method {
    pub fn info(self) -> &'static MethodInfo {
        // A test below proves that every method has its row.
        METHODS.iter().find(|row| row.method == self).unwrap_or(&METHODS[0])
    }

    /// Whether it tries other methods and takes one's tree.
    pub fn is_search(self) -> bool {
        matches!(self, Method::Auto | Method::Best)
    }

    /// The revision of the method's output. A search's stands for its rule and for every method that it might take: their sum grows when
    /// any of them does.
    pub fn revision(self) -> u32 {
        if self.is_search() {
            let others: u32 = METHODS.iter().filter(|row| !row.method.is_search()).map(|row| row.revision).sum();
            self.info().revision + others
        } else {
            self.info().revision
        }
    }
}

impl BuildOptions {
    /// The options that decide this build's output, as names and values in the order of the registry: what META shows
    /// and the build key hashes, beside the method's name and revision. What is not done, a pass or cutting, is not named: a recipe
    /// without it stays what it was before there was such a thing.
    pub fn effective(&self) -> Vec<(String, String)> {
        let passes = if self.method.is_search() { &[] } else { PASSES };
        let of_method = self.method.info().options.iter().chain(passes).filter(|option| match option {
            O::Presplit => self.presplit > 0.0,
            O::Reinsert => self.reinsert > 0,
            O::Adapt => self.adapt > 0,
            O::Collapse => self.collapse,
            _ => true,
        });
        of_method.map(|o| (o.name().to_string(), o.value(self))).collect()
    }

    /// The command line's flags that say the same; those that the method does not read are left out.
    pub fn as_flags(&self) -> String {
        let flag = |(name, value): (String, String)| match (name.as_str(), value.as_str()) {
            ("unsplit", "true") => String::new(),
            ("unsplit", _) => " --no-unsplit".to_string(),
            ("collapse", _) => " --collapse".to_string(),
            _ => format!(" --{name} {value}"),
        };
        format!("--method {}", self.method) + &self.effective().into_iter().map(flag).collect::<String>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_finds_its_own_row() {
        for row in METHODS {
            assert_eq!(row.method.info().name, row.name);
        }
    }

    #[test]
    fn options_that_a_method_ignores_are_not_part_of_its_recipe() {
        let base = BuildOptions { method: Method::Binned, ..BuildOptions::default() };
        let other = BuildOptions { split_alpha: 0.5, spatial_bins: 7, unsplit: false, ..base.clone() };
        assert_eq!(base.effective(), other.effective());
        let sbvh = BuildOptions { method: Method::Sbvh, ..base.clone() };
        assert_ne!(sbvh.effective(), BuildOptions { method: Method::Sbvh, ..other }.effective());
        assert!(base.effective().contains(&("sah-trav".into(), "1.2".into())));
    }

    #[test]
    fn passes_are_part_of_every_recipe_that_does_them() {
        for row in METHODS.iter().filter(|row| !row.method.is_search()) {
            let without =
                BuildOptions { method: row.method, reinsert: 0, adapt: 0, collapse: false, ..BuildOptions::default() };
            let is_pass = |name: &str| ["reinsert", "adapt", "collapse", "presplit"].contains(&name);
            assert!(without.effective().iter().all(|(name, _)| !is_pass(name)));
            let with = BuildOptions { reinsert: 7, adapt: 9, collapse: true, ..without };
            let named = |name: &str, value: &str| with.effective().contains(&(name.into(), value.into()));
            assert!(named("reinsert", "7") && named("adapt", "9") && named("collapse", "true"));
            let cut = BuildOptions { presplit: 0.25, ..with.clone() };
            assert_eq!(cut.effective() != with.effective(), row.options.contains(&O::Presplit));
        }
    }

    #[test]
    fn a_search_has_another_revision_when_a_method_has_and_reads_no_pass() {
        let others: u32 = METHODS.iter().filter(|row| !row.method.is_search()).map(|row| row.revision).sum();
        for method in [Method::Auto, Method::Best] {
            assert_eq!(method.revision(), method.info().revision + others);
            let plain = BuildOptions { method, ..BuildOptions::default() };
            let passed = BuildOptions { reinsert: 5, adapt: 5, collapse: true, bins: 3, ..plain.clone() };
            assert_eq!(plain.effective(), passed.effective());
            assert_ne!(plain.effective(), BuildOptions { split_budget: 1.1, ..plain.clone() }.effective());
        }
        assert_eq!(Method::Sweep.revision(), Method::Sweep.info().revision);
    }

    #[test]
    fn both_zeros_are_one_value() {
        let plus = BuildOptions { method: Method::Sbvh, split_alpha: 0.0, ..BuildOptions::default() };
        let minus = BuildOptions { method: Method::Sbvh, split_alpha: -0.0, ..BuildOptions::default() };
        assert_eq!(plus.effective(), minus.effective());
    }
}
