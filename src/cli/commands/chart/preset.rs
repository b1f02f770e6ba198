//! Which preset to type for a model, by its chart.

use super::measure::Model;
use super::quoted;
use crate::cli::figures;
use crate::cli::names;
use crate::cli::reading::ModelReading;
use crate::report::tradeoff::{Origin, Row};
use std::path::Path;

/// A preset suits that costs rays at most so much more than the cheapest tree of the chart that flags build.
const WITHIN: f64 = 1.05;
/// Ray cost whose standard error is a larger share of it tells no points apart that people would choose between.
const TOLD_APART: f64 = 0.05;

/// The quickest preset of those that suit, and what it is chosen from.
pub struct Advice<'a> {
    pub preset: &'a Row,
    /// Its ray cost over the least one.
    pub over: f64,
    /// The recipe of that.
    pub least: &'a Row,
}

/// Nothing where not all presets were measured, or too few rays counted.
pub fn advice(model: &Model, asked: u32) -> Option<Advice<'_>> {
    let measured = &model.recipes;
    let has_all = !measured.left_out.iter().any(|left| left.origin == Origin::Preset);
    if !has_all || few_rays(model, asked).is_some() {
        return None;
    }
    let ours = || measured.recipes.iter().filter(|row| row.origin != Origin::Peer);
    let least = ours().min_by(|a, b| a.rays.cost.total_cmp(&b.rays.cost))?;
    let presets = || ours().filter(|row| row.origin == Origin::Preset);
    let cheapest = presets().min_by(|a, b| a.rays.cost.total_cmp(&b.rays.cost))?;
    let suits = |row: &&Row| row.rays.cost <= WITHIN * least.rays.cost;
    let seconds = |row: &Row| row.build.median_seconds;
    let preset = presets().filter(suits).min_by(|a, b| seconds(a).total_cmp(&seconds(b))).unwrap_or(cheapest);
    Some(Advice { preset, over: preset.rays.cost / least.rays.cost, least })
}

impl Advice<'_> {
    /// In a line, with what to type.
    pub fn line(&self, path: &Path, reading: &ModelReading) -> String {
        let Advice { preset, least, .. } = self;
        let cost = match 100.0 * (self.over - 1.0) {
            more if more < 0.05 => "no other tree here costs rays less".to_string(),
            more => format!("its rays cost {more:.1} % more than by {}", least.name),
        };
        let output = path.with_extension("bvhc");
        let mut typed =
            format!("bvhc build {} -o {}", quoted(&path.to_string_lossy()), quoted(&output.to_string_lossy()));
        for word in ["--preset".to_string(), preset.name.clone()].iter().chain(&reading.typed()) {
            typed = format!("{typed} {}", quoted(word));
        }
        format!(
            "For {} preset {} suits, built in {} ms: {cost}. Type: {typed}",
            names::file(path),
            preset.name,
            figures::milliseconds(preset.build.median_seconds)
        )
    }
}

/// What is said where rays are too few to tell points apart, by the row whose cost is known worst. `asked` rays a set were wanted.
pub fn few_rays(model: &Model, asked: u32) -> Option<String> {
    let share = |row: &Row| if row.rays.cost > 0.0 { row.rays.standard_error / row.rays.cost } else { 1.0 };
    let worst = model.recipes.recipes.iter().map(share).fold(0.0, f64::max);
    let sets = model.recipes.recipes.first().map_or(&[][..], |row| &row.rays.sets[..]);
    let rays = sets.iter().map(|set| set.rays).sum::<u64>();
    // Of a handful the error itself is a guess.
    let is_known = sets.iter().all(|set| set.rays >= LEAST_RAYS);
    if worst <= TOLD_APART && is_known {
        return None;
    }
    // The error falls with the root of the number.
    let wanted = (f64::from(asked) * (worst / TOLD_APART).powi(2)) as u32;
    let more = if is_known { wanted.next_power_of_two() } else { 0 }.clamp(DEFAULT_RAYS, MOST_RAYS);
    let known = if is_known { format!("is known to ±{:.0} %", 100.0 * worst) } else { "is a guess".into() };
    let help = if more > asked { format!("; --rays {more} tells more") } else { String::new() };
    Some(format!("{} tell no recipes apart: ray cost {known}{help}", figures::counted(rays, "ray", "rays")))
}

/// Fewest rays of a set with a spread that says something.
const LEAST_RAYS: u64 = 64;
const DEFAULT_RAYS: u32 = 4096;
/// What the flag takes.
const MOST_RAYS: u32 = 1_000_000;
