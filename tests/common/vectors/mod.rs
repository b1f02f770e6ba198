//! The test vectors of the format: small valid files, one invalid file for each rule of the catalogue, and further ones where a rule is easily
//! asked too little.
//!
//! They are made here, from hand-made trees, so that no change of a builder changes them. `cargo run --example vectors` writes them to
//! `format-spec/vectors`; `tests/vectors.rs` holds what is committed there against what is made here.
#![allow(dead_code)]

pub mod branches;
pub mod bytes;
pub mod compact;
pub mod invalid;
pub mod scenes;
pub mod sequences;
pub mod turns;
pub mod valid;

use bvhc::cache::{Cache, Sequence, tree_flags};
use bvhc::report::info::{FileInfo, MetaInfo};

/// A file of the folder of vectors.
pub struct File {
    /// Relative to the folder, with `/`.
    pub path: String,
    pub bytes: Vec<u8>,
    /// Its bytes depend on the compressor's version.
    pub packed: bool,
}

/// Every file of the folder, in the order of their paths.
pub fn files() -> Vec<File> {
    let mut files = Vec::new();
    for v in valid::all() {
        let info = info(&v.bytes);
        files.push(File { path: format!("valid/{}.bvhc", v.name), bytes: v.bytes, packed: v.packed });
        files.push(File { path: format!("valid/{}.info.json", v.name), bytes: info.into_bytes(), packed: v.packed });
    }
    for v in invalid::all() {
        let mut path = v.rule.vector().trim_start_matches("format-spec/vectors/").to_owned();
        if !v.case.is_empty() {
            path = path.replace(".bvhc", &format!(".{}.bvhc", v.case));
        }
        files.push(File { path, bytes: v.bytes, packed: v.packed });
    }
    files.sort_by(|a, b| a.path.cmp(&b.path));

    // List the hashes as `b3sum --check` reads them.
    let lines = files.iter().map(|f| format!("{}  {}\n", blake3::hash(&f.bytes).to_hex(), f.path));
    let list = lines.collect::<String>().into_bytes();
    files.push(File { path: "BLAKE3SUMS".into(), bytes: list, packed: true });
    files
}

/// What `bvhc info --json` says of the file, without its path.
pub fn info(file: &[u8]) -> String {
    let info = if bytes::header(file).has(tree_flags::SEQUENCE) {
        let sequence = Sequence::from_slice(file, &Default::default()).expect("a valid vector opens");
        FileInfo::new(sequence.header(), sequence.sections(), sequence.meta().map(MetaInfo::from))
    } else {
        let cache = Cache::from_bytes(file, &Default::default()).expect("a valid vector opens");
        FileInfo::new(cache.header(), cache.sections(), cache.meta().map(MetaInfo::from))
    };
    serde_json::to_string_pretty(&info).expect("facts are plain data") + "\n"
}
