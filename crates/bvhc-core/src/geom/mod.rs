//! Geometry that every room shares: boxes, affine transforms, rays, and what lies between two ends.
//!
//! Positions and boxes are `f32` (what the file stores); transforms are composed in `f64` and rounded once, when an
//! instance is written. Nothing here knows a tree, a file or a thread, and nothing uses fused multiply-add: the same
//! input gives the same bits on every machine.

mod aabb;
mod affine;
pub mod clip;
mod mix;
pub(crate) mod orient;
mod ray;
mod sweep;
pub mod vector;

pub use aabb::Aabb;
pub use affine::Affine;
pub(crate) use affine::{round_down, round_up};
pub use mix::Mix;
pub use ray::Ray;
pub use sweep::swept_box;

/// A position or direction in the scene's own unit.
pub type Point = [f32; 3];
