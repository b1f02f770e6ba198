//! What a tree is worth before a ray is traced: the SAH, and the end-point overlap that the SAH does not see.

pub mod epo;
mod subtrees;

pub use bvhc_core::quality::{REPORT_INTERSECTION_COST, REPORT_TRAVERSAL_COST, sah};
pub use subtrees::Subtrees;

use bvhc_core::quality::cost_of_visit;
