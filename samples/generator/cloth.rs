//! A drawn curtain: a fine cloth in deep folds, dense and curved everywhere.

use super::mesh::{Mesh, turn};

pub fn scene() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.group("cloth");
    mesh.sheet(320, 48, false, |u, v| {
        // The folds deepen from the rail downward, lean with the draught, and double back on themselves below.
        let drop = 3.2 * v;
        let deep = 0.08 + 0.22 * v;
        let (cos, sin) = turn(11.0 * u + 0.13 * v);
        let (_, slow) = turn(2.0 * u + 0.4 * v);
        let (_, overlap) = turn(22.0 * u);
        let x = 4.0 * u + 0.07 * v * overlap + 0.05 * cos * v;
        [x, 3.4 - drop, deep * sin + 0.12 * v * slow]
    });
    mesh.group("rail");
    mesh.bar([-0.2, 3.46, 0.0], [4.2, 3.46, 0.0], 0.03, 12);
    mesh.group("rings");
    for ring in 0..24 {
        let x = (f64::from(ring) + 0.5) / 6.0;
        mesh.sheet(12, 8, true, |u, v| {
            let ((c, s), (c2, s2)) = (turn(u), turn(v));
            let r = 0.05 + 0.008 * c2;
            [x + 0.008 * s2, 3.45 + r * c, r * s]
        });
    }
    mesh
}
