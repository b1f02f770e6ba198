//! The `.bvhc` file: fixed-size little-endian records in hashed, aligned sections behind a 256-byte header.
//!
//! `records` are the bytes, [`Image`] is a whole file's content in memory, [`View`] is the borrowed form that traversal reads,
//! mapped or not. `format-spec/SPEC.md` is the law; this room knows no builder.

pub mod check;
mod header;
mod image;
pub mod keys;
mod records;
pub mod rules;
mod section;
mod view;

pub use header::{BUILDERS, Header, KNOWN_REQUIRED_FEATURES, MAGIC, MAJOR, MAX_SECTIONS, MIN_MINOR, MINOR, builder_id};
pub use image::Image;
pub use records::{BlasRecord, GeomRecord, InstanceRecord, NO_NODE, TriangleRecord, tree_flags};
pub use section::{KINDS, KindRule, Presence, SectionEntry, SectionKind, section_flags};
pub use view::{BlasView, View};
