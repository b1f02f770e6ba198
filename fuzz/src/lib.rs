//! What is fuzzed, how inputs are changed, and what a case may take. `fuzz_targets` run it under libFuzzer, `src/bin/twin.rs` on a stable
//! toolchain.

pub mod guard;
pub mod mutate;
pub mod planted;
pub mod seeds;
pub mod targets;
#[path = "../../tests/common/vectors/mod.rs"]
pub mod vectors;

#[cfg(feature = "libfuzzer")]
pub mod under_libfuzzer;
