//! One tree in bounds of several kinds: how much surface they have, and what rays pay for it.

use bvhc::oriented::BoundingVolume;
use bvhc::scene::Mesh;
use bvhc::tree::Tree;

/// Sums over all nodes but the root, which every ray meets.
#[derive(Clone, Copy, Default)]
pub struct Sums {
    pub area: f64,
    pub cost: f64,
}

/// Bound what is below each node by bounds of a kind.
pub fn bounded<V: BoundingVolume>(mesh: &Mesh, tree: &Tree) -> Sums {
    let mut sums = Sums::default();
    if let Some(root) = tree.nodes.first().filter(|root| !root.is_leaf()) {
        for child in 0..2 {
            below::<V>(mesh, tree, root.first as usize + child, &mut sums);
        }
    }
    sums
}

/// The corners of all triangles below a node. As deep as the tree.
fn below<V: BoundingVolume>(mesh: &Mesh, tree: &Tree, node: usize, sums: &mut Sums) -> Vec<[f64; 3]> {
    let record = tree.nodes[node];
    let first = record.first as usize;
    let points: Vec<[f64; 3]> = if record.is_leaf() {
        let triangles = tree.refs[first..first + record.count as usize].iter();
        let corners = triangles.flat_map(|t| mesh.triangles[*t as usize]);
        corners.map(|v| mesh.positions[v as usize].map(f64::from)).collect()
    } else {
        let mut points = below::<V>(mesh, tree, first, sums);
        points.extend(below::<V>(mesh, tree, first + 1, sums));
        points
    };
    if let Some(bounds) = V::of_points(&points) {
        sums.area += bounds.area();
        sums.cost += bounds.cost();
    }
    points
}
