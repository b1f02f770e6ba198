//! What is said about a cache file: [`FileInfo`](info::FileInfo) from its header alone, [`FileReport`](file::FileReport) from
//! its trees.
//!
//! Everything here is data with one serialisation for machines; the text that people read is laid out by `cli`.

#[cfg(feature = "cli")]
pub mod accuracy;
#[cfg(feature = "cli")]
pub mod chart;
pub mod file;
pub mod info;
pub mod overlap;
pub mod stats;
