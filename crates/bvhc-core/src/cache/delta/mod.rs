//! Codec 2: a sequence as differences (`format-spec/SPEC.md`, section 8.1). What is decoded is the same to the last bit.
//!
//! | file | holds |
//! |---|---|
//! | `ranks` | which pose another one is stored relative to |
//! | `weights` | how a vertex follows those before it |
//! | `residuals` | the vertices of a pose, less what was predicted |
//! | `links` | nodes without boxes, and the boxes that follow from the vertices |
//! | `triangles` | the triangles of the topologies |
//! | `planes` | bytes of one kind side by side, packed |
//! | `blocks` | what of a block stands where |
//! | `encode` | packing, block after block |

mod blocks;
mod encode;
mod links;
mod planes;
mod ranks;
mod residuals;
mod triangles;
mod weights;

pub use blocks::{Blocks, shape_of};
pub use encode::{Block, Encoder};
pub use links::Link;
pub use ranks::Ranks;
pub use residuals::Base;
pub use triangles::{decode as decode_triangles, pack as pack_triangles};
pub use weights::{Kept, Weights};
