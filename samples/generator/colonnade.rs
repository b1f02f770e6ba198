//! A two-storey hall of columns, 72 m long: what Sponza is to a builder, in a scene of our own.
//!
//! Fine stonework (capitals, arches) stands among trim that runs the whole length of the hall: cornices, rails, floor
//! boards, roof slats, and braces and cables that cross it slantwise. The long pieces have their centres in the middle, so
//! their boxes cover the hall whatever an object split does with them; only cutting them helps.

use super::mesh::{Mesh, Random, Vec3, turn};

const LENGTH: f64 = 72.0;
const BAYS: usize = 12;
const BAY: f64 = LENGTH / BAYS as f64;
/// Half the nave's width, and half the hall's.
const NAVE: f64 = 6.0;
const HALL: f64 = 11.0;
const STOREY: f64 = 7.0;

pub fn scene() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.group("columns");
    for storey in 0..2 {
        for row in [-NAVE, NAVE] {
            for column in 0..=BAYS {
                let foot = [column as f64 * BAY, storey as f64 * STOREY, row];
                mesh.lathe(foot, &profile(if storey == 0 { 0.55 } else { 0.4 }), 20);
            }
        }
    }
    mesh.group("arches");
    for storey in 0..2 {
        for row in [-NAVE, NAVE] {
            for bay in 0..BAYS {
                arch(&mut mesh, [bay as f64 * BAY, storey as f64 * STOREY + 4.2, row]);
            }
        }
    }
    trim(&mut mesh);
    shell(&mut mesh);
    slanted(&mut mesh);
    mesh
}

/// Base, shaft and capital as (radius, height); the shaft is one row of tall thin triangles.
fn profile(radius: f64) -> [(f64, f64); 14] {
    let at = |r: f64, h: f64| (radius * r, h);
    [
        at(1.45, 0.0),
        at(1.45, 0.18),
        at(1.3, 0.24),
        at(1.38, 0.33),
        at(1.22, 0.42),
        at(1.05, 0.5),
        at(0.88, 3.5),
        at(1.0, 3.56),
        at(0.96, 3.66),
        at(1.1, 3.8),
        at(1.32, 3.92),
        at(1.5, 4.0),
        at(1.5, 4.12),
        at(1.2, 4.2),
    ]
}

/// A round arch over one bay: the soffit and both faces up to a straight lintel.
fn arch(mesh: &mut Mesh, left: Vec3) {
    let (middle, radius, depth, top) = (left[0] + BAY / 2.0, BAY / 2.0 - 0.5, 0.45, 2.6);
    let curve = |u: f64| {
        let (cos, sin) = turn(0.5 - u / 2.0);
        [middle + radius * cos, left[1] + 0.9 * radius * sin]
    };
    mesh.sheet(16, 1, false, |u, v| {
        let [x, y] = curve(u);
        [x, y, left[2] + depth * (2.0 * v - 1.0)]
    });
    for side in [-depth, depth] {
        mesh.sheet(16, 1, false, |u, v| {
            let [x, y] = curve(u);
            if v == 0.0 { [x, y, left[2] + side] } else { [x, left[1] + top, left[2] + side] }
        });
    }
}

/// Flat quadrilaterals along the hall between the joints given, from line `a` to line `b` in (y, z).
fn strip(mesh: &mut Mesh, a: (f64, f64), b: (f64, f64), joints: &[f64]) {
    for x in joints.windows(2) {
        mesh.quad([[x[0], a.0, a.1], [x[1], a.0, a.1], [x[1], b.0, b.1], [x[0], b.0, b.1]]);
    }
}

/// Pieces that run the whole length of the hall, or most of it up to a joint that is staggered as boards are laid.
fn trim(mesh: &mut Mesh) {
    let along = |mesh: &mut Mesh, a: (f64, f64), b: (f64, f64)| strip(mesh, a, b, &[0.0, LENGTH]);
    let mut random = Random(1);
    let mut jointed = |mesh: &mut Mesh, a: (f64, f64), b: (f64, f64)| {
        let joint = LENGTH * random.between(0.2, 0.8);
        strip(mesh, a, b, &[0.0, joint, LENGTH]);
    };
    mesh.group("cornices");
    let steps =
        [(0.0, 0.0), (0.06, 0.05), (0.12, 0.05), (0.16, 0.11), (0.24, 0.13), (0.27, 0.2), (0.34, 0.2), (0.4, 0.28)];
    for height in [4.05, 6.55, 11.05, 13.55] {
        for (row, outward) in [(-NAVE, 1.0), (-NAVE, -1.0), (NAVE, 1.0), (NAVE, -1.0)] {
            for pair in steps.windows(2) {
                let at = |(rise, reach): (f64, f64)| (height + rise, row + outward * (0.46 + reach));
                along(mesh, at(pair[0]), at(pair[1]));
            }
        }
    }
    mesh.group("rails");
    for row in [-NAVE - 0.5, NAVE + 0.5] {
        for height in [7.3, 7.6, 7.9, 8.2] {
            mesh.bar([0.0, height, row], [LENGTH, height, row], 0.04, 8);
        }
    }
    mesh.group("balusters");
    for row in [-NAVE - 0.5, NAVE + 0.5] {
        for post in 0..180 {
            let x = (f64::from(post) + 0.5) * LENGTH / 180.0;
            mesh.lathe([x, 7.0, row], &[(0.05, 0.0), (0.09, 0.35), (0.04, 0.9), (0.07, 1.2)], 6);
        }
    }
    mesh.group("boards");
    for (floor, from, to) in [(0.0, -HALL, HALL), (6.95, -HALL, -NAVE - 0.6), (6.95, NAVE + 0.6, HALL)] {
        let boards = ((to - from) / 0.2).floor() as usize;
        let width = (to - from) / boards as f64;
        for board in 0..boards {
            let z = from + board as f64 * width;
            jointed(mesh, (floor, z), (floor, z + width * 0.97));
        }
    }
    mesh.group("wall courses");
    for wall in [-HALL, HALL] {
        for course in 0..70 {
            let y = f64::from(course) * 0.2;
            let relief = if course % 2 == 0 { 0.0 } else { 0.03 };
            jointed(mesh, (y, wall + relief), (y + 0.195, wall + relief));
        }
    }
}

/// End walls and cross beams: coarse boxes.
fn shell(mesh: &mut Mesh) {
    mesh.group("ends");
    for x in [-0.6, LENGTH + 0.2] {
        mesh.cuboid([x, 0.0, -HALL], [x + 0.4, 15.0, HALL]);
    }
    mesh.group("beams");
    for bay in 0..=BAYS {
        let x = bay as f64 * BAY;
        mesh.cuboid([x - 0.15, 13.95, -HALL], [x + 0.15, 14.35, HALL]);
        for row in [-HALL, NAVE + 0.4] {
            mesh.cuboid([x - 0.12, 6.5, row], [x + 0.12, 6.9, row + HALL - NAVE - 0.4]);
        }
    }
}

/// What lies along no axis: the pitched roof, braces under it, and cables hung across the nave.
fn slanted(mesh: &mut Mesh) {
    mesh.group("slats");
    let mut random = Random(3);
    for side in [-1.0, 1.0] {
        for slat in 0..60 {
            let at = |t: f64| (14.4 + 6.0 * t, side * HALL * (1.0 - t));
            let ((y0, z0), (y1, z1)) = (at(f64::from(slat) / 60.0), at((f64::from(slat) + 0.92) / 60.0));
            strip(mesh, (y0, z0), (y1, z1), &[0.0, LENGTH * random.between(0.2, 0.8), LENGTH]);
        }
    }
    mesh.group("rafters");
    for rafter in 0..=48 {
        let x = f64::from(rafter) * LENGTH / 48.0;
        for side in [-1.0, 1.0] {
            let along = [0.0, 6.0, -side * HALL];
            mesh.block([x - 0.08, 14.1, side * HALL], [0.16, 0.0, 0.0], along, [0.0, 0.25, 0.0]);
        }
    }
    mesh.group("braces");
    for bay in 0..BAYS {
        let x = bay as f64 * BAY;
        for side in [-1.0, 1.0] {
            mesh.bar([x, 14.2, side * HALL], [x + BAY, 19.8, side * 1.0], 0.09, 6);
            mesh.bar([x + BAY, 14.2, side * HALL], [x, 19.8, side * 1.0], 0.09, 6);
        }
    }
    mesh.group("cables");
    for bay in 0..BAYS - 2 {
        let x = bay as f64 * BAY;
        for (drop, reach) in [(12.8, 3.0), (11.6, 2.0)] {
            mesh.bar([x, drop, -NAVE], [x + reach * BAY * 0.66, 9.0, NAVE], 0.03, 5);
            mesh.bar([x, drop, NAVE], [x + reach * BAY * 0.66, 9.0, -NAVE], 0.03, 5);
        }
    }
}
