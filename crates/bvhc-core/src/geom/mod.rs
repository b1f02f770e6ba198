//! Geometry that every room shares: boxes, affine transforms and rays.
//!
//! Positions and boxes are `f32` (what the file stores); transforms are composed in `f64` and rounded once, when an
//! instance is written. Nothing here knows a tree, a file or a thread, and nothing uses fused multiply-add: the same
//! input gives the same bits on every machine.

mod aabb;
mod affine;
pub mod clip;
pub(crate) mod orient;
mod ray;
pub mod vector;

pub use aabb::Aabb;
pub use affine::Affine;
pub(crate) use affine::{round_down, round_up};
pub use ray::Ray;

/// A position or direction in the scene's own unit.
pub type Point = [f32; 3];
