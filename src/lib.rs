//! `bvhc` compiles triangle scenes into bounding volume hierarchies offline and stores them in a cache file that renderers,
//! engines and simulators map into memory and traverse at once.
//!
//! ```text
//! OBJ / glTF ─ scene:: ─▶ Scene ─ build:: ─▶ Accel ─ cache:: ─▶ file ─▶ check · stats · trace · your engine
//! ```

pub mod build;
pub mod cache;
pub mod geom;
pub mod report;
pub mod scene;
pub mod trace;
pub mod tree;

#[cfg(feature = "cli")]
pub mod cli;

/// The Rust in README.md compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
