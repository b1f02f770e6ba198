//! The same bytes for any number of threads.

use crate::common::models_dir;
use crate::{Place, repository};
use std::path::{Path, PathBuf};

fn models_in(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut entries: Vec<PathBuf> = entries.map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            models_in(&path, found);
        } else if path.extension().is_some_and(|e| e == "obj" || e == "gltf" || e == "glb") {
            found.push(path);
        }
    }
}

/// Build with one thread and with two, and compare; `false` where the model is refused, which must then happen alike.
fn same_for_any_jobs(model: &Path, options: &[&str]) -> bool {
    let place = Place::new();
    let build = |jobs: &str, out: &str| {
        let mut command = place.command();
        command.arg("build").arg(model).args(["-q", "-o", out, "--jobs", jobs]).args(options);
        command.output().unwrap()
    };
    let (one, two) = (build("1", "one.bvhc"), build("2", "two.bvhc"));
    assert_eq!(one.status.code(), two.status.code(), "{}", model.display());
    if !one.status.success() {
        return false;
    }
    assert!(place.read("one.bvhc") == place.read("two.bvhc"), "{} differs with {options:?}", model.display());
    true
}

#[test]
fn samples_give_the_same_bytes_with_one_thread_and_with_two() {
    let mut models = Vec::new();
    models_in(&repository().join("samples"), &mut models);
    let quick = models.iter().filter(|m| m.metadata().unwrap().len() < 2 << 20);
    let built = quick.filter(|m| same_for_any_jobs(m, &["--preset", "balanced"])).count();
    assert!(models.is_empty() || built > 0);
}

#[test]
#[ignore = "long: every real scene, twice by each method; every corner case, twice by one"]
fn long_real_scenes_give_the_same_bytes_with_one_thread_and_with_two() {
    let Some(folder) = models_dir() else { return };
    let mut models = Vec::new();
    models_in(&folder, &mut models);
    let mut built = 0;
    for model in &models {
        // Corner cases are hundreds of files too small for a second thread; they are here for what readers do.
        let is_corner = model.components().any(|c| c.as_os_str().to_string_lossy().ends_with("_corner"));
        let methods: &[&str] = if is_corner { &["binned"] } else { &["binned", "sbvh"] };
        for method in methods {
            built += usize::from(same_for_any_jobs(model, &["--method", method]));
        }
    }
    println!("{} models, {built} pairs of files compared", models.len());
    assert!(built > 0);
}
