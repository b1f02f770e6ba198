//! Bases that a set of points suggests.

use super::basis::Basis;
use super::extremes::Extremes;
use crate::geom::vector::{cross, dot, sub};

/// The bases of DiTO-14: a large triangle among the extreme points, and those that lead from its edges to the points farthest above and
/// below it. Each triangle gives one basis for each of its edges, with its normal (Larsson and Källberg, "Fast Computation of Tight-Fitting
/// Oriented Bounding Boxes", Game Engine Gems 2, 2011, section 1.2).
pub fn ditetrahedron(extremes: &Extremes) -> Vec<Basis> {
    // The base: the two that are farthest apart of a direction, and what is farthest from their line.
    let between = |k: usize| sub(extremes.high[k], extremes.low[k]);
    let widest = first_greatest(0..7, |k| dot(between(k), between(k)));
    let (a, b) = (extremes.low[widest], extremes.high[widest]);
    let edge = between(widest);
    if dot(edge, edge) == 0.0 {
        return Vec::new();
    }
    let points = extremes.points();
    let from_line = |i: usize| cross(edge, sub(points[i], a));
    let farthest = first_greatest(0..points.len(), |i| dot(from_line(i), from_line(i)));
    let normal = from_line(farthest);
    if dot(normal, normal) == 0.0 {
        return vec![Basis::along(edge, [0.0; 3])];
    }
    let c = points[farthest];

    // The two tetrahedra that stand on it.
    let height = |i: usize| dot(normal, sub(points[i], a));
    let above = first_greatest(0..points.len(), height);
    let below = first_greatest(0..points.len(), |i| -height(i));
    let mut triangles = vec![[a, b, c]];
    for apex in [above, below].into_iter().filter(|i| height(*i) != 0.0).map(|i| points[i]) {
        triangles.extend([[a, b, apex], [b, c, apex], [c, a, apex]]);
    }
    triangles.iter().flat_map(of_edges).collect()
}

/// Of the facets of the points' convex hull, one basis for each edge. Of the least box only this is certain: two faces that meet each hold an
/// edge of the hull (O'Rourke, "Finding Minimal Enclosing Boxes", 1985). So these are candidates, and not the answer.
///
/// Each three points are asked against all others: for a few dozen points at most.
pub fn hull_facets(points: &[[f64; 3]]) -> Vec<Basis> {
    /// How far off a plane, for the size of what is asked, still is in it.
    const IN_PLANE: f64 = 1e-12;
    let mut bases = Vec::new();
    for i in 0..points.len() {
        for j in i + 1..points.len() {
            for k in j + 1..points.len() {
                let [a, b, c] = [points[i], points[j], points[k]];
                let normal = cross(sub(b, a), sub(c, a));
                let size = dot(normal, normal).sqrt();
                if size == 0.0 {
                    continue;
                }
                let (mut above, mut below) = (false, false);
                for p in points {
                    let to = sub(*p, a);
                    let (height, reach) = (dot(normal, to), size * dot(to, to).sqrt());
                    above |= height > IN_PLANE * reach;
                    below |= height < -IN_PLANE * reach;
                }
                if !(above && below) {
                    bases.extend(of_edges(&[a, b, c]));
                }
            }
        }
    }
    bases
}

/// In a triangle's plane, along each of its edges.
fn of_edges([a, b, c]: &[[f64; 3]; 3]) -> [Basis; 3] {
    let [ab, bc, ca] = [sub(*b, *a), sub(*c, *b), sub(*a, *c)];
    [Basis::along(ab, bc), Basis::along(bc, ca), Basis::along(ca, ab)]
}

/// The first of those for which it is greatest.
fn first_greatest(among: std::ops::Range<usize>, of: impl Fn(usize) -> f64) -> usize {
    let mut best = among.start;
    for i in among {
        if of(i) > of(best) {
            best = i;
        }
    }
    best
}
