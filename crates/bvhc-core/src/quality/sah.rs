use super::cost_of_visit;
use crate::layout::Node;

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
    let sum: f64 = nodes.iter().enumerate().filter(|(i, _)| *i != 1).map(|(_, n)| cost_of_visit(n) * area(n)).sum();
    (sum / root) as f32
}
