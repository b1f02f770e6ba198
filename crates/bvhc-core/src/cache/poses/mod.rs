//! What opening and checking a sequence share: whether its rows lead where they say, and how a pose becomes the tree of a still file.

mod pose;
mod rows;

pub use pose::{PoseRows, Posed};
pub use rows::{Rows, parts_of};
