//! What a tree is expected to cost before a ray is traced: the surface area heuristic (SAH).

mod sah;

pub use sah::sah;

use crate::layout::Node;

/// C_T of every reported SAH and EPO: the cost of an inner node, two box tests (Aila, Karras and Laine, "On Quality Metrics of
/// Bounding Volume Hierarchies", 2013).
pub const REPORT_TRAVERSAL_COST: f64 = 1.2;
/// C_I of every reported SAH and EPO: the cost of a triangle test.
pub const REPORT_INTERSECTION_COST: f64 = 1.0;

/// C_n, what a ray pays at a node: C_T for an inner one, C_I for each reference of a leaf.
pub fn cost_of_visit(node: &Node) -> f64 {
    if node.is_leaf() { REPORT_INTERSECTION_COST * f64::from(node.count) } else { REPORT_TRAVERSAL_COST }
}
