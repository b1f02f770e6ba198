//! The targets: what a case does, and what must hold.

mod check;
mod decoding;
mod model;
mod reader;

use crate::mutate::{self, Change};
use crate::planted::Seen;

/// One thing that is fuzzed.
pub struct Target {
    pub name: &'static str,
    /// Run a case; what it came upon is for planted faults.
    pub run: fn(&[u8]) -> Seen,
    /// Change an input in its own terms.
    pub change: Change,
    /// What planted faults panic at. No seed that is used to look for them comes upon one.
    pub faults: &'static [&'static str],
}

pub const TARGETS: [Target; 6] =
    [reader::TARGET, check::TARGET, decoding::TARGET, model::OBJ, model::GLTF, model::POSING];

pub fn by_name(name: &str) -> Option<&'static Target> {
    static ALL: [Target; 6] = TARGETS;
    ALL.iter().find(|t| t.name == name)
}

/// No input is longer.
pub const MAX_LEN: usize = mutate::MAX_LEN;

/// Limits of memory by the length of the input, so that small and large ones are tried and a case always has the same.
fn limit(input: &[u8]) -> u64 {
    1 << (18 + 2 * (input.len() % 5))
}
