//! What three papers claim of their trees, measured: `cargo run --release --example claims -- [MODELS]`
//!
//! MODELS is a folder as `BVHC_MODELS` names one; without it the samples stand in.
//!
//! 1. M. Molenaar and C. Freda, "Bounding Volume Hierarchies" (2018), table 1: what a frame takes in trees of spatial splits, of bins along the longest axis, and of
//!    bins along three, on a scan, a hall and another scan. Here rays of a renderer: camera, one bounce, occlusion.
//! 2. P. Ganestam, R. Barringer, M. Doggett and T. Akenine-Möller, "Bonsai: Rapid Bounding Volume Hierarchy Generation using Mini Trees" (2015): trees as quick to
//!    trace as those of a full sweep, built in less time.
//! 3. D. Aston, "Agglomerative Building and Traversal of an Object Aligned Bounding Volume Hierarchy" (2018): hierarchies beat brute force by orders of magnitude.
//!
//! Ray cost is a count, 1.2 · inner nodes + triangle tests, the same on every machine. Times are the least of three rounds on one thread that alternate over
//! what is compared.

use bvhc::build::{Axes, BuildOptions, Executor, Levels, Method, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::compile::compile;
use bvhc::scene::{ReadOptions, Scene, read};
use bvhc::trace::brute::Oracle;
use bvhc::trace::probe::{Camera, ProbeRays, SETS};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const ROUNDS: usize = 3;
const RAYS: usize = 1 << 14;
/// Rays that brute force gets.
const BRUTE: usize = 200;

/// A scene of the first paper, ours in its place, and its milliseconds a frame: SBVH, longest axis, three axes.
const TABLE: [(&str, [&str; 2], [f64; 3]); 3] = [
    ("bunny", ["stanford_bunny/stanford_bunny.obj", "curtain.obj"], [4.31, 4.17, 4.07]),
    ("Sponza", ["sponza_dabrovic/sponza.obj", "colonnade.obj"], [12.01, 14543.66, 12.53]),
    ("dragon", ["stanford_dragon/dragon_202k.obj", "pillar.obj"], [7.30, 7.67, 7.27]),
];

/// Trees of one scene, what rays cost in them, and what they take.
struct Tried {
    cost: f64,
    trace: f64,
    build: f64,
}

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).map(PathBuf::from);
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples");
    let files = TABLE.map(|(_, [model, sample], _)| match &folder {
        Some(folder) => folder.join(model),
        None => samples.join(sample),
    });
    let exec = Executor::sequential();
    let draft = BuildOptions::preset(Preset::Draft);
    let one = |options: BuildOptions| BuildOptions { levels: Levels::One, ..options };
    let method = |method| one(BuildOptions { method, ..BuildOptions::preset(Preset::Best) });
    let seed = [method(Method::Sbvh), one(BuildOptions { axes: Axes::Longest, ..draft.clone() }), one(draft)];

    println!("1. Over bins along three axes; the paper's frame times in brackets.\n");
    println!("| scene | file | triangles | SBVH: ray cost | time | longest axis: ray cost | time |");
    println!("|---|---|--:|--:|--:|--:|--:|");
    for ((name, _, paper), file) in TABLE.iter().zip(&files) {
        let scene = read(file, &ReadOptions::default())?;
        let [split, longest, three] = tried(&scene, &seed, &exec)?;
        let cells = [(split, paper[0]), (longest, paper[1])].map(|(tree, theirs)| {
            let (cost, time) = (tree.cost / three.cost, tree.trace / three.trace);
            format!("{cost:.2} | {time:.2} ({:.2})", theirs / paper[2])
        });
        println!("| {name} | {} | {} | {} |", stem(file), scene.instanced_triangles(), cells.join(" | "));
    }

    println!("\n2. Trees of `bonsai` over trees of `sweep`: 1 is as quick to trace, below 1 is built sooner.\n");
    println!("| file | ray cost | traced speed | build time |\n|---|--:|--:|--:|");
    for file in &files {
        let scene = read(file, &ReadOptions::default())?;
        let [bonsai, sweep] = tried(&scene, &[method(Method::Bonsai), method(Method::Sweep)], &exec)?;
        let (cost, speed, build) = (bonsai.cost / sweep.cost, sweep.trace / bonsai.trace, bonsai.build / sweep.build);
        println!("| {} | {cost:.3} | {speed:.2} | {build:.2} |", stem(file));
    }

    println!("\n3. Brute force over a tree of `balanced`: tests a ray, and seconds a ray.\n");
    println!("| file | triangles | nodes and tests a ray | fewer by | quicker by |\n|---|--:|--:|--:|--:|");
    for file in &files {
        let scene = read(file, &ReadOptions::default())?;
        let image = image(&scene, &one(BuildOptions::preset(Preset::Balanced)), &exec)?;
        let view = image.view();
        let probe = ProbeRays::around(&view, &Camera::around(&view), RAYS);
        let sets = probe.cost(&view, &exec).sets;
        let work = sets.iter().flatten().sum::<f64>() / sets.len() as f64;
        let rays = &probe.rays(0)[..BRUTE.min(probe.len(0))];
        let start = Instant::now();
        rays.iter().for_each(|ray| _ = std::hint::black_box(bvhc::trace::closest_hit(&view, ray)));
        let through = start.elapsed().as_secs_f64();
        let oracle = Oracle::new(&scene, &exec);
        let start = Instant::now();
        rays.iter().for_each(|ray| _ = std::hint::black_box(oracle.trace(ray)));
        let brute = start.elapsed().as_secs_f64();
        let triangles = scene.instanced_triangles() as f64;
        println!("| {} | {triangles} | {work:.1} | {:.0} | {:.0} |", stem(file), triangles / work, brute / through);
    }
    Ok(())
}

fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn image(scene: &Scene, options: &BuildOptions, exec: &Executor) -> Result<Image> {
    Ok(Image::new(&compile(scene.clone(), options, exec, &NoProgress)?, exec)?)
}

/// All of them, in rounds that alternate.
fn tried<const N: usize>(scene: &Scene, options: &[BuildOptions; N], exec: &Executor) -> Result<[Tried; N]> {
    let mut out = [0; N].map(|_| Tried { cost: 0.0, trace: f64::INFINITY, build: f64::INFINITY });
    let images: Vec<Image> = options.iter().map(|options| image(scene, options, exec)).collect::<Result<_>>()?;
    for (tried, image) in out.iter_mut().zip(&images) {
        let view = image.view();
        tried.cost = ProbeRays::around(&view, &Camera::around(&view), RAYS).cost(&view, exec).mean();
    }
    for _ in 0..ROUNDS {
        for ((tried, image), options) in out.iter_mut().zip(&images).zip(options) {
            let start = Instant::now();
            std::hint::black_box(compile(scene.clone(), options, exec, &NoProgress)?);
            tried.build = tried.build.min(start.elapsed().as_secs_f64());
            let view = image.view();
            let probe = ProbeRays::around(&view, &Camera::around(&view), RAYS);
            let start = Instant::now();
            (0..SETS.len()).for_each(|set| _ = std::hint::black_box(probe.trace(set, &view)));
            tried.trace = tried.trace.min(start.elapsed().as_secs_f64());
        }
    }
    Ok(out)
}
