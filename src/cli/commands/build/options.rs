//! Flags that change the output: a preset and what is set on top of it, turned into [`BuildOptions`].

use crate::build::{Axes, BuildOptions, Clip, Levels, MAX_ADAPT, Method, Named, Preset};
use crate::scene::{Degenerate, Format, ReadOptions};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// The flags as typed. Each one overrides the preset.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Tree options")]
pub struct TreeArgs {
    /// Where to start from; the flags below override it, and one that `auto` or `best` does not read makes it sbvh
    #[arg(long, value_parser = choice::<Preset>(), value_name = "NAME", default_value = "auto", long_help = preset_help())]
    pub preset: Preset,
    /// How trees are built: binned (object splits only), sbvh (object and spatial splits), sweep (object splits at every
    /// plane), bonsai (many small sweep trees under one), agglomerative (neighbours merge, from the triangles up), or a
    /// search that tries several: auto (stops where the rest cannot pay) or best (the whole list)
    #[arg(long, visible_alias = "builder", value_parser = choice::<Method>(), value_name = "NAME")]
    pub method: Option<Method>,
    /// Axes on which object bins are tried
    #[arg(long, value_parser = choice::<Axes>(), value_name = "WHICH")]
    pub axes: Option<Axes>,
    /// Object bins per axis
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=256))]
    pub bins: Option<u32>,
    /// Spatial bins per axis
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=256))]
    pub spatial_bins: Option<u32>,
    /// Neighbours to either side among which agglomerative clusters look for their best match
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=31))]
    pub radius: Option<u32>,
    /// Cut large triangles before the build into as many more references as this share of the triangles; 0 cuts none
    #[arg(long, value_name = "SHARE", value_parser = presplit_share)]
    pub presplit: Option<f32>,
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
    #[arg(long, value_parser = choice::<Clip>(), value_name = "HOW")]
    pub clip: Option<Clip>,
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
    /// Open mini trees where a node's area is more than so many times that of the average mini tree
    #[arg(long, value_name = "RATIO", value_parser = prune_ratio)]
    pub prune: Option<f32>,
    /// After the build, move subtrees to where they cost least, in at most so many rounds; 0 leaves the tree as it is
    #[arg(long, value_name = "ROUNDS", value_parser = clap::value_parser!(u32).range(0..=1000))]
    pub reinsert: Option<u32>,
    /// After the build, put parts of the tree together anew where so many rays a set, traced everywhere, then visit fewer boxes; 0 leaves it
    #[arg(long, value_name = "RAYS", value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_ADAPT)))]
    pub adapt: Option<u32>,
    /// After the build, make leaves of subtrees where the SAH says that it is cheaper
    #[arg(long)]
    pub collapse: bool,
    /// One tree over everything, or one per mesh and one over the instances
    #[arg(long, value_parser = choice::<Levels>(), value_name = "HOW", conflicts_with = "flatten")]
    pub levels: Option<Levels>,
    /// Bake all instances into one tree; short for `--levels one`
    #[arg(long)]
    pub flatten: bool,
}

impl TreeArgs {
    /// The preset with every flag that was typed on top.
    pub fn resolve(&self) -> BuildOptions {
        let base = BuildOptions::preset(self.preset);
        let levels = if self.flatten { Levels::One } else { self.levels.unwrap_or(base.levels) };
        let method = match self.method {
            Some(method) => method,
            None if base.method.is_search() && self.chooses_a_recipe() => Method::Sbvh,
            None => base.method,
        };
        BuildOptions {
            method,
            axes: self.axes.unwrap_or(base.axes),
            bins: self.bins.unwrap_or(base.bins),
            spatial_bins: self.spatial_bins.unwrap_or(base.spatial_bins),
            radius: self.radius.unwrap_or(base.radius),
            presplit: self.presplit.unwrap_or(base.presplit),
            max_leaf: self.max_leaf.unwrap_or(base.max_leaf),
            traversal_cost: self.sah_trav.unwrap_or(base.traversal_cost),
            intersection_cost: self.sah_isect.unwrap_or(base.intersection_cost),
            clip: self.clip.unwrap_or(base.clip),
            split_alpha: self.split_alpha.unwrap_or(base.split_alpha),
            split_budget: self.split_budget.unwrap_or(base.split_budget),
            unsplit: base.unsplit && !self.no_unsplit,
            prune: self.prune.unwrap_or(base.prune),
            reinsert: self.reinsert.unwrap_or(base.reinsert),
            adapt: self.adapt.unwrap_or(base.adapt),
            collapse: base.collapse || self.collapse,
            levels,
        }
    }

    /// Whether a flag was typed that searches decide about themselves.
    fn chooses_a_recipe(&self) -> bool {
        let counts = [self.bins, self.spatial_bins, self.radius, self.reinsert, self.adapt];
        let reals = [self.presplit, self.split_alpha, self.prune];
        counts.iter().any(Option::is_some)
            || reals.iter().any(Option::is_some)
            || self.axes.is_some()
            || self.clip.is_some()
            || self.no_unsplit
            || self.collapse
    }
}

/// How models are read.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadArgs {
    /// What to do with triangles without area
    #[arg(long, value_parser = choice::<Degenerate>(), value_name = "POLICY", default_value = "drop")]
    pub degenerate: Degenerate,
    /// Let a glTF file name buffers outside its own folder
    #[arg(long)]
    pub allow_outside: bool,
    /// The glTF scene to build; default: the one that the file names
    #[arg(long, value_name = "N")]
    pub scene: Option<u32>,
    /// What comes from standard input; told by its content if not given
    #[arg(long, value_name = "FORMAT", value_enum)]
    pub input_format: Option<InputFormat>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum InputFormat {
    Obj,
    Gltf,
    Glb,
}

impl From<InputFormat> for Format {
    fn from(format: InputFormat) -> Format {
        match format {
            InputFormat::Obj => Format::Obj,
            InputFormat::Gltf | InputFormat::Glb => Format::Gltf,
        }
    }
}

impl ReadArgs {
    pub fn resolve(&self) -> ReadOptions {
        let (degenerate, allow_outside, scene) = (self.degenerate, self.allow_outside, self.scene);
        ReadOptions { degenerate, allow_outside, scene, ..ReadOptions::default() }
    }

    /// The options that decide what is read, for META and the build key; the others only decide whether.
    pub fn effective(&self) -> Vec<(String, String)> {
        let scene = self.scene.map_or_else(|| "default".to_string(), |n| n.to_string());
        vec![("degenerate".into(), self.degenerate.name().to_string()), ("scene".into(), scene)]
    }
}

/// Each preset with its expansion, one a line.
pub fn preset_lines() -> Vec<(String, String)> {
    Preset::names().iter().map(|(p, name)| (name.to_string(), BuildOptions::preset(*p).as_flags())).collect()
}

fn preset_help() -> String {
    let mut text = String::from(
        "Where to start from; the flags below override it. Each preset stands for what follows. \
         With auto or best, a flag that they do not read chooses a recipe: --method sbvh, if no other is named.\n",
    );
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

fn prune_ratio(text: &str) -> Result<f32, String> {
    number(text).and_then(|v| if (0.0..=1e3).contains(&v) { Ok(v) } else { Err(format!("{v} is not in 0..1000")) })
}

fn presplit_share(text: &str) -> Result<f32, String> {
    number(text).and_then(|v| if (0.0..=63.0).contains(&v) { Ok(v) } else { Err(format!("{v} is not in 0..63")) })
}

fn factor(text: &str) -> Result<f32, String> {
    number(text).and_then(|v| if (1.0..=64.0).contains(&v) { Ok(v) } else { Err(format!("{v} is not in 1..64")) })
}

/// A closed set of the library as values of a flag: its names are the choices.
fn choice<T: Named + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let names = T::names().into_iter().map(|(_, name)| PossibleValue::new(name));
    PossibleValuesParser::new(names).try_map(|text| T::parse(&text))
}

impl Named for Degenerate {
    const KIND: &'static str = "policy";

    fn names() -> Vec<(Self, &'static str)> {
        vec![(Degenerate::Keep, "keep"), (Degenerate::Drop, "drop"), (Degenerate::Error, "error")]
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
    fn a_flag_that_a_search_decides_about_switches_it_off() {
        for preset in ["auto", "best"] {
            let of = |flags: &str| resolved(&format!("--preset {preset} {flags}"));
            let search = of("").method;
            assert!(search.is_search());
            for kept in
                ["--max-leaf 4", "--sah-trav 2", "--sah-isect 2", "--split-budget 2", "--levels two", "--flatten"]
            {
                assert_eq!(of(kept).method, search, "{kept}");
                assert_ne!(of(kept).effective(), of("").effective(), "{kept}");
            }
            let chosen = [
                "--bins 8",
                "--spatial-bins 8",
                "--radius 3",
                "--reinsert 0",
                "--adapt 0",
                "--presplit 0",
                "--split-alpha 0",
                "--prune 1",
                "--axes all",
                "--clip box",
                "--no-unsplit",
                "--collapse",
            ];
            for flag in chosen {
                assert_eq!(of(flag).method, Method::Sbvh, "{flag}");
                assert_eq!(of(&format!("{flag} --method sweep")).method, Method::Sweep, "{flag}");
            }
        }
    }

    #[test]
    fn a_preset_means_what_its_expansion_says() {
        for (name, flags) in preset_lines() {
            let preset = resolved(&format!("--preset {name}"));
            let spelt = resolved(&flags);
            // The flags of a binned preset leave out what only spatial splits read.
            assert_eq!(preset.as_flags(), spelt.as_flags(), "{name}");
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
            "--reinsert -1",
            "--reinsert 1001",
            "--adapt -1",
            "--adapt 1048577",
            "--radius 0",
            "--radius 32",
            "--presplit -1",
            "--presplit 64",
        ] {
            assert!(Bare::try_parse_from(std::iter::once("x").chain(bad.split(' '))).is_err(), "{bad}");
        }
    }
}
