//! A helicopter on the pad, rotors turning: an OBJ frame sequence with one topology.
//!
//! The main rotor turns 15° a frame, so its long blades lie along an axis in some frames and between two in the others; a builder that
//! looks at one axis only is fast in one frame and slow in the next.

use super::mesh::{Mesh, Vec3, add, spin, turn};

pub const FRAMES: u32 = 12;

const MAST: Vec3 = [0.0, 3.4, 0.0];
const TAIL: Vec3 = [-9.0, 2.9, 0.35];

pub fn frame(number: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let step = f64::from(number - 1);
    body(&mut mesh);

    mesh.group("main rotor");
    let mut blade = Mesh::default();
    blade.sheet(24, 8, true, |u, v| {
        // A thin lens in section, twisted along the span and drooping to the tip.
        let (cos, sin) = turn(u);
        let span = 0.5 + 7.0 * v;
        [span, 0.04 * sin + 0.06 * cos * (1.0 - v) - 0.12 * v * v, 0.28 * cos]
    });
    for blade_number in 0..4 {
        let angle = turn(f64::from(blade_number) / 4.0 + step * 15.0 / 360.0);
        mesh.append(&blade, |p| add(MAST, spin(p, angle)));
    }
    mesh.lathe([0.0, 2.6, 0.0], &[(0.12, 0.0), (0.12, 0.7), (0.45, 0.75), (0.45, 0.9), (0.1, 1.0)], 24);

    mesh.group("tail rotor");
    for blade_number in 0..3 {
        let (cos, sin) = turn(f64::from(blade_number) / 3.0 + step * 50.0 / 360.0);
        mesh.append(&blade, |p| {
            let [along, thick, wide] = [p[0] * 0.14, p[1] * 0.3, p[2] * 0.3];
            add(TAIL, [along * cos - wide * sin, along * sin + wide * cos, thick])
        });
    }
    mesh
}

/// Cabin, boom, fin and skids: the same in each frame.
fn body(mesh: &mut Mesh) {
    mesh.group("cabin");
    mesh.sheet(32, 24, true, |u, v| {
        let ((along, around), (cos, sin)) = (turn(0.005 + v * 0.49), turn(u));
        [2.6 * along - 0.2, 1.7 + 1.05 * around * sin, 1.0 * around * cos]
    });
    mesh.group("boom");
    mesh.sheet(16, 4, true, |u, v| {
        let (cos, sin) = turn(u);
        let radius = 0.45 - 0.3 * v;
        [-2.2 - 6.8 * v, 2.1 + 0.5 * v + radius * sin, radius * cos]
    });
    mesh.group("fin");
    mesh.cuboid([-9.5, 1.9, -0.05], [-8.6, 3.9, 0.05]);
    mesh.group("skids");
    for z in [-1.1, 1.1] {
        mesh.bar([-2.2, 0.1, z], [2.4, 0.1, z], 0.06, 10);
        for x in [-1.2, 1.2] {
            mesh.bar([x, 0.1, z], [x, 1.0, z * 0.6], 0.05, 8);
        }
    }
    mesh.group("pad");
    mesh.quad([[-12.0, 0.0, 12.0], [12.0, 0.0, 12.0], [12.0, 0.0, -12.0], [-12.0, 0.0, -12.0]]);
}
