//! A teapot on the centre spot of a stadium: most triangles in a ten-thousandth of the scene's width.

use super::mesh::{Mesh, turn};

pub fn scene() -> Mesh {
    let mut mesh = Mesh::default();
    stands(&mut mesh);
    teapot(&mut mesh);
    mesh
}

/// An oval bowl 240 m long: thirty tiers of a step and a riser, a roof ring, floodlight masts and the pitch.
fn stands(mesh: &mut Mesh) {
    let oval = |u: f64, outward: f64, height: f64| {
        let (cos, sin) = turn(u);
        [(70.0 + outward) * cos, height, -(50.0 + outward) * sin]
    };
    mesh.group("pitch");
    mesh.quad([[-55.0, 0.0, 36.0], [55.0, 0.0, 36.0], [55.0, 0.0, -36.0], [-55.0, 0.0, -36.0]]);
    mesh.group("stands");
    mesh.sheet(96, 60, true, |u, v| {
        let step = (v * 60.0 + 0.5).floor();
        let (tread, riser) = (((step + 1.0) / 2.0).floor(), (step / 2.0).floor());
        oval(u, tread * 1.4, 1.0 + riser * 0.7)
    });
    mesh.group("roof");
    mesh.sheet(96, 1, true, |u, v| oval(u, 20.0 + 30.0 * v, 34.0 - 4.0 * v));
    mesh.group("masts");
    for mast in 0..8 {
        let [x, _, z] = oval((f64::from(mast) + 0.5) / 8.0, 46.0, 0.0);
        mesh.bar([x, 0.0, z], [x, 48.0, z], 0.5, 12);
    }
}

/// Body, lid, knob, spout and handle, 30 cm wide.
fn teapot(mesh: &mut Mesh) {
    mesh.group("teapot body");
    mesh.sheet(96, 48, true, |u, v| {
        // A round belly on a narrow foot, by a cubic from foot to rim.
        let radius = 0.06 * (1.0 - v) * (1.0 - v) * (1.0 - v)
            + 0.54 * v * (1.0 - v) * (1.0 - v)
            + 0.48 * v * v * (1.0 - v)
            + 0.08 * v * v * v;
        let (cos, sin) = turn(u);
        [radius * cos, 0.01 + 0.16 * v, -radius * sin]
    });
    mesh.group("teapot lid");
    mesh.sheet(96, 16, true, |u, v| {
        let radius = 0.076 * (1.0 - v * v) + 0.004;
        let (cos, sin) = turn(u);
        [radius * cos, 0.17 + 0.04 * v, -radius * sin]
    });
    mesh.lathe([0.0, 0.205, 0.0], &[(0.006, 0.0), (0.014, 0.008), (0.016, 0.016), (0.012, 0.024), (0.004, 0.028)], 48);
    // Spout and handle are tubes about a curve in the x-y plane.
    let tube = |mesh: &mut Mesh, centre: &dyn Fn(f64) -> [f64; 2], radius: &dyn Fn(f64) -> f64| {
        mesh.sheet(48, 40, true, |u, v| {
            let ([x, y], [x1, y1]) = (centre(v), centre(v + 0.001));
            let (dx, dy) = (x1 - x, y1 - y);
            let length = (dx * dx + dy * dy).sqrt();
            let (cos, sin) = turn(u);
            let r = radius(v);
            [x - dy / length * r * cos, y + dx / length * r * cos, r * sin]
        });
    };
    mesh.group("teapot spout");
    tube(mesh, &|t| [0.11 + 0.10 * t, 0.06 + 0.11 * t * t * (1.6 - 0.6 * t)], &|t| 0.028 - 0.016 * t);
    mesh.group("teapot handle");
    tube(
        mesh,
        &|t| {
            let (cos, sin) = turn(0.25 + 0.5 * t);
            [-0.11 + 0.075 * cos, 0.09 + 0.06 * sin]
        },
        &|_| 0.01,
    );
}
