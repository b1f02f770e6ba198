//! Wide trees: a binary tree collapsed to nodes of 4 or 8 children, and traversal that tests all children at once.
//!
//! ```text
//! View ── plan, emit ──▶ WideTrees ──▶ WideView ── closest_hit, any_hit
//!                            └──▶ CompactTrees ──▶ WideView
//! ```
//!
//! The *plan* decides by dynamic programming which nodes of the binary tree stay, so that the wide tree has the least SAH cost of all that can be
//! collapsed from it (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017, section 3.1). The
//! binary tree is needed no more than for its triangles, whose order stays.
//!
//! A ray gets the answer that it gets in the binary tree, to the last bit: triangles are tested by the same arithmetic, no box test rejects what that
//! would accept, and among hits of equal distance the order of (instance, geometry, primitive) decides, and no order of visits. Where
//! one triangle stands in several leaves, the record that is named may be another one of those.

mod ask;
mod block;
mod boxes;
mod collapse;
mod compact;
mod emit;
mod plan;
mod record;
mod scene;
mod stack;
#[cfg(test)]
mod tests;
mod trees;
mod walk;

pub use block::TriangleBlock;
pub use collapse::Collapse;
pub use compact::CompactTrees;
pub use record::WideRecord;
pub use scene::WideView;
pub use trees::WideTrees;
