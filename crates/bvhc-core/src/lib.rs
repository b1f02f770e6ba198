//! Opens `.bvhc` cache files and traces rays through them: what a renderer, an engine or a simulator links.
//!
//! The files are built by the crate and program `bvhc`. This crate reads no models and builds no trees.
//!
//! # Open a file and trace a ray
//!
//! ```no_run
//! use bvhc_core::{Cache, Ray};
//!
//! let cache = Cache::open("scene.bvhc")?; // maps the file and checks its hashes
//! let ray = Ray::new([0.25, 0.25, -2.0], [0.0, 0.0, 1.0]);
//! if let Some(hit) = cache.closest_hit(&ray)? {
//!     println!("triangle {} at distance {}", hit.prim, hit.t);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//!
//! | feature | default | brings |
//! |---|---|---|
//! | `mmap` | yes | files are mapped instead of read |
//! | `meta` | yes | provenance: what a file was built from |
//! | `pure` | yes | hashing without assembly, so that no C compiler is needed |
//! | `zstd` | no | compressed sections; needs a C compiler |
//! | `rayon` | no | hashing, decoding and checking on several threads |
//! | `serde` | no | reports and rules can be serialised |
//!
//! # Rooms
//!
//! Each imports only from those before it: [`exec`], [`geom`], `random` and `size` (closed to others), [`simd`], [`layout`], [`refit`](mod@refit), [`quality`], [`cache`], [`trace`].

#![warn(missing_docs)]

pub mod cache;
pub mod exec;
pub mod geom;
pub mod layout;
mod pod;
pub mod quality;
#[doc(hidden)] // for the crates of this repository
pub mod random;
pub mod refit;
pub mod simd;
#[doc(hidden)]
pub mod size;
pub mod trace;

pub use cache::{Cache, Sequence};
pub use geom::Ray;
pub use trace::Hit;

/// The Rust in README.md compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
