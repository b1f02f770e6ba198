//! The `.bvhc` file: fixed-size little-endian records in hashed, aligned sections behind a 256-byte header.
//!
//! Reading, validation and the rules are those of the crate `bvhc-core`, and appear here again. This room adds what makes files:
//! [`Image`] is a whole file's content in memory, the writer stores it, [`convert`] changes the container alone, and [`freshness`] tells
//! whether a file is up to date. `format-spec/SPEC.md` is the law; this room knows no builder.

mod atomic;
pub mod check;
mod convert;
mod extract;
mod frame_order;
mod freshness;
mod image;
mod intact;
mod provenance;
mod sealed;
mod sequence_writer;
mod writer;

pub use atomic::{Staged, Strays, stage_bytes, sync_folder};
pub use bvhc_core::cache::*;
pub use convert::{ConvertOptions, ConvertSummary, convert};
pub use freshness::{Freshness, Staleness, freshness, freshness_of_bytes, hash_file};
pub use image::Image;
pub(crate) use image::{instance_record, triangle_record};
pub use intact::{intact, sound_sequence};
pub use provenance::provenance;
pub use sealed::{Codec, WriteSummary};
// It asks no rule of what it is given, so that only the sequence builder and tests have it.
#[cfg(not(feature = "testing"))]
pub(crate) use sequence_writer::{Parts, SequenceWriter};
#[cfg(feature = "testing")]
pub use sequence_writer::{Parts, SequenceWriter};
pub use writer::{WriteOptions, stage_file, to_bytes, write_file, write_to};
