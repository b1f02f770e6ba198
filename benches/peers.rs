//! Beside obvhs: build time, tree quality and ray cost on the same scenes, in one run.
//!
//! `cargo bench --bench peers -- [--rays N] [--rounds N] [--svg FILE] [SCENE…]` prints a Markdown table per scene. Scenes are the samples and, where the folder of
//! models is there, four real ones; `SCENE` may also be a path. Builds are interleaved: each round builds every tree once, and the
//! table shows medians. All trees go through one evaluator, our own traversal: inner nodes entered and triangles tested per ray
//! for camera rays, one cosine-weighted bounce, and ambient occlusion (any hit within 10 % of the diagonal); SAH has C_T = 1.2, C_I = 1.
//! `work` is 1.2·nodes + triangles, averaged over the three sets; Mrays/s are of one thread. At the end stands one table over all
//! scenes; `--svg FILE` draws build time against work.
//!
//! obvhs comes in two forms that one program cannot hold, since Cargo unifies features; so each form is a worker process (`benches/obvhs_worker`),
//! built here and asked through a pipe. Without a network and its sources, its rows are left out.

#[path = "peers/chart.rs"]
mod chart;

use bvhc::build::{BuildOptions, Executor, NoProgress, Preset, build_tree, compile};
use bvhc::cache::{Image, View};
use bvhc::geom::Ray;
use bvhc::scene::{Mesh, ReadOptions, read};
use bvhc::trace::rays::{Random, camera, cosine_ray};
use bvhc::trace::{Counters, any_hit, closest_hit, try_any_hit, try_closest_hit};
use bvhc::tree::{Accel, Node, Tree, quality};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

const MODELS: [&str; 4] = [
    "sponza_dabrovic/sponza.obj",
    "obvhs_kitchen/kitchen.obj",
    "stanford_bunny/stanford_bunny.obj",
    "city_san_francisco/san_francisco.obj",
];
const SAMPLES: [&str; 4] = ["colonnade.obj", "corrugated_roof.obj", "curtain.obj", "stadium.obj"];
const OBVHS: [&str; 6] = ["fastest", "very_fast", "fast", "medium", "slow", "very_slow"];
const OURS: [(&str, Preset); 3] =
    [("bvhc draft", Preset::Draft), ("bvhc balanced", Preset::Balanced), ("bvhc best", Preset::Best)];

fn main() {
    let smoke = std::env::var_os("BVHC_BENCH_SMOKE").is_some();
    let (mut rays, mut rounds, mut scenes) =
        if smoke { (1 << 10, 1, vec!["stadium.obj".into()]) } else { (1 << 18, 5, Vec::new()) };
    let (mut svg, mut scenes_done) = (None, Vec::new());
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--rays" => rays = args.next().and_then(|v| v.parse().ok()).expect("--rays takes a number"),
            "--rounds" => rounds = args.next().and_then(|v| v.parse().ok()).expect("--rounds takes a number"),
            "--svg" => svg = Some(PathBuf::from(args.next().expect("--svg takes a file"))),
            "--bench" | "--test" => {}
            _ => scenes.push(arg),
        }
    }
    let workers = if smoke { [None, None] } else { [build_worker(false), build_worker(true)] };
    let files: Vec<PathBuf> = scene_files().into_iter().filter(|f| scenes.is_empty() || named(f, &scenes)).collect();
    let extra: Vec<PathBuf> = scenes.iter().map(PathBuf::from).filter(|p| p.is_file() && !files.contains(p)).collect();
    assert!(!files.is_empty() || !extra.is_empty(), "no scene is called {scenes:?}; is BVHC_MODELS set?");
    for file in files.into_iter().chain(extra) {
        match read(&file, &ReadOptions::default()) {
            Ok(scene) => {
                let options = BuildOptions { levels: bvhc::build::Levels::One, ..BuildOptions::preset(Preset::Draft) };
                let accel = compile(scene, &options, &Executor::sequential(), &NoProgress).expect("a flat scene");
                scenes_done.push(bench(&file, accel, &workers, rays, rounds));
            }
            Err(e) => println!("{}: {e}", file.display()),
        }
    }
    println!("\n### All scenes: work · SAH · build ms on one thread / two\n\n{}", chart::table(&scenes_done));
    if let Some(path) = svg {
        std::fs::write(&path, chart::svg(&scenes_done)).expect("a chart where --svg says");
    }
}

fn scene_files() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let models = std::env::var_os("BVHC_MODELS").map_or_else(|| root.join("../shared/models"), PathBuf::from);
    let files = SAMPLES.iter().map(|s| root.join("samples").join(s)).chain(MODELS.iter().map(|m| models.join(m)));
    files.filter(|f| f.is_file()).collect()
}

fn named(file: &Path, scenes: &[String]) -> bool {
    scenes.iter().any(|s| file.to_string_lossy().contains(s.as_str()))
}

/// One builder's figures.
struct Row {
    name: String,
    /// Milliseconds on one thread and on two, by round.
    times: [Vec<f64>; 2],
    image: Image,
    sah: f32,
    rays: [Vec<f64>; 3],
}

fn bench(file: &Path, accel: Accel, workers: &[Option<PathBuf>; 2], count: usize, rounds: usize) -> chart::Scene {
    let mesh = &accel.meshes[0];
    let sets = RaySets::new(&Image::new(&accel), count);
    let execs = [Executor::sequential(), Executor::new(2).expect("two threads")];
    let mut pipes: Vec<Option<Pipe>> =
        workers.iter().map(|w| w.as_ref().map(|path| Pipe::open(path, mesh).expect("a worker"))).collect();
    let mut rows: Vec<Row> = Vec::new();
    for round in 0..rounds {
        let mut index = 0;
        let mut store = |name: String, thread: usize, ms: f64, tree: Tree, rows: &mut Vec<Row>| {
            if round == 0 && (thread == 0 || rows.len() <= index) {
                rows.push(Row::new(name, mesh, tree));
            }
            rows[index].times[thread].push(ms);
            index += thread;
        };
        for (name, preset) in OURS {
            for (thread, exec) in execs.iter().enumerate() {
                let start = Instant::now();
                let tree = build_tree(mesh, &BuildOptions::preset(preset), exec, &NoProgress).expect("a tree");
                store(name.into(), thread, start.elapsed().as_secs_f64() * 1e3, tree, &mut rows);
            }
        }
        for (preset, name) in OBVHS.iter().enumerate() {
            for (thread, pipe) in pipes.iter_mut().enumerate() {
                let Some(pipe) = pipe else { continue };
                let (ms, tree) = pipe.build(preset as u8).expect("an answer from the worker");
                store(format!("obvhs {name}"), thread, ms, tree, &mut rows);
            }
        }
        for row in &mut rows {
            for (set, rates) in row.rays.iter_mut().enumerate() {
                rates.push(sets.rate(set, &row.image.view()));
            }
        }
    }
    print(file, mesh, &sets, rows)
}

impl Row {
    fn new(name: String, mesh: &Mesh, tree: Tree) -> Row {
        let sah = quality::sah(&tree.nodes);
        let image = Image::new(&Accel { meshes: vec![mesh.clone()], blases: vec![tree], ..Accel::default() });
        Row { name, times: Default::default(), image, sah, rays: Default::default() }
    }
}

fn print(file: &Path, mesh: &Mesh, sets: &RaySets, rows: Vec<Row>) -> chart::Scene {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let count = mesh.triangles.len();
    let mut trees = Vec::new();
    println!("\n### {name} ({count} triangles, {} rays a set)\n", sets.rays[0].len());
    println!(
        "| tree | refs/tri | depth | SAH | primary v/t | diffuse v/t | AO v/t | work | Mrays/s p / d / a | build ms 1T / 2T |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    for mut row in rows {
        let view = row.image.view();
        let per_ray: Vec<[f64; 2]> = (0..3).map(|set| sets.visits(set, &view)).collect();
        let work = per_ray.iter().map(|[v, t]| 1.2 * v + t).sum::<f64>() / 3.0;
        let rate = [0, 1, 2].map(|set| median(&mut row.rays[set]));
        let times = [0, 1].map(|thread| median(&mut row.times[thread]));
        let vt = |set: usize| format!("{:.1}/{:.1}", per_ray[set][0], per_ray[set][1]);
        println!(
            "| {} | {:.2} | {} | {:.2} | {} | {} | {} | {work:.2} | {:.2} / {:.2} / {:.2} | {:.1} / {:.1} |",
            row.name,
            row.image.triangles.len() as f64 / count as f64,
            row.image.blases[0].max_depth,
            row.sah,
            vt(0),
            vt(1),
            vt(2),
            rate[0],
            rate[1],
            rate[2],
            times[0],
            times[1]
        );
        trees.push(chart::Built { name: row.name, work, sah: f64::from(row.sah), times });
    }
    chart::Scene { name: name.into_owned(), trees }
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Camera, diffuse and occlusion rays: the same for every tree of the scene.
struct RaySets {
    rays: [Vec<Ray>; 3],
}

impl RaySets {
    fn new(image: &Image, count: usize) -> RaySets {
        let view = image.view();
        let bounds = image.nodes[0].bounds();
        let at =
            |s: [f64; 3]| [0, 1, 2].map(|a| f64::from(bounds.min[a]) + s[a] * f64::from(bounds.max[a] - bounds.min[a]));
        let extent = bounds.extent().map(f64::from);
        let diagonal = extent.iter().map(|e| e * e).sum::<f64>().sqrt();

        // Stand inside where the middle is walled in, otherwise outside; look along the longer horizontal side.
        let middle = at([0.5; 3]).map(|v| v as f32);
        let walls = (0..6).filter(|i| {
            let mut direction = [0.0; 3];
            direction[i / 2] = if i % 2 == 0 { 1.0 } else { -1.0 };
            any_hit(&view, &Ray::new(middle, direction))
        });
        let along_x = extent[0] >= extent[2];
        let (eye, look) = if walls.count() >= 5 {
            if along_x {
                (at([0.2, 0.4, 0.45]), at([0.9, 0.4, 0.55]))
            } else {
                (at([0.45, 0.4, 0.2]), at([0.55, 0.4, 0.9]))
            }
        } else {
            let center = at([0.5; 3]);
            (std::array::from_fn(|a| center[a] + diagonal * [0.5, 0.45, 0.7][a]), center)
        };
        let side = (count as f64).sqrt() as usize;
        let primary = camera(eye, look, [0.0, 1.0, 0.0], 0.6, side, side);

        // Bounce off what the camera sees, over and over with other directions until there are enough.
        let mut random = Random::new(7);
        let hits: Vec<([f64; 3], [f64; 3])> = primary.iter().filter_map(|ray| surface(&view, ray)).collect();
        let mut bounce = || -> Vec<Ray> {
            let lift = 1e-4 * diagonal;
            let one =
                |(p, n): &([f64; 3], [f64; 3])| cosine_ray([0, 1, 2].map(|a| p[a] + lift * n[a]), *n, &mut random);
            hits.iter().cycle().take(if hits.is_empty() { 0 } else { side * side }).map(one).collect()
        };
        let diffuse = bounce();
        let unit = |r: Ray| {
            let length = r.direction.iter().map(|c| c * c).sum::<f32>().sqrt();
            Ray { direction: r.direction.map(|c| c / length), ..r }.until((0.1 * diagonal) as f32)
        };
        let occlusion = bounce().into_iter().map(unit).collect();
        RaySets { rays: [primary, diffuse, occlusion] }
    }

    /// Millions of rays a second.
    fn rate(&self, set: usize, view: &View<'_>) -> f64 {
        let start = Instant::now();
        let hits = match set {
            2 => self.rays[2].iter().filter(|ray| any_hit(view, ray)).count(),
            _ => self.rays[set].iter().filter(|ray| closest_hit(view, ray).is_some()).count(),
        };
        std::hint::black_box(hits);
        self.rays[set].len() as f64 / start.elapsed().as_secs_f64() / 1e6
    }

    /// Inner nodes and triangles per ray.
    fn visits(&self, set: usize, view: &View<'_>) -> [f64; 2] {
        let mut counters = Counters::default();
        for ray in &self.rays[set] {
            match set {
                2 => drop(try_any_hit(view, ray, &mut counters).expect("a well-formed tree")),
                _ => drop(try_closest_hit(view, ray, &mut counters).expect("a well-formed tree")),
            }
        }
        [counters.inner_nodes, counters.triangles].map(|n| n as f64 / self.rays[set].len() as f64)
    }
}

/// Where a ray ends, and the unit normal there on the ray's side.
fn surface(view: &View<'_>, ray: &Ray) -> Option<([f64; 3], [f64; 3])> {
    let hit = closest_hit(view, ray)?;
    let [a, b, c] = view.triangles[hit.triangle].corners().map(|p| p.map(f64::from));
    let (e, f): ([f64; 3], [f64; 3]) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
    let n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
    let d = ray.direction.map(f64::from);
    let length = n.iter().map(|v| v * v).sum::<f64>().sqrt();
    let facing = if n[0] * d[0] + n[1] * d[1] + n[2] * d[2] > 0.0 { -length } else { length };
    let point = [0, 1, 2].map(|k| f64::from(ray.origin[k]) + f64::from(hit.t) * d[k]);
    Some((point, n.map(|v| v / facing)))
}

/// Build one form of the worker; `None`, with the reason on stderr, where that fails.
fn build_worker(parallel: bool) -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let form = if parallel { "parallel" } else { "serial" };
    let target = root.join("target").join(format!("obvhs-{form}"));
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--release", "--locked", "--quiet", "--manifest-path"]);
    cargo.arg(root.join("benches/obvhs_worker/Cargo.toml")).arg("--target-dir").arg(&target);
    if parallel {
        cargo.args(["--features", "parallel"]);
    }
    match cargo.status() {
        Ok(status) if status.success() => Some(target.join("release/obvhs_worker")),
        other => {
            eprintln!("obvhs ({form}) is left out: its worker could not be built: {other:?}");
            None
        }
    }
}

/// A worker at work on one mesh.
struct Pipe {
    child: Child,
}

impl Pipe {
    fn open(worker: &Path, mesh: &Mesh) -> std::io::Result<Pipe> {
        let mut child =
            Command::new(worker).env("RAYON_NUM_THREADS", "2").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let corners: Vec<[[f32; 3]; 3]> = (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect();
        let input = child.stdin.as_mut().expect("a pipe was asked for");
        input.write_all(&(corners.len() as u32).to_ne_bytes())?;
        input.write_all(bytemuck::cast_slice(&corners))?;
        input.flush()?;
        Ok(Pipe { child })
    }

    fn build(&mut self, preset: u8) -> std::io::Result<(f64, Tree)> {
        let input = self.child.stdin.as_mut().expect("a pipe was asked for");
        input.write_all(&[preset])?;
        input.flush()?;
        let output = self.child.stdout.as_mut().expect("a pipe was asked for");
        let mut milliseconds = [0; 8];
        output.read_exact(&mut milliseconds)?;
        let mut count = [0; 4];
        output.read_exact(&mut count)?;
        let mut nodes =
            vec![Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 }; u32::from_ne_bytes(count) as usize];
        output.read_exact(bytemuck::cast_slice_mut(&mut nodes))?;
        output.read_exact(&mut count)?;
        let mut refs = vec![0u32; u32::from_ne_bytes(count) as usize];
        output.read_exact(bytemuck::cast_slice_mut(&mut refs))?;
        Ok((f64::from_ne_bytes(milliseconds), canonical(&nodes, &refs)))
    }
}

impl Drop for Pipe {
    /// Closing its input ends the worker.
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        let _ = self.child.wait();
    }
}

/// Any tree of sibling pairs in our order: pairs in depth-first preorder, leaves likewise.
fn canonical(nodes: &[Node], refs: &[u32]) -> Tree {
    let Some(root) = nodes.first() else { return Tree::default() };
    let mut tree = Tree { nodes: vec![*root; 2], refs: Vec::with_capacity(refs.len()) };
    tree.nodes[1] = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };
    let mut stack = vec![0usize];
    while let Some(at) = stack.pop() {
        let node = tree.nodes[at];
        if node.is_leaf() {
            tree.nodes[at].first = tree.refs.len() as u32;
            tree.refs.extend(&refs[node.first as usize..(node.first + node.count) as usize]);
        } else {
            let pair = tree.nodes.len();
            tree.nodes[at].first = pair as u32;
            tree.nodes.extend_from_slice(&nodes[node.first as usize..][..2]);
            stack.extend([pair + 1, pair]);
        }
    }
    tree
}
