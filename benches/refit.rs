//! How quick trees are refitted: ours beside Embree's, and beside building.
//!
//! ```text
//! cargo bench --bench refit -- [--scenes A,B] [--rounds N]
//! ```
//!
//! Scenes are those of the bench `peers`; without a list five of them, or the samples. Each is one mesh that twists about its middle to and fro, in eight poses, and
//! every round refits one pose after another by each way on one thread, so that clocks that drift drift for all. Times are medians over all refits.
//!
//! *Ours* is `bvhc_core::refit` over a tree of `sweep` with two rounds of reinsertion, as a file of a sequence holds it. *Embree* is the commit of a triangle geometry
//! with `RTC_BUILD_QUALITY_REFIT` whose vertex buffer was updated, in a dynamic scene of low quality, without which it does not refit; its library is found as by
//! `peers`. *Draft* is our quickest build, of one pose a round. Copying positions to where each wants them is in none of the times.

#[path = "refit/embree.rs"]
mod embree;
// Of these two, the bench `peers` uses more.
#[allow(dead_code)]
#[path = "peers/scenes.rs"]
mod scenes;
#[allow(dead_code)]
#[path = "peers/workers.rs"]
mod workers;

use bvhc::build::{BuildOptions, Executor, Method, NoProgress, Preset};
use bvhc::cache::IndexedTriangleRecord;
use bvhc::compile::build_tree;
use bvhc::geom::Point;
use bvhc::scene::Mesh;
use bvhc::tree::{Node, Tree};
use clap::Parser;
use embree::Refitter;
use std::process::ExitCode;
use std::time::Instant;
use workers::Embree;

/// Poses of a scene.
const POSES: usize = 8;
/// What is measured if nobody says: from a few thousand triangles to some hundred thousands, scans and architecture.
const SCENES: [&str; 5] = ["bunny", "dragon_202k", "san_francisco", "lamborghini", "obvhs_kitchen"];

#[derive(Parser)]
#[command(about = "Refit our trees and Embree's to the same motion")]
struct Options {
    /// Scenes by name or path
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<String>,
    /// How often all poses are refitted
    #[arg(long, default_value_t = 9)]
    rounds: usize,
    /// What cargo adds
    #[arg(long, hide = true)]
    bench: bool,
    #[arg(long, hide = true)]
    test: bool,
}

fn main() -> ExitCode {
    let mut options = Options::parse();
    let is_smoke = std::env::var_os("BVHC_BENCH_SMOKE").is_some();
    if is_smoke {
        options = Options { rounds: 1, scenes: vec!["stadium".into()], ..options };
    }
    match run(&options, is_smoke) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options, is_smoke: bool) -> Result<(), String> {
    let all = scenes::scenes(&options.scenes)?;
    let is_default = |name: &str| SCENES.contains(&name) || !all.iter().any(|scene| SCENES.contains(&&*scene.name));
    let some = all.iter().filter(|scene| !options.scenes.is_empty() || is_default(&scene.name));
    let embree = if is_smoke { None } else { Embree::find() };
    println!("| scene | triangles | ours, Mtri/s | Embree, Mtri/s | ours : Embree | draft, Mtri/s | ours : draft |");
    println!("|---|--:|--:|--:|--:|--:|--:|");
    let mut logs = [Vec::new(), Vec::new()];
    for scene in some {
        let mesh = scene.load()?;
        let times =
            measure(&mesh, embree.as_ref(), options.rounds.max(1)).map_err(|e| format!("{}: {e}", scene.name))?;
        let triangles = mesh.triangles.len() as f64;
        let rate = |milliseconds: f64| triangles / milliseconds / 1e3;
        let show = |value: f64| if value.is_nan() { "-".to_string() } else { format!("{value:.1}") };
        let [ours, embree, draft] = times.map(median);
        println!(
            "| {} | {triangles} | {:.1} | {} | {} | {:.2} | {:.1} |",
            scene.name,
            rate(ours),
            show(rate(embree)),
            show(embree / ours),
            rate(draft),
            draft / ours
        );
        logs[0].push((embree / ours).ln());
        logs[1].push((draft / ours).ln());
    }
    let [beside_embree, beside_draft] = logs.map(|logs| (logs.iter().sum::<f64>() / logs.len() as f64).exp());
    if embree.is_some() {
        println!("\nGeometric mean beside Embree: {beside_embree:.2}");
    }
    println!("\nGeometric mean beside draft: {beside_draft:.1}");
    Ok(())
}

/// Milliseconds: ours, Embree's, draft's.
fn measure(mesh: &Mesh, embree: Option<&Embree>, rounds: usize) -> Result<[Vec<f64>; 3], String> {
    let exec = Executor::sequential();
    let preset = BuildOptions::preset(Preset::Draft);
    let options = BuildOptions { method: Method::Sweep, reinsert: 2, ..preset.clone() };
    let tree = build_tree(mesh, &options, &exec, &NoProgress).map_err(|e| e.to_string())?;
    let (order, triangles) = leaf_order(mesh, &tree);
    let poses: Vec<Vec<Point>> = (0..POSES).map(|pose| twisted(mesh, pose)).collect();
    // As a pose of a file has them.
    let ordered = |pose: &Vec<Point>| order.iter().map(|v| pose[*v as usize]).collect();
    let vertices: Vec<Vec<Point>> = poses.iter().map(ordered).collect();
    let mut refitter = embree.map(|form| Refitter::open(form, &mesh.triangles, &poses)).transpose();
    let refitter = refitter.as_mut().map_err(|e| e.to_string())?;

    let mut nodes: Vec<Node> = tree.nodes;
    let mut times: [Vec<f64>; 3] = Default::default();
    for round in 0..rounds {
        for pose in 0..POSES {
            let start = Instant::now();
            bvhc_core::refit::refit(&mut nodes, &triangles, &vertices[pose]).map_err(|e| e.to_string())?;
            times[0].push(start.elapsed().as_secs_f64() * 1e3);
            if let Some(refitter) = refitter {
                let (milliseconds, bounds) = refitter.refit(pose as u8).map_err(|e| e.to_string())?;
                times[1].push(milliseconds);
                if bounds != [nodes[0].min, nodes[0].max] {
                    return Err(format!("Embree's box of pose {pose} is {bounds:?}"));
                }
            }
        }
        let moved = Mesh { positions: poses[round % POSES].clone(), ..mesh.clone() };
        let start = Instant::now();
        std::hint::black_box(build_tree(&moved, &preset, &exec, &NoProgress)).map_err(|e| e.to_string())?;
        times[2].push(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(times)
}

/// The vertices in the order in which the leaves first use them, and the triangles by these.
fn leaf_order(mesh: &Mesh, tree: &Tree) -> (Vec<u32>, Vec<IndexedTriangleRecord>) {
    let mut place = vec![u32::MAX; mesh.positions.len()];
    let mut order = Vec::new();
    let triangle = |r: &u32| {
        let corners = mesh.triangles[*r as usize].map(|v| {
            if place[v as usize] == u32::MAX {
                place[v as usize] = order.len() as u32;
                order.push(v);
            }
            place[v as usize]
        });
        IndexedTriangleRecord { corners, prim: *r, geom: 0, flags: 0 }
    };
    let triangles = tree.refs.iter().map(triangle).collect();
    (order, triangles)
}

/// A mesh that turns about its middle, the more the farther up, to and fro over the poses.
fn twisted(mesh: &Mesh, pose: usize) -> Vec<Point> {
    let bounds = bvhc::geom::Aabb::from_points(&mesh.positions);
    let middle = bounds.center2().map(|c| f64::from(c) * 0.5);
    let height = f64::from(bounds.extent()[1]).max(1e-9);
    let most = (std::f64::consts::TAU * pose as f64 / POSES as f64).sin() * 0.6;
    let turn = |p: &Point| {
        let [x, y, z] = [0, 1, 2].map(|k| f64::from(p[k]) - middle[k]);
        let (sin, cos) = (most * y / height).sin_cos();
        [x * cos - z * sin + middle[0], y + middle[1], x * sin + z * cos + middle[2]].map(|c| c as f32)
    };
    mesh.positions.iter().map(turn).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
