//! The `bvhc` program; everything it does is in [`bvhc::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    bvhc::cli::run(std::env::args_os().collect()).into()
}
