//! The `.bvhc` file as a reader sees it: opened, validated, handed out as slices; and the rules that it is checked by.
//!
//! `format-spec/SPEC.md` is the law; this room knows no builder and no model.

mod aligned;
pub mod check;
mod container;
mod decode;
#[cfg(feature = "zstd")]
mod delta;
mod error;
mod file_bytes;
mod head;
pub mod keys;
mod meta;
mod open;
mod options;
mod origin;
#[cfg(feature = "zstd")]
mod pack;
mod poses;
mod reader;
mod records_by_id;
mod report;
pub mod rules;
mod sequence;
mod sound;

pub use crate::layout::{
    BlasRecord, BlasView, CompactNode, DELTA_MIN_MINOR, FrameRecord, GeomRecord, Header, IndexedTriangleRecord,
    InstanceRecord, KINDS, KNOWN_REQUIRED_FEATURES, KindRule, MAGIC, MAJOR, MAX_SECTIONS, MAX_STRING_LEN, MIN_MINOR,
    MINOR, NO_NODE, Names, PoseRecord, Presence, SEQUENCE_MIN_MINOR, SectionEntry, SectionKind, TopologyRecord,
    TriangleRecord, TurnRecord, View, WideRow, clip_name, minor_of, required_features, section_flags, side_flags,
    tree_flags,
};
pub use error::{CacheError, ErrorKind, Limited, Unlike};
pub use file_bytes::FileBytes;
pub use head::Head;
pub use meta::{Dependency, MAX_META_LEN, Meta};
pub use options::{OpenOptions, Validation};
pub use reader::{Cache, Opened};
pub use records_by_id::RecordsById;
pub use sequence::{Between, BetweenInstance, BetweenTree, Frame, Frames, Moment, Sequence};

/// What writers of files share with the reader. Not part of the stable interface.
#[doc(hidden)]
pub mod parts {
    #[cfg(feature = "testing")]
    pub use super::check::cover::{Cover, Covered, most_steps};
    pub use super::container::{Container, check_tree_flags, is_known_codec, is_understood};
    #[cfg(feature = "zstd")]
    pub use super::delta::{Block, Encoder, pack_triangles};
    pub use super::error::Fault;
    #[cfg(feature = "zstd")]
    pub use super::pack::{BLOCK_LEN, frames_of, pack, unpack as unpack_frames};
    pub use crate::layout::{clip, encode_names};
}
