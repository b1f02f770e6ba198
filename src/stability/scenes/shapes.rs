//! What failure scenes are put together from: triangles without any order or sharing.

use crate::random::Random;

pub type Point = [f64; 3];
/// Triangles by their corners.
pub type Soup = Vec<[Point; 3]>;

pub fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn scale(a: Point, by: f64) -> Point {
    a.map(|c| c * by)
}

/// A random point of the cube from `low` to `high`.
pub fn within(random: &mut Random, low: f64, high: f64) -> Point {
    [0; 3].map(|_| low + (high - low) * random.unit())
}

/// A direction as the repository's random numbers have them, of length 1.
pub fn direction(random: &mut Random) -> Point {
    random.direction()
}

/// Two triangles with the corners in order around.
pub fn quad(soup: &mut Soup, [a, b, c, d]: [Point; 4]) {
    soup.extend([[a, b, c], [a, c, d]]);
}

/// An axis-aligned box of 12 triangles.
pub fn cuboid(soup: &mut Soup, low: Point, high: Point) {
    let p = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 0 { low[k] } else { high[k] });
    for face in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
        quad(soup, face.map(p));
    }
}

/// A sheet of `columns` × `rows` cells over `surface(u, v)` with u and v from 0 to 1.
pub fn sheet(soup: &mut Soup, columns: usize, rows: usize, surface: impl Fn(f64, f64) -> Point) {
    let p = |i: usize, j: usize| surface(i as f64 / columns as f64, j as f64 / rows as f64);
    for j in 0..rows {
        for i in 0..columns {
            quad(soup, [p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1)]);
        }
    }
}

/// A square bar of 8 long triangles.
pub fn bar(soup: &mut Soup, from: Point, to: Point, radius: f64) {
    let along = add(to, scale(from, -1.0));
    let steep = along[1].abs() > along[0].abs() + along[2].abs();
    let (right, up) =
        if steep { ([radius, 0.0, 0.0], [0.0, 0.0, radius]) } else { ([0.0, radius, 0.0], [radius, 0.0, -radius]) };
    let ring = [add(right, up), add(right, scale(up, -1.0)), scale(add(right, up), -1.0), add(scale(right, -1.0), up)];
    for i in 0..4 {
        let (a, b) = (ring[i], ring[(i + 1) % 4]);
        quad(soup, [add(from, a), add(from, b), add(to, b), add(to, a)]);
    }
}

/// Every corner put through `map`.
pub fn mapped(soup: Soup, map: impl Fn(Point) -> Point) -> Soup {
    soup.into_iter().map(|corners| corners.map(&map)).collect()
}

/// Turned about the vertical and then about the x axis, each by the angle with this sine and cosine.
pub fn turned([x, y, z]: Point, (sin, cos): (f64, f64)) -> Point {
    let (x, z) = (x * cos + z * sin, z * cos - x * sin);
    [x, y * cos - z * sin, y * sin + z * cos]
}
