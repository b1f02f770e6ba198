//! The scenes, and where their cameras stand.

use bvhc::build::{BuildOptions, Executor, Levels, Preset};
use bvhc::compile::lay_out;
use bvhc::scene::{Degenerate, Mesh, ReadOptions, read};
use bvhc::trace::probe::Camera;
use std::path::{Path, PathBuf};

pub struct Scene {
    pub name: String,
    pub file: PathBuf,
    /// Eye and aim as shares of the scene's box, and which axis is up; without it the library chooses.
    camera: Option<Place>,
}

#[derive(Clone, Copy)]
struct Place {
    eye: [f64; 3],
    aim: [f64; 3],
    up: usize,
    tan_half: f64,
}

/// Without a place the library chooses; those of the scenes in `recorded.csv` make the rays about as dear in Embree's trees as the recorded ones were.
const fn place(eye: [f64; 3], aim: [f64; 3], up: usize, tan_half: f64) -> Option<Place> {
    Some(Place { eye, aim, up, tan_half })
}

const Y: usize = 1;
const Z: usize = 2;

/// Real ones by their file in the folder of models, small enough that all of them take minutes.
const MODELS: &[(&str, &str, Option<Place>)] = &[
    ("sponza_dabrovic", "sponza_dabrovic/sponza.obj", place([0.19, 0.13, 0.19], [0.49, 0.32, 0.97], Y, 0.44)),
    ("sponza_crytek_partial", "sponza_crytek_partial/sponza_crytek_partial.obj", None),
    ("obvhs_kitchen", "obvhs_kitchen/kitchen.obj", place([0.89, 0.80, 0.77], [0.22, 0.48, 0.60], Y, 0.95)),
    ("bunny", "stanford_bunny/stanford_bunny.obj", place([-0.30, -0.90, 1.81], [0.53, 0.34, 0.71], Y, 0.35)),
    ("dragon_202k", "stanford_dragon/dragon_202k.obj", None),
    ("san_francisco", "city_san_francisco/san_francisco.obj", place([0.69, 0.73, 0.49], [0.54, 0.47, 0.15], Z, 0.93)),
    (
        "bitterli_kitchen",
        "bitterli_kitchen/bitterli_kitchen.obj",
        place([0.81, 0.45, 0.54], [0.23, 0.10, 0.18], Y, 0.81),
    ),
    ("lamborghini", "sf_lamborghini/sf_lamborghini.glb", None),
    ("macross_city", "sf_macross_city/sf_macross_city.glb", None),
    ("ldraw_cafe_corner", "ldraw_cafe_corner/ldraw_cafe_corner.glb", None),
];

/// Our own, shipped with the repository; taken only where they are asked for or no models are there.
const SAMPLES: [&str; 4] = ["colonnade.obj", "corrugated_roof.obj", "curtain.obj", "stadium.obj"];

/// The scenes asked for, by name or by path; by default the real ones, or the samples where there are none.
pub fn scenes(wanted: &[String]) -> Result<Vec<Scene>, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = std::env::var_os("BVHC_MODELS").map_or_else(|| root.join("../shared/models"), PathBuf::from);
    let models = MODELS.iter().map(|(name, file, camera)| Scene {
        name: name.to_string(),
        file: folder.join(file),
        camera: *camera,
    });
    let samples = SAMPLES.iter().map(|file| of_path(root.join("samples").join(file)));
    let known: Vec<Scene> = models.chain(samples).filter(|s| s.file.is_file()).collect();
    if wanted.is_empty() {
        let is_model = |s: &Scene| s.file.starts_with(&folder);
        let any = known.iter().any(is_model);
        return Ok(known.into_iter().filter(|s| is_model(s) || !any).collect());
    }
    let mut out = Vec::new();
    for name in wanted {
        let known = known.iter().find(|s| s.name.eq_ignore_ascii_case(name)).map(|s| Scene {
            name: s.name.clone(),
            file: s.file.clone(),
            camera: s.camera,
        });
        let path = Some(PathBuf::from(name)).filter(|p| p.is_file()).map(of_path);
        out.push(known.or(path).ok_or_else(|| format!("no scene or file is called {name}; is BVHC_MODELS set?"))?);
    }
    Ok(out)
}

fn of_path(file: PathBuf) -> Scene {
    Scene { name: file.file_stem().unwrap_or_default().to_string_lossy().into_owned(), file, camera: None }
}

impl Scene {
    /// All triangles in one mesh in world space.
    pub fn load(&self) -> Result<Mesh, String> {
        // Triangles without area too: every builder gets the file as it is.
        let scene = read(&self.file, &ReadOptions { degenerate: Degenerate::Keep, ..ReadOptions::default() })
            .map_err(|e| e.to_string())?;
        let options = BuildOptions { levels: Levels::One, ..BuildOptions::preset(Preset::Draft) };
        let laid_out = lay_out(scene, &options, &Executor::sequential()).map_err(|e| e.to_string())?;
        laid_out.meshes.into_iter().next().ok_or_else(|| format!("{} holds no triangles", self.file.display()))
    }

    /// The chosen camera in a scene of these bounds.
    pub fn camera(&self, min: [f64; 3], max: [f64; 3]) -> Option<Camera> {
        self.camera.map(|place| {
            let mut up = [0.0; 3];
            up[place.up] = 1.0;
            Camera { up, tan_half: place.tan_half, ..Camera::within(min, max, place.eye, place.aim) }
        })
    }
}
