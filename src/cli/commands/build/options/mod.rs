//! Flags that change the output.
//!
//! `tree` has those that choose a recipe, made from the library's tables; `listing` prints the table of options for `-O help`; `reading` has
//! those that choose what of a model is read, and `nodes` in which forms the trees are stored.

pub mod listing;
mod nodes;
mod reading;
mod tree;

pub use nodes::{NodeForm, nodes_change};
pub use reading::{InputFormat, ReadArgs};
pub use tree::{TreeArgs, preset_lines};
