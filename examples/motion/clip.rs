//! The frames of an animation as poses of one mesh.

use crate::Result;
use bvhc::build::motion::Motion;
use bvhc::build::{BuildOptions, Executor, Levels, Preset};
use bvhc::cache::Image;
use bvhc::compile;
use bvhc::geom::Aabb;
use bvhc::scene::{self, AnimationChoice, Degenerate, Mesh, Moment, ReadOptions, Seconds};
use bvhc::trace::probe::{Camera, ProbeRays};
use bvhc::tree::{Tree, refit};
use std::path::{Path, PathBuf};

/// The poses of one mesh.
pub struct Clip {
    pub name: String,
    pub meshes: Vec<Mesh>,
}

impl Clip {
    /// What its triangles do.
    pub fn motion(&self) -> Result<Motion<'_>> {
        let mut motion = Motion::new(&self.meshes[0].triangles);
        for mesh in &self.meshes {
            motion.push(&mesh.positions)?;
        }
        Ok(motion)
    }

    pub fn triangles(&self) -> usize {
        self.meshes[0].triangles.len()
    }

    /// A tree of each frame.
    pub fn trees(&self, options: &BuildOptions, exec: &Executor) -> Result<Vec<Tree>> {
        let build = |mesh| Ok(compile::build_tree(mesh, options, exec, &bvhc::build::NoProgress)?);
        self.meshes.iter().map(build).collect()
    }

    /// Three sets of about so many rays into a frame. The tree decides nothing but how long it takes to make them.
    pub fn rays(&self, frame: usize, tree: &Tree, count: usize, exec: &Executor) -> ProbeRays {
        let image = Image::of_tree(&self.meshes[frame], tree, exec).expect("a tree over this mesh");
        ProbeRays::around(&image.view(), &cameras(tree.nodes[0].bounds()), count)
    }

    /// What a ray costs on average in a tree that is refitted to a frame.
    pub fn ray_cost(&self, frame: usize, tree: &Tree, rays: &ProbeRays, exec: &Executor) -> f64 {
        let (mesh, mut fitted) = (&self.meshes[frame], tree.clone());
        refit(&mut fitted.nodes, |slot| mesh.corners(tree.refs[slot] as usize)).expect("a tree that was built");
        self.ray_cost_as_built(frame, &fitted, rays, exec)
    }

    /// The same in a tree that was built for the frame.
    pub fn ray_cost_as_built(&self, frame: usize, tree: &Tree, rays: &ProbeRays, exec: &Executor) -> f64 {
        let image = Image::of_tree(&self.meshes[frame], tree, exec).expect("a tree over this mesh");
        rays.cost(&image.view(), exec).mean()
    }
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

/// A glTF file with `:` and the number of an animation, or a folder of OBJ files.
pub fn read(model: &str, frames: usize) -> Result<Clip> {
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
