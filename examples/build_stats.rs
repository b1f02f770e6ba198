//! Build time and tree quality, a row per scene and preset:
//! `cargo run --release --example build_stats -- [--jobs N] [--repeat N] [--set option=value]… [--preset NAME]… FILE…`
//!
//! SAH with the report constants over leaves as stored; ms is the least of the repeats, reading excluded.

use bvhc::build::{self, Axes, BuildOptions, Clip, Executor, Levels, Method, NoProgress, Preset};
use bvhc::scene::{self, Mesh, ReadOptions};
use bvhc::tree::quality::sah;
use std::time::Instant;

fn main() {
    let (mut jobs, mut repeat, mut sets, mut files, mut presets) = (0, 3, Vec::new(), Vec::new(), Vec::new());
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().expect("a value after the option");
        match arg.as_str() {
            "--jobs" => jobs = value().parse().expect("a number of threads"),
            "--repeat" => repeat = value().parse().expect("a number of builds"),
            "--set" => sets.push(value()),
            "--preset" => presets.push(value()),
            _ => files.push(arg),
        }
    }
    if presets.is_empty() {
        presets = ["draft", "balanced", "best"].map(String::from).to_vec();
    }
    let exec = Executor::new(jobs).expect("threads");
    println!("| scene | triangles | preset | ms | ms/Mtri | SAH | refs/tri | depth | nodes |");
    println!("|---|--:|---|--:|--:|--:|--:|--:|--:|");
    for file in &files {
        let mesh = read(file);
        for preset in &presets {
            let mut options = BuildOptions::preset(match preset.as_str() {
                "draft" => Preset::Draft,
                "balanced" => Preset::Balanced,
                _ => Preset::Best,
            });
            sets.iter().for_each(|s| set(&mut options, s));
            let (mut least, mut tree) = (f64::INFINITY, None);
            for _ in 0..repeat {
                let start = Instant::now();
                tree = Some(build::build_tree(&mesh, &options, &exec, &NoProgress).expect("a tree"));
                least = least.min(start.elapsed().as_secs_f64() * 1e3);
            }
            let tree = tree.expect("one build at least");
            let count = mesh.triangles.len() as f64;
            println!(
                "| {} | {} | {preset} | {least:.1} | {:.0} | {:.2} | {:.3} | {} | {} |",
                std::path::Path::new(file).file_stem().unwrap_or_default().to_string_lossy(),
                mesh.triangles.len(),
                least / count * 1e6,
                sah(&tree.nodes),
                tree.refs.len() as f64 / count,
                tree.max_depth(),
                tree.live_nodes(),
            );
        }
    }
}

fn set(options: &mut BuildOptions, assignment: &str) {
    let (name, value) = assignment.split_once('=').expect("option=value");
    let number = || value.parse::<f32>().expect("a number");
    match name {
        "method" => options.method = if value == "binned" { Method::Binned } else { Method::Sbvh },
        "axes" => options.axes = if value == "longest" { Axes::Longest } else { Axes::All },
        "bins" => options.bins = number() as u32,
        "spatial_bins" => options.spatial_bins = number() as u32,
        "max_leaf" => options.max_leaf = number() as u32,
        "ct" => options.traversal_cost = number(),
        "ci" => options.intersection_cost = number(),
        "clip" => options.clip = if value == "box" { Clip::Box } else { Clip::Exact },
        "alpha" => options.split_alpha = number(),
        "budget" => options.split_budget = number(),
        "unsplit" => options.unsplit = value == "true",
        _ => panic!("no option {name}"),
    }
}

/// The scene as one mesh in world space.
fn read(path: &str) -> Mesh {
    let scene = scene::read(path.as_ref(), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let options = BuildOptions { levels: Levels::One, ..BuildOptions::preset(Preset::Draft) };
    let accel = build::compile(scene, &options, &Executor::sequential(), &NoProgress).expect("one mesh");
    accel.meshes.into_iter().next().expect("a mesh")
}
