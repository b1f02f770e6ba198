//! The `.bvhc` file: fixed-size little-endian records in hashed, aligned sections behind a 256-byte header.
//!
//! `records` are the bytes, [`Image`] is a whole file's content in memory, [`View`] is the borrowed form that traversal reads,
//! mapped or not. `format-spec/SPEC.md` is the law; this room knows no builder.

mod aligned;
mod atomic;
pub mod check;
mod container;
mod convert;
mod error;
mod freshness;
mod head;
mod header;
mod image;
pub mod keys;
mod meta;
mod names;
mod pack;
mod reader;
mod records;
pub mod rules;
mod section;
mod view;
mod writer;

pub use convert::{ConvertOptions, ConvertSummary, convert};
pub use error::{CacheError, ErrorKind};
pub use freshness::{Freshness, Staleness, freshness, freshness_of_bytes, hash_file};
pub use head::Head;
pub use header::{BUILDERS, Header, KNOWN_REQUIRED_FEATURES, MAGIC, MAJOR, MAX_SECTIONS, MIN_MINOR, MINOR, builder_id};
pub use image::Image;
pub(crate) use image::triangle_record;
pub use meta::{Dependency, MAX_META_LEN, MAX_STRING_LEN, Meta};
pub use names::{Names, clip_name};
pub use reader::{Cache, FileBytes, OpenOptions, Validation};
pub use records::{BlasRecord, GeomRecord, InstanceRecord, NO_NODE, TriangleRecord, tree_flags};
pub use section::{KINDS, KindRule, Presence, SectionEntry, SectionKind, section_flags};
pub use view::{BlasView, View};
pub use writer::{Codec, WriteOptions, WriteSummary, to_bytes, write_file, write_to};
