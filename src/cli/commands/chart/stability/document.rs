//! The figures for programs.

use super::super::document::Outputs;
use super::Judged;
use crate::cli::drawing::FIGURES;
use crate::cli::exit::Exit;
use crate::cli::table::csv_line;
use crate::stability::{Effort, MotionReport, Refusal, SceneReport, SplitReport};
use serde::Serialize;

/// What a run came to.
#[derive(Serialize)]
pub struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    interrupted: bool,
    #[serde(flatten)]
    effort: Effort,
    outputs: Outputs,
    scenes: &'a [SceneReport],
    motions: &'a [MotionReport],
    splits: Option<&'a SplitReport>,
    refused: &'a [Refusal],
    left_out: &'a [&'static str],
    broken: &'a [String],
}

impl<'a> Document<'a> {
    pub fn new(judged: &'a Judged, broken: &'a [String], outputs: Outputs, exit: Exit) -> Document<'a> {
        Document {
            schema: "bvhc.stability.v1",
            exit_code: exit.code(),
            interrupted: exit == Exit::Interrupted,
            effort: judged.effort,
            outputs,
            scenes: &judged.scenes,
            motions: &judged.motions,
            splits: judged.splits.as_ref(),
            refused: &judged.refused,
            left_out: &judged.left_out,
            broken,
        }
    }
}

/// What comes after [`FIGURES`].
const COLUMNS: [&str; 14] = [
    "triangles",
    "wrong",
    "depth",
    "largest_leaf",
    "references",
    "nodes",
    "cost",
    "over_cheapest",
    "seconds",
    "peak_bytes",
    "time_growth",
    "memory_growth",
    "trees_built",
    "reason",
];

/// All figures, a line each, with a heading.
pub fn csv(judged: &Judged) -> String {
    let mut out = csv_line(FIGURES.into_iter().chain(COLUMNS));
    let mut put = |head: [&str; 4], cells: [String; 14]| {
        out.push_str(&csv_line(head.into_iter().chain(cells.iter().map(String::as_str))));
    };
    for scene in &judged.scenes {
        for grown in &scene.recipes {
            for (row, growth) in [(&grown.small, None), (&grown.large, Some(grown))] {
                let of = |value: &dyn Fn(&crate::stability::Grown) -> f64| {
                    growth.map_or(String::new(), |g| value(g).to_string())
                };
                let cells = [
                    row.triangles.to_string(),
                    row.wrong.to_string(),
                    row.depth.to_string(),
                    row.largest_leaf.to_string(),
                    row.references.to_string(),
                    row.nodes.to_string(),
                    row.cost.to_string(),
                    of(&|g| g.over),
                    row.seconds.to_string(),
                    row.peak_bytes.to_string(),
                    of(&|g| g.time_growth),
                    of(&|g| g.memory_growth),
                    String::new(),
                    growth.and_then(|g| g.poor).unwrap_or_default().to_string(),
                ];
                put([scene.name, scene.id, row.recipe, ""], cells);
            }
        }
    }
    for motion in &judged.motions {
        for row in &motion.rows {
            let mut cells = [const { String::new() }; 14];
            cells[0] = motion.triangles.to_string();
            cells[1] = row.wrong.to_string();
            cells[7] = row.worst_over.to_string();
            cells[12] = row.built.to_string();
            put([motion.name, motion.id, row.refit, ""], cells);
        }
    }
    out
}
