//! What rays save where subtrees of a finished tree lie along bases of their own.

use bvhc::build::{BuildOptions, Executor, NoProgress, Preset};
use bvhc::cache::{Cache, Image, Meta, OpenOptions, Validation, WriteOptions, to_bytes};
use bvhc::compile::{build_tree, orient_image, segments};
use bvhc::oriented::{Basis, Choice, NODE, TURN, Turned, orient};
use bvhc::scene::Mesh;
use bvhc::trace::probe::{Camera, ProbeRays, SETS};
use bvhc::trace::{Observer, try_closest_hit};
use std::error::Error;

/// Rays in a set.
const RAYS: usize = 1300;

/// What turning does to the tree of `best`.
pub struct Saving {
    /// Of a ray along the axes.
    pub cost: f64,
    /// With any rotation, and with those of a set.
    pub turned: [Outcome; 2],
    /// In the file that `--orient` writes.
    pub file: InFile,
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

pub struct InFile {
    /// What closest-hit rays pay over what they pay along the axes.
    pub paid: f64,
    /// Turned subtrees.
    pub turns: usize,
    /// Bytes of the file over those without turned subtrees.
    pub bytes: f64,
    /// Answers that differ from those along the axes.
    pub differ: u64,
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
        let changes = orient(&mut turned, &forming, &choice, exec);
        let work = turned.work(0, &Basis::AXES, judging.iter());
        lost += work.lost;
        turned.turn(0, Basis::AXES);
        Outcome { over: work.cost() / along_axes.cost(), changes }
    });
    let file = in_file(&image, &ProbeRays::around(&view, &[left, right], RAYS), exec)?;
    Ok(Saving { cost: along_axes.cost() / judging.len() as f64, turned: outcomes, file, lost })
}

/// What closest-hit rays pay in a file, in triangle tests.
#[derive(Default)]
struct Paid(f64);

impl Observer for Paid {
    fn inner_node(&mut self) {
        self.0 += NODE;
    }
    fn triangle(&mut self) {
        self.0 += 1.0;
    }
    fn turn(&mut self) {
        self.0 += TURN;
    }
}

/// Turn subtrees, write the file, open it again, and trace in it.
fn in_file(image: &Image, rays: &ProbeRays, exec: &Executor) -> Result<InFile, Box<dyn Error>> {
    let file = |image: &Image| to_bytes(image, &Meta::default(), &WriteOptions::default(), exec);
    let mut oriented = image.clone();
    orient_image(&mut oriented, exec)?;
    let (plain, bytes) = (file(image)?, file(&oriented)?);
    let cache = Cache::from_bytes(&bytes, &OpenOptions { validation: Validation::Tree, ..OpenOptions::default() })?;
    let Some(turned) = cache.turned() else { return Ok(InFile { paid: 1.0, turns: 0, bytes: 1.0, differ: 0 }) };
    let (mut along_axes, mut paid, mut differ) = (Paid::default(), Paid::default(), 0);
    for ray in (0..SETS.len()).flat_map(|set| rays.rays(set)) {
        let want = try_closest_hit(&turned.view, ray, &mut along_axes)?;
        let hit = turned.trace::<false, _>(ray, &mut paid)?;
        let named = |hit: bvhc::Hit| (hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.geom, hit.prim);
        differ += u64::from(hit.map(named) != want.map(named));
    }
    let (paid, turns) = (paid.0 / along_axes.0, turned.rows.len());
    Ok(InFile { paid, turns, bytes: bytes.len() as f64 / plain.len() as f64, differ })
}
