//! What the integration tests share.
#![allow(dead_code)]

pub mod devices;
pub mod faults;
pub mod meshes;
pub mod scenes;
pub mod vectors;

use std::path::PathBuf;

/// The folder of real scenes: `BVHC_MODELS`, else `../shared/models` beside the repository.
pub fn models_dir() -> Option<PathBuf> {
    folder_of("BVHC_MODELS", "models")
}

/// The folder of inputs that once were read wrongly: `BVHC_CASES`, else `../shared/cases`.
pub fn cases_dir() -> Option<PathBuf> {
    folder_of("BVHC_CASES", "cases")
}

/// The folder of animated situations and baked animations: `BVHC_SEQUENCES`, else `../shared/sequences`.
pub fn sequences_dir() -> Option<PathBuf> {
    folder_of("BVHC_SEQUENCES", "sequences")
}

/// `None`, with a line that says so, where the folder is absent: such tests pass without it.
fn folder_of(variable: &str, name: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared")).join(name);
    let dir = std::env::var_os(variable).map_or_else(beside, PathBuf::from);
    if dir.is_dir() {
        return Some(dir);
    }
    println!("skipped: no folder of {name} (set {variable})");
    None
}
