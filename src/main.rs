//! The `bvhc` program; everything it does is in [`bvhc::cli`].

use bvhc::stability::heap::Counting;
use std::process::ExitCode;

/// Counts for `bvhc chart --stability` alone.
#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn main() -> ExitCode {
    bvhc::cli::run(std::env::args_os().collect()).into()
}
