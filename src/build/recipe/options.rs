//! Everything that a user can ask of a build and that changes its output, with the presets as their expansions.

use crate::build::agglomerative::MAX_RADIUS;
use crate::build::error::BuildError;

/// How trees are built. A name in the registry; more follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Object splits only, binned SAH (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007).
    Binned,
    /// Bottom-up clustering along a Morton curve (Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume
    /// Hierarchy Construction", 2018).
    Agglomerative,
    /// Object and spatial splits (Stich, Friedrich and Dietrich, "Spatial Splits in Bounding Volume Hierarchies",
    /// 2009).
    Sbvh,
    /// Sweep trees of small groups, pruned, under a sweep tree over them (Ganestam, Barringer, Doggett and Akenine-Möller, "Bonsai: Rapid
    /// Bounding Volume Hierarchy Generation using Mini Trees", 2015).
    Bonsai,
    /// Object splits only, at every plane between two centres (MacDonald and Booth, "Heuristics for Ray Tracing Using Space
    /// Subdivision", 1990), the axes sorted once.
    Sweep,
    /// A search that stops early: from the cheapest recipe upward until measured rays say that the rest cannot pay.
    Auto,
    /// A search that tries a fixed list and takes what measured rays like best.
    Best,
}

/// Which axes object bins are tried on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    All,
    /// Only the longest axis of the centroid box: Wald's original, kept because its failure on architecture is a
    /// lesson.
    Longest,
}

/// How a reference is cut at a spatial split plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clip {
    /// Cut only the reference's box: quicker, looser.
    Box,
    /// Cut the triangle (Sutherland–Hodgman) and take the tight box of what is left.
    Exact,
}

/// One tree over everything, or one per mesh and one over the instances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Levels {
    /// Two levels when some mesh stands in several places, one otherwise.
    Auto,
    /// Bake every instance into one tree (`--flatten`).
    One,
    Two,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    Auto,
    Draft,
    Balanced,
    Best,
}

/// Every field changes the output and is part of the build key; thread counts and verbosity live elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildOptions {
    pub method: Method,
    pub axes: Axes,
    /// Object bins per axis, 2..=256. Small nodes use fewer.
    pub bins: u32,
    /// Spatial bins per axis, 2..=256.
    pub spatial_bins: u32,
    /// Neighbours to either side among which a cluster looks for its best match, 1..=31.
    pub radius: u32,
    /// References that cutting large triangles before the build may add, as a share of the triangles: 0 cuts none.
    pub presplit: f32,
    /// Most references in a leaf that the SAH may choose, 1..=255.
    pub max_leaf: u32,
    /// C_T: cost of an inner node.
    pub traversal_cost: f32,
    /// C_I: cost of a triangle test.
    pub intersection_cost: f32,
    pub clip: Clip,
    /// Spatial splits are tried where the children of the best object split overlap by more than this share of the
    /// *root's* area: 0 tries everywhere, 1 nowhere.
    pub split_alpha: f32,
    /// Most references a BLAS may have, as a multiple of its triangles: 1 forbids duplicates.
    pub split_budget: f32,
    /// Put a straddling reference wholly to one side where that is cheaper.
    pub unsplit: bool,
    /// Mini trees are opened where a node's area is more than so many times that of the average mini tree.
    pub prune: f32,
    /// Most rounds of reinsertion over the finished tree; 0 leaves it as the method built it. A pass, so it goes with every method.
    pub reinsert: u32,
    /// Rays in each of three sets that the finished tree is adapted to, after reinsertion; 0 adapts it to none. A pass.
    pub adapt: u32,
    /// Make leaves of subtrees of the finished tree where the SAH says that it is cheaper. A pass.
    pub collapse: bool,
    pub levels: Levels,
}

/// Most rays in a set that a tree can be adapted to: 200 MB of them.
pub const MAX_ADAPT: u32 = 1 << 20;

impl BuildOptions {
    pub fn preset(preset: Preset) -> BuildOptions {
        let auto = BuildOptions {
            method: Method::Auto,
            axes: Axes::All,
            bins: 128,
            spatial_bins: 32,
            radius: 14,
            presplit: 0.0,
            max_leaf: 8,
            traversal_cost: 1.2,
            intersection_cost: 1.0,
            clip: Clip::Exact,
            split_alpha: 1e-4,
            split_budget: 1.5,
            unsplit: true,
            prune: 0.1,
            reinsert: 0,
            adapt: 0,
            collapse: false,
            levels: Levels::Auto,
        };
        match preset {
            Preset::Auto => auto,
            Preset::Best => BuildOptions { method: Method::Best, ..auto },
            Preset::Balanced => BuildOptions {
                method: Method::Sbvh,
                bins: 64,
                spatial_bins: 8,
                split_alpha: 1e-3,
                split_budget: 1.25,
                ..auto
            },
            Preset::Draft => BuildOptions { method: Method::Binned, bins: 32, ..auto },
        }
    }
}

impl Default for BuildOptions {
    fn default() -> Self {
        BuildOptions::preset(Preset::Auto)
    }
}

impl BuildOptions {
    /// Refuse values that no build can honour.
    pub fn validate(&self) -> Result<(), BuildError> {
        let refuse = |option: &'static str, value: String, rule: &'static str, good: &str| {
            Err(BuildError::Option { option, value, rule, help: format!("Try --{option} {good}.") })
        };
        let counts = [
            ("bins", self.bins, 2..=256, "it must be between 2 and 256", "16"),
            ("spatial-bins", self.spatial_bins, 2..=256, "it must be between 2 and 256", "16"),
            ("radius", self.radius, 1..=MAX_RADIUS, "it must be between 1 and 31", "14"),
            ("max-leaf", self.max_leaf, 1..=255, "it must be between 1 and 255", "8"),
            ("reinsert", self.reinsert, 0..=1000, "it must be between 0 and 1000", "12"),
            ("adapt", self.adapt, 0..=MAX_ADAPT, "it must be between 0 and 1048576", "4096"),
        ];
        for (option, value, range, rule, good) in counts {
            if !range.contains(&value) {
                return refuse(option, value.to_string(), rule, good);
            }
        }

        // Costs meet each other and counts of up to 2³¹ in `f32`; a million times apart they still compare well.
        let cost = "it must be between 0.001 and 1000";
        let reals = [
            ("sah-trav", self.traversal_cost, 1e-3..=1e3, cost, "1.2"),
            ("sah-isect", self.intersection_cost, 1e-3..=1e3, cost, "1"),
            ("presplit", self.presplit, 0.0..=63.0, "it must be between 0 and 63", "0.3"),
            ("split-alpha", self.split_alpha, 0.0..=1.0, "it must be between 0 and 1", "1e-4"),
            ("split-budget", self.split_budget, 1.0..=64.0, "it must be between 1 and 64", "1.5"),
            ("prune", self.prune, 0.0..=1e3, "it must be between 0 and 1000", "0.1"),
        ];
        for (option, value, range, rule, good) in reals {
            if !range.contains(&value) {
                return refuse(option, value.to_string(), rule, good);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_valid() {
        for preset in [Preset::Auto, Preset::Draft, Preset::Balanced, Preset::Best] {
            BuildOptions::preset(preset).validate().unwrap();
        }
    }

    #[test]
    fn each_bad_value_is_refused_by_name() {
        let ok = BuildOptions::default();
        let bad = [
            ("bins", BuildOptions { bins: 1, ..ok.clone() }),
            ("spatial-bins", BuildOptions { spatial_bins: 257, ..ok.clone() }),
            ("radius", BuildOptions { radius: 0, ..ok.clone() }),
            ("radius", BuildOptions { radius: 32, ..ok.clone() }),
            ("presplit", BuildOptions { presplit: -0.1, ..ok.clone() }),
            ("presplit", BuildOptions { presplit: f32::NAN, ..ok.clone() }),
            ("max-leaf", BuildOptions { max_leaf: 0, ..ok.clone() }),
            ("max-leaf", BuildOptions { max_leaf: 256, ..ok.clone() }),
            ("reinsert", BuildOptions { reinsert: 1001, ..ok.clone() }),
            ("adapt", BuildOptions { adapt: MAX_ADAPT + 1, ..ok.clone() }),
            ("sah-trav", BuildOptions { traversal_cost: f32::NAN, ..ok.clone() }),
            ("sah-isect", BuildOptions { intersection_cost: 0.0, ..ok.clone() }),
            ("split-alpha", BuildOptions { split_alpha: -0.1, ..ok.clone() }),
            ("split-budget", BuildOptions { split_budget: f32::INFINITY, ..ok.clone() }),
            ("prune", BuildOptions { prune: -0.5, ..ok }),
        ];
        for (name, options) in bad {
            match options.validate() {
                Err(BuildError::Option { option, .. }) => assert_eq!(option, name),
                other => panic!("{name}: {other:?}"),
            }
        }
    }
}
