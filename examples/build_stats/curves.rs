//! Charts of the table's columns.

use crate::Row;
use bvhc::report::chart::{Axis, Chart, Panel, Point, Series};

pub type Draw = fn(&[Row]) -> Chart;

/// Time for each of n·log2 n against the number of triangles: a curve that stays level grows with it.
pub fn growth(rows: &[Row]) -> Chart {
    let count = Axis::logarithmic("triangles");
    let time = Axis::linear("build time, ns for each of n·log2 n").lower_is_better();
    let curve = |recipe: &String| {
        let points = rows.iter().filter(|row| &row.recipe == recipe).map(|row| Point::new(row.triangles, row.growth()));
        points.collect()
    };
    let panel = curves(Panel::new("", count, time), distinct(rows, |row| &row.recipe), curve);
    Chart { panels: vec![panel], columns: 1, ..Chart::default() }
}

/// Rays and time of `bonsai,prune=…` beside `sweep`, against the ratio.
pub fn pruning(rows: &[Row]) -> Chart {
    let ratio = || Axis::logarithmic("ratio of --prune");
    let cost = Axis::linear("ray cost, sweep = 1").lower_is_better();
    let time = Axis::linear("build time, sweep = 1").lower_is_better();
    let curve = |scene: &String, quantity: fn(&Row) -> f64| {
        let of_scene = || rows.iter().filter(|row| &row.scene == scene);
        let one = of_scene().find(|row| row.recipe == "sweep").map_or(f64::NAN, quantity);
        let pruned = of_scene().filter_map(|row| Some((row.recipe.strip_prefix("bonsai,prune=")?.parse().ok()?, row)));
        pruned.map(|(ratio, row)| Point::new(ratio, quantity(row) / one)).collect()
    };
    let scenes = || distinct(rows, |row| &row.scene);
    let rays =
        curves(Panel::new("", ratio(), cost), scenes(), |scene| curve(scene, |row| row.ray_cost.unwrap_or(f64::NAN)));
    let times = curves(Panel::new("", ratio(), time), scenes(), |scene| curve(scene, |row| row.ms));
    Chart { panels: vec![rays, times], columns: 2, ..Chart::default() }
}

/// The values of a column, each once, in their order.
fn distinct(rows: &[Row], column: fn(&Row) -> &String) -> Vec<&String> {
    let mut values: Vec<&String> = Vec::new();
    for value in rows.iter().map(column) {
        if !values.contains(&value) {
            values.push(value);
        }
    }
    values
}

fn curves(panel: Panel, names: Vec<&String>, points: impl Fn(&String) -> Vec<Point>) -> Panel {
    names
        .into_iter()
        .enumerate()
        .fold(panel, |panel, (colour, name)| panel.with(Series::new(name.as_str(), colour, points(name)).connected()))
}
