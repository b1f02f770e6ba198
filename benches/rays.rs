//! How many rays a second our forms of one tree answer, and Embree beside them.
//!
//! ```text
//! cargo bench --bench rays -- [--scenes A,B] [--recipe NAME] [--rays N] [--rounds N]
//! ```
//!
//! Scenes are those of the bench `peers`; without a list three of them, or the samples. Our tree is built by one recipe of that bench and traced as it is (*binary*),
//! collapsed to nodes of eight children (*wide*), and in nodes of 80 bytes (*compact*). *Embree* is version 4, `rtcIntersect1` and `rtcOccluded1` in a
//! static scene with `RTC_SCENE_FLAG_ROBUST`, of medium and of high quality; its library is found as by `peers`.
//!
//! Rays are those of the report, the same for all: through the pixels of a camera, one diffuse bounce off what it sees, and occlusion from there (any hit). All
//! on one thread. In every round each form traces every set once, one form after the other, so that clocks that drift drift for all. A clock runs over each 1,024 rays,
//! and a set's time is the sum of their medians over the rounds: another program that takes the processor for a while falls out so. Our forms
//! must find equally many hits, and Embree as many, but for one ray in a thousand.

// Of these, the bench `peers` uses more.
#[path = "rays/embree.rs"]
mod embree;
#[allow(dead_code)]
#[path = "peers/recipes.rs"]
mod recipes;
#[allow(dead_code)]
#[path = "peers/scenes.rs"]
mod scenes;
#[allow(dead_code)]
#[path = "peers/workers.rs"]
mod workers;

use bvhc::Ray;
use bvhc::build::{BuildOptions, Executor, NoProgress};
use bvhc::cache::Image;
use bvhc::compile::build_tree;
use bvhc::scene::Mesh;
use bvhc::trace::probe::{Camera, ProbeRays, SETS};
use bvhc::trace::wide::{Collapse, CompactTrees, WideTrees};
use bvhc::trace::{Hit, Malformed, any_hit, closest_hit};
use bvhc::tree::Accel;
use clap::Parser;
use embree::{QUALITIES, Tracer};
use std::process::ExitCode;
use std::time::Instant;
use workers::Embree;

/// What is measured if nobody says.
const SCENES: [&str; 3] = ["sponza_dabrovic", "obvhs_kitchen", "bunny"];

#[derive(Parser)]
#[command(about = "Trace the same rays through our forms of one tree and through Embree's scenes")]
struct Options {
    /// Scenes by name or path
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<String>,
    /// Recipe of the bench `peers` that our tree is built by
    #[arg(long, default_value = "auto")]
    recipe: String,
    /// Rays in each of the three sets
    #[arg(long, default_value_t = 1 << 16)]
    rays: usize,
    /// How often all of them are traced
    #[arg(long, default_value_t = 15)]
    rounds: usize,
    /// What cargo adds
    #[arg(long, hide = true)]
    bench: bool,
    #[arg(long, hide = true)]
    test: bool,
}

/// Rays that a clock runs over.
const CHUNK: usize = 1024;

/// The columns: our forms, then Embree's scenes.
const OURS: [&str; 3] = ["binary", "wide", "compact"];

fn main() -> ExitCode {
    let mut options = Options::parse();
    let is_smoke = std::env::var_os("BVHC_BENCH_SMOKE").is_some();
    if is_smoke {
        options = Options { rounds: 1, rays: 256, scenes: vec!["stadium".into()], recipe: "draft".into(), ..options };
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
    let recipe = recipes::recipes(std::slice::from_ref(&options.recipe), &[])?.remove(0);
    let embree = if is_smoke { None } else { Embree::find() };
    let qualities = if embree.is_some() { &QUALITIES[..] } else { &[] };
    let names = OURS.iter().map(|name| name.to_string()).chain(qualities.iter().map(|q| format!("Embree {q}")));
    println!("Millions of rays a second\n\n| scene | rays | {} |", names.collect::<Vec<_>>().join(" | "));
    println!("|---|---|{}", "--:|".repeat(OURS.len() + qualities.len()));
    let mut rates: Vec<[Vec<f64>; 3]> = Vec::new();
    for scene in some {
        let measured = measure(scene, &recipe.options, embree.as_ref(), options);
        let measured = measured.map_err(|e| format!("{}: {e}", scene.name))?;
        for (set, rates) in SETS.iter().zip(&measured) {
            let columns: Vec<String> = rates.iter().map(|rate| format!("{rate:.3}")).collect();
            println!("| {} | {set} | {} |", scene.name, columns.join(" | "));
        }
        rates.push(measured);
    }
    println!("\nTimes as many rays a second, geometric means over the scenes\n\n| quotient | {} |", SETS.join(" | "));
    println!("|---|--:|--:|--:|");
    let columns: Vec<String> =
        OURS.map(str::to_string).into_iter().chain(qualities.iter().map(|q| format!("Embree {q}"))).collect();
    for ours in 0..OURS.len() {
        for other in (0..columns.len()).filter(|&other| other >= OURS.len() || (other == 0 && ours > 0)) {
            let mean = |set: usize| {
                let logs = rates.iter().map(|scene| (scene[set][ours] / scene[set][other]).ln());
                (logs.sum::<f64>() / rates.len() as f64).exp()
            };
            let means: Vec<String> = (0..SETS.len()).map(|set| format!("{:.2}", mean(set))).collect();
            println!("| {} : {} | {} |", columns[ours], columns[other], means.join(" | "));
        }
    }
    Ok(())
}

/// Millions of rays a second, by set and column.
fn measure(
    scene: &scenes::Scene,
    recipe: &BuildOptions,
    embree: Option<&Embree>,
    options: &Options,
) -> Result<[Vec<f64>; 3], String> {
    let mesh = scene.load()?;
    let image = image_of(&mesh, recipe)?;
    let view = image.view();
    let bounds = image.nodes.first().map_or(([0.0; 3], [1.0; 3]), |n| (n.min.map(f64::from), n.max.map(f64::from)));
    let camera = scene.camera(bounds.0, bounds.1).unwrap_or_else(|| Camera::automatic(&view));
    let rays = ProbeRays::new(&view, &camera, options.rays);
    let wide = WideTrees::<8>::new(&view, &Collapse::default()).map_err(|e| e.to_string())?;
    let compact = CompactTrees::new(&wide);
    let (wide, compact) = (wide.view(&view), compact.view(&view));
    let forms = [
        form(|ray| closest_hit(&view, ray), |ray| any_hit(&view, ray)),
        form(|ray| wide.closest_hit(ray), |ray| wide.any_hit(ray)),
        form(|ray| compact.closest_hit(ray), |ray| compact.any_hit(ray)),
    ];
    let mut tracer = embree.map(|embree| Tracer::open(embree, &mesh, &rays)).transpose().map_err(|e| e.to_string())?;
    let columns = forms.len() + if tracer.is_some() { QUALITIES.len() } else { 0 };

    // By set, column and chunk.
    let mut times = [0, 1, 2].map(|set| vec![vec![Vec::new(); rays.len(set).div_ceil(CHUNK)]; columns]);
    for _ in 0..options.rounds.max(1) {
        for (set, times) in times.iter_mut().enumerate() {
            let mut hits = Vec::new();
            for (form, times) in forms.iter().zip(times.iter_mut()) {
                let mut found = 0;
                for (some, times) in rays.rays(set).chunks(CHUNK).zip(times) {
                    let start = Instant::now();
                    found += form(some, set == 2).map_err(|e| e.to_string())?;
                    times.push(start.elapsed().as_secs_f64());
                }
                hits.push(found);
            }
            if hits.iter().any(|found| *found != hits[0]) {
                return Err(format!("{} rays: our forms find {hits:?} hits", SETS[set]));
            }
            for (quality, times) in times[forms.len()..].iter_mut().enumerate() {
                let tracer = tracer.as_mut().expect("there are columns for it");
                let (seconds, found) = tracer.trace(set, quality, times.len()).map_err(|e| e.to_string())?;
                times.iter_mut().zip(seconds).for_each(|(times, seconds)| times.push(seconds));
                if found.abs_diff(hits[0]) > rays.len(set).div_ceil(1000) {
                    return Err(format!("{} rays: Embree finds {found} hits, where there are {}", SETS[set], hits[0]));
                }
            }
        }
    }
    let rate = |set: usize, chunks: &Vec<Vec<f64>>| {
        rays.len(set) as f64 / 1e6 / chunks.iter().map(|times| median(times.clone())).sum::<f64>()
    };
    Ok([0, 1, 2].map(|set| times[set].iter().map(|chunks| rate(set, chunks)).collect()))
}

/// Something that traces rays, for any hit or for the closest ones, and says how many hit.
type Form<'a> = Box<dyn Fn(&[Ray], bool) -> Result<usize, Malformed> + 'a>;

fn form<'a>(
    closest: impl Fn(&Ray) -> Result<Option<Hit>, Malformed> + 'a,
    any: impl Fn(&Ray) -> Result<bool, Malformed> + 'a,
) -> Form<'a> {
    Box::new(move |rays, is_any| {
        let mut hits = 0;
        for ray in rays {
            hits += usize::from(if is_any { any(ray)? } else { closest(ray)?.is_some() });
        }
        Ok(hits)
    })
}

fn image_of(mesh: &Mesh, recipe: &BuildOptions) -> Result<Image, String> {
    let exec = Executor::new(0).map_err(|e| e.to_string())?;
    let tree = build_tree(mesh, recipe, &exec, &NoProgress).map_err(|e| e.to_string())?;
    let accel = Accel { meshes: vec![mesh.clone()], blases: vec![tree], ..Accel::default() };
    Image::new(&accel, &exec).map_err(|e| e.to_string())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
