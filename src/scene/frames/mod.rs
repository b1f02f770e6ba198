//! Files that are the frames of one sequence: names with a place for a number, lists of numbers, and what a folder has of both.

mod folder;
mod numbers;
mod pattern;

pub use folder::{Folder, ranges, runs};
pub use numbers::{MOST_NUMBERS, Numbers};
pub use pattern::{Match, NoPattern, Pattern};
