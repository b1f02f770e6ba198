//! The file's binary records and the borrowed form that traversal reads: `format-spec/SPEC.md` in Rust.

mod compact;
mod header;
mod names;
mod node;
mod records;
mod section;
mod sequence;
mod turn;
mod view;
mod wide;

pub use compact::CompactNode;
pub use header::{
    DELTA_MIN_MINOR, Header, KNOWN_REQUIRED_FEATURES, MAGIC, MAJOR, MAX_SECTIONS, MIN_MINOR, MINOR, SEQUENCE_MIN_MINOR,
    required_features,
};
pub use names::{MAX_STRING_LEN, Names, clip, clip_name, encode_names};
pub use node::{MAX_DEPTH, MAX_LEAF, Node, max_depth};
pub use records::{
    BlasRecord, GeomRecord, InstanceRecord, NO_NODE, TriangleRecord, orientation, side_flags, tree_flags,
};
pub use section::{KINDS, KindRule, Presence, SectionEntry, SectionKind, minor_of, section_flags};
pub use sequence::{FrameRecord, IndexedTriangleRecord, PoseRecord, TopologyRecord};
pub use turn::{NEST, TurnRecord, marks_of};
pub use view::{BlasView, View};
pub use wide::{WideNode, WideRow};
