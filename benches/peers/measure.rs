//! One scene: every tree built in alternation, and all of them judged alike.

use crate::recipes::Recipe;
use crate::scenes::Scene;
use crate::workers::Family;
use bvhc::build::{BuildOptions, Executor, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::compile::build_tree;
use bvhc::report::tradeoff::Pipe;
use bvhc::scene::Mesh;
use bvhc::trace::probe::{Camera, ProbeRays, RayCost};
use bvhc::tree::quality::epo::{EndPointOverlap, MOST_VISITS, exact, sampled};
use bvhc::tree::quality::{Subtrees, sah};
use bvhc::tree::{Accel, Tree};
use serde::Serialize;
use std::time::Instant;

/// How thoroughly.
#[derive(Clone, Copy)]
pub struct Effort {
    /// Rays in each of the three sets.
    pub rays: usize,
    /// How often every tree is built and traced; times are medians.
    pub rounds: usize,
    /// Points of the surface for EPO; `None` clips every triangle.
    pub epo_points: Option<usize>,
}

/// All that was measured on a scene.
#[derive(Serialize)]
pub struct Measured {
    pub name: String,
    pub triangles: usize,
    pub rays_per_set: usize,
    pub trees: Vec<Row>,
}

/// One builder's tree.
#[derive(Serialize)]
pub struct Row {
    /// `bvhc`, or a peer.
    pub family: String,
    pub setting: String,
    /// Median milliseconds on one thread and on two; not a number (null) where that form is missing.
    pub ms: [f64; 2],
    pub refs_per_triangle: f64,
    pub depth: u32,
    pub sah: f64,
    pub epo: f64,
    pub epo_standard_error: f64,
    /// Inner nodes entered and triangles tested per ray: primary, diffuse, occlusion.
    pub visits: [[f64; 2]; 3],
    /// Mean over the sets of 1.2 · nodes + triangles.
    pub ray_cost: f64,
    /// Millions of rays a second on one thread by our own traversal, medians.
    pub mrays: [f64; 3],
}

impl Row {
    pub fn name(&self) -> String {
        format!("{} {}", self.family, self.setting)
    }

    pub fn is_ours(&self) -> bool {
        self.family == OURS
    }

    pub fn diffuse_work(&self) -> f64 {
        1.2 * self.visits[1][0] + self.visits[1][1]
    }
}

pub const OURS: &str = "bvhc";

/// A tree on its way to a [`Row`].
struct Entry {
    family: String,
    setting: String,
    times: [Vec<f64>; 2],
    tree: Tree,
}

pub fn measure(scene: &Scene, recipes: &[Recipe], families: &[Family], effort: Effort) -> Result<Measured, String> {
    let mesh = scene.load()?;
    let mut entries: Vec<Entry> = Vec::new();
    for round in 0..effort.rounds {
        let mut next = 0;
        let mut keep = |family: &str, setting: &str, built: [Option<(f64, Tree)>; 2]| {
            if round == 0 {
                let (family, setting) = (family.to_string(), setting.to_string());
                entries.push(Entry { family, setting, times: Default::default(), tree: Tree::default() });
            }
            let entry = &mut entries[next];
            next += 1;
            // The tree of one thread is judged; the peers' trees of two may differ from run to run.
            for (thread, (ms, tree)) in built.into_iter().enumerate().rev().filter_map(|(i, b)| Some((i, b?))) {
                entry.times[thread].push(ms);
                if round == 0 {
                    entry.tree = tree;
                }
            }
        };
        for recipe in recipes {
            keep(OURS, &recipe.name, [1, 2].map(|threads| Some(ours(&mesh, recipe, threads))));
        }
        for family in families {
            let mut pipes = [None, None];
            for (i, form) in family.forms.iter().enumerate() {
                if let Some(form) = form {
                    let pipe = Pipe::open(form, i + 1, &mesh, &|| true);
                    pipes[i] = Some(pipe.map_err(|e| format!("{} does not start: {e}", family.name))?);
                }
            }
            for (number, setting) in family.settings.iter().enumerate() {
                let mut built = [None, None];
                for (i, pipe) in pipes.iter_mut().enumerate() {
                    if let Some(pipe) = pipe {
                        let answer = pipe.build(number as u8, &|| true);
                        built[i] = Some(answer.map_err(|e| format!("{} {setting} failed: {e}", family.name))?);
                    }
                }
                keep(family.name, setting, built);
            }
        }
    }
    Ok(judge(scene, &mesh, entries, effort))
}

fn ours(mesh: &Mesh, recipe: &Recipe, threads: usize) -> (f64, Tree) {
    let exec = Executor::new(threads).expect("two threads");
    let start = Instant::now();
    let tree = build_tree(mesh, &recipe.options, &exec, &NoProgress).expect("a tree of a mesh that was read");
    (start.elapsed().as_secs_f64() * 1e3, tree)
}

fn judge(scene: &Scene, mesh: &Mesh, entries: Vec<Entry>, effort: Effort) -> Measured {
    let exec = Executor::new(0).expect("threads");
    let image_of = |tree: Tree| {
        Image::new(&Accel { meshes: vec![mesh.clone()], blases: vec![tree], ..Accel::default() }, &exec)
            .expect("a tree over its own mesh")
    };

    // The rays come from a tree of our own, so that they depend on no choice of recipes.
    let draft = build_tree(mesh, &BuildOptions::preset(Preset::Draft), &exec, &NoProgress).expect("a tree");
    let image = image_of(draft);
    let bounds = image.nodes.first().map_or(([0.0; 3], [1.0; 3]), |n| (n.min.map(f64::from), n.max.map(f64::from)));
    let camera = scene.camera(bounds.0, bounds.1).unwrap_or_else(|| Camera::automatic(&image.view()));
    let rays = ProbeRays::new(&image.view(), &camera, effort.rays);
    drop(image);

    let triangles = mesh.triangles.len();
    let mut judged: Vec<(Row, Image)> = Vec::new();
    for entry in entries {
        let epo = overlap(mesh, &entry.tree, effort.epo_points, &exec);
        let (refs, depth, sah) = (entry.tree.refs.len(), entry.tree.max_depth(), sah(&entry.tree.nodes));
        let image = image_of(entry.tree);
        let cost: RayCost = rays.cost(&image.view(), &exec);
        let row = Row {
            family: entry.family,
            setting: entry.setting,
            ms: entry.times.map(median),
            refs_per_triangle: refs as f64 / triangles as f64,
            depth,
            sah: f64::from(sah),
            epo: epo.epo(),
            epo_standard_error: epo.standard_error(),
            visits: cost.sets,
            ray_cost: cost.mean(),
            mrays: [f64::NAN; 3],
        };
        judged.push((row, image));
    }

    // Rays per second in rounds too, since clocks drift while ten trees are traced.
    let mut rates = vec![[const { Vec::new() }; 3]; judged.len()];
    for _ in 0..effort.rounds {
        for ((_, image), rates) in judged.iter().zip(&mut rates) {
            for (set, rates) in rates.iter_mut().enumerate() {
                let start = Instant::now();
                std::hint::black_box(rays.trace(set, &image.view()));
                rates.push(rays.len(set) as f64 / start.elapsed().as_secs_f64() / 1e6);
            }
        }
    }
    let trees = judged.into_iter().zip(rates).map(|((row, _), rates)| Row { mrays: rates.map(median), ..row });
    Measured { name: scene.name.clone(), triangles, rays_per_set: rays.len(0), trees: trees.collect() }
}

fn overlap(mesh: &Mesh, tree: &Tree, points: Option<usize>, exec: &Executor) -> EndPointOverlap {
    let subtrees = Subtrees::new(&tree.nodes, &tree.refs, mesh.triangles.len());
    match points {
        None => exact(&subtrees, |t| mesh.corners(t), exec),
        Some(points) => sampled(&subtrees, |t| mesh.corners(t), points, MOST_VISITS, exec),
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
