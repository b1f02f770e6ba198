//! How a recipe does on a failure scene: what it must keep always, and what its tree costs. Counts alone, no clock.

use bvhc::build::{Axes, BuildOptions, Executor, HullBasis, Method, NoProgress, Preset};
use bvhc::cache::{Image, View};
use bvhc::compile::compile;
use bvhc::geom::Ray;
use bvhc::scene::Scene;
use bvhc::trace::any_hit;
use bvhc::trace::brute::{Answer, Oracle};
use bvhc::trace::compare::compare;
use bvhc::trace::probe::{Camera, ProbeRays};
use bvhc::trace::rays::Sampler;

/// Every preset, every method with the options of a preset, and every pass.
pub fn recipes() -> Vec<(&'static str, BuildOptions)> {
    let (draft, best) = (BuildOptions::preset(Preset::Draft), BuildOptions::preset(Preset::Best));
    let method = |method| BuildOptions { method, ..best.clone() };
    let sweep = method(Method::Sweep);
    vec![
        ("draft", draft.clone()),
        ("balanced", BuildOptions::preset(Preset::Balanced)),
        ("auto", BuildOptions::preset(Preset::Auto)),
        ("best", best.clone()),
        ("longest axis", BuildOptions { axes: Axes::Longest, ..draft }),
        ("binned", method(Method::Binned)),
        ("sbvh", method(Method::Sbvh)),
        ("bonsai", method(Method::Bonsai)),
        ("sweep", sweep.clone()),
        ("agglomerative", method(Method::Agglomerative)),
        ("oabb", method(Method::Oabb)),
        ("oabb along leaves", BuildOptions { basis: HullBasis::Leaf, ..method(Method::Oabb) }),
        ("presplit", BuildOptions { presplit: 0.3, ..sweep.clone() }),
        ("reinsert", BuildOptions { reinsert: 4, ..sweep.clone() }),
        ("adapt", BuildOptions { adapt: 128, ..sweep.clone() }),
        ("collapse", BuildOptions { collapse: true, ..sweep }),
    ]
}

/// What is judged.
#[derive(Clone, Debug)]
pub struct Row {
    pub recipe: &'static str,
    pub triangles: u64,
    /// Rays whose hit no correct traversal gives, of any or the closest hit.
    pub wrong: u64,
    pub depth: u32,
    pub largest_leaf: u32,
    /// References for each triangle.
    pub references: f64,
    pub nodes: u64,
    /// 1.2 · inner nodes + triangles a ray, the mean of three sets; 0 where nothing is seen.
    pub cost: f64,
    /// The bounds that the options promise.
    most_references: f64,
}

impl Row {
    /// What is broken, in words; nothing where all promises are kept.
    pub fn broken(&self) -> Option<String> {
        if self.wrong > 0 {
            return Some(format!("{} wrong hits", self.wrong));
        }
        if self.depth > bvhc::tree::MAX_DEPTH || self.largest_leaf > 255 {
            return Some(format!("depth {}, leaf of {}", self.depth, self.largest_leaf));
        }
        let too_many = self.references > self.most_references + 1e-9;
        too_many.then(|| format!("{:.3} references a triangle, above {:.3}", self.references, self.most_references))
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
}

impl<'a> Judge<'a> {
    /// About `rays` rays for hits, and as many in each set for costs.
    pub fn new(scene: &'a Scene, rays: usize, exec: &Executor) -> Judge<'a> {
        let (oracle, sampled) = (Oracle::new(scene, exec), Sampler::new(scene).mixed(rays as u64, 1));
        let answers = oracle.trace_all(&sampled, exec);
        Judge { scene, oracle, rays: sampled, answers, probe: None, count: rays }
    }

    pub fn build(&self, options: &BuildOptions, exec: &Executor) -> Image {
        let accel = compile(self.scene.clone(), options, exec, &NoProgress).expect("every failure scene can be built");
        Image::new(&accel, exec).expect("a tree that the format has room for")
    }

    /// Build by a recipe and judge the tree.
    pub fn row(&mut self, recipe: &'static str, options: &BuildOptions, exec: &Executor) -> Row {
        let image = self.build(options, exec);
        let view = image.view();
        let tally = compare(&view, &self.oracle, &self.rays, &self.answers, exec).expect("a tree");
        let certain = self.rays.iter().zip(&self.answers).filter(|(_, answer)| answer.certain().is_some());
        let lost = certain.filter(|(ray, _)| any_hit(&view, ray) != Ok(true)).count() as u64;
        let count = self.count;
        // Every tree of the scene would find the same rays.
        let probe = self.probe.get_or_insert_with(|| ProbeRays::around(&view, &Camera::around(&view), count));
        let triangles: u64 = view.blases.iter().map(|blas| u64::from(blas.prim_count)).sum();
        let per = |n: usize| if triangles == 0 { 0.0 } else { n as f64 / triangles as f64 };
        Row {
            recipe,
            triangles,
            wrong: tally.wrong() + lost,
            depth: view.blases.iter().map(|blas| blas.max_depth).max().unwrap_or(0),
            largest_leaf: leaves(&view).max().unwrap_or(0),
            references: per(view.triangles.len()),
            nodes: view.nodes.len() as u64,
            cost: probe.cost(&view, exec).mean(),
            most_references: most_references(options),
        }
    }
}

fn leaves<'v>(view: &View<'v>) -> impl Iterator<Item = u32> + use<'v> {
    view.nodes.iter().map(|node| node.count)
}

/// What the options allow: searches try splits within the budget, and cutting before the build adds its share for three of ten.
fn most_references(options: &BuildOptions) -> f64 {
    match options.method {
        Method::Sbvh | Method::Auto | Method::Best => f64::from(options.split_budget),
        _ => 1.0 + f64::from(options.presplit),
    }
}
