//! What rays save where subtrees of a finished tree lie along bases of their own.

use bvhc::build::{BuildOptions, Executor, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::compile::{build_tree, segments};
use bvhc::oriented::{Basis, Choice, Turned, orient};
use bvhc::scene::Mesh;
use bvhc::trace::probe::Camera;
use std::error::Error;

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
    let records = view.blas(0).ok_or("the image has no tree")?;
    let [front, left, back, right] = Camera::around(&view);
    let [forming, judging] = [[front, back], [left, right]].map(|cameras| segments(&view, &records, &cameras, exec));
    let mut turned = Turned::new(records);
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
