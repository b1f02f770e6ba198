//! What people build: halls, stands, roofs, cloth, cities. Long pieces among fine ones, and nothing along the axes.

use super::shapes::{Point, Soup, add, bar, cuboid, direction, mapped, quad, scale, sheet, turned, within};
use crate::random::Random;

/// Columns in bays, and trim that runs the whole length in single pieces, between walls.
pub fn hall(count: usize) -> Soup {
    let mut soup = open_hall(count);
    let length = soup.iter().flatten().map(|p| p[0]).fold(0.0, f64::max);
    cuboid(&mut soup, [-1.0, -0.5, -8.5], [length + 1.0, 10.5, 8.5]);
    soup
}

/// The same without walls.
fn open_hall(count: usize) -> Soup {
    let mut soup = Soup::new();
    let bays = (count / 36).max(2);
    let length = 6.0 * bays as f64;
    for bay in 0..bays {
        let x = 6.0 * bay as f64;
        for z in [-5.0, 5.0] {
            bar(&mut soup, [x, 0.0, z], [x, 7.0, z], 0.4);
            cuboid_top(&mut soup, [x, 7.0, z]);
        }
    }
    for strip in 0..count / 18 {
        let z = -8.0 + 16.0 * strip as f64 / (count / 18) as f64;
        let y = [0.0, 7.4, 10.0][strip % 3];
        quad(&mut soup, [[0.0, y, z], [length, y, z], [length, y + 0.1, z + 0.2], [0.0, y + 0.1, z + 0.2]]);
    }
    soup
}

/// The open hall with curtains between the columns.
pub fn arcade(count: usize) -> Soup {
    let mut soup = open_hall(count / 2);
    let bays = (count / 2 / 36).max(2);
    let folds = (count / 2 / bays / 4).max(1);
    for bay in 0..bays {
        let left = 6.0 * bay as f64 + 1.0;
        for (side, z) in [-5.0, 5.0].into_iter().enumerate() {
            sheet(&mut soup, folds, 1, |u, v| {
                let fold = (u * folds as f64).round() as usize + side;
                [left + 4.0 * u, 7.0 * v, z + if fold.is_multiple_of(2) { 0.15 } else { -0.15 }]
            });
        }
    }
    soup
}

fn cuboid_top(soup: &mut Soup, at: Point) {
    quad(soup, [[-0.6, 0.4, -0.6], [0.6, 0.4, -0.6], [0.6, 0.4, 0.6], [-0.6, 0.4, 0.6]].map(|p| add(at, p)));
    quad(soup, [[-0.6, 0.0, -0.6], [0.6, 0.0, -0.6], [0.6, 0.4, -0.6], [-0.6, 0.4, -0.6]].map(|p| add(at, p)));
}

/// The hall without walls, turned by 45° about two axes.
pub fn turned_hall(count: usize) -> Soup {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    mapped(open_hall(count), |p| turned(p, (half, half)))
}

/// A body and long blades at an angle, as a rotor has them between two frames.
pub fn rotor(count: usize) -> Soup {
    let mut soup = Soup::new();
    sphere(&mut soup, count * 3 / 4, 1.0, [0.0; 3]);
    for blade in 0..count / 32 {
        let (sin, cos) = [(0.6, 0.8), (-0.8, 0.6), (-0.6, -0.8), (0.8, -0.6), (0.28, 0.96)][blade % 5];
        let (y, reach) = (1.5 + 0.01 * blade as f64, 9.0 + 0.03 * blade as f64);
        bar(&mut soup, [0.3 * cos, y, 0.3 * sin], [reach * cos, y, reach * sin], 0.08);
    }
    soup
}

/// Nearly all triangles in a ten-thousandth of the scene's width.
pub fn teapot_in_a_stadium(count: usize) -> Soup {
    let mut soup = Soup::new();
    sphere(&mut soup, count * 9 / 10, 0.01, [0.0; 3]);
    for step in 0..count / 20 {
        let (near, y) = (60.0 + step as f64, 0.5 * step as f64);
        quad(
            &mut soup,
            [[-near, y, -near], [near, y, -near], [near, y + 0.5, -near - 1.0], [-near, y + 0.5, -near - 1.0]],
        );
    }
    soup
}

/// Sheets down a slope, turned off every axis.
pub fn roof(count: usize) -> Soup {
    let mut soup = Soup::new();
    sheet(&mut soup, count / 2, 1, |u, v| {
        let fold = (u * (count / 2) as f64).round() as i64;
        [30.0 * u, if fold % 2 == 0 { 0.0 } else { 0.05 }, 12.0 * v]
    });
    // 30° and 25° to the last digit that matters here.
    mapped(soup, |p| turned(p, (0.5, 0.866_025_4)))
}

/// Bars in three directions, turned by 45°.
pub fn scaffold(count: usize) -> Soup {
    let mut soup = Soup::new();
    let side = ((count / 24) as f64).sqrt().ceil().max(2.0) as usize;
    let reach = 2.0 * side as f64;
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (2.0 * i as f64, 2.0 * j as f64))) {
        bar(&mut soup, [i, j, 0.0], [i, j, reach], 0.05);
        bar(&mut soup, [i, 0.0, j], [i, reach, j], 0.05);
        bar(&mut soup, [0.0, i, j], [reach, i, j], 0.05);
    }
    let half = std::f64::consts::FRAC_1_SQRT_2;
    mapped(soup, |p| turned(p, (half, half)))
}

/// Cloth in deep folds.
pub fn curtain(count: usize) -> Soup {
    let mut soup = Soup::new();
    let rows = ((count / 16) as f64).sqrt().max(2.0) as usize;
    sheet(&mut soup, 8 * rows, rows, |u, v| {
        // A wave of parabolas, which no library of functions has a part in.
        let place = 11.0 * u + 0.2 * v;
        let part = place.fract();
        let wave = if place as i64 % 2 == 0 { 4.0 * part * (1.0 - part) } else { -4.0 * part * (1.0 - part) };
        [4.0 * u + 0.1 * v * wave, 3.0 * (1.0 - v), (0.08 + 0.25 * v) * wave]
    });
    soup
}

/// Thousands of triangles in a few planes that lean.
pub fn pillar(count: usize) -> Soup {
    let mut soup = Soup::new();
    let rows = (count / 8 / 4).max(1);
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    for side in 0..4 {
        let ([x0, z0], [x1, z1]) = (corners[side], corners[(side + 1) % 4]);
        sheet(&mut soup, 4, rows, |u, v| [x0 + (x1 - x0) * u, 40.0 * v, z0 + (z1 - z0) * u]);
    }
    mapped(soup, |p| turned(p, (0.28, 0.96)))
}

/// A plane of two triangles, and grass on it.
pub fn meadow(count: usize) -> Soup {
    let (mut soup, mut random) = (Soup::new(), Random::new(26));
    quad(&mut soup, [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [100.0, 0.0, 100.0], [0.0, 0.0, 100.0]]);
    for _ in 2..count {
        let [x, _, z] = within(&mut random, 0.0, 100.0);
        let lean = scale(direction(&mut random), 0.2);
        soup.push([[x, 0.0, z], [x + 0.05, 0.0, z + 0.02], [x + lean[0], 0.8, z + lean[2]]]);
    }
    soup
}

/// Equal blocks in equal streets, and pipes across them.
pub fn city(count: usize) -> Soup {
    let mut soup = Soup::new();
    let side = ((count / 14) as f64).sqrt().max(2.0) as usize;
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (4.0 * i as f64, 4.0 * j as f64))) {
        cuboid(&mut soup, [i, 0.0, j], [i + 3.0, 6.0, j + 3.0]);
    }
    let reach = 4.0 * side as f64;
    for pipe in 0..count / 56 {
        let (y, z) = (6.5 + 0.2 * (pipe % 7) as f64, reach * pipe as f64 / (count / 56) as f64);
        bar(&mut soup, [0.0, y, z], [reach, y, z], 0.05);
    }
    soup
}

/// A wide, nearly flat height field.
pub fn terrain(count: usize) -> Soup {
    let mut soup = Soup::new();
    let side = ((count / 2) as f64).sqrt().max(2.0) as usize;
    sheet(&mut soup, side, side, |u, v| {
        let (x, z) = (u * side as f64, v * side as f64);
        [x, 0.05 * ((x as i64 * 7 + z as i64 * 13) % 5) as f64, z]
    });
    soup
}

/// A ball of about so many triangles, even as a scan is.
pub fn sphere(soup: &mut Soup, count: usize, radius: f64, centre: Point) {
    let n = ((count / 12) as f64).sqrt().max(1.0) as usize;
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            sheet(soup, n, n, |u, v| {
                let mut p = [side; 3];
                (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (2.0 * u - 1.0, 2.0 * v - 1.0);
                let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
                add(centre, scale(p, radius / length))
            });
        }
    }
}

/// A ball alone.
pub fn ball(count: usize) -> Soup {
    let mut soup = Soup::new();
    sphere(&mut soup, count, 1.0, [0.0; 3]);
    soup
}

/// Thin ribbons that curl from the middle outward.
pub fn hairball(count: usize) -> Soup {
    let (mut soup, mut random) = (Soup::new(), Random::new(9));
    while soup.len() < count {
        let (mut at, mut way) = ([0.0; 3], direction(&mut random));
        for _ in 0..8 {
            way = add(way, scale(direction(&mut random), 0.5));
            let (to, wide) = (add(at, scale(way, 0.15)), scale(direction(&mut random), 0.004));
            quad(&mut soup, [at, add(at, wide), add(to, wide), to]);
            at = to;
        }
    }
    soup
}
