//! The commands, one file each: its flags as a clap type, and `run`.

pub mod build;
pub mod chart;
pub mod check;
mod compare;
pub mod completions;
pub mod convert;
pub mod explain;
mod frames;
pub mod info;
pub mod man;
pub mod reference;
pub mod stats;
mod still;
pub mod verify;
pub mod view;
