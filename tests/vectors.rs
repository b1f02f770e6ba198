//! The committed test vectors are those that `cargo run --example vectors` writes.

mod common;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bvhc::cache::check::{Level, Limits, check_bytes};
use bvhc::cache::{Cache, rules};
use bvhc::exec::Executor;
use common::vectors::{self, bytes};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("format-spec/vectors")
}

#[test]
fn committed_vectors_are_those_that_are_made() {
    for made in vectors::files() {
        let committed = std::fs::read(folder().join(&made.path)).unwrap_or_default();
        if made.packed {
            // Another version of the compressor may write other bytes; the content is what counts.
            assert!(!committed.is_empty(), "{} is missing", made.path);
            if made.path.ends_with(".bvhc") {
                let id = |file: &[u8]| bytes::header(file).content_id;
                assert_eq!(id(&committed), id(&made.bytes), "{}", made.path);
            }
            continue;
        }
        assert!(committed == made.bytes, "{}: run `cargo run --example vectors` if the format has changed", made.path);
    }
}

#[test]
fn the_list_of_hashes_is_that_of_the_committed_files_and_there_are_no_others() {
    let list = std::fs::read_to_string(folder().join("BLAKE3SUMS")).unwrap();
    let mut listed = BTreeSet::new();
    let mut total = 0;
    for line in list.lines() {
        let (hash, path) = line.split_once("  ").unwrap();
        let file = std::fs::read(folder().join(path)).unwrap();
        assert_eq!(blake3::hash(&file).to_hex().as_str(), hash, "{path}");
        listed.insert(path.to_owned());
        total += file.len();
    }
    assert!(total < 2_000_000, "the vectors take {total} bytes");
    for sub in ["valid", "invalid"] {
        for entry in std::fs::read_dir(folder().join(sub)).unwrap() {
            let path = format!("{sub}/{}", entry.unwrap().file_name().to_string_lossy());
            assert!(listed.contains(&path), "{path} is not listed");
        }
    }
}

/// The committed files are judged, not only those that were just made.
#[test]
fn committed_vectors_are_judged_as_their_names_say() {
    for rule in rules::all() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(rule.vector());
        let file = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let max_memory = if rule == &rules::E0127 { 1000 } else { 1 << 30 };
        let report =
            check_bytes(&file, Level::Tree, None, &Limits { max_memory, ..Limits::default() }, &Executor::current());
        let at_source = rule.id.starts_with("E06");
        assert_eq!(report.count(rule) > 0, !at_source, "{}", rule.id);
        assert!(report.is_clean() || !at_source, "{}", rule.id);
        let refused = Cache::from_bytes(&file, &Default::default()).is_err();
        let container = rule.id < "E0300"
            && rule.id != "E0127"
            && !["E0206", "E0207", "E0208", "E0209", "E0210"].contains(&rule.id);
        assert!(refused || !container, "{}: the reader opens it", rule.id);
    }
}
