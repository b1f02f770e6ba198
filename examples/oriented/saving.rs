//! What rays save where subtrees of a finished tree lie along bases of their own.

use crate::orient::{Choice, orient};
use crate::turned::{Segment, Turned};
use bvhc::build::{BuildOptions, Executor, NoProgress, Preset};
use bvhc::cache::{Image, View};
use bvhc::compile::build_tree;
use bvhc::oriented::Basis;
use bvhc::scene::Mesh;
use bvhc::trace::closest_hit;
use bvhc::trace::probe::{Camera, ProbeRays, SETS};
use bvhc::tree::Tree;
use std::error::Error;

/// Rays in a set, of those that choose and of those that judge.
const RAYS: usize = 1300;

/// What turning does to the tree of `best`.
pub struct Saving {
    /// Of a ray along the axes.
    pub cost: f64,
    /// With any rotation, and with those of a set.
    pub turned: [Outcome; 2],
    /// Hits that were not found, along the axes and turned.
    pub lost: u64,
}

#[derive(Clone, Copy)]
pub struct Outcome {
    /// What rays pay over what they pay along the axes.
    pub over: f64,
    /// Subtrees whose basis is another than that above them.
    pub changes: usize,
}

/// Choose by rays from two sides of the scene, and judge by rays from the two others.
pub fn saving(mesh: &Mesh, set: &[Basis], exec: &Executor) -> Result<Saving, Box<dyn Error>> {
    let tree = build_tree(mesh, &BuildOptions::preset(Preset::Best), exec, &NoProgress)?;
    let image = Image::of_tree(mesh, &tree, exec)?;
    let view = image.view();
    let [front, left, back, right] = Camera::around(&view);
    let [forming, judging] = [[front, back], [left, right]].map(|cameras| segments(&view, &tree, &cameras));
    let mut turned = Turned::new(mesh, &tree);
    let along_axes = turned.work(0, &Basis::AXES, judging.iter());
    let mut lost = along_axes.lost;
    let outcomes = [Choice::Free, Choice::Among(set.to_vec())].map(|choice| {
        let changes = orient(&mut turned, &forming, &choice);
        let work = turned.work(0, &Basis::AXES, judging.iter());
        lost += work.lost;
        turned.turn(0, Basis::AXES);
        Outcome { over: work.cost() / along_axes.cost(), changes }
    });
    Ok(Saving { cost: along_axes.cost() / judging.len() as f64, turned: outcomes, lost })
}

/// All three sets of rays, up to what they hit.
fn segments(view: &View, tree: &Tree, cameras: &[Camera]) -> Vec<Segment> {
    let probe = ProbeRays::around(view, cameras, RAYS);
    let rays = (0..SETS.len()).flat_map(|set| probe.rays(set));
    rays.map(|ray| {
        let hit = closest_hit(view, ray).ok().flatten();
        Segment::new(ray, hit.map(|hit| (hit.t, tree.refs[hit.triangle])), &tree.nodes[0].bounds())
    })
    .collect()
}
