//! What is said about a cache file: [`FileInfo`] from its header alone, [`Stats`](stats::Stats) from its trees.
//!
//! Everything here is data with one serialisation for machines; the text that people read is laid out by `cli`.

pub mod info;
