//! Write the test vectors of the format: `cargo run --example vectors -- [FOLDER]`, `format-spec/vectors` by default.
//!
//! They are committed, and a test holds what is committed against what would be written, so a change of the format shows in the
//! history as changed vectors and never by accident.

#[path = "../tests/common/vectors/mod.rs"]
mod vectors;

use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/format-spec/vectors");
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from(default), PathBuf::from);
    let files = vectors::files();
    let mut bytes = 0;
    for file in &files {
        let path = folder.join(&file.path);
        std::fs::create_dir_all(path.parent().unwrap_or(&folder))?;
        std::fs::write(&path, &file.bytes)?;
        bytes += file.bytes.len();
    }
    println!("{} files, {bytes} bytes in {}", files.len(), folder.display());
    Ok(())
}
