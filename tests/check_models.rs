//! The check on trees that the builders make, and its speed.

mod common;

use std::time::Instant;

use bvhc::build::{self, BuildOptions, Executor, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::cache::check::{Limits, Report, check_image};
use bvhc::scene::{self, ReadOptions};

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

/// On one thread, so that the figure is a core's.
fn timed(image: &Image) -> (Report, f64) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let start = Instant::now();
        let report = check_image(image, &Limits::default());
        (report, start.elapsed().as_secs_f64())
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
            let (report, seconds) = timed(&image);
            let name = file.file_name().unwrap().to_string_lossy();
            let speed = bytes(&image) as f64 / seconds * 1e-9;
            println!("{name} {preset:?}: {} bytes, {speed:.2} GB/s, {}", bytes(&image), show(&report));
            bad += usize::from(!report.is_valid());
        }
    }
    assert_eq!(bad, 0, "{bad} trees are not valid");
}
