//! The check on trees that the builders make; how fast it is, is printed and not judged.

mod common;

use std::time::Instant;

use bvhc::build::{BuildOptions, Executor, NoProgress, Preset};
use bvhc::cache::check::{Level, Limits, Report, check_bytes, check_image};
use bvhc::cache::{Image, Meta, WriteOptions, to_bytes};
use bvhc::compile;
use bvhc::geom::Affine;
use bvhc::scene::{self, Instance, Mesh, Part, ReadOptions, Scene};

fn bytes(image: &Image) -> usize {
    size_of_val(&image.nodes[..])
        + size_of_val(&image.triangles[..])
        + size_of_val(&image.geoms[..])
        + size_of_val(&image.blases[..])
        + size_of_val(&image.tlas_nodes[..])
        + size_of_val(&image.instances[..])
}

fn show(report: &Report) -> String {
    let lines: Vec<String> = report.findings.iter().take(8).map(|f| format!("  {f}")).collect();
    let counts: Vec<String> = report.counts().map(|(r, n)| format!("{} {} x{n}", r.id, r.name)).collect();
    format!("{}\n{}", counts.join(", "), lines.join("\n"))
}

/// Processor seconds that this thread has had, which other processes do not change; wall-clock time where the system does not
/// say.
fn seconds(start: Instant) -> f64 {
    let on_cpu = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = on_cpu.and_then(|s| s.split_whitespace().next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

/// On one thread, so that the figure is a core's.
fn timed(check: impl FnOnce() -> Report) -> (Report, f64) {
    let start = Instant::now();
    let before = seconds(start);
    let report = check();
    (report, seconds(start) - before)
}

#[test]
#[ignore = "long: builds every OBJ model of the models folder with every preset"]
fn long_every_tree_of_every_model_is_valid() {
    let Some(dir) = common::models_dir() else { return };
    let exec = Executor::new(0).unwrap();
    let wanted = std::env::var("BVHC_ONLY").unwrap_or_default();
    let mut files = Vec::new();
    for folder in std::fs::read_dir(dir).unwrap().flatten().filter(|f| f.path().is_dir()) {
        let found = std::fs::read_dir(folder.path()).unwrap().flatten().map(|f| f.path());
        files.extend(found.filter(|f| f.extension().is_some_and(|e| e == "obj" || e == "glb" || e == "gltf")));
    }
    files.sort();
    let mut bad = 0;
    for file in files.iter().filter(|f| f.to_string_lossy().contains(&wanted)) {
        let Ok(scene) = scene::read(file, &ReadOptions::default()) else { continue };
        for preset in [Preset::Draft, Preset::Best] {
            let accel =
                compile::compile(scene.clone(), &BuildOptions::preset(preset), &exec, &NoProgress).expect("a tree");
            let image = Image::new(&accel, &Executor::current()).unwrap();
            let (report, seconds) = timed(|| check_image(&image, &Limits::default(), &Executor::sequential()));
            let name = file.file_name().unwrap().to_string_lossy();
            let speed = bytes(&image) as f64 / seconds * 1e-9;
            println!("{name} {preset:?}: {} bytes, {speed:.2} GB/s, {}", bytes(&image), show(&report));
            bad += usize::from(!report.is_valid());
        }
    }
    assert_eq!(bad, 0, "{bad} trees are not valid");
}

/// The whole check of a whole file, hashes included. Prints how much of it one core checks in a second.
#[test]
#[ignore = "long: builds and checks meshes of a million triangles"]
fn long_check_of_everything() {
    let mut scenes = vec![("terrain".to_owned(), terrain()), ("straws".to_owned(), straws())];
    let models = ["city_san_francisco/san_francisco", "obvhs_kitchen/kitchen", "bitterli_kitchen/bitterli_kitchen"];
    for (dir, model) in common::models_dir().iter().flat_map(|dir| models.map(|m| (dir, m))) {
        match scene::read(&dir.join(model).with_extension("obj"), &ReadOptions::default()) {
            Ok(scene) => scenes.push((model.to_owned(), scene)),
            Err(why) => println!("skipped {model}: {why}"),
        }
    }
    let exec = Executor::new(0).unwrap();
    for (name, scene) in scenes {
        for preset in [Preset::Draft, Preset::Best] {
            let options = BuildOptions::preset(preset);
            let accel = compile::compile(scene.clone(), &options, &exec, &NoProgress).expect("a tree");
            let image = Image::new(&accel, &Executor::current()).unwrap();
            let file = to_bytes(&image, &Meta::default(), &WriteOptions::default(), &Executor::current()).unwrap();
            // Systems count processor time in steps of some milliseconds: check small files as often as makes that small.
            let often = 1 + 200_000_000 / file.len();
            let check = || check_bytes(&file, Level::Tree, None, &Limits::default(), &Executor::sequential());
            let runs = (0..3).map(|_| timed(|| (1..often).fold(check(), |_, _| check())));
            let (report, seconds) = runs.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
            let (len, speed) = (file.len(), (file.len() * often) as f64 / seconds * 1e-9);
            let prims: u64 = image.blases.iter().map(|b| u64::from(b.prim_count)).sum();
            let refs = image.triangles.len();
            println!(
                "{name} {preset:?}: {prims} triangles, {refs} references, {len} bytes, {speed:.2} GB/s on one core"
            );
            assert!(report.is_valid(), "{}", show(&report));
            assert!(refs as u64 > prims || name != "straws" || preset == Preset::Draft, "nothing was split");
        }
    }
}

/// A million triangles beside each other: nothing to split.
fn terrain() -> Scene {
    let n = 700;
    let height = |x: u32, y: u32| ((x * 37 + y * 61) % 101) as f32 * 0.02;
    let at = |x: u32, y: u32| [x as f32, y as f32, height(x, y)];
    let positions = (0..=n).flat_map(|y| (0..=n).map(move |x| at(x, y))).collect();
    let quads = (0..n).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x));
    scene_of(positions, quads.flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]).collect())
}

/// Long thin triangles in all directions: what spatial splits are for.
fn straws() -> Scene {
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5
    };
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..100_000 {
        let start = [0; 3].map(|_| random() * 100.0);
        let along = [0; 3].map(|_| random() * 10.0);
        positions.extend([start, [0, 1, 2].map(|k| start[k] + along[k]), [0, 1, 2].map(|k| start[k] + random() * 0.1)]);
        triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    scene_of(positions, triangles)
}

fn scene_of(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Scene {
    let count = triangles.len() as u32;
    let parts = vec![Part { triangle_count: count, prim_count: count, ..Part::default() }];
    let mesh = Mesh { name: "mesh".into(), positions, triangles, parts, ..Mesh::default() };
    let instance = Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() };
    Scene { meshes: vec![mesh], instances: vec![instance], ..Scene::default() }
}
