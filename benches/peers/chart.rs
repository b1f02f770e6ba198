//! The chart: build time across, ray cost upwards, one panel a scene, with the front over all builders.

use crate::measure::Measured;
use bvhc::report::chart::{Axis, Chart, Panel, Point, Series};

/// What is named beside its dot; the others would cover one another.
const NAMED: [&str; 8] = [
    "bvhc draft",
    "bvhc balanced",
    "bvhc best",
    "bvhc auto",
    "obvhs fastest",
    "obvhs very_slow",
    "embree medium",
    "embree high",
];

pub fn svg(scenes: &[Measured]) -> Result<String, String> {
    let chart = Chart {
        title: String::new(),
        notes: vec![
            "Every tree was built from the same triangles and traced by the same rays. Lower left is better.".into(),
        ],
        panels: scenes.iter().map(panel).collect(),
        columns: 2,
        ..Chart::default()
    };
    chart.svg().map_err(|e| e.to_string())
}

fn panel(scene: &Measured) -> Panel {
    let time = Axis::logarithmic("build time on two threads, ms").lower_is_better();
    let cost = Axis::linear("ray cost").lower_is_better();
    let mut panel = Panel::new(scene.name.clone(), time, cost);
    for (colour, family) in ["bvhc", "obvhs", "embree", "bvh", "tinybvh"].into_iter().enumerate() {
        let trees = scene.trees.iter().filter(|t| t.family == family && t.ms[1].is_finite());
        let points: Vec<Point> = trees
            .map(|tree| {
                let point = Point::new(tree.ms[1], tree.ray_cost);
                if NAMED.contains(&tree.name().as_str()) { point.named(tree.setting.clone()) } else { point }
            })
            .collect();
        if !points.is_empty() {
            panel = panel.with(Series::new(family, colour, points));
        }
    }
    panel.with_front()
}
