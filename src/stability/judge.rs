//! How a recipe does on a scene: what it must keep always, and what its trees cost.

use super::clock;
use super::effort::Effort;
use super::heap;
use super::recipes::Recipe;
use crate::build::{BuildError, BuildOptions, Method, NoProgress};
use crate::cache::{Image, View};
use crate::compile::compile;
use crate::exec::Executor;
use crate::geom::{Affine, Ray};
use crate::scene::Scene;
use crate::trace::brute::{Answer, Oracle};
use crate::trace::compare::compare;
use crate::trace::probe::{Camera, ProbeRays};
use crate::trace::rays::Sampler;
use crate::trace::wide::CompactTrees;
use crate::trace::{Counters, Malformed, any_hit, closest_hit};
use crate::tree::MAX_DEPTH;
use serde::Serialize;

/// Most triangles in a leaf that the format has room for.
const MOST_IN_LEAF: u32 = 255;

/// What is judged of one recipe on one scene in one size. All but `seconds` are counts, the same on every machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The name of the recipe.
    pub recipe: &'static str,
    /// Of the scene, each mesh once.
    pub triangles: u64,
    /// Rays whose hit no correct traversal gives: of the nearest or of any hit in the binary trees, or of the nearest in the trees of eight children that
    /// are made of them.
    pub wrong: u64,
    /// Deepest leaf of all trees.
    pub depth: u32,
    /// Triangles in the fullest leaf.
    pub largest_leaf: u32,
    /// References for each triangle.
    pub references: f64,
    /// Most of them that the options allow.
    pub most_references: f64,
    /// Nodes of all trees.
    pub nodes: u64,
    /// Whether the box of the root is the smallest one around all triangles; always where a scene has instances, whose boxes may be loose.
    pub tight: bool,
    /// 1.2 · inner nodes + triangles a ray, the mean of three sets; 0 where nothing is seen.
    pub cost: f64,
    /// The least of the builds, on one thread: what it ran, where the system tells, and else by the clock on the wall.
    pub seconds: f64,
    /// Most bytes that a build held at once, its result included; 0 where the program does not [count](heap::Counting).
    pub peak_bytes: u64,
}

impl Row {
    /// What is broken of that which holds for every recipe on every scene, in words; nothing where all is kept.
    pub fn broken(&self) -> Option<String> {
        if self.wrong > 0 {
            return Some(format!("{} wrong hits", self.wrong));
        }
        if self.depth > MAX_DEPTH || self.largest_leaf > MOST_IN_LEAF {
            return Some(format!("depth {}, leaf of {}", self.depth, self.largest_leaf));
        }
        if self.references > self.most_references + 1e-9 {
            return Some(format!("{:.3} references a triangle, above {:.3}", self.references, self.most_references));
        }
        (!self.tight).then(|| "a root with a loose box".into())
    }
}

/// A scene with its rays and what brute force says about them.
pub struct Judge<'a> {
    scene: &'a Scene,
    oracle: Oracle<'a>,
    rays: Vec<Ray>,
    answers: Vec<Answer>,
    probe: Option<ProbeRays>,
    count: usize,
    rounds: u32,
    exec: &'a Executor,
}

/// Why a scene could not be judged, which no scene of the list should be a reason for.
#[derive(Debug, thiserror::Error)]
pub enum JudgeError {
    /// It could not be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// Its trees are no records of the format.
    #[error(transparent)]
    Cache(#[from] crate::cache::CacheError),
    /// A ray came upon a malformed tree.
    #[error(transparent)]
    Malformed(#[from] Malformed),
}

impl<'a> Judge<'a> {
    /// With about as many rays as `effort` says. Each recipe is built as often as that, at least once.
    pub fn new(scene: &'a Scene, effort: &Effort, exec: &'a Executor) -> Judge<'a> {
        let (oracle, rays) = (Oracle::new(scene, exec), Sampler::new(scene).mixed(effort.judged_rays as u64, 1));
        let answers = oracle.trace_all(&rays, exec);
        Judge { scene, oracle, rays, answers, probe: None, count: effort.rays, rounds: effort.rounds, exec }
    }

    /// The scene's trees by these options.
    ///
    /// # Errors
    /// Where they cannot be built.
    pub fn build(&self, options: &BuildOptions) -> Result<Image, JudgeError> {
        Ok(Image::new(&self.compile(options)?, self.exec)?)
    }

    fn compile(&self, options: &BuildOptions) -> Result<crate::tree::Accel, BuildError> {
        compile(self.scene.clone(), options, &Executor::sequential(), &NoProgress)
    }

    /// Build by a recipe and judge the trees.
    ///
    /// # Errors
    /// Where they cannot be built or traced.
    pub fn row(&mut self, recipe: &Recipe) -> Result<Row, JudgeError> {
        let (accel, peak) = heap::peak_of(|| self.compile(&recipe.options));
        let accel = accel?;
        // The first build also brings memory and caches into place, so it is no round.
        let mut seconds = f64::INFINITY;
        for _ in 0..self.rounds {
            let start = clock::now();
            std::hint::black_box(self.compile(&recipe.options)?);
            seconds = seconds.min(clock::now() - start);
        }
        let image = Image::new(&accel, self.exec)?;
        let view = image.view();
        let count = self.count;
        // Every tree of the scene would find the same rays.
        let probe = self.probe.get_or_insert_with(|| ProbeRays::around(&view, &Camera::around(&view), count));
        let cost = probe.cost(&view, self.exec).mean();
        let triangles: u64 = view.blases.iter().map(|blas| u64::from(blas.prim_count)).sum();
        let per = |n: usize| if triangles == 0 { 0.0 } else { n as f64 / triangles as f64 };
        Ok(Row {
            recipe: recipe.name,
            triangles,
            wrong: self.wrong(&view)?,
            depth: view.blases.iter().map(|blas| blas.max_depth).max().unwrap_or(0),
            largest_leaf: view.nodes.iter().map(|node| node.count).max().unwrap_or(0),
            references: per(view.triangles.len()),
            most_references: most_references(&recipe.options),
            nodes: view.nodes.len() as u64,
            tight: self.is_tight(&view),
            cost,
            seconds: if seconds.is_finite() { seconds } else { 0.0 },
            peak_bytes: peak as u64,
        })
    }

    /// Rays that find what they should not, in any of the forms of the trees.
    fn wrong(&self, view: &View<'_>) -> Result<u64, Malformed> {
        let tally = compare(view, &self.oracle, &self.rays, &self.answers, self.exec)?;
        let compact = CompactTrees::of(view)?;
        let wide = compact.view(view);
        let mut wrong = tally.wrong();
        for (ray, answer) in self.rays.iter().zip(&self.answers) {
            wrong += u64::from(answer.certain().is_some() && !any_hit(view, ray)?);
            // To the last bit, but for which of several records of a triangle it is.
            let told = |hit: crate::Hit| (hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.geom, hit.prim);
            let (two, eight) = (closest_hit(view, ray)?, wide.try_closest_hit(ray, &mut Counters::default())?);
            wrong += u64::from(two.map(told) != eight.map(told));
        }
        Ok(wrong)
    }

    fn is_tight(&self, view: &View<'_>) -> bool {
        let ([mesh], [instance]) = (&self.scene.meshes[..], &self.scene.instances[..]) else { return true };
        let boxes = (0..mesh.triangles.len()).map(|i| mesh.triangle_box(i));
        let (Some(around), Some(root)) = (boxes.reduce(|a, b| a.union(b)), view.nodes.first()) else { return true };
        instance.transform != Affine::IDENTITY || (root.min, root.max) == (around.min, around.max)
    }
}

/// What the options allow: searches try splits within the budget, and cutting before the build adds its share of the triangles.
fn most_references(options: &BuildOptions) -> f64 {
    match options.method {
        Method::Sbvh | Method::Auto | Method::Best => f64::from(options.split_budget),
        _ => 1.0 + f64::from(options.presplit),
    }
}
