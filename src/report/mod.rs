//! What is said about a cache file: [`FileInfo`](info::FileInfo) from its header alone, and for the command line what its trees come to
//! (`file`, `stats`, `overlap`, `outline`), charts, pictures and pages.
//!
//! Everything here is data with one serialisation for machines; the text that people read is laid out by `cli`.

#[cfg(feature = "cli")]
pub mod accuracy;
#[cfg(feature = "cli")]
pub mod chart;
#[cfg(feature = "cli")]
pub mod effort;
#[cfg(feature = "cli")]
pub(crate) mod families;
#[cfg(feature = "cli")]
pub(crate) mod file;
pub mod frames;
#[cfg(feature = "cli")]
mod html;
pub mod info;
#[cfg(feature = "cli")]
pub mod metrics;
#[cfg(feature = "cli")]
pub mod outline;
#[cfg(feature = "cli")]
pub mod rays;
// Public for the fuzz targets, which build without the command line.
#[doc(hidden)]
pub mod overlap;
#[cfg(feature = "cli")]
pub mod page;
#[cfg(feature = "cli")]
pub mod picture;
#[doc(hidden)]
pub mod stats;
#[cfg(feature = "cli")]
pub mod tradeoff;
