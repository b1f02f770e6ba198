//! What a tree is worth before a ray is traced: the SAH, and the end-point overlap that the SAH does not see.

pub mod epo;
mod sah;
mod subtrees;

pub use sah::sah;
pub use subtrees::Subtrees;

use super::Node;

/// C_T of every reported SAH and EPO: the cost of an inner node, two box tests (Aila, Karras and Laine, "On Quality Metrics of
/// Bounding Volume Hierarchies", 2013).
pub const REPORT_TRAVERSAL_COST: f64 = 1.2;
/// C_I of every reported SAH and EPO: the cost of a triangle test.
pub const REPORT_INTERSECTION_COST: f64 = 1.0;

/// C_n, what a ray pays at a node: C_T for an inner one, C_I for each reference of a leaf.
fn cost_of_visit(node: &Node) -> f64 {
    if node.is_leaf() { REPORT_INTERSECTION_COST * f64::from(node.count) } else { REPORT_TRAVERSAL_COST }
}
