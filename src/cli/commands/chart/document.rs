//! The figures for programs.

use super::measure::{Arithmetic, Charted, Missing};
use super::sections::arithmetic_name;
use super::{ChartArgs, command, preset};
use crate::cli::Context;
use crate::cli::drawing::FIGURES;
use crate::cli::exit::Exit;
use crate::cli::table::csv_line;
use crate::report::frames::SequenceReport;
use crate::report::tradeoff::{FormRow, Prediction, Row, TradeOff, predictions};
use crate::verify::accuracy::Report;
use serde::Serialize;
use std::collections::BTreeMap;

/// What a run came to.
#[derive(Serialize)]
pub struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    interrupted: bool,
    /// On which trees were built.
    threads: u64,
    /// What the run was given.
    budget: f64,
    most_rounds: u32,
    outputs: Outputs,
    models: Vec<ModelDocument<'a>>,
    sequences: Vec<SequenceDocument<'a>>,
    /// How well figures of trees predict the time that rays take, over all models.
    predictions: Vec<Prediction>,
}

/// Files that were written.
#[derive(Serialize)]
pub struct Outputs {
    pub html: Option<String>,
    pub svg: Option<String>,
    pub png: Option<String>,
    pub csv: Option<String>,
}

#[derive(Serialize)]
struct ModelDocument<'a> {
    path: String,
    triangles: u64,
    instanced_triangles: u64,
    command: String,
    #[serde(flatten)]
    recipes: &'a TradeOff,
    arithmetic: Option<ArithmeticDocument<'a>>,
    /// Why there is no `arithmetic`: `not_asked`, `budget` or `interrupted`.
    arithmetic_left_out: Option<&'static str>,
    /// The forms of one of the trees; `null` where there was no time.
    forms: Option<FormsDocument<'a>>,
    /// Which preset suits, by its flag; `null` where too little is known.
    advice: Option<&'a str>,
}

#[derive(Serialize)]
struct FormsDocument<'a> {
    /// The recipe of the trees.
    tree: &'a str,
    rows: &'a [FormRow],
}

#[derive(Serialize)]
struct ArithmeticDocument<'a> {
    /// The recipe of the trees.
    tree: &'a str,
    #[serde(flatten)]
    report: &'a Report,
}

#[derive(Serialize)]
struct SequenceDocument<'a> {
    command: String,
    #[serde(flatten)]
    report: &'a SequenceReport,
    /// Of each frame.
    open_seconds: &'a [f64],
}

impl<'a> Document<'a> {
    pub fn new(
        args: &ChartArgs,
        charted: &'a [Charted],
        outputs: Outputs,
        exit: Exit,
        context: &Context,
    ) -> Document<'a> {
        let (mut models, mut sequences) = (Vec::new(), Vec::new());
        for one in charted {
            let command = command(args, one.path());
            match one {
                Charted::Sequence(sequence) => {
                    let (report, open_seconds) = (&sequence.report, &sequence.opened[..]);
                    sequences.push(SequenceDocument { command, report, open_seconds });
                }
                Charted::Model(model) => {
                    let shown = |a: &'a Arithmetic| ArithmeticDocument { tree: &a.tree, report: &a.report };
                    models.push(ModelDocument {
                        path: model.path.to_string_lossy().into_owned(),
                        triangles: model.triangles,
                        instanced_triangles: model.instanced_triangles,
                        command,
                        recipes: &model.recipes,
                        arithmetic: model.arithmetic.as_ref().ok().map(shown),
                        arithmetic_left_out: model.arithmetic.as_ref().err().map(|missing| missing.name()),
                        forms: model.forms.as_ref().map(|(tree, rows)| FormsDocument { tree, rows }),
                        advice: preset::advice(model, args.rays).map(|advice| advice.preset.flags.as_str()),
                    });
                }
            }
        }
        Document {
            schema: "bvhc.chart.v1",
            exit_code: exit.code(),
            interrupted: exit == Exit::Interrupted,
            threads: context.exec.threads() as u64,
            budget: args.budget().as_secs_f64(),
            most_rounds: args.rounds(),
            outputs,
            models,
            sequences,
            predictions: predictions_of(charted),
        }
    }
}

/// Over all models together.
pub fn predictions_of(charted: &[Charted]) -> Vec<Prediction> {
    let models = charted.iter().filter_map(|one| match one {
        Charted::Model(model) => Some(&model.recipes),
        Charted::Sequence(_) => None,
    });
    predictions(&models.collect::<Vec<_>>())
}

impl Missing {
    fn name(self) -> &'static str {
        match self {
            Missing::NotAsked => "not_asked",
            Missing::Budget => "budget",
            Missing::Interrupted => "interrupted",
        }
    }
}

/// What comes after [`FIGURES`], empty where a picture has no such figure.
const COLUMNS: [&str; 28] = [
    "chosen_by",
    "front",
    "rounds",
    "median_seconds",
    "lower_seconds",
    "upper_seconds",
    "least_seconds",
    "most_seconds",
    "ray_cost",
    "visits",
    "tests",
    "nodes",
    "references",
    "depth",
    "sah",
    "mrays_per_second",
    "fair_wrong_per_million",
    "hard_wrong_per_million",
    "largest_ulps",
    "segment",
    "built",
    "bytes",
    "open_seconds",
    "epo",
    "trace_seconds",
    "bits",
    "bytes_per_triangle",
    "lost",
];

/// All figures, a line each, with a heading.
pub fn csv(charted: &[Charted]) -> String {
    let mut out = csv_line(FIGURES.into_iter().chain(COLUMNS));
    for one in charted {
        let path = one.path().to_string_lossy();
        let mut put = |picture: &str, name: &str, flags: &str, cells: &BTreeMap<&str, String>| {
            debug_assert!(cells.keys().all(|column| COLUMNS.contains(column)));
            let cells = COLUMNS.iter().map(|column| cells.get(column).map_or("", String::as_str));
            out.push_str(&csv_line([&*path, picture, name, flags].into_iter().chain(cells)));
        };
        match one {
            Charted::Sequence(sequence) => {
                for (frame, seconds) in sequence.report.frames.iter().zip(&sequence.opened) {
                    let mut cells = BTreeMap::from([
                        ("sah", frame.sah.to_string()),
                        ("segment", frame.segment.to_string()),
                        ("built", frame.built.to_string()),
                        ("bytes", frame.bytes.to_string()),
                        ("open_seconds", seconds.to_string()),
                    ]);
                    cells.extend(frame.ray_cost.map(|cost| ("ray_cost", cost.to_string())));
                    put("frames", &frame.number.to_string(), "", &cells);
                }
            }
            Charted::Model(model) => {
                for row in &model.recipes.recipes {
                    put("recipes", &row.name, &row.flags, &recipe_cells(row));
                }
                for row in model.forms.iter().flat_map(|(_, rows)| rows) {
                    let cells = BTreeMap::from([
                        ("mrays_per_second", row.mrays_per_second.to_string()),
                        ("bits", row.bits.to_string()),
                        ("bytes_per_triangle", row.bytes_per_triangle.to_string()),
                        ("lost", row.lost.to_string()),
                    ]);
                    put("forms", row.name, "", &cells);
                }
                let rows = model.arithmetic.iter().flat_map(|measured| &measured.report.rows);
                for row in rows {
                    let cells = BTreeMap::from([
                        ("mrays_per_second", row.mrays_per_second.to_string()),
                        ("fair_wrong_per_million", row.fair.per_million().to_string()),
                        ("hard_wrong_per_million", row.hard.per_million().to_string()),
                        ("largest_ulps", row.distance.max().to_string()),
                        ("visits", row.inner_nodes_per_ray.to_string()),
                        ("tests", row.triangles_per_ray.to_string()),
                    ]);
                    put("arithmetic", &arithmetic_name(row), "", &cells);
                }
            }
        }
    }
    out
}

fn recipe_cells(row: &Row) -> BTreeMap<&'static str, String> {
    let build = &row.build;
    BTreeMap::from([
        ("chosen_by", row.chosen_by.join(" ")),
        ("front", row.front.to_string()),
        ("rounds", build.rounds.to_string()),
        ("median_seconds", build.median_seconds.to_string()),
        ("lower_seconds", build.lower_seconds.to_string()),
        ("upper_seconds", build.upper_seconds.to_string()),
        ("least_seconds", build.least_seconds.to_string()),
        ("most_seconds", build.most_seconds.to_string()),
        ("ray_cost", row.rays.cost.to_string()),
        ("visits", row.rays.mean(|set| set.visits).to_string()),
        ("tests", row.rays.mean(|set| set.tests).to_string()),
        ("nodes", row.nodes.to_string()),
        ("references", row.references.to_string()),
        ("depth", row.depth.to_string()),
        ("sah", row.sah.to_string()),
        ("epo", row.epo.to_string()),
        ("trace_seconds", row.trace_seconds.to_string()),
    ])
}
