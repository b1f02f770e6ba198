//! The surface of what planes enclose.

use super::basis::unit;
use crate::geom::vector::{cross, dot, sub};

/// Surface area of `{p : n·p ≤ d for all (n, d)}`. The first six planes are those of a box along the axes, in the order +x −x +y −y +z −z.
///
/// Each plane's face is a square that is larger than the box, cut by all others. Planes that others cut off have no face.
pub(super) fn area(planes: &[([f64; 3], f64)]) -> f64 {
    let high = [0, 1, 2].map(|a| planes[2 * a].1);
    let low = [0, 1, 2].map(|a| -planes[2 * a + 1].1);
    let middle = [0, 1, 2].map(|a| 0.5 * (low[a] + high[a]));
    let reach = (0..3).map(|a| high[a] - low[a]).sum::<f64>();
    if !(reach > 0.0) {
        return 0.0;
    }
    // Around the middle, in the size of the box: no number is large or small.
    let planes: Vec<([f64; 3], f64)> = (planes.iter())
        .filter_map(|(normal, distance)| {
            let length = dot(*normal, *normal).sqrt();
            Some((unit(*normal)?, (distance - dot(*normal, middle)) / (length * reach)))
        })
        .collect();
    let faces = planes.iter().enumerate().map(|(k, plane)| {
        let mut face = square(*plane);
        for (_, cut) in planes.iter().enumerate().filter(|(other, _)| *other != k) {
            face = clipped(&face, *cut);
        }
        polygon_area(&face)
    });
    faces.sum::<f64>() * reach * reach
}

/// In the plane, so large that it reaches beyond a box around the origin whose sides sum up to 1.
fn square((normal, distance): ([f64; 3], f64)) -> Vec<[f64; 3]> {
    let basis = super::basis::Basis::along(normal, [0.0; 3]);
    [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]].map(|[y, z]| basis.point([distance, y, z])).to_vec()
}

/// What of a convex polygon is on the inner side (Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974).
fn clipped(polygon: &[[f64; 3]], (normal, distance): ([f64; 3], f64)) -> Vec<[f64; 3]> {
    let mut inside = Vec::with_capacity(polygon.len() + 1);
    for (i, b) in polygon.iter().enumerate() {
        let a = polygon[(i + polygon.len() - 1) % polygon.len()];
        let (from, to) = (distance - dot(normal, a), distance - dot(normal, *b));
        if (from < 0.0) != (to < 0.0) {
            let t = from / (from - to);
            inside.push([0, 1, 2].map(|k| a[k] + t * (b[k] - a[k])));
        }
        if to >= 0.0 {
            inside.push(*b);
        }
    }
    inside
}

fn polygon_area(corners: &[[f64; 3]]) -> f64 {
    let Some((first, others)) = corners.split_first() else { return 0.0 };
    let mut sum = [0.0; 3];
    for pair in others.windows(2) {
        let part = cross(sub(pair[0], *first), sub(pair[1], *first));
        sum = [0, 1, 2].map(|k| sum[k] + part[k]);
    }
    0.5 * dot(sum, sum).sqrt()
}
