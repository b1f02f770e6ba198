//! `bvhc-test-client RAYS FILE…`: what rays hit in each file. The same text as `tests/client/run.mjs` prints for the WebAssembly module.

use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(rays) = arguments.next().and_then(|rays| rays.parse().ok()) else {
        eprintln!("usage: bvhc-test-client RAYS FILE...");
        return ExitCode::from(2);
    };
    for path in arguments {
        match std::fs::read(&path) {
            Ok(file) => print!("== {path}\n{}", bvhc_test_client::trace(&file, rays)),
            Err(error) => {
                eprintln!("cannot read {path}: {error}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}
