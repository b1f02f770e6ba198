//! Beside the peers: build time, tree quality and ray cost of our recipes and of other builders on the same triangles, in one run.
//!
//! ```text
//! cargo bench --bench peers -- [--scenes A,B] [--recipes A,B] [--recipe NAME=FLAGS]… [--peers A,B|none]
//!                              [--rays N] [--rounds N] [--quick] [--json FILE] [--csv FILE] [--svg FILE]
//! ```
//!
//! Scenes are ten real ones from the folder of models (`BVHC_MODELS`), or the samples where that is missing; a path is a scene too. Peers are obvhs, bvh,
//! tinybvh and Embree 4; what cannot be had is left out with a note. Embree's shared library is loaded at run time: `BVHC_EMBREE` names it, or it is
//! found where the system or the Python package `embreex` keeps it. Builds alternate: each
//! round builds every tree once on one thread and once on two, and times are medians over the rounds. A build's time is that of the builder alone, from
//! triangles in memory to a tree in memory.
//!
//! All trees go through one evaluator. SAH and EPO have C_T = 1.2 and C_I = 1. v/t are inner nodes entered and triangles tested per ray by our own
//! traversal for camera rays, one cosine-weighted bounce, and ambient occlusion (any hit within 10 % of the diagonal); `ray cost` is 1.2·v + t,
//! averaged over the three. Mrays/s are of one thread. At the end stand geometric means over all scenes, and for each peer's
//! setting whether a recipe of ours is both as quick and as good; for builders that are no crates, by their recorded figures (`peers/recorded.rs`).

#[path = "peers/chart.rs"]
mod chart;
#[path = "peers/measure.rs"]
mod measure;
#[path = "peers/recipes.rs"]
mod recipes;
#[path = "peers/recorded.rs"]
mod recorded;
#[path = "peers/report.rs"]
mod report;
#[path = "peers/scenes.rs"]
mod scenes;
#[path = "peers/workers.rs"]
mod workers;

use clap::Parser;
use measure::Effort;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Parser)]
#[command(about = "Build our recipes and other builders' trees on the same triangles, and judge them alike")]
struct Options {
    /// Scenes by name or path; default: all models, or the samples where there are none
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<String>,
    /// Which of our listed recipes; default: all
    #[arg(long, value_delimiter = ',')]
    recipes: Vec<String>,
    /// One more recipe: a name and the flags of `bvhc build` that it stands for
    #[arg(long, value_name = "NAME=FLAGS")]
    recipe: Vec<String>,
    /// Which peers, or `none`; default: all that can be had
    #[arg(long, value_delimiter = ',')]
    peers: Vec<String>,
    /// Rays in each of the three sets
    #[arg(long, default_value_t = 1 << 18)]
    rays: usize,
    /// How often everything is built and traced
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// One round, 16,384 rays a set, EPO at 65,536 points
    #[arg(long)]
    quick: bool,
    /// Everything as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Everything as comma-separated values
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Build time against ray cost, a panel a scene
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// What cargo adds
    #[arg(long, hide = true)]
    bench: bool,
    #[arg(long, hide = true)]
    test: bool,
}

fn main() -> ExitCode {
    let mut options = Options::parse();
    if std::env::var_os("BVHC_BENCH_SMOKE").is_some() {
        // Once through, without a network: a sample, our own recipes, and all outputs.
        options = Options { quick: true, scenes: vec!["stadium".into()], peers: vec!["none".into()], ..options };
    }
    match run(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), String> {
    let recipes = recipes::recipes(&options.recipes, &options.recipe)?;
    let scenes = scenes::scenes(&options.scenes)?;
    let families = workers::asked(&options.peers)?;
    let effort = match options.quick {
        true => Effort { rays: options.rays.min(1 << 14), rounds: 1, epo_points: Some(1 << 16) },
        false => Effort { rays: options.rays, rounds: options.rounds.max(1), epo_points: None },
    };

    // What is done is printed and written at once, so that a run may be cut short.
    let mut done = Vec::new();
    for scene in scenes {
        let measured = measure::measure(&scene, &recipes, &families, effort)?;
        print!("{}", report::scene(&measured));
        done.push(measured);
        write(options.json.as_deref(), || serde_json::to_string_pretty(&done).map_err(|e| e.to_string()))?;
        write(options.csv.as_deref(), || Ok(report::csv(&done)))?;
        write(options.svg.as_deref(), || chart::svg(&done))?;
    }
    print!("{}{}{}", report::summary(&done), report::dominance(&done), recorded::dominance(&done));
    Ok(())
}

fn write(file: Option<&Path>, content: impl Fn() -> Result<String, String>) -> Result<(), String> {
    let Some(file) = file else { return Ok(()) };
    std::fs::write(file, content()?).map_err(|e| format!("cannot write {}: {e}", file.display()))
}
