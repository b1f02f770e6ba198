//! Structure-aware: words of a valid vector are overwritten and every hash made right again, so that the fuzzer's time goes to
//! the rules behind the hashes.

#![no_main]

#[path = "../trace.rs"]
mod trace;
#[path = "../../tests/common/vectors/mod.rs"]
mod vectors;

use std::sync::OnceLock;

use bvhc::exec::Executor;
use bvhc::cache::check::{Level, Limits, check_bytes};
use libfuzzer_sys::fuzz_target;

fn files() -> &'static [Vec<u8>] {
    static FILES: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    FILES.get_or_init(|| vectors::valid::all().into_iter().map(|v| v.bytes).collect())
}

// One byte chooses the vector; then six bytes an edit: where (u16, in words) and what (u32).
fuzz_target!(|input: &[u8]| {
    let Some((choice, edits)) = input.split_first() else { return };
    let mut bytes = files()[usize::from(*choice) % files().len()].clone();
    for edit in edits.chunks_exact(6) {
        let at = usize::from(u16::from_le_bytes([edit[0], edit[1]])) * 4 % bytes.len();
        bytes[at..at + 4].copy_from_slice(&edit[2..6]);
    }
    let bytes = vectors::bytes::refix(bytes);
    let limits = Limits { max_memory: 64 << 20, ..Limits::default() };
    let report = check_bytes(&bytes, Level::Tree, None, &limits, &Executor::current());
    trace::agree(&bytes, report.is_valid());
});
