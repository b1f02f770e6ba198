//! Flags that change the output: a preset and what is set on top of it, turned into [`BuildOptions`].

use crate::build::{Axes, BuildOptions, Clip, Levels, Method, Preset};
use crate::scene::{Degenerate, ReadOptions};
use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};

/// The flags as typed. Each one overrides the preset.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Tree options")]
pub struct TreeArgs {
    /// Where to start from; the flags below override it
    #[arg(long, value_enum, value_name = "NAME", default_value = "best", long_help = preset_help())]
    pub preset: PresetName,
    /// How trees are built
    #[arg(long, visible_alias = "builder", value_enum, value_name = "NAME")]
    pub method: Option<MethodName>,
    /// Axes on which object bins are tried
    #[arg(long, value_enum, value_name = "WHICH")]
    pub axes: Option<AxesName>,
    /// Object bins per axis
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=256))]
    pub bins: Option<u32>,
    /// Spatial bins per axis
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=256))]
    pub spatial_bins: Option<u32>,
    /// Most triangles in a leaf
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=255))]
    pub max_leaf: Option<u32>,
    /// Cost of an inner node in the SAH (C_T)
    #[arg(long, value_name = "COST", value_parser = positive)]
    pub sah_trav: Option<f32>,
    /// Cost of a triangle test in the SAH (C_I)
    #[arg(long, value_name = "COST", value_parser = positive)]
    pub sah_isect: Option<f32>,
    /// What a spatial split cuts: the reference's box (quicker) or the triangle itself (tighter)
    #[arg(long, value_enum, value_name = "HOW")]
    pub clip: Option<ClipName>,
    /// Try a spatial split where the object split's children overlap by more than this share of the root's area; 0 tries
    /// everywhere, 1 nowhere
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub split_alpha: Option<f32>,
    /// Most references that a tree may have, as a multiple of its triangles; 1 forbids duplicates
    #[arg(long, value_name = "FACTOR", value_parser = factor)]
    pub split_budget: Option<f32>,
    /// Do not put straddling references back to one side
    #[arg(long)]
    pub no_unsplit: bool,
    /// One tree over everything, or one per mesh and one over the instances
    #[arg(long, value_enum, value_name = "HOW", conflicts_with = "flatten")]
    pub levels: Option<LevelsName>,
    /// Bake all instances into one tree; short for `--levels one`
    #[arg(long)]
    pub flatten: bool,
}

impl TreeArgs {
    /// The preset with every flag that was typed on top.
    pub fn resolve(&self) -> BuildOptions {
        let base = BuildOptions::preset(self.preset.0);
        let levels = if self.flatten { Levels::One } else { self.levels.map_or(base.levels, |n| n.0) };
        BuildOptions {
            method: self.method.map_or(base.method, |n| n.0),
            axes: self.axes.map_or(base.axes, |n| n.0),
            bins: self.bins.unwrap_or(base.bins),
            spatial_bins: self.spatial_bins.unwrap_or(base.spatial_bins),
            max_leaf: self.max_leaf.unwrap_or(base.max_leaf),
            traversal_cost: self.sah_trav.unwrap_or(base.traversal_cost),
            intersection_cost: self.sah_isect.unwrap_or(base.intersection_cost),
            clip: self.clip.map_or(base.clip, |n| n.0),
            split_alpha: self.split_alpha.unwrap_or(base.split_alpha),
            split_budget: self.split_budget.unwrap_or(base.split_budget),
            unsplit: base.unsplit && !self.no_unsplit,
            levels,
        }
    }
}

/// How models are read.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadArgs {
    /// What to do with triangles without area
    #[arg(long, value_enum, value_name = "POLICY", default_value = "drop")]
    pub degenerate: DegenerateName,
    /// Let a glTF file name buffers outside its own folder
    #[arg(long)]
    pub allow_outside: bool,
    /// The glTF scene to build; default: the one that the file names
    #[arg(long, value_name = "N")]
    pub scene: Option<u32>,
}

impl ReadArgs {
    pub fn resolve(&self) -> ReadOptions {
        let (degenerate, allow_outside, scene) = (self.degenerate.0, self.allow_outside, self.scene);
        ReadOptions { degenerate, allow_outside, scene, ..ReadOptions::default() }
    }

    /// The options that decide what is read, for META and the build key; the others only decide whether.
    pub fn effective(&self) -> Vec<(String, String)> {
        let scene = self.scene.map_or_else(|| "default".to_string(), |n| n.to_string());
        vec![("degenerate".into(), self.degenerate.to_string()), ("scene".into(), scene)]
    }
}

/// The flags that say the same as these options: how help shows a preset, and what `info` prints of a file.
pub fn as_flags(o: &BuildOptions) -> String {
    let mut flags = format!("--method {} --axes {} --bins {}", MethodName(o.method), AxesName(o.axes), o.bins);
    if o.method == Method::Sbvh {
        flags += &format!(
            " --spatial-bins {} --clip {} --split-alpha {} --split-budget {}{}",
            o.spatial_bins,
            ClipName(o.clip),
            o.split_alpha,
            o.split_budget,
            if o.unsplit { "" } else { " --no-unsplit" }
        );
    }
    flags
        + &format!(
            " --max-leaf {} --sah-trav {} --sah-isect {} --levels {}",
            o.max_leaf,
            o.traversal_cost,
            o.intersection_cost,
            LevelsName(o.levels)
        )
}

/// Each preset with its expansion, one a line.
pub fn preset_lines() -> Vec<(String, String)> {
    PresetName::value_variants().iter().map(|p| (p.to_string(), as_flags(&BuildOptions::preset(p.0)))).collect()
}

fn preset_help() -> String {
    let mut text = String::from("Where to start from; the flags below override it. Each preset stands for:\n");
    for (name, flags) in preset_lines() {
        text.push_str(&format!("\n{name}:\n  {flags}"));
    }
    text
}

fn number(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|v: &f32| v.is_finite()).ok_or_else(|| format!("`{text}` is not a finite number"))
}

fn positive(text: &str) -> Result<f32, String> {
    number(text).and_then(|v| if v > 0.0 { Ok(v) } else { Err(format!("{v} is not above 0")) })
}

fn share(text: &str) -> Result<f32, String> {
    number(text).and_then(|v| if (0.0..=1.0).contains(&v) { Ok(v) } else { Err(format!("{v} is not in 0..1")) })
}

fn factor(text: &str) -> Result<f32, String> {
    number(text).and_then(|v| if (1.0..=64.0).contains(&v) { Ok(v) } else { Err(format!("{v} is not in 1..64")) })
}

/// Give a library enum its names on the command line, in a wrapper, so that the library needs no clap.
macro_rules! named {
    ($wrapper:ident, $inner:ident, $( $variant:ident = $name:literal : $help:literal ),+ $(,)?) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $wrapper(pub $inner);

        impl ValueEnum for $wrapper {
            fn value_variants<'a>() -> &'a [Self] {
                &[$( $wrapper($inner::$variant) ),+]
            }

            fn to_possible_value(&self) -> Option<PossibleValue> {
                Some(match self.0 {
                    $( $inner::$variant => PossibleValue::new($name).help($help) ),+
                })
            }
        }

        impl std::fmt::Display for $wrapper {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self.0 {
                    $( $inner::$variant => $name ),+
                })
            }
        }
    };
}

named!(PresetName, Preset,
    Draft = "draft": "object splits only: quickest to build",
    Balanced = "balanced": "spatial splits with fewer bins and a smaller budget",
    Best = "best": "spatial splits with full effort: quickest to trace",
);
named!(MethodName, Method,
    Binned = "binned": "object splits on binned centroids (Wald 2007)",
    Sbvh = "sbvh": "object and spatial splits (Stich et al. 2009)",
);
named!(AxesName, Axes,
    All = "all": "every axis",
    Longest = "longest": "only the longest; worse on architecture",
);
named!(ClipName, Clip,
    Box = "box": "cut the box only",
    Exact = "exact": "cut the triangle",
);
named!(LevelsName, Levels,
    Auto = "auto": "two levels when a mesh stands in several places",
    One = "one": "bake everything into one tree",
    Two = "two": "always a tree over instances",
);

named!(DegenerateName, Degenerate,
    Keep = "keep": "keep them",
    Drop = "drop": "leave them out, since no ray can hit them",
    Error = "error": "refuse the model",
);

impl Default for PresetName {
    fn default() -> Self {
        PresetName(Preset::Best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Bare {
        #[command(flatten)]
        tree: TreeArgs,
    }

    fn resolved(args: &str) -> BuildOptions {
        Bare::try_parse_from(std::iter::once("x").chain(args.split_whitespace())).unwrap().tree.resolve()
    }

    #[test]
    fn the_default_is_the_library_default() {
        assert_eq!(resolved(""), BuildOptions::default());
    }

    #[test]
    fn flags_override_the_preset() {
        let o = resolved("--preset draft --builder sbvh --bins 8 --no-unsplit --flatten");
        assert_eq!((o.method, o.bins, o.unsplit, o.levels), (Method::Sbvh, 8, false, Levels::One));
    }

    #[test]
    fn a_preset_means_what_its_expansion_says() {
        for (name, flags) in preset_lines() {
            let preset = resolved(&format!("--preset {name}"));
            let spelt = resolved(&flags);
            // The flags of a binned preset leave out what only spatial splits read.
            assert_eq!(as_flags(&preset), as_flags(&spelt), "{name}");
        }
    }

    #[test]
    fn absurd_values_are_refused() {
        for bad in [
            "--bins 1",
            "--max-leaf 0",
            "--max-leaf 256",
            "--sah-trav 0",
            "--sah-trav nan",
            "--split-alpha 2",
            "--split-budget 0.5",
        ] {
            assert!(Bare::try_parse_from(std::iter::once("x").chain(bad.split(' '))).is_err(), "{bad}");
        }
    }
}
