//! Compiles `shim.cpp` with the header tiny_bvh.h of the package tinybvh-rs, wherever Cargo keeps that.

use std::process::Command;

const PACKAGE: &str = "tinybvh-rs-0.1.0-beta.3";

fn main() {
    println!("cargo:rerun-if-changed=src/shim.cpp");
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let output =
        Command::new(cargo).args(["metadata", "--format-version", "1", "--locked"]).output().expect("cargo metadata");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let manifest = format!("{PACKAGE}/Cargo.toml");
    let manifest = text.split('"').find(|part| part.ends_with(&manifest)).expect("a package of the lock file");
    let folder = manifest.trim_end_matches("Cargo.toml").to_string() + "ffi/tinybvh";
    let mut build = cc::Build::new();
    build
        .cpp(true)
        .std("c++20")
        .flag("-march=native")
        .opt_level(3)
        .warnings(false)
        .include(folder)
        .file("src/shim.cpp");
    if std::env::var_os("CARGO_FEATURE_PARALLEL").is_none() {
        build.define("NO_THREADED_BUILDS", None);
    }
    build.compile("shim");
}
