//! What each scene is held to, beside what holds for every recipe on all of them.

use super::judge::Row;
use super::recipes::AUTO;
use serde::Serialize;

/// A promise about the recipes on one scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gate {
    /// What a ray costs by the first recipe is at most so many times what it costs by the second.
    AtMost(&'static str, f64, &'static str),
    /// It is at least as much: a failure that is known, and that the scene is there to show.
    AtLeast(&'static str, f64, &'static str),
    /// A recipe has at most so many references a triangle.
    References(&'static str, f64),
}

/// What became of a promise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Kept {
    /// The promise, for people.
    pub promise: String,
    /// What was measured.
    pub value: f64,
    /// Whether it is kept.
    pub holds: bool,
}

use Gate::{AtLeast, AtMost, References};

/// At most so many times as much as by the cheapest recipe costs a ray where `auto` chose; it judges by families of rays, and the table by cameras.
pub const AUTO_MARGIN: f64 = 1.25;
/// More than this times the cheapest is poor.
pub const POOR: f64 = 1.5;
/// A build may take so many times as long for each triangle of the larger size, and hold so many times as much.
pub const GROWTH: [f64; 2] = [3.0, 1.6];
/// What asks rays may take so many times as long for each triangle of the larger size, or as many times as there are triangles: up to 8,192 triangles more
/// triangles have more rays, and where boxes overlap like fog each of them visits a part of them all.
pub const GROWTH_OF_RAYS: f64 = 5.0;

/// Whether a recipe traces rays to build.
pub fn asks_rays(recipe: &str) -> bool {
    [AUTO, "best", "adapt"].contains(&recipe)
}

/// How many times as long a recipe may take for each triangle where there are `triangles` times as many.
pub fn time_growth(recipe: &str, triangles: f64) -> f64 {
    if asks_rays(recipe) { GROWTH_OF_RAYS.max(triangles) } else { GROWTH[0] }
}

const GATES: &[(&str, &[Gate])] = &[
    ("F01", &[AtLeast("longest axis", 1.0, "draft"), AtMost("draft", 1.6, "sbvh")]),
    ("F03", &[AtMost("draft", 1.25, "sweep")]),
    ("F07", &[AtMost("agglomerative", 1.3, "binned")]),
    ("F08", &[References(AUTO, 1.02), References("best", 1.02)]),
    ("F10", &[AtMost("sbvh", 0.9, "sweep")]),
    ("F20", &[References("sbvh", 1.5)]),
    ("F32", &[AtMost(AUTO, 1.0, "sweep")]),
];

/// What a scene is held to beside the rest.
pub fn gates(id: &str) -> impl Iterator<Item = Gate> {
    GATES.iter().filter(move |(of, _)| *of == id).flat_map(|(_, gates)| gates.iter().copied())
}

impl Gate {
    /// Whether it is kept by what was measured; `None` where one of its recipes was not.
    pub fn asked(self, rows: &[Row]) -> Option<Kept> {
        let find = |name: &str| rows.iter().find(|row| row.recipe == name);
        let over = |a: &str, b: &str| Some(ratio(find(a)?.cost, find(b)?.cost));
        Some(match self {
            AtMost(a, most, b) => {
                let value = over(a, b)?;
                Kept { promise: format!("{a} costs at most {most} times {b}"), value, holds: value <= most }
            }
            AtLeast(a, least, b) => {
                let value = over(a, b)?;
                Kept { promise: format!("{a} costs at least {least} times {b}"), value, holds: value >= least }
            }
            References(a, most) => {
                let value = find(a)?.references;
                Kept { promise: format!("{a} has at most {most} references a triangle"), value, holds: value <= most }
            }
        })
    }
}

/// How many times as much; nothing costs as much as nothing.
pub fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 1.0 }
}

/// Why trees of oriented boxes do badly where a scene is there for something else.
const ORIENTED: &str = "pairs are chosen among neighbours on the Morton curve by boxes that may lean, and rays walk those along the axes that come of it";

/// Why a recipe does badly on a scene: what the scene is there for, where that is about the recipe.
pub fn reason(recipe: &str, breaks: &'static str) -> &'static str {
    let is_about_it = ["agglomeration", "oriented"].iter().any(|of| breaks.starts_with(of));
    if recipe.starts_with("oabb") && !is_about_it { ORIENTED } else { breaks }
}
