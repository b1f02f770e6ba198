//! Tall pillars whose sides are exactly coplanar: thousands of triangles that share six planes.

use super::mesh::{Mesh, Vec3, add, scale};

pub fn scene() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.group("upright");
    pillar(&mut mesh, [0.0; 3], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    // Turned by the 3-4-5 triangle, so that four decimals hold the corners exactly and the sides stay coplanar.
    mesh.group("turned");
    pillar(&mut mesh, [8.0, 0.0, 0.0], [[0.6, 0.0, -0.8], [0.0, 1.0, 0.0], [0.8, 0.0, 0.6]]);
    mesh.group("leaning");
    pillar(&mut mesh, [16.0, 0.0, 0.0], [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]]);
    mesh
}

/// Four sides of 12 × 160 cells, 2 m wide and 40 m high, over the axes given.
fn pillar(mesh: &mut Mesh, foot: Vec3, [x, y, z]: [Vec3; 3]) {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    for side in 0..4 {
        let ([x0, z0], [x1, z1]) = (corners[side], corners[(side + 1) % 4]);
        mesh.sheet(12, 160, false, |u, v| {
            let (a, b) = (x0 + (x1 - x0) * u, z0 + (z1 - z0) * u);
            add(foot, add(add(scale(x, a), scale(z, b)), scale(y, 40.0 * v)))
        });
    }
}
