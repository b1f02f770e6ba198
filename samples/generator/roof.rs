//! Corrugated sheets at 30° on a rotated shed: long, thin, and along no axis.

use super::mesh::{Mesh, Vec3, pitch, spin, turn};

const WAVES: usize = 120;
const FACETS: usize = 8;

pub fn scene() -> Mesh {
    let mut mesh = Mesh::default();
    // Two pitches of three overlapping rows of sheets. The corrugation runs down the slope in one piece a sheet.
    for (side, name) in [(1.0, "south"), (-1.0, "north")] {
        mesh.group(name);
        for row in 0..3 {
            let near = f64::from(row) * 3.8;
            mesh.sheet(WAVES * FACETS, 1, false, |u, v| {
                let (_, wave) = turn(u * WAVES as f64);
                let lift = 0.04 * wave + 0.02 * f64::from(3 - row);
                place([30.0 * (u - 0.5), lift, near + 4.0 * v], side)
            });
        }
    }
    mesh.group("purlins");
    for side in [1.0, -1.0] {
        for purlin in 0..8 {
            let z = 0.4 + f64::from(purlin) * 1.55;
            mesh.bar(place([-15.0, -0.12, z], side), place([15.0, -0.12, z], side), 0.06, 6);
        }
    }
    mesh
}

/// From the sheet's plane to the world: down the 30° slope to one side of the ridge, the shed turned by 25°.
fn place(p: Vec3, side: f64) -> Vec3 {
    let sloped = pitch(p, turn(1.0 / 12.0));
    let raised = [sloped[0], 12.0 + sloped[1], side * sloped[2]];
    spin(raised, turn(25.0 / 360.0))
}
