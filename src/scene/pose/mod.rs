//! Posing: what morph targets, joints and nodes make of a mesh's vertices.
//!
//! Node transforms and morph weights go in, positions come out, for the rest pose and for any other time alike. Everything is computed
//! in `f64`; [`Rounded`] then rounds each coordinate to `f32` once.
//!
//! The rules are those of glTF 2.0, 3.7.2.2 and 3.7.3: displacements of morph targets come first; joints place a skinned mesh, and the
//! node that shows it does not.

mod hierarchy;
mod round;
mod vertices;

pub(super) use hierarchy::Hierarchy;
pub(super) use round::{Rounded, split, split_all};
pub(super) use vertices::{Influences, Place, Target, Vertices};
