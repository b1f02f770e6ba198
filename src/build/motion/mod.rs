//! Trees for a mesh that moves: one topology, or a few, for all frames of an animation.
//!
//! In each frame the boxes of a tree are [fitted](crate::tree::refit) to where the triangles stand then, and its topology stays. A tree that is built for one frame
//! is good there and worse elsewhere. Here trees are chosen and changed so that they are good on average over the frames, and a set of them is found of
//! which each frame takes the one that is best for it.
//!
//! The measure is the SAH of a tree fitted to a frame. It needs no ray, and a mean of it is one sum over the nodes.

mod cost;
mod frames;
mod keyed;
mod medoids;
mod optimise;
mod policy;
mod rebuild;
mod representatives;

pub use cost::{cost, costs, triangle_cost};
pub use frames::{Motion, MotionError};
pub use keyed::{Keyed, Trees, keyed};
pub use medoids::{Choice, choose};
pub use optimise::optimise;
pub use policy::{Refit, RefitPolicy};
pub use rebuild::{Cost, Rebuild, Schedule, Step, Verdict, schedule};
pub use representatives::{Pose, representatives};

/// Raised whenever trees for whole animations come out otherwise, and added to the method's revision: no file of before then passes for one of now.
pub const REVISION: u32 = 2;

#[cfg(test)]
mod tests;
