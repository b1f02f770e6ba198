//! What the integration tests share.
#![allow(dead_code)]

pub mod devices;
pub mod faults;
pub mod meshes;
pub mod scenes;
pub mod vectors;

use std::path::PathBuf;

/// The folder of real scenes: `BVHC_MODELS`, else `../shared/models` beside the repository. `None`, with a line that says so,
/// where it is absent: such tests pass without it.
pub fn models_dir() -> Option<PathBuf> {
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/models"));
    let dir = std::env::var_os("BVHC_MODELS").map_or_else(beside, PathBuf::from);
    if dir.is_dir() {
        return Some(dir);
    }
    println!("skipped: no folder of models (set BVHC_MODELS)");
    None
}

/// The folder of inputs that once were read wrongly: `BVHC_CASES`, else `../shared/cases` beside the repository. `None`, with a line that
/// says so, where it is absent: such tests pass without it.
pub fn cases_dir() -> Option<PathBuf> {
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/cases"));
    let dir = std::env::var_os("BVHC_CASES").map_or_else(beside, PathBuf::from);
    if dir.is_dir() {
        return Some(dir);
    }
    println!("skipped: no folder of cases (set BVHC_CASES)");
    None
}
