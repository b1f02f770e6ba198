//! The check on trees that the builders make, and its speed.

mod common;

use std::time::Instant;

use bvhc::build::{self, BuildOptions, Executor, NoProgress, Preset};
use bvhc::cache::check::{Level, Limits, Report, check_bytes, check_image};
use bvhc::cache::{Image, Meta, WriteOptions, to_bytes};
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
fn timed(check: impl FnOnce() -> Report + Send) -> (Report, f64) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let start = Instant::now();
        let before = seconds(start);
        let report = check();
        (report, seconds(start) - before)
    })
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
                build::compile(scene.clone(), &BuildOptions::preset(preset), &exec, &NoProgress).expect("a tree");
            let image = Image::new(&accel);
            let (report, seconds) = timed(|| check_image(&image, &Limits::default()));
            let name = file.file_name().unwrap().to_string_lossy();
            let speed = bytes(&image) as f64 / seconds * 1e-9;
            println!("{name} {preset:?}: {} bytes, {speed:.2} GB/s, {}", bytes(&image), show(&report));
            bad += usize::from(!report.is_valid());
        }
    }
    assert_eq!(bad, 0, "{bad} trees are not valid");
}

/// The whole check of a whole file, hashes included: at least 1 GB/s on one core of a desktop machine. The floor asserted
/// leaves room for slow ones; debug builds only print.
#[test]
#[ignore = "long: builds and checks a mesh of a million triangles"]
fn long_check_of_everything_in_gigabytes_a_second() {
    let n = 700;
    let height = |x: u32, y: u32| ((x * 37 + y * 61) % 101) as f32 * 0.02;
    let at = |x: u32, y: u32| [x as f32, y as f32, height(x, y)];
    let mut mesh = Mesh { name: "terrain".into(), ..Mesh::default() };
    for y in 0..=n {
        mesh.positions.extend((0..=n).map(|x| at(x, y)));
    }
    for y in 0..n {
        for x in 0..n {
            let a = y * (n + 1) + x;
            mesh.triangles.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        }
    }
    let count = mesh.triangles.len() as u32;
    mesh.parts = vec![Part { triangle_count: count, prim_count: count, ..Part::default() }];
    let instance = Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() };
    let scene = Scene { meshes: vec![mesh], instances: vec![instance], ..Scene::default() };
    let exec = Executor::new(0).unwrap();
    for preset in [Preset::Draft, Preset::Best] {
        let accel = build::compile(scene.clone(), &BuildOptions::preset(preset), &exec, &NoProgress).expect("a tree");
        let file = to_bytes(&Image::new(&accel), &Meta::default(), &WriteOptions::default()).unwrap();
        let runs = (0..3).map(|_| timed(|| check_bytes(&file, Level::Tree, None, &Limits::default())));
        let (report, seconds) = runs.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        let speed = file.len() as f64 / seconds * 1e-9;
        println!("{preset:?}: {count} triangles, {} bytes, checked at {speed:.2} GB/s on one core", file.len());
        assert!(report.is_valid(), "{}", show(&report));
        assert!(cfg!(debug_assertions) || speed > 0.3, "{speed:.2} GB/s");
    }
}
