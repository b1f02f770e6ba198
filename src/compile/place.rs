//! How well 32-bit matrices place a mesh.

use crate::geom::{Aabb, Affine, Point};
use crate::scene::{Bounds, Loss, Mesh, shortest_edges};

/// How small a mesh's triangles are: enough to tell what moving all of it by some distance is worth.
pub(super) struct Grain {
    pub bounds: Bounds,
    /// Shortest edges of some triangles, ascending, and for each the sum of the reciprocals from it on.
    edges: Vec<f64>,
    reciprocals: Vec<f64>,
}

impl Grain {
    pub fn new(mesh: &Mesh) -> Grain {
        let edges = shortest_edges(mesh);
        let mut sum = 0.0;
        let mut reciprocals: Vec<f64> = edges
            .iter()
            .rev()
            .map(|e| {
                sum += 1.0 / e;
                sum
            })
            .collect();
        reciprocals.reverse();
        Grain { bounds: mesh_box(mesh), edges, reciprocals }
    }

    /// What the mesh loses when rays come to it by the inverse that a file has of a matrix: it then stands elsewhere by as much as both
    /// roundings make, in the mesh's own unit.
    pub fn loss_by_matrix(&self, transform: &Affine) -> Loss {
        let Some(edge) = self.edges.get(self.edges.len() / 2) else { return Loss::default() };
        if *transform == Affine::IDENTITY {
            return Loss { edge: *edge, ..Loss::default() };
        }
        let back = Affine::from_f32(&transform.to_f32()).inverse().map(|inverse| Affine::from_f32(&inverse.to_f32()));
        let farthest = back.map_or(f64::INFINITY, |back| {
            // An affine map moves no point of a box farther than one of its corners.
            let moved = |p: [f64; 3]| distance(back.transform_point(transform.transform_point(p)), p);
            self.bounds.corners().into_iter().map(moved).fold(0.0, f64::max)
        });
        Loss { farthest, edge: *edge, share: self.share(farthest), gone: 0.0 }
    }

    /// The mean over the triangles of a distance as a share of the shortest edge, at most 1.
    fn share(&self, distance: f64) -> f64 {
        let gone = self.edges.partition_point(|e| *e <= distance);
        let rest = self.reciprocals.get(gone).map_or(0.0, |sum| distance * sum);
        (gone as f64 + rest) / self.edges.len() as f64
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
}

/// A vertex; NaN for an index that names none, which no measure counts.
pub(super) fn vertex(mesh: &Mesh, v: u32) -> Point {
    mesh.positions.get(v as usize).copied().unwrap_or([f32::NAN; 3])
}

/// The box of what a mesh's triangles use.
pub(super) fn mesh_box(mesh: &Mesh) -> Bounds {
    // Whatever a scene is that nobody has validated yet, measuring it does no harm.
    let used = mesh.triangles.iter().flatten().filter_map(|v| mesh.positions.get(*v as usize).copied());
    used.fold(Aabb::EMPTY, Aabb::grow).into()
}

/// A box of the world that contains a moved one.
pub(super) fn world_box(Bounds { min, max }: &Bounds, transform: &Affine) -> Bounds {
    let mut out = Bounds { min: [0.0; 3], max: [0.0; 3] };
    for (a, row) in transform.rows.iter().enumerate() {
        let ends = [0, 1, 2].map(|c| [row[c] * min[c], row[c] * max[c]]);
        out.min[a] = row[3] + ends.iter().map(|[x, y]| x.min(*y)).sum::<f64>();
        out.max[a] = row[3] + ends.iter().map(|[x, y]| x.max(*y)).sum::<f64>();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh() -> Mesh {
        Mesh {
            positions: vec![[0.0; 3], [0.25, 0.0, 0.0], [0.0, 1.0, 0.0], [4.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [1, 2, 3]],
            ..Mesh::default()
        }
    }

    #[test]
    fn a_distance_counts_for_each_triangle_by_its_edge_and_at_most_once() {
        let grain = Grain::new(&mesh());
        let long = (1.0f64 + 0.0625).sqrt();
        for (distance, want) in [
            (0.0, 0.0),
            (0.125, 0.25 + 0.0625 / long),
            (0.25, 0.5 + 0.125 / long),
            (0.5, 0.5 + 0.25 / long),
            (9.0, 1.0),
        ] {
            assert!((grain.share(distance) - want).abs() < 1e-12, "{distance}");
        }
    }

    #[test]
    fn matrices_of_floats_lose_nothing_and_others_what_rounding_is_worth() {
        let grain = Grain::new(&mesh());
        assert_eq!(grain.bounds, Bounds { min: [0.0; 3], max: [4.0, 1.0, 0.0] });
        for exact in [Affine::IDENTITY, Affine::translation([500_123.25, 0.0, -4_649_776.5])] {
            assert_eq!(grain.loss_by_matrix(&exact).farthest, 0.0);
        }
        let off = grain.loss_by_matrix(&Affine::translation([500_123.25, 0.0, -4_649_776.75]));
        assert_eq!((off.farthest, off.share > 0.5), (0.25, true));
        // The way back of a turned mesh is rounded where it is far from its own origin, even if the matrix is exact.
        let turned = Affine { rows: [[0.6, -0.8, 0.0, 4e6], [0.8, 0.6, 0.0, 3e6], [0.0, 0.0, 1.0, 0.0]] };
        assert!(!grain.loss_by_matrix(&turned).is_tolerable());
        let singular = Affine { rows: [[0.0; 4]; 3] };
        assert_eq!(grain.loss_by_matrix(&singular).share, 1.0);
    }
}
