//! Writes every sample scene: `cargo run --release --example samples -- [FOLDER]` (default: the `samples` folder itself).
//!
//! One scene per lesson; `samples/README.md` says which. The bytes are the same on every machine: coordinates come from
//! `+ - * /` and square roots alone (all exactly rounded), angles from a polynomial of our own, and every number is
//! written with a fixed count of decimals. A test compares a fresh run with the committed files.

#[path = "generator/cloth.rs"]
mod cloth;
#[path = "generator/colonnade.rs"]
mod colonnade;
#[path = "generator/forest.rs"]
mod forest;
#[path = "generator/helicopter.rs"]
mod helicopter;
#[path = "generator/mesh.rs"]
mod mesh;
#[path = "generator/pillar.rs"]
mod pillar;
#[path = "generator/roof.rs"]
mod roof;
#[path = "generator/stadium.rs"]
mod stadium;

/// Every sample as (path below the folder, bytes).
pub fn files() -> Vec<(String, Vec<u8>)> {
    let obj = |name: &str, mesh: mesh::Mesh| (name.to_string(), mesh.to_obj());
    let mut files = vec![
        obj("colonnade.obj", colonnade::scene()),
        obj("corrugated_roof.obj", roof::scene()),
        obj("curtain.obj", cloth::scene()),
        obj("pillar.obj", pillar::scene()),
        obj("stadium.obj", stadium::scene()),
    ];
    files.extend(
        (1..=helicopter::FRAMES)
            .map(|frame| (format!("helicopter/heli.{frame:04}.obj"), helicopter::frame(frame).to_obj())),
    );
    let (json, binary) = forest::scene();
    files.push(("forest.gltf".to_string(), forest::to_gltf(&json, &binary)));
    files.push(("forest.glb".to_string(), forest::to_glb(&json, &binary)));
    files
}

#[allow(dead_code)] // The test that includes this file calls `files` alone.
fn main() -> std::io::Result<()> {
    let default = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("samples");
    let folder = std::env::args_os().nth(1).map_or(default, std::path::PathBuf::from);
    for (name, bytes) in files() {
        let path = folder.join(&name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)?;
        }
        std::fs::write(&path, &bytes)?;
        println!("{name:28} {:>9} bytes", bytes.len());
    }
    Ok(())
}
