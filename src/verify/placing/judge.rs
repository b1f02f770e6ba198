use crate::cache::TriangleRecord;
use crate::geom::{Affine, Point};
use crate::scene::Instance;

/// A triangle of the file against one of the model.
#[derive(Clone, Copy)]
pub struct Judged {
    /// How far its corner is off that is off the most.
    pub moved: f64,
    /// The shortest edge of the model's triangle.
    pub edge: f64,
    /// Two of its corners moved against each other by more than half its longest edge, one of them by more than a quarter: it came to nothing, as
    /// [`Loss::gone`](crate::scene::Loss) counts. What moves all corners alike, as the matrix of an instance does, leaves a small triangle its shape.
    pub gone: bool,
    /// Rounding does not explain it.
    pub astray: bool,
}

/// Where a model's corner belongs in a tree, and how far off rounding may put it on each axis: half the distance between floats where it was
/// moved and stored, and what 32-bit matrices add where it is the matrix that moves it.
pub fn judge(
    record: &TriangleRecord,
    corners: [Point; 3],
    instance: &Instance,
    to_tree: &Affine,
    by_matrix: bool,
) -> Judged {
    let magnitudes =
        |m: &Affine, p: [f64; 3]| m.rows.map(|r| (0..3).map(|c| (r[c] * p[c]).abs()).sum::<f64>() + r[3].abs());
    let (mut exact, mut off) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
    let (mut moved, mut astray) = (0.0f64, false);
    for (k, stored) in record.corners().iter().enumerate() {
        let p = corners[k].map(f64::from);
        exact[k] = to_tree.transform_point(instance.transform.transform_point(p));
        let reach = magnitudes(to_tree, magnitudes(&instance.transform, p));
        off[k] = [0, 1, 2].map(|a| f64::from(stored[a]) - exact[k][a]);
        moved = moved.max(apart(off[k], [0.0; 3]));
        astray |= (0..3).any(|a| {
            let stored = f64::from(stored[a]).abs() * 2f64.powi(-24) + f64::from(f32::from_bits(1));
            let of_matrix = if by_matrix { reach[a] * 2f64.powi(-21) } else { 0.0 };
            !(off[k][a].abs() <= 1.01 * stored + reach[a] * 2f64.powi(-48) + of_matrix)
        });
    }
    let edges = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| apart(exact[a], exact[b]));
    let bent = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| apart(off[a], off[b])).into_iter().fold(0.0, f64::max);
    let gone = bent > 0.5 * edges.into_iter().fold(0.0, f64::max);
    Judged { moved, edge: edges.into_iter().fold(f64::INFINITY, f64::min), gone, astray }
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>().sqrt()
}
