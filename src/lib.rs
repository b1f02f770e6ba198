//! `bvhc` compiles triangle scenes into bounding volume hierarchies offline and stores them in a cache file that renderers,
//! engines and simulators map into memory and traverse at once.
//!
//! ```text
//! OBJ / glTF ─ scene:: ─▶ Scene ─ compile:: ─▶ Accel ─ cache:: ─▶ file ─▶ check · stats · trace · your engine
//! ```
//!
//! # Open a file and trace a ray
//!
//! ```
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("scene.bvhc");
//! # let model = folder.path().join("scene.obj");
//! # std::fs::write(&model, "o roof\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
//! # bvhc::Build::of_model(&model)?.run()?.write(&path)?;
//! use bvhc::{Cache, Ray};
//!
//! let cache = Cache::open(&path)?; // maps the file and checks its hashes
//! let ray = Ray::new([0.25, 0.25, -2.0], [0.0, 0.0, 1.0]);
//! if let Some(hit) = cache.closest_hit(&ray)? {
//!     let part = cache.name(hit.geom); // empty where the part has none
//!     println!("triangle {} of {part} at distance {}", hit.prim, hit.t);
//! #   assert_eq!((hit.t, hit.prim, part), (2.0, 0, "roof"));
//! }
//! assert!(!cache.any_hit(&ray.until(1.0))?);
//!
//! // Or hand the records to your own traversal, or to a GPU: plain slices of 32- and 48-byte records.
//! let (nodes, triangles) = (cache.nodes(), cache.triangles());
//! assert_eq!(size_of_val(nodes) + size_of_val(triangles), 32 * nodes.len() + 48 * triangles.len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Cache::open_with`](cache::Cache::open_with) chooses how much is checked ([`Validation`](cache::Validation)):
//!
//! | level | holds afterwards | cost |
//! |---|---|---|
//! | `Quick` | right format and version, complete, header and table intact | the table's length, for any size of file |
//! | `Hash`, the default | and every byte is what was written | one pass of BLAKE3 |
//! | `Tree` | and every record is sound, whoever wrote it | a few passes over the records |
//!
//! Traversal is memory-safe and ends at every level; on a malformed tree it returns an error.
//!
//! # Build a file
//!
//! ```
//! # let folder = tempfile::tempdir()?;
//! # let (model, path) = (folder.path().join("scene.obj"), folder.path().join("scene.bvhc"));
//! # std::fs::write(&model, "o roof\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
//! use bvhc::{Build, build::Preset};
//!
//! Build::of_model(&model)?.preset(Preset::Balanced).run()?.write(&path)?;
//! # assert_eq!(bvhc::Cache::open(&path)?.triangles().len(), 1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Build`] takes arrays as well, and several meshes with instances. What it builds can be traced without a file.
//!
//! # Rooms
//!
//! Each imports only from those before it, and all of them from `bvhc-core`.
//!
//! - [`scene`]: reading OBJ and glTF, with every policy about broken geometry;
//! - [`tree`]: the linear tree and its quality;
//! - [`oriented`]: boxes and slabs that need not lie along the axes, the bases that suit them, and which subtrees pay along one;
//! - [`build`]: one mesh becomes a tree: methods, options and passes; the top level over instances;
//! - [`cache`]: the file: writing, opening, checking, converting, and whether it is up to date;
//! - [`trace`]: watertight traversal and the brute force that it is judged by;
//! - [`search`]: methods that build, trace and choose; the rays that trees are adapted to;
//! - [`compile`]: a whole scene becomes all of its trees;
//! - [`sequence`]: many frames become one file;
//! - [`Build`]: all of this in one go;
//! - [`verify`]: rays traced on the CPU and on OpenCL devices, compared with the oracle;
//! - [`report`]: facts about a file, as data, and charts;
//! - [`stability`]: scenes on which builders are known to fail, and how every method does on them.
//!
//! The file format is `format-spec/SPEC.md`: a reader in another language needs nothing else.

#![warn(missing_docs)]

pub mod build;
mod builder;
mod built;
pub mod cache;
pub mod compile;
pub mod oriented;
pub mod report;
pub mod scene;
pub mod search;
pub mod sequence;
pub mod stability;
pub mod trace;
pub mod tree;
pub mod verify;

#[cfg(feature = "cli")]
#[doc(hidden)]
// The program is the interface: `main.rs`, and tests that hold its texts against the documents, come in here.
pub mod cli;

pub use builder::Build;
pub use built::Built;
pub use bvhc_core::{exec, geom, layout, random, refit, simd, size};
pub use cache::{Cache, Opened, Sequence};
pub use geom::Ray;
pub use trace::Hit;

/// The Rust in README.md and docs/ compiles; `tests/cli/documents.rs` sees that no page is forgotten.
#[cfg(doctest)]
mod documents {
    #[doc = include_str!("../README.md")]
    struct Readme;
    #[doc = include_str!("../docs/inputs.md")]
    struct Inputs;
}
