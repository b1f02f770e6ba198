//! The league: builders beside each other on the same scenes, binary and 8-wide, each with its own traversal, and what that loses.
//!
//! ```text
//! cargo bench --bench league -- [--scenes A,B] [--recipes A,B] [--peers A,B|none] [--rays N] [--output NAME] [--smoke]
//! ```
//!
//! Scenes, peers and what cannot be had are those of `peers.rs`; with `--smoke` it is a tiny sample without peers. Of every tree it says
//!
//! - *nodes*, and *ray cost* (1.2 · inner nodes + triangle tests a ray) by our evaluator, for binary trees, which can be read;
//! - *build*: the builder alone on one thread, from triangles in memory to what rays are traced in;
//! - *bytes* that rays need, and *load*: what a program pays at every start, for us opening the file with its hashes checked, for a peer the build;
//! - *Mrays/s* by the builder's own traversal on one thread, the least time of three;
//! - *lost hits* of fair rays (what four cameras see, and one diffuse bounce off it) and of hard ones (at vertices and edges, along axes and lattices, from far
//!   away): where nothing is found although the exact oracle is certain of a hit, or only something farther away. *False* are hits where nothing is.
//!   `verify::answers` says how an answer is judged. All rays begin at distance 0, have no end and a direction of length 1.
//!
//! The exit code is 1 where a tree of ours loses a hit. `NAME.json`, `NAME.svg`, `NAME.html` and `NAME.md` are written after each scene.

#[path = "league/draw.rs"]
mod draw;
#[path = "league/measure.rs"]
mod measure;
#[path = "league/pipe.rs"]
mod pipe;
#[path = "peers/recipes.rs"]
mod recipes;
#[path = "peers/scenes.rs"]
#[allow(dead_code)]
mod scenes;
#[path = "peers/workers.rs"]
#[allow(dead_code)]
mod workers;

use bvhc::report::chart::page::Page;
use clap::Parser;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Parser)]
#[command(about = "Trees of several builders, traced by each builder's own traversal and judged by exact arithmetic")]
struct Options {
    /// Scenes by name or path; default: all models, or the samples where there are none
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<String>,
    /// Which of our listed recipes
    #[arg(long, value_delimiter = ',', default_value = "draft,balanced,auto,best")]
    recipes: Vec<String>,
    /// Which peers, or `none`; default: all that can be had
    #[arg(long, value_delimiter = ',')]
    peers: Vec<String>,
    /// Fair rays, and half as many hard ones
    #[arg(long, default_value_t = 1 << 14)]
    rays: usize,
    /// Files to write, without their extensions
    #[arg(long, value_name = "NAME", default_value = "target/league")]
    output: PathBuf,
    /// A sample of a few thousand triangles, 512 rays, without peers: ends in seconds
    #[arg(long)]
    smoke: bool,
    /// What cargo adds
    #[arg(long, hide = true)]
    bench: bool,
    #[arg(long, hide = true)]
    test: bool,
}

fn main() -> ExitCode {
    let mut options = Options::parse();
    if options.smoke || std::env::var_os("BVHC_BENCH_SMOKE").is_some() {
        let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/helicopter/heli.0001.obj");
        let (scenes, peers) = (vec![sample.to_string_lossy().into_owned()], vec!["none".into()]);
        options = Options { rays: 512, scenes, peers, ..options };
    }
    match run(&options) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(lost) => {
            eprintln!("error: our own trees lose {lost} hits");
            ExitCode::FAILURE
        }
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

/// How many hits trees of ours lose.
fn run(options: &Options) -> Result<u64, String> {
    let recipes = recipes::recipes(&options.recipes, &[])?;
    let families = workers::asked(&options.peers)?;
    let mut done = Vec::new();
    let mut lost = 0;
    for scene in scenes::scenes(&options.scenes)? {
        let measured = measure::measure(&scene, &recipes, &families, options.rays)?;
        lost += measured.rows.iter().filter(|row| row.peer == measure::OURS).map(measure::Row::lost).sum::<u64>();
        done.push(measured);
        write(options, &done)?;
    }
    print!("{}", draw::markdown(&done));
    Ok(lost)
}

fn write(options: &Options, done: &[measure::Measured]) -> Result<(), String> {
    let sections = done.iter().map(draw::section).collect();
    let lead = draw::LEAD.iter().map(|text| (*text).to_string()).collect();
    let page = Page { title: "The league".into(), lead, sections, ..Page::default() };
    let json = serde_json::to_string_pretty(done).map_err(|e| e.to_string())?;
    let svg = draw::chart(done).svg().map_err(|e| e.to_string())?;
    let files = [("json", json), ("svg", svg), ("html", page.html()), ("md", draw::markdown(done))];
    for (extension, content) in files {
        let file = options.output.with_extension(extension);
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder).map_err(|e| format!("cannot make {}: {e}", folder.display()))?;
        }
        std::fs::write(&file, content).map_err(|e| format!("cannot write {}: {e}", file.display()))?;
    }
    Ok(())
}
