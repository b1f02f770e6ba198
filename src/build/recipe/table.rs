//! The table of options: one row each. From a row come the field of [`BuildOptions`] with its value in every preset, the flag, its check
//! and its help, the name in META and in the build key, and the documentation.
//!
//! The order of the rows is the order in META and in the build key. A row may be put anywhere without changing the keys of
//! recipes that do not name it.

use super::options::{Axes, Clip, HullBasis, Levels, Method, Preset, Purpose};
use super::row::{InKey, Kind, OptionInfo, Readers, Spelling};
use super::value::{OptionValue, names_of};

/// Most rays of a family that a tree can be adapted to: some 500 MiB of them.
pub const MAX_ADAPT: u32 = 1 << 20;
/// Most neighbours to either side of a cluster among which its best match is looked for: their places are numbered in six bits.
pub(in crate::build) const MAX_RADIUS: u32 = 31;

/// Costs meet each other and counts of up to 2³¹ in `f32`; a million times apart they still compare well.
const COST: Kind = Kind::Real(1e-3, 1e3);

/// Writes the struct, the presets and the table out of the rows. A row begins with the field, its type, its value, and its value in the
/// presets where it is another; then the columns of [`OptionInfo`] follow, all of them, in this order.
macro_rules! options {
    ($($field:ident: $type:ty = $value:expr, $($preset:ident: $other:expr,)* {
        name: $name:literal,
        placeholder: $placeholder:literal,
        kind: $kind:expr,
        readers: $readers:expr,
        key: $key:expr,
        spelling: $spelling:expr,
        help: $help:literal,
        details: $details:literal,
    })*) => {
        /// Everything that a user can ask of a build and that changes its output. Thread counts and verbosity live elsewhere.
        #[derive(Clone, Debug, PartialEq)]
        pub struct BuildOptions {
            /// How trees are built.
            pub method: Method,
            $(
                #[doc = concat!($help, ". ", $details)]
                pub $field: $type,
            )*
        }

        impl BuildOptions {
            /// What a preset stands for.
            pub fn preset(preset: Preset) -> BuildOptions {
                BuildOptions {
                    method: preset.info().method,
                    $($field: match preset { $(Preset::$preset => $other,)* _ => $value },)*
                }
            }
        }

        /// Every option but for the method, in the order in which META and the build key name them.
        pub static OPTIONS: &[OptionInfo] = &[$(OptionInfo {
            name: $name,
            placeholder: $placeholder,
            kind: $kind,
            readers: $readers,
            key: $key,
            spelling: $spelling,
            help: $help,
            details: $details,
            write: |options| options.$field.write(),
            read: |options, text| OptionValue::read(text).map(|value| options.$field = value).is_some(),
            fits: |options, kind| options.$field.fits(kind),
        },)*];
    };
}

options! {
    axes: Axes = Axes::All, {
        name: "axes",
        placeholder: "WHICH",
        kind: Kind::Choice(names_of::<Axes>),
        readers: Readers::Only(&[Method::Binned, Method::Sbvh]),
        key: InKey::Always,
        spelling: Spelling::Flag,
        help: "Axes on which object bins are tried",
        details: "`longest` is quicker and fails on long halls, which is a lesson of the samples.",
    }

    bins: u32 = 128, Draft: 32, Balanced: 64, {
        name: "bins",
        placeholder: "N",
        kind: Kind::Count(2, 256),
        readers: Readers::Only(&[Method::Binned, Method::Sbvh]),
        key: InKey::Always,
        spelling: Spelling::Flag,
        help: "Object bins per axis",
        details: "More bins find better planes in large nodes and take longer. Small nodes use fewer.",
    }

    spatial_bins: u32 = 32, Balanced: 8, {
        name: "spatial-bins",
        placeholder: "N",
        kind: Kind::Count(2, 256),
        readers: Readers::Only(&[Method::Sbvh]),
        key: InKey::Always,
        spelling: Spelling::Flag,
        help: "Spatial bins per axis",
        details: "The planes between them are where triangles may be cut. More bins find better planes in large nodes and take longer.",
    }

    radius: u32 = 14, {
        name: "radius",
        placeholder: "N",
        kind: Kind::Count(1, MAX_RADIUS),
        readers: Readers::Only(&[Method::Agglomerative, Method::Oabb]),
        key: InKey::Always,
        spelling: Spelling::Setting,
        help: "Neighbours to either side among which clusters look for their best match",
        details: "They are neighbours on the Morton curve. Fewer are quicker; from two on, trees are about as good on average.",
    }

    basis: HullBasis = HullBasis::Fit, {
        name: "basis",
        placeholder: "WHICH",
        kind: Kind::Choice(names_of::<HullBasis>),
        readers: Readers::Only(&[Method::Oabb]),
        key: InKey::Always,
        spelling: Spelling::Setting,
        help: "Along what the box of two clusters lies: along one of both (quicker), or along what suits the whole",
        details: "With `leaf` all boxes lie along some triangle and grow from level to level, which is the lesson of the method's author.",
    }

    max_leaf: u32 = 8, {
        name: "max-leaf",
        placeholder: "N",
        kind: Kind::Count(1, 255),
        readers: Readers::Every,
        key: InKey::Always,
        spelling: Spelling::Setting,
        help: "Most triangles in a leaf",
        details: "A leaf holds fewer where the SAH says that splitting is cheaper.",
    }

    traversal_cost: f32 = 1.2, {
        name: "sah-trav",
        placeholder: "COST",
        kind: COST,
        readers: Readers::Every,
        key: InKey::Always,
        spelling: Spelling::Setting,
        help: "Cost of an inner node in the SAH",
        details: "C_T in the formula. The higher its ratio to sah-isect, the larger are leaves.",
    }

    intersection_cost: f32 = 1.0, {
        name: "sah-isect",
        placeholder: "COST",
        kind: COST,
        readers: Readers::Every,
        key: InKey::Always,
        spelling: Spelling::Setting,
        help: "Cost of a triangle test in the SAH",
        details: "C_I in the formula. The higher its ratio to sah-trav, the smaller are leaves.",
    }

    clip: Clip = Clip::Exact, {
        name: "clip",
        placeholder: "HOW",
        kind: Kind::Choice(names_of::<Clip>),
        readers: Readers::Only(&[Method::Sbvh]),
        key: InKey::Always,
        spelling: Spelling::Setting,
        help: "What a spatial split cuts: the reference's box (quicker) or the triangle itself (tighter)",
        details: "A triangle that runs aslant fills little of its box. Cutting the triangle then leaves much smaller boxes.",
    }

    split_alpha: f32 = 1e-4, Balanced: 1e-3, {
        name: "split-alpha",
        placeholder: "SHARE",
        kind: Kind::Real(0.0, 1.0),
        readers: Readers::Only(&[Method::Sbvh]),
        key: InKey::Always,
        spelling: Spelling::Flag,
        help: "Try a spatial split where the object split's children overlap by more than this share of the root's area; 0 tries everywhere, 1 nowhere",
        details: "A higher share is quicker, since small nodes then try no spatial split.",
    }

    split_budget: f32 = 1.5, Balanced: 1.25, {
        name: "split-budget",
        placeholder: "FACTOR",
        kind: Kind::Real(1.0, 64.0),
        readers: Readers::Only(&[Method::Sbvh, Method::Auto, Method::Best]),
        key: InKey::Always,
        spelling: Spelling::Flag,
        help: "Most references that a tree may have, as a multiple of its triangles; 1 forbids duplicates",
        details: "It bounds memory and the size of the file. Memory for that many references is set aside.",
    }

    unsplit: bool = true, {
        name: "unsplit",
        placeholder: "BOOL",
        kind: Kind::Switch,
        readers: Readers::Only(&[Method::Sbvh]),
        key: InKey::Always,
        spelling: Spelling::Setting,
        help: "Put a straddling reference wholly to one side of a spatial split where that is cheaper",
        details: "Without it there are more references.",
    }

    prune: f32 = 0.1, {
        name: "prune",
        placeholder: "RATIO",
        kind: Kind::Real(0.0, 1e3),
        readers: Readers::Only(&[Method::Bonsai]),
        key: InKey::Always,
        spelling: Spelling::Setting,
        help: "Open mini trees where a node's area is more than so many times that of the average mini tree",
        details: "A lower ratio opens more of them, at most an eighth as many nodes as there are references.",
    }

    presplit: f32 = 0.0, {
        name: "presplit",
        placeholder: "SHARE",
        kind: Kind::Real(0.0, 63.0),
        readers: Readers::Only(&[Method::Binned, Method::Bonsai, Method::Sweep, Method::Agglomerative]),
        key: InKey::UnlessOff,
        spelling: Spelling::Setting,
        help: "Cut large triangles before the build into as many more references as this share of the triangles; 0 cuts none",
        details: "It helps where triangles are large or thin. A share of 0.3 adds at most three references for every ten triangles.",
    }

    levels: Levels = Levels::Auto, {
        name: "levels",
        placeholder: "HOW",
        kind: Kind::Choice(names_of::<Levels>),
        readers: Readers::Every,
        key: InKey::Always,
        spelling: Spelling::Flag,
        help: "One tree over everything, or one per mesh and one over the instances",
        details: "`auto` takes two levels when some mesh stands in several places.",
    }

    reinsert: u32 = 0, {
        name: "reinsert",
        placeholder: "ROUNDS",
        kind: Kind::Count(0, 1000),
        readers: Readers::AllButSearches,
        key: InKey::UnlessOff,
        spelling: Spelling::Flag,
        help: "After the build, move subtrees to where they cost least, in at most so many rounds; 0 leaves the tree as it is",
        details: "The eighth round still gains a little, later ones next to nothing.",
    }

    adapt: u32 = 0, {
        name: "adapt",
        placeholder: "RAYS",
        kind: Kind::Count(0, MAX_ADAPT),
        readers: Readers::AllButSearches,
        key: InKey::UnlessOff,
        spelling: Spelling::Flag,
        help: "After the build, put parts of the tree together anew where so many rays of each family then visit fewer boxes; 0 leaves it",
        details: "The rays are derived from the scene. It comes after reinsertion, and is taken back where other rays of any family would pay for it. `auto` and `best` take half a ray a triangle, and 4096 at most.",
    }

    collapse: bool = false, {
        name: "collapse",
        placeholder: "BOOL",
        kind: Kind::Switch,
        readers: Readers::AllButSearches,
        key: InKey::UnlessOff,
        spelling: Spelling::Setting,
        help: "After the build, make leaves of subtrees where the SAH says that it is cheaper",
        details: "Leaves stay within max-leaf.",
    }

    purpose: Purpose = Purpose::All, {
        name: "rays-for",
        placeholder: "WHAT",
        kind: Kind::Choice(names_of::<Purpose>),
        readers: Readers::WhereRaysDecide,
        key: InKey::UnlessUsual,
        spelling: Spelling::Flag,
        help: "What the rays are for that searches judge trees by, and that trees are adapted to",
        details: "`camera` is pictures, `bake` is light that is stored at surfaces, `physics` is queries from anywhere; `all` weighs all families of rays alike.",
    }
}

/// The option of that name.
pub fn option(name: &str) -> Option<&'static OptionInfo> {
    OPTIONS.iter().find(|row| row.name == name)
}
