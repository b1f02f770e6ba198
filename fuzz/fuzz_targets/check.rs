//! Any bytes: check and reader end, and what both accept can be traced.

#![no_main]

#[path = "../trace.rs"]
mod trace;

use bvhc::exec::Executor;
use bvhc::cache::check::{Level, Limits, check_bytes};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { max_memory: 64 << 20, ..Limits::default() };
    let report = check_bytes(bytes, Level::Tree, None, &limits, &Executor::current());
    trace::agree(bytes, report.is_valid());
});
