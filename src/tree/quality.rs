//! What a tree is worth before a ray is traced.

use super::Node;

/// C_T of every reported SAH: the cost of an inner node, two box tests (Aila, Karras and Laine, "On Quality Metrics of Bounding
/// Volume Hierarchies", 2013).
pub const REPORT_TRAVERSAL_COST: f64 = 1.2;
/// C_I of every reported SAH: the cost of a triangle test.
pub const REPORT_INTERSECTION_COST: f64 = 1.0;

/// SAH = Σ_inner C_T·A(n)/A(root) + Σ_leaf C_I·N(n)·A(n)/A(root), with the report constants. Summed in `f64` in node order,
/// so the value is the same on every machine. 0 where the root has no area.
pub fn sah(nodes: &[Node]) -> f32 {
    let area = |n: &Node| {
        let [x, y, z] = [0, 1, 2].map(|a| f64::from(n.max[a]) - f64::from(n.min[a]));
        x * y + y * z + z * x
    };
    let root = match nodes.first() {
        Some(root) if area(root) > 0.0 => area(root),
        _ => return 0.0,
    };
    let cost = |n: &Node| {
        let per_visit = if n.is_leaf() { REPORT_INTERSECTION_COST * f64::from(n.count) } else { REPORT_TRAVERSAL_COST };
        per_visit * area(n)
    };
    let sum: f64 = nodes.iter().enumerate().filter(|(i, _)| *i != 1).map(|(_, n)| cost(n)).sum();
    (sum / root) as f32
}
