//! The closed sets that options choose from, and what holds for all options together.

use super::table::OPTIONS;
use crate::build::error::BuildError;

pub use super::table::BuildOptions;
pub(in crate::build) use super::table::MAX_RADIUS;

/// How trees are built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// Object splits only, binned SAH (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007).
    Binned,
    /// Bottom-up clustering along a Morton curve (Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding Volume
    /// Hierarchy Construction", 2018).
    Agglomerative,
    /// The same by boxes that lie along what they hold (Aston, "Agglomerative Building and Traversal of an Object Aligned Bounding Volume
    /// Hierarchy", 2018).
    Oabb,
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
#[non_exhaustive]
pub enum Axes {
    /// The best plane of all three axes.
    All,
    /// Only the longest axis of the centroid box: Wald's original, kept because its failure on architecture is a
    /// lesson.
    Longest,
}

/// How a reference is cut at a spatial split plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Clip {
    /// Cut only the reference's box: quicker, looser.
    Box,
    /// Cut the triangle (Sutherland–Hodgman) and take the tight box of what is left.
    Exact,
}

/// Along what the box of a cluster lies, where clusters have oriented ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HullBasis {
    /// Along one of the two that became one, and so along some triangle: the method's original, kept because it shows how boxes then grow.
    Leaf,
    /// Along what suits the whole: of several candidates the one with the least box.
    Fit,
}

/// One tree over everything, or one per mesh and one over the instances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Levels {
    /// Two levels when some mesh stands in several places, one otherwise.
    Auto,
    /// Bake every instance into one tree.
    One,
    /// Even where every mesh stands in one place.
    Two,
}

/// What rays are for. Other methods than searches ask it only where a tree is adapted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Purpose {
    /// Every family of rays alike.
    All,
    /// Pictures: cameras, a bounce, occlusion and light at what they see.
    Camera,
    /// Light that is stored at surfaces: rays that start there.
    Bake,
    /// Queries from anywhere: chords, lines of sight, what surrounds each triangle.
    Physics,
}

/// A method and a value for every option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Preset {
    /// The search `auto`: quick where measured rays say that more would not pay. The default.
    Auto,
    /// `binned`, for trees that are thrown away soon.
    Draft,
    /// `sbvh`: spatial splits, without a search.
    Balanced,
    /// `best`: the longest search.
    Best,
}

impl Default for BuildOptions {
    fn default() -> Self {
        BuildOptions::preset(Preset::Auto)
    }
}

impl BuildOptions {
    /// Refuse values that no build can honour.
    ///
    /// # Errors
    /// [`BuildError::Option`] with the first option whose value is out of its range.
    pub(crate) fn validate(&self) -> Result<(), BuildError> {
        match OPTIONS.iter().find(|row| !row.is_valid(self)) {
            Some(row) => Err(row.refusal(row.value(self))),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::MAX_ADAPT;
    use super::*;

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
