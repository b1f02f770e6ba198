//! Trees for animations beside a new tree in every frame:
//! `cargo run --release --example motion -- [--frames N] [--rays N] [--jobs N] MODEL[:ANIMATION]…`
//!
//! MODEL is a glTF file, and ANIMATION the number of one of its animations, 0 if it is left out; or a folder of OBJ files that are frames. Of a glTF
//! animation N frames are taken (24), evenly from its first key to its last. Everything is one mesh in world space.
//!
//! A row is a model and a way to have a tree in each frame. SAH and ray cost are relative to `rebuild`, which builds `sweep` with 8 rounds of reinsertion in
//! every frame: the mean over the frames and the worst of them. Ray cost is the mean over three sets of about N rays (4096): from 16 cameras all
//! around, one diffuse bounce, and ambient occlusion; 0 traces none. `time` is what processors took to make the trees, where the system tells (Linux);
//! with one job nothing else is counted. `best frame` knows all frames' trees, and its time is not stated, nor is that of `first frame`: `refit to R` builds anew
//! where the refitted tree costs more than R times what a new one is expected to.

use bvhc::build::motion::{self, Motion, Policy, Trees};
use bvhc::build::{BuildOptions, Executor, Levels, Method, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::compile;
use bvhc::geom::Aabb;
use bvhc::scene::{self, AnimationChoice, Degenerate, Mesh, Moment, ReadOptions, Seconds};
use bvhc::trace::probe::{Camera, ProbeRays};
use bvhc::tree::{Tree, refit};
use std::error::Error;
use std::path::{Path, PathBuf};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let (mut frames, mut rays, mut jobs, mut models) = (24, 4096, 1, Vec::new());
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut number = || args.next().and_then(|n| n.parse().ok()).ok_or("a number after the option");
        match arg.as_str() {
            "--frames" => frames = number()?,
            "--rays" => rays = number()?,
            "--jobs" => jobs = number()?,
            _ => models.push(arg),
        }
    }
    let exec = Executor::new(jobs)?;
    println!("| clip | triangles | frames | way | trees | SAH mean | worst | rays mean | worst | time |");
    println!("|---|--:|--:|---|--:|--:|--:|--:|--:|--:|");
    for model in &models {
        let clip = read(model, frames)?;
        measure(&clip, rays, &exec)?;
    }
    Ok(())
}

/// The poses of one mesh.
struct Clip {
    name: String,
    meshes: Vec<Mesh>,
}

/// One way to have a tree in every frame.
struct Way {
    name: &'static str,
    trees: Vec<Tree>,
    serves: Vec<usize>,
    /// Milliseconds that it took to make the trees.
    cpu: f64,
}

fn measure(clip: &Clip, rays: usize, exec: &Executor) -> Result<()> {
    let recipe = |reinsert| BuildOptions { method: Method::Sweep, reinsert, ..BuildOptions::preset(Preset::Auto) };
    let triangles = clip.meshes[0].triangles.clone();
    let mut motion = Motion::new(&triangles);
    for mesh in &clip.meshes {
        motion.push(&mesh.positions)?;
    }
    let frames = motion.frames();
    let per_frame = |options: &BuildOptions| -> Result<Vec<Tree>> {
        (clip.meshes.iter()).map(|mesh| Ok(compile::build_tree(mesh, options, exec, &NoProgress)?)).collect()
    };
    let options = recipe(8);
    let timed = |name, work: &dyn Fn() -> Result<(Vec<Tree>, Vec<usize>)>| -> Result<Way> {
        let start = cpu_ms();
        let (trees, serves) = work()?;
        Ok(Way { name, trees, serves, cpu: cpu_ms() - start })
    };
    let keyed = |trees| -> Result<(Vec<Tree>, Vec<usize>)> {
        let keyed = motion::keyed(&motion, trees, &options, exec, &NoProgress)?;
        Ok((keyed.trees, keyed.serves))
    };
    let mut ways = vec![
        timed("rebuild", &|| Ok((per_frame(&options)?, (0..frames).collect())))?,
        timed("rebuild, plain sweep", &|| Ok((per_frame(&recipe(0))?, (0..frames).collect())))?,
        timed("all frames", &|| keyed(Trees::AtMost(1)))?,
        timed("at most three", &|| keyed(Trees::AtMost(3)))?,
        timed("auto", &|| keyed(Trees::Auto))?,
    ];
    let fresh = ways[0].trees.clone();
    let all = motion::costs(&fresh, &motion, &options, exec);
    let own: Vec<f64> = (0..frames).map(|f| all[f][f]).collect();
    let mean = |t: usize| (0..frames).map(|f| all[f][t] / own[f]).sum::<f64>();
    let best = (0..frames).reduce(|a, b| if mean(b) < mean(a) { b } else { a }).unwrap_or(0);
    let units: Vec<f64> = (0..frames).map(|frame| motion::triangle_cost(&motion, frame, &options)).collect();
    for (name, ratio) in [("refit to 1.05", 1.05), ("refit to 1.1", 1.1), ("refit to 1.2", 1.2), ("refit to 1.4", 1.4)]
    {
        let policy = Policy { ratio, ..Policy::default() };
        let keys = motion::key_frames(frames, policy, |key, frame| all[frame][key] / units[frame]);
        let built: Vec<usize> = (0..frames).filter(|frame| keys[*frame] == *frame).collect();
        let serves = keys.iter().map(|key| built.partition_point(|b| b < key)).collect();
        let trees = built.iter().map(|frame| fresh[*frame].clone()).collect::<Vec<Tree>>();
        let cpu = ways[0].cpu * built.len() as f64 / frames as f64;
        ways.push(Way { name, trees, serves, cpu });
    }
    for (name, frame) in [("first frame", 0), ("best frame", best)] {
        let trees = vec![fresh[frame].clone()];
        ways.push(Way { name, trees, serves: vec![0; frames], cpu: 0.0 });
    }
    let costs: Vec<Vec<[f64; 2]>> = (0..frames)
        .map(|frame| {
            let probes = (rays > 0).then(|| probes(&clip.meshes[frame], &ways[0].trees[frame], rays, exec));
            let cost = |way: &Way| {
                let mut tree = way.trees[way.serves[frame]].clone();
                let refs = tree.refs.clone();
                refit(&mut tree.nodes, |slot| motion.corners(frame, refs[slot] as usize));
                let sah = f64::from(bvhc::tree::quality::sah(&tree.nodes));
                let ray = probes.as_ref().map_or(0.0, |probes| {
                    let image = Image::of_tree(&clip.meshes[frame], &tree, exec).expect("a tree over this mesh");
                    probes.cost(&image.view(), exec).mean()
                });
                [sah, ray]
            };
            ways.iter().map(cost).collect()
        })
        .collect();
    for (w, way) in ways.iter().enumerate() {
        let over = |measure: usize| {
            let ratios = costs.iter().map(|row| row[w][measure] / row[0][measure]);
            let worst = ratios.clone().fold(0.0, f64::max);
            (ratios.sum::<f64>() / frames as f64, worst)
        };
        let ((sah, sah_worst), (ray, ray_worst)) = (over(0), over(1));
        println!(
            "| {} | {} | {frames} | {} | {} | {sah:.3} | {sah_worst:.3} | {ray:.3} | {ray_worst:.3} | {:.2} |",
            clip.name,
            triangles.len(),
            way.name,
            way.trees.len(),
            way.cpu / ways[0].cpu
        );
    }
    Ok(())
}

fn probes(mesh: &Mesh, tree: &Tree, rays: usize, exec: &Executor) -> ProbeRays {
    let image = Image::of_tree(mesh, tree, exec).expect("a tree over this mesh");
    let view = image.view();
    ProbeRays::around(&view, &cameras(tree.nodes[0].bounds()), rays)
}

/// Sixteen cameras all around, so that no view decides. Their eyes are a diagonal away from the middle.
fn cameras(bounds: Aabb) -> Vec<Camera> {
    let middle = bounds.center2().map(|c| f64::from(c) * 0.5);
    let diagonal = bounds.extent().iter().map(|e| f64::from(*e).powi(2)).sum::<f64>().sqrt();
    let camera = |i: u32| {
        // Points of a spiral from pole to pole.
        let y = 1.0 - f64::from(2 * i + 1) / 16.0;
        let (turn, around) = (f64::from(i) * 2.399_963, (1.0 - y * y).sqrt());
        let direction = [around * turn.cos(), y, around * turn.sin()];
        let eye = [0, 1, 2].map(|k| middle[k] + diagonal * direction[k]);
        Camera { eye, look_at: middle, up: [0.0, 1.0, 0.0], tan_half: 0.45 }
    };
    (0..16).map(camera).collect()
}

fn read(model: &str, frames: usize) -> Result<Clip> {
    let (path, number) = match model.rsplit_once(':') {
        Some((path, number)) => (path, number.parse()?),
        None => (model, 0),
    };
    let path = Path::new(path);
    let one = |path: &Path, moment: Option<Moment>| -> Result<Mesh> {
        let options = ReadOptions { degenerate: Degenerate::Keep, moment, ..ReadOptions::default() };
        let scene = scene::read(path, &options)?;
        let levels = BuildOptions { levels: Levels::One, ..BuildOptions::preset(Preset::Draft) };
        let mut laid = compile::lay_out(scene, &levels, &Executor::sequential())?;
        Ok(laid.meshes.pop().ok_or("no triangles")?)
    };
    let mut meshes = if path.is_dir() {
        let entries =
            std::fs::read_dir(path)?.map(|e| e.map(|e| e.path())).collect::<std::io::Result<Vec<PathBuf>>>()?;
        let mut files: Vec<PathBuf> =
            entries.into_iter().filter(|p| p.extension().is_some_and(|e| e == "obj")).collect();
        files.sort();
        files.iter().map(|file| one(file, None)).collect::<Result<Vec<Mesh>>>()?
    } else {
        let all = scene::animations(path, &ReadOptions::default())?;
        let keys = all.get(number as usize).and_then(|a| a.keys).ok_or("no such animation, or it moves nothing")?;
        let at = |frame: usize| {
            let share = frame as f64 / (frames.max(2) - 1) as f64;
            f64::from(keys.first) + share * (f64::from(keys.last) - f64::from(keys.first))
        };
        let moment = |frame| Moment { animation: AnimationChoice::Number(number), time: Seconds::new(at(frame)) };
        (0..frames).map(|frame| one(path, Some(moment(frame)))).collect::<Result<Vec<Mesh>>>()?
    };
    let first = meshes[0].clone();
    let before = meshes.len();
    let counts = |mesh: &Mesh| (mesh.triangles.len(), mesh.positions.len());
    meshes.retain(|mesh| counts(mesh) == counts(&first));
    if meshes.len() < before {
        eprintln!(
            "{model}: {} frames have other numbers of triangles or vertices and are left out",
            before - meshes.len()
        );
    }
    // A polygon is cut for each file anew: the first one's cut counts.
    meshes.iter_mut().for_each(|mesh| mesh.triangles.clone_from(&first.triangles));
    let stem = |p: &Path| p.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = match path.parent() {
        Some(folder) if stem(path) == "scene" => stem(folder),
        _ => stem(path),
    };
    Ok(Clip { name: format!("{name} {number}"), meshes })
}

/// Milliseconds that processors have spent on this process so far, where the system tells.
fn cpu_ms() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    stat.split(' ').next().and_then(|n| n.parse::<f64>().ok()).unwrap_or(0.0) / 1e6
}
