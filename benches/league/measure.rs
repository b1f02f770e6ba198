//! One scene: every tree built, traced by its builder's own traversal, and judged by the oracle.

use crate::pipe::Tracer;
use crate::recipes::Recipe;
use crate::scenes::Scene;
use crate::workers::Family;
use bvhc::build::{BuildOptions, Executor, Preset};
use bvhc::cache::{Image, View};
use bvhc::report::tradeoff::Pipe;
use bvhc::scene::{Mesh, Scene as Model};
use bvhc::trace::brute::{Answer, Oracle};
use bvhc::trace::compare::{Verdict, judge};
use bvhc::trace::probe::{Camera, ProbeRays};
use bvhc::trace::rays::{RaySet, Sampler};
use bvhc::verify::answers;
use bvhc::{Build, Cache, Hit, Ray};
use serde::Serialize;
use std::time::Instant;

pub const OURS: &str = "bvhc";

/// All that was measured on a scene.
#[derive(Serialize)]
pub struct Measured {
    pub name: String,
    pub triangles: usize,
    pub fair_rays: usize,
    pub hard_rays: usize,
    /// Hits of these by the oracle.
    pub hits: [u64; 2],
    pub rows: Vec<Row>,
    /// What peers could not do, and why.
    pub failed: Vec<String>,
}

/// One tree in one form. Not a number (null) is what nobody tells.
#[derive(Serialize)]
pub struct Row {
    pub peer: String,
    pub setting: String,
    pub form: &'static str,
    pub nodes: f64,
    pub ray_cost: f64,
    pub build_ms: f64,
    pub load_ms: f64,
    pub bytes: f64,
    pub mrays_per_second: f64,
    pub fair: Errors,
    pub hard: Errors,
}

/// Wrong answers.
#[derive(Clone, Copy, Default, Serialize)]
pub struct Errors {
    pub missed: u64,
    pub farther: u64,
    pub false_hits: u64,
}

impl Errors {
    fn of(verdicts: &[Verdict]) -> Errors {
        let count = |wanted: Verdict| verdicts.iter().filter(|v| **v == wanted).count() as u64;
        let [missed, farther, false_hits] = [Verdict::Missed, Verdict::Farther, Verdict::False].map(count);
        Errors { missed, farther, false_hits }
    }

    pub fn lost(&self) -> u64 {
        self.missed + self.farther
    }
}

impl Row {
    pub fn name(&self) -> String {
        format!("{} {}", self.peer, self.setting)
    }

    /// Of fair and hard rays.
    pub fn lost(&self) -> u64 {
        self.fair.lost() + self.hard.lost()
    }
}

pub const FORMS: [&str; 2] = ["binary", "8-wide"];

/// What is asked, and what is right.
struct Asked<'a> {
    mesh: &'a Mesh,
    oracle: &'a Oracle<'a>,
    rays: Vec<Ray>,
    /// The first of them are fair.
    fair: usize,
    answers: Vec<Answer>,
    /// For ray cost.
    probe: ProbeRays,
    exec: &'a Executor,
}

impl Asked<'_> {
    fn errors(&self, verdicts: &[Verdict]) -> [Errors; 2] {
        let (fair, hard) = verdicts.split_at(self.fair);
        [Errors::of(fair), Errors::of(hard)]
    }

    fn mrays(&self, seconds: f64) -> f64 {
        self.rays.len() as f64 / seconds / 1e6
    }
}

pub fn measure(scene: &Scene, recipes: &[Recipe], families: &[Family], count: usize) -> Result<Measured, String> {
    let mesh = scene.load()?;
    let exec = Executor::new(0).map_err(|e| e.to_string())?;
    let model = Model::of_mesh(mesh.clone());
    let (oracle, sampler) = (Oracle::new(&model, &exec), Sampler::new(&model));
    // The rays come from a quick tree of ours, so that they depend on no choice of recipes.
    let draft = built(&mesh, &BuildOptions::preset(Preset::Draft), false)?.0;
    let probe = ProbeRays::around(&draft.view(), &Camera::around(&draft.view()), count / 2);
    let fair: Vec<Ray> = [0, 1].iter().flat_map(|set| probe.rays(*set)).copied().collect();
    let hard =
        [RaySet::Vertices, RaySet::Edges, RaySet::Triangles, RaySet::Axis, RaySet::Planes, RaySet::Grid, RaySet::Far];
    let shares = RaySet::shares(&hard, count as u64 / 2);
    let hard: Vec<Ray> = hard.iter().zip(shares).flat_map(|(set, n)| sampler.rays(*set, n as usize, 1)).collect();
    let [fair, hard] = [fair, hard].map(|rays| rays.iter().filter_map(plain).collect::<Vec<Ray>>());
    let rays = [&fair[..], &hard[..]].concat();
    let answers = oracle.trace_all(&rays, &exec);
    let hits = |answers: &[Answer]| answers.iter().filter(|a| a.certain().is_some()).count() as u64;
    let hits = [hits(&answers[..fair.len()]), hits(&answers[fair.len()..])];
    let asked = Asked { mesh: &mesh, oracle: &oracle, rays, fair: fair.len(), answers, probe, exec: &exec };

    let (mut rows, mut failed) = (Vec::new(), Vec::new());
    for recipe in recipes {
        for wide in [false, true] {
            rows.push(ours(recipe, wide, &asked)?);
        }
    }
    for family in families {
        if let Err(why) = peer(family, &asked, &mut rows) {
            failed.push(format!("{}: {why}", family.name));
        }
    }
    failed.iter().for_each(|why| eprintln!("{} without {why}", scene.name));
    let (name, triangles) = (scene.name.clone(), mesh.triangles.len());
    Ok(Measured { name, triangles, fair_rays: fair.len(), hard_rays: hard.len(), hits, rows, failed })
}

/// The ray from 0 to infinity, with a direction of length 1: what every peer can be asked.
fn plain(ray: &Ray) -> Option<Ray> {
    let d = ray.direction.map(f64::from);
    let length = d.iter().map(|c| c * c).sum::<f64>().sqrt();
    let is_finite = ray.origin.iter().chain(&ray.direction).all(|c| c.is_finite()) && length > 0.0;
    is_finite.then(|| Ray::new(ray.origin, d.map(|c| (c / length) as f32)))
}

/// What a recipe builds, with the milliseconds on one thread.
fn built(mesh: &Mesh, options: &BuildOptions, compact: bool) -> Result<(bvhc::Built, f64), String> {
    let build = Build::of_scene(Model::of_mesh(mesh.clone())).map_err(|e| e.to_string())?;
    let build = build.options(options.clone()).compact(compact).threads(1);
    let start = Instant::now();
    let built = build.run().map_err(|e| e.to_string())?;
    Ok((built, start.elapsed().as_secs_f64() * 1e3))
}

/// How often a file is opened and rays are traced; the least time counts.
const ROUNDS: usize = 3;

fn ours(recipe: &Recipe, wide: bool, asked: &Asked<'_>) -> Result<Row, String> {
    let (built, build_ms) = built(asked.mesh, &recipe.options, wide)?;
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let path = folder.path().join("league.bvhc");
    built.write(&path).map_err(|e| e.to_string())?;
    drop(built);
    let mut load_ms = f64::INFINITY;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        Cache::open(&path).map_err(|e| e.to_string())?;
        load_ms = load_ms.min(start.elapsed().as_secs_f64() * 1e3);
    }
    let cache = Cache::open(&path).map_err(|e| e.to_string())?;
    let view = cache.view();
    // The file of compact trees has the binary ones beside them.
    let trees = cache.compact();
    let trace = |ray: &Ray| match &trees {
        Some(wide) => wide.closest_hit(ray),
        None => bvhc::trace::closest_hit(&view, ray),
    };
    let (mut seconds, mut hits): (f64, Vec<Option<Hit>>) = (f64::INFINITY, Vec::new());
    for _ in 0..ROUNDS {
        let start = Instant::now();
        hits = asked.rays.iter().map(&trace).collect::<Result<_, _>>().map_err(|e| e.to_string())?;
        seconds = seconds.min(start.elapsed().as_secs_f64());
    }
    let verdicts: Vec<Verdict> =
        hits.iter().zip(&asked.answers).map(|(hit, answer)| judge(&view, asked.oracle, answer, hit.as_ref())).collect();
    let [fair, hard] = asked.errors(&verdicts);
    Ok(Row {
        peer: OURS.into(),
        setting: recipe.name.clone(),
        form: FORMS[usize::from(wide)],
        nodes: if wide { cache.compact_nodes().len() } else { view.nodes.len() } as f64,
        ray_cost: if wide { f64::NAN } else { cost(&view, asked) },
        build_ms,
        load_ms,
        bytes: path.metadata().map_err(|e| e.to_string())?.len() as f64,
        mrays_per_second: asked.mrays(seconds),
        fair,
        hard,
    })
}

fn cost(view: &View<'_>, asked: &Asked<'_>) -> f64 {
    asked.probe.cost(view, asked.exec).mean()
}

/// Every setting of a peer in every form that it has.
fn peer(family: &Family, asked: &Asked<'_>, rows: &mut Vec<Row>) -> Result<(), String> {
    let worker = family.forms[0].as_ref().ok_or("it has no form for one thread")?;
    let mut pipe = Pipe::open(worker, 1, asked.mesh, &|| true).map_err(|e| e.to_string())?;
    let mut tracer = Tracer::open(worker, asked.mesh, &asked.rays).map_err(|e| e.to_string())?;
    for (number, setting) in family.settings.iter().enumerate() {
        let told = |e: std::io::Error| format!("{setting}: {e}");
        let (binary_ms, tree) = pipe.build(number as u8, &|| true).map_err(told)?;
        let image = Image::of_tree(asked.mesh, &tree, asked.exec).map_err(|e| format!("{setting}: {e}"))?;
        let binary_cost = cost(&image.view(), asked);
        for wide in [false, true] {
            let traced = tracer.trace(number as u8, wide).map_err(told)?;
            let mut row = Row {
                peer: family.name.to_string(),
                setting: (*setting).to_string(),
                form: FORMS[usize::from(wide)],
                nodes: if wide { f64::NAN } else { tree.nodes.len() as f64 },
                ray_cost: if wide { f64::NAN } else { binary_cost },
                build_ms: binary_ms,
                load_ms: binary_ms,
                bytes: f64::NAN,
                mrays_per_second: f64::NAN,
                fair: Errors::default(),
                hard: Errors::default(),
            };
            if let Some(told) = traced {
                let judged = told.hits.iter().zip(&asked.answers).map(|(hit, answer)| answers::judge(answer, *hit));
                [row.fair, row.hard] = asked.errors(&judged.collect::<Vec<_>>());
                (row.build_ms, row.load_ms, row.bytes) = (told.milliseconds, told.milliseconds, told.bytes);
                row.nodes = if told.nodes.is_nan() { row.nodes } else { told.nodes };
                row.mrays_per_second = asked.mrays(told.seconds);
            } else if wide {
                continue;
            }
            rows.push(row);
        }
    }
    Ok(())
}
