//! The committed sample scenes are what the generator writes.

#[path = "../samples/generate.rs"]
mod generate;

#[test]
fn the_generator_reproduces_the_committed_samples() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("samples");
    let files = generate::files();
    assert!(files.iter().map(|(_, bytes)| bytes.len()).sum::<usize>() < 10_000_000, "the samples outgrew 10 MB");
    for (name, bytes) in files {
        let committed = std::fs::read(folder.join(&name)).unwrap_or_else(|e| panic!("cannot read samples/{name}: {e}"));
        assert!(committed == bytes, "samples/{name} differs: run `cargo run --release --example samples` and commit");
    }
}
