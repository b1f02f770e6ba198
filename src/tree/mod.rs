//! The linear tree: 32-byte nodes in canonical order plus the leaf-ordered list of references, and what can be said of it.
//!
//! Builders end in this room and the cache starts from it. A [`Tree`] is the same thing for a mesh (its references name
//! triangles) and for a scene's top level (its references name instances).

mod node;
pub mod quality;
mod refit;

pub use bvhc_core::layout::{MAX_DEPTH, Node, max_depth};
pub use node::Tree;
pub(crate) use refit::refit_built;
pub use refit::{refit, refit_on};

use crate::scene::{Instance, Mesh};

/// Everything that a cache file stores, still in memory: one tree per mesh and, in a two-level file, one over the instances.
#[derive(Clone, Debug, Default)]
pub struct Accel {
    /// The geometry that the BLASes index, parallel to `blases`. At one level, one mesh in world space.
    pub meshes: Vec<Mesh>,
    /// One tree over each of `meshes`.
    pub blases: Vec<Tree>,
    /// `None`: one level, at most one BLAS, world space.
    pub tlas: Option<Tree>,
    /// What the TLAS's references index; empty without a TLAS.
    pub instances: Vec<Instance>,
    /// Why the builder chose what it chose, for people; empty where nothing was chosen.
    pub notes: Vec<String>,
}
