//! The boxes below turned subtrees: the least ones along other axes that hold what the tree's own leaves hold.

use crate::exec::Executor;
use crate::geom::Aabb;
use crate::geom::clip::Polygon;
use crate::layout::{BlasView, Node, TurnRecord};

/// What a leaf holds of its triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// The part in the leaf's own box: a tree with spatial splits says of no more that it is there.
    Part,
    /// All of them: no box need be larger.
    Whole,
}

/// The records of `ONOD` for these turned subtrees of a tree: the links are those of the tree, and each box is the least that holds what is below.
///
/// A leaf holds of each of its triangles what `held` says. `None` where the rows or the tree lead out of the records.
pub fn turned_nodes(tree: &BlasView<'_>, rows: &[TurnRecord], held: Held, exec: &Executor) -> Option<Vec<Node>> {
    let parts = exec.map_range(rows.len(), |i| below(tree, &rows[i], held));
    let mut out = Vec::new();
    // Subtrees within others come behind them, and take their place.
    for (row, part) in rows.iter().zip(parts) {
        let (part, start) = (part?, row.node_offset as usize);
        if start > out.len() {
            return None;
        }
        let end = start.checked_add(part.len())?;
        out.resize(end.max(out.len()), part[0]);
        out[start..end].copy_from_slice(&part);
    }
    Some(out)
}

/// All nodes below one turn, as if no other lay within.
fn below(tree: &BlasView<'_>, row: &TurnRecord, part: Held) -> Option<Vec<Node>> {
    let axes = row.axes.map(|axis| axis.map(f64::from));
    let first = row.first as usize;
    let mut out = tree.nodes.get(first..row.end as usize).filter(|nodes| !nodes.is_empty())?.to_vec();
    for i in (0..out.len()).rev() {
        let node = out[i];
        let bounds = if node.is_leaf() {
            let start = node.first as usize;
            let held = tree.triangles.get(start..start.checked_add(node.count as usize)?)?;
            held.iter().fold(Aabb::EMPTY, |sum, t| sum.union(of_triangle(&t.corners(), &node.bounds(), &axes, part)))
        } else {
            let child = (node.first as usize).checked_sub(first).filter(|child| *child > i)?;
            let [a, b] = out.get(child..)?.first_chunk::<2>()?;
            a.bounds().union(b.bounds())
        };
        out[i] = Node { min: bounds.min, max: bounds.max, ..node };
    }
    Some(out)
}

/// Along other axes, of a triangle what is in a leaf's box. Where rounding leaves nothing, all of it.
fn of_triangle(corners: &[[f32; 3]; 3], leaf: &Aabb, axes: &[[f64; 3]; 3], held: Held) -> Aabb {
    let whole = Polygon::triangle(corners).along(axes).unwrap_or(Aabb::EMPTY);
    if held == Held::Whole || leaf.contains(&Aabb::from_points(corners)) {
        return whole;
    }
    // Both hold the part, so what they have in common does.
    let cut = Polygon::inside(corners, leaf).along(axes).map(|part| part.intersection(whole));
    cut.filter(|cut| !cut.is_empty()).unwrap_or(whole)
}
