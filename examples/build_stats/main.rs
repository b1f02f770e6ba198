//! Build time, memory and tree quality, a row per scene and recipe:
//! `cargo run --release --example build_stats -- [--jobs N] [--repeat N] [--rays N] [--phases] [--set option=value]… [--recipe RECIPE]… FILE…`
//!
//! A recipe is a preset or a method and what is set on top, as in `draft`, `sweep` or `bonsai,prune=0.01`; --set counts for all. SAH with
//! the report constants over leaves as stored; ms is the least of the repeats, in which recipes take turns, reading excluded, and
//! cpu ms the least time that threads ran, where the system tells (Linux), which a busy machine disturbs less. With --rays, the last
//! column is the mean of 1.2·(inner nodes) + triangles per ray over three sets of so many rays: chords, bounces and occlusion. peak B/tri is the
//! most memory that a build held at once beside the scene, its result included, in bytes per triangle.
//!
//! A FILE `hills:N` is a height field of about N triangles; with several of them, ns/(n·log2 n) tells how the time grows.
//!
//! --growth SVG draws that, a curve for each recipe; --pruning SVG draws what `bonsai,prune=…` costs in rays and time beside `sweep`, which must
//! be among the recipes.
//!
//! With --phases there is a table for each scene and recipe instead: what the parts of a build take on one thread and on N (2 if --jobs
//! is not given), which take turns. ms is the least of the repeats and cpu ms the mean of what the threads ran; shared is the part of the
//! time that N threads can divide, and speed-up alone what all this makes of the speed-up where nothing else wants the processors.

mod curves;
mod phases;

use self::phases::cpu_ms;
use bvhc::build::{self, BuildOptions, Executor, Levels, Method, Named, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::compile;
use bvhc::geom::Affine;
use bvhc::scene::{self, Instance, Mesh, ReadOptions, Scene};
use bvhc::stability::heap::{self, Counting};
use bvhc::trace::rays::{RaySet, Sampler};
use bvhc::trace::{Counters, try_any_hit, try_closest_hit};
use bvhc::tree::quality::sah;
use bvhc::tree::{Accel, Tree};
use std::time::Instant;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() {
    let (mut jobs, mut repeat, mut rays, mut by_phases) = (0, 3, 0, false);
    let (mut sets, mut files, mut recipes, mut charts) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().expect("a value after the option");
        match arg.as_str() {
            "--jobs" => jobs = value().parse().expect("a number of threads"),
            "--repeat" => repeat = value().parse().expect("a number of builds"),
            "--rays" => rays = value().parse().expect("a number of rays"),
            "--phases" => by_phases = true,
            "--growth" => charts.push((curves::growth as curves::Draw, value())),
            "--pruning" => charts.push((curves::pruning as curves::Draw, value())),
            "--set" => sets.push(value()),
            "--recipe" | "--preset" => recipes.push(value()),
            _ => files.push(arg),
        }
    }
    if recipes.is_empty() {
        recipes = ["draft", "balanced", "best"].map(String::from).to_vec();
    }
    let options: Vec<BuildOptions> = recipes.iter().map(|recipe| options_of(recipe, &sets)).collect();
    if by_phases {
        for file in &files {
            let scene = read(file);
            for (recipe, options) in recipes.iter().zip(&options) {
                let label = format!("{}, {recipe}", name_of(file));
                phases::print(&label, &scene.meshes[0], options, if jobs > 1 { jobs } else { 2 }, repeat);
            }
        }
        return;
    }
    let exec = Executor::new(jobs).expect("threads");
    println!(
        "| scene | triangles | recipe | ms | ms/Mtri | cpu ms | ns/(n·log2 n) | peak B/tri | SAH | refs/tri | depth | nodes | ray cost |"
    );
    println!("|---|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    let mut rows = Vec::new();
    for file in &files {
        let scene = read(file);
        let mesh = &scene.meshes[0];
        let mut built = vec![(f64::INFINITY, f64::INFINITY, 0, Tree::default()); options.len()];
        for _ in 0..repeat {
            for (options, (least, least_cpu, peak, tree)) in options.iter().zip(&mut built) {
                *tree = Tree::default();
                let (start, start_cpu) = (Instant::now(), cpu_ms());
                (*tree, *peak) =
                    heap::peak_of(|| compile::build_tree(mesh, options, &exec, &NoProgress).expect("a tree"));
                *least = least.min(start.elapsed().as_secs_f64() * 1e3);
                *least_cpu = least_cpu.min(cpu_ms() - start_cpu);
            }
        }
        for (recipe, (ms, cpu_ms, peak, tree)) in recipes.iter().zip(built) {
            let count = mesh.triangles.len() as f64;
            let (nodes, depth, sah) = (tree.live_nodes(), tree.max_depth(), sah(&tree.nodes));
            let duplication = tree.refs.len() as f64 / count;
            let ray_cost = (rays > 0).then(|| ray_cost(&scene, tree, rays));
            let row = Row { scene: name_of(file), recipe: recipe.clone(), triangles: count, ms, ray_cost };
            println!(
                "| {} | {count} | {recipe} | {ms:.1} | {:.0} | {cpu_ms:.1} | {:.1} | {:.0} | {sah:.2} | {duplication:.3} | {depth} | {nodes} | {} |",
                row.scene,
                ms / count * 1e6,
                row.growth(),
                peak as f64 / count,
                ray_cost.map_or_else(String::new, |cost| format!("{cost:.2}")),
            );
            rows.push(row);
        }
    }
    for (draw, file) in charts {
        std::fs::write(file, draw(&rows).svg().expect("points to draw")).expect("a file to write");
    }
}

/// A line of the table.
struct Row {
    scene: String,
    recipe: String,
    triangles: f64,
    ms: f64,
    ray_cost: Option<f64>,
}

impl Row {
    /// Nanoseconds for each of n·log2 n.
    fn growth(&self) -> f64 {
        self.ms * 1e6 / (self.triangles * self.triangles.log2())
    }
}

fn name_of(file: &str) -> String {
    std::path::Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// A preset or a method, then what is set on top of it.
fn options_of(recipe: &str, sets: &[String]) -> BuildOptions {
    let mut parts = recipe.split(',');
    let name = parts.next().unwrap_or_default();
    let mut options = match Preset::parse(name) {
        Ok(preset) => BuildOptions::preset(preset),
        Err(_) => BuildOptions {
            method: Method::parse(name).expect("a preset or a method"),
            ..BuildOptions::preset(Preset::Draft)
        },
    };
    parts.for_each(|assignment| set(&mut options, assignment));
    sets.iter().for_each(|assignment| set(&mut options, assignment));
    options
}

fn ray_cost(scene: &Scene, tree: Tree, rays: usize) -> f64 {
    let accel = Accel { meshes: scene.meshes.clone(), blases: vec![tree], ..Accel::default() };
    let image = Image::new(&accel, &Executor::current()).expect("a tree over the meshes that it was built for");
    let (view, sampler) = (image.view(), Sampler::new(scene));
    let mut counters = Counters::default();
    let mut traced = 0;
    for (set, any) in [(RaySet::Uniform, false), (RaySet::Bounce, false), (RaySet::Shadow, true)] {
        for ray in sampler.rays(set, rays, 1) {
            traced += 1;
            if any {
                try_any_hit(&view, &ray, &mut counters).expect("a sound tree");
            } else {
                try_closest_hit(&view, &ray, &mut counters).expect("a sound tree");
            }
        }
    }
    (1.2 * counters.inner_nodes as f64 + counters.triangles as f64) / f64::from(traced)
}

fn set(options: &mut BuildOptions, assignment: &str) {
    let (name, value) = assignment.split_once('=').expect("option=value");
    let row = build::option(name).unwrap_or_else(|| panic!("no option {name}"));
    row.set(options, value).unwrap_or_else(|e| panic!("{e}"));
}

/// The scene as one mesh in world space: a file's, or hills of N triangles for `hills:N`.
fn read(path: &str) -> Scene {
    if let Some(count) = path.strip_prefix("hills:") {
        let mesh = hills(count.parse().expect("a number of triangles"));
        let instance = Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() };
        return Scene { meshes: vec![mesh], instances: vec![instance], ..Scene::default() };
    }
    let scene = scene::read(path.as_ref(), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let options = BuildOptions { levels: Levels::One, ..BuildOptions::preset(Preset::Draft) };
    let laid_out = compile::lay_out(scene, &options, &Executor::sequential()).expect("one mesh");
    let instance = Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() };
    Scene { meshes: laid_out.meshes, instances: vec![instance], ..Scene::default() }
}

/// A height field over a square grid, of at least so many triangles.
fn hills(triangles: usize) -> Mesh {
    let side = (triangles as f64 / 2.0).sqrt().ceil() as u32;
    let height = |x: f64, y: f64| (x * 0.37).sin() * (y * 0.23).cos() + 5.0 * (x * 0.011).sin() * (y * 0.017).sin();
    let corner = |i: u32| {
        let (x, y) = (f64::from(i % (side + 1)), f64::from(i / (side + 1)));
        [x as f32, y as f32, height(x, y) as f32]
    };
    let cell = |i: u32| {
        let at = i / side * (side + 1) + i % side;
        [[at, at + 1, at + side + 2], [at, at + side + 2, at + side + 1]]
    };
    Mesh {
        positions: (0..(side + 1) * (side + 1)).map(corner).collect(),
        triangles: (0..side * side).flat_map(cell).collect(),
        ..Mesh::default()
    }
}
