//! What a campaign starts from: small files that are made here, those in `fuzz/seeds`, and corner files where folders of them are there.

use crate::mutate::packed;
use crate::targets::MAX_LEN;
use crate::vectors::{invalid, valid};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Seeds of which none is broken: what planted faults are looked for from.
pub fn sound(target: &str) -> Vec<Vec<u8>> {
    match target {
        "reader" | "check" => valid::all().into_iter().map(|v| v.bytes).collect(),
        "decoding" => decodable(),
        _ => {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds").join(target);
            files_below(&folder).iter().filter_map(|f| std::fs::read(f).ok()).collect()
        }
    }
}

/// And those that are broken in known ways, and corner files of `BVHC_MODELS` and `BVHC_CASES`.
pub fn all(target: &str) -> Vec<Vec<u8>> {
    let mut seeds = sound(target);
    let beside = |variable: &str, name: &str| {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared").join(name);
        std::env::var_os(variable).map_or(folder, PathBuf::from)
    };
    let (models, cases) = (beside("BVHC_MODELS", "models"), beside("BVHC_CASES", "cases"));
    let read = |files: Vec<PathBuf>, extension: &str| -> Vec<Vec<u8>> {
        let wanted = files.into_iter().filter(|f| f.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension)));
        wanted.filter_map(|f| std::fs::read(f).ok()).collect()
    };
    match target {
        "reader" | "check" => {
            seeds.extend(invalid::all().into_iter().map(|v| v.bytes));
            seeds.extend(read(files_below(&cases), "bvhc"));
        }
        "obj" => {
            seeds.extend(read(files_below(&models.join("obj_corner")), "obj"));
            seeds.extend(read(files_below(&cases), "obj"));
        }
        "gltf" | "posing" => {
            let files = [files_below(&models.join("gltf_corner")), files_below(&cases)].concat();
            seeds.extend(
                files.iter().filter(|f| f.extension().is_some_and(|e| e == "gltf")).filter_map(|f| embedded(f)),
            );
            seeds.extend(read(files, "glb"));
            if target == "posing" {
                let poses = |seed: &Vec<u8>| {
                    let has = |word: &[u8]| seed.windows(word.len()).any(|w| w == word);
                    has(b"\"skins\"") || has(b"\"targets\"")
                };
                seeds.retain(poses);
            }
        }
        _ => {}
    }
    seeds.retain(|seed| seed.len() <= MAX_LEN);
    seeds
}

fn decodable() -> Vec<Vec<u8>> {
    let ramp = |len: usize| -> Vec<u8> { (0..len).map(|i| (i / 7 % 251) as u8).collect() };
    let mut seeds = Vec::new();
    for (len, level) in [(0, 3), (1, 3), (600, 3), (20_000, 1), (20_000, 19), (1 << 20, 3), ((1 << 20) + 5000, 3)] {
        seeds.push(packed::pack((len % 3) as u8, &ramp(len), level));
    }
    seeds
}

/// A glTF with its buffers inside, so that it is one input.
fn embedded(path: &Path) -> Option<Vec<u8>> {
    let mut document: Value = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
    for buffer in document.get_mut("buffers").and_then(Value::as_array_mut).into_iter().flatten() {
        let uri = buffer.get("uri").and_then(Value::as_str).unwrap_or("data:").to_owned();
        if !uri.starts_with("data:") {
            let bytes = std::fs::read(path.parent()?.join(uri)).ok().filter(|b| b.len() <= MAX_LEN / 2)?;
            buffer["uri"] = json!(format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes)));
        }
    }
    // Pictures play no part.
    document.as_object_mut()?.remove("images");
    serde_json::to_vec(&document).ok()
}

/// Every file of a folder and the folders in it, in the order of their names.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    paths.sort();
    paths.into_iter().flat_map(|p| if p.is_dir() { files_below(&p) } else { vec![p] }).collect()
}
