use super::models_dir;
use bvhc::scene::{ReadOptions, Scene, read};
use std::path::{Path, PathBuf};

pub fn samples_dir() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("samples")
}

/// A file of the folder `samples`.
pub fn sample(name: &str) -> Scene {
    read(&samples_dir().join(name), &ReadOptions::default()).expect("a scene")
}

/// All models below a folder, but for the corner cases.
pub fn model_files(dir: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(dir).expect("a folder").map(|e| e.expect("an entry").path()).collect();
    entries.sort();
    let mut out = Vec::new();
    for path in entries {
        let corner = path.file_name().is_some_and(|n| n == "obj_corner" || n == "gltf_corner");
        if path.is_dir() && !corner {
            out.extend(model_files(&path));
        } else if path.extension().is_some_and(|e| e == "obj" || e == "gltf" || e == "glb") {
            out.push(path);
        }
    }
    out
}

/// The real scenes by name, where they are: the first, the middle and the last frame of each sequence, and every other file. `BVHC_ONLY` names a
/// part of those that are wanted.
pub fn real_scenes() -> Option<Vec<(String, PathBuf)>> {
    let models = models_dir()?;
    let only = std::env::var("BVHC_ONLY").unwrap_or_default();
    let files = without_most_frames(model_files(&models)).into_iter();
    let named = files.map(|f| (f.strip_prefix(&models).expect("a model").to_string_lossy().into_owned(), f));
    Some(named.filter(|(name, _)| name.contains(&only)).collect())
}

fn without_most_frames(files: Vec<PathBuf>) -> Vec<PathBuf> {
    let is_frame =
        |f: &Path| f.parent().and_then(Path::file_name).is_some_and(|n| n.to_string_lossy().starts_with("seq_"));
    let mut out = Vec::new();
    for folder in files.chunk_by(|a, b| a.parent() == b.parent()) {
        match folder {
            [first, .., last] if is_frame(first) => {
                out.extend([first, &folder[folder.len() / 2], last].map(PathBuf::clone))
            }
            _ => out.extend_from_slice(folder),
        }
    }
    out
}
