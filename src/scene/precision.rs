//! What storing corners in 32 bits does to a mesh's shape, and from where to measure them so that it does least.

use super::bounds::Bounds;
use super::{Mesh, ReadReport};
use crate::geom::Point;
use crate::geom::vector::sub;

/// How far corners move when they are stored, held against the triangles that they belong to.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Loss {
    /// The farthest that a corner moves, in the unit of the positions.
    pub farthest: f64,
    /// The median of the triangles' shortest edges, in the same unit.
    pub edge: f64,
    /// The mean over the triangles of how far a corner moves, as a share of the triangle's shortest edge and at most 1. At 1 nothing is
    /// left of the shape.
    pub share: f64,
    /// The share of the triangles that come to nothing: a corner moves by more than a quarter of the triangle's longest edge. A sliver whose shortest edge is
    /// lost is none of them.
    pub gone: f64,
}

impl Loss {
    /// The share of a triangle up to which a mesh keeps its shape. Models that are as far from the origin as they are large stay a
    /// hundred times below it, but for such with many slivers, which come within a tenth of it.
    pub const MOST: f64 = 1.0 / 64.0;

    /// The share of the triangles that may come to nothing. A mean does not tell of them where a few small ones stand among many large ones.
    pub const MOST_GONE: f64 = 1.0 / 16384.0;

    /// Whether the mesh keeps its shape.
    pub fn is_tolerable(&self) -> bool {
        self.weight() <= 1.0
    }

    /// Whether more of the shape is lost than by another.
    pub fn is_more_than(&self, other: &Loss) -> bool {
        self.weight() > other.weight()
    }

    /// What is lost as a multiple of what may be. Both are divided by powers of two, so that no order among equals comes from rounding.
    fn weight(&self) -> f64 {
        (self.share / Loss::MOST).max(self.gone / Loss::MOST_GONE)
    }

    /// Triangles of a mesh that are enough to judge it by: the mean of so many values of at most 1 is off by 0.2 % of 1 where it is
    /// [`Loss::MOST`].
    pub const SAMPLE: usize = 4096;

    /// The loss as at most `most` triangles tell it, spread over all of them and the same every time; those that come to nothing are looked for
    /// among all. `exact` and `stored` tell where a vertex is and where it comes to be.
    pub fn of(
        triangles: &[[u32; 3]],
        most: usize,
        exact: impl Fn(u32) -> [f64; 3],
        stored: impl Fn(u32) -> [f64; 3],
    ) -> Loss {
        let (mut farthest, mut sum, mut edges) = (0.0f64, 0.0, Vec::new());
        for t in spread(triangles, most) {
            let corners = t.map(&exact);
            let edge = shortest_edge(corners);
            // Without an edge there is no shape to lose, and what no f32 holds is not stored at all.
            if !(edge > 0.0 && corners.iter().flatten().all(|c| (*c as f32).is_finite())) {
                continue;
            }
            let moved = (0..3).map(|k| length(sub(stored(t[k]), corners[k]))).fold(0.0, f64::max);
            farthest = farthest.max(moved);
            sum += (moved / edge).min(1.0);
            edges.push(edge);
        }
        if edges.is_empty() {
            return Loss::default();
        }
        let gone = gone(triangles, farthest, exact, stored);
        let (share, middle) = (sum / edges.len() as f64, edges.len() / 2);
        let (_, edge, _) = edges.select_nth_unstable_by(middle, f64::total_cmp);
        Loss { farthest, edge: *edge, share, gone }
    }
}

/// Of triangles whose corners stay where they are.
pub(super) fn unmoved(triangles: &[[u32; 3]], exact: impl Fn(u32) -> [f64; 3]) -> Loss {
    let is_stored = |corners: &[[f64; 3]; 3]| corners.iter().flatten().all(|c| (*c as f32).is_finite());
    let corners = spread(triangles, Loss::SAMPLE).map(|t| t.map(&exact)).filter(is_stored);
    let mut edges: Vec<f64> = corners.map(shortest_edge).filter(|edge| *edge > 0.0).collect();
    if edges.is_empty() {
        return Loss::default();
    }
    let middle = edges.len() / 2;
    let (_, edge, _) = edges.select_nth_unstable_by(middle, f64::total_cmp);
    Loss { edge: *edge, ..Loss::default() }
}

/// [`Loss::gone`]. Where some look shows that no corner moves by more than `farthest`, or a little more, only small triangles are asked.
fn gone(
    triangles: &[[u32; 3]],
    farthest: f64,
    exact: impl Fn(u32) -> [f64; 3],
    stored: impl Fn(u32) -> [f64; 3],
) -> f64 {
    let is_gone = |t: &[u32; 3]| {
        let corners = t.map(&exact);
        let reach = corners.iter().flatten().fold(0.0, |most: f64, c| most.max(c.abs()));
        // Floats of that size are 2^-23 of it apart, or less.
        let least = 64.0 * farthest.max(reach * f64::from(f32::EPSILON));
        // Nearly all triangles are larger, and need no root to be told so. The margin is for rounding.
        if longest_square(corners) > 1.001 * least * least + f64::MIN_POSITIVE {
            return false;
        }
        let longest = longest_edge(corners);
        // What no f32 holds is not stored at all.
        let small = reach <= f64::from(f32::MAX) && longest <= least;
        longest > 0.0 && small && (0..3).any(|k| length(sub(stored(t[k]), corners[k])) > 0.25 * longest)
    };
    let count = triangles.iter().filter(|t| is_gone(t)).count();
    count as f64 / triangles.len() as f64
}

/// At most so many of the triangles, from everywhere: multiples of the golden ratio leave no pattern of the mesh out.
pub(super) fn spread(triangles: &[[u32; 3]], most: usize) -> impl Iterator<Item = [u32; 3]> {
    let all = triangles.len();
    (0..all.min(most)).map(move |i| match all <= most {
        true => triangles[i],
        false => {
            let turn = (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            triangles[((u128::from(turn) * all as u128) >> 64) as usize]
        }
    })
}

/// The shortest edges of some thousand of a mesh's triangles, ascending; triangles that have one without length are passed over.
pub(crate) fn shortest_edges(mesh: &Mesh) -> Vec<f64> {
    // An index of nothing, in a scene that nobody has validated, gives no edge.
    let vertex = |v: u32| mesh.positions.get(v as usize).map_or([f64::NAN; 3], |p| p.map(f64::from));
    let edge = |t: [u32; 3]| shortest_edge(t.map(vertex));
    let mut edges: Vec<f64> = spread(&mesh.triangles, Loss::SAMPLE).map(edge).filter(|e| *e > 0.0).collect();
    edges.sort_unstable_by(f64::total_cmp);
    edges
}

fn shortest_edge([a, b, c]: [[f64; 3]; 3]) -> f64 {
    length(sub(a, b)).min(length(sub(b, c))).min(length(sub(c, a)))
}

fn longest_edge([a, b, c]: [[f64; 3]; 3]) -> f64 {
    length(sub(a, b)).max(length(sub(b, c))).max(length(sub(c, a)))
}

fn longest_square([a, b, c]: [[f64; 3]; 3]) -> f64 {
    square(sub(a, b)).max(square(sub(b, c))).max(square(sub(c, a)))
}

fn length(v: [f64; 3]) -> f64 {
    square(v).sqrt()
}

fn square(v: [f64; 3]) -> f64 {
    v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
}

/// Where to measure the points of a box from, so that 32 bits hold them well: near its middle, at multiples of the power of two below its
/// longest side, so that round numbers stay round. The origin itself for a box that lies around it. Each coordinate is an `f32`.
pub(crate) fn local_origin(bounds: Bounds) -> [f64; 3] {
    let (Bounds { min, max }, longest) = (bounds, bounds.longest());
    if !longest.is_finite() {
        return [0.0; 3];
    }
    // A number without its mantissa is the power of two below it; logarithms round differently from machine to machine.
    let step = f64::from_bits(longest.to_bits() & f64::INFINITY.to_bits());
    [0, 1, 2].map(|a| {
        let middle = 0.5 * (min[a] + max[a]);
        let rounded = (middle / step).round() * step;
        let near = if rounded.is_finite() { rounded as f32 } else { middle as f32 };
        if middle.abs() > longest && near.is_finite() { f64::from(near) + 0.0 } else { 0.0 }
    })
}

/// Whether points lie so far off, for the size of their box, that 32-bit floats may be too coarse for what they show.
pub(super) fn is_far(points: &[[f64; 3]]) -> bool {
    let farthest = points.iter().flatten().fold(0.0, |most: f64, c| most.max(c.abs()));
    farthest > 16.0 * Bounds::of(points.iter().copied()).longest()
}

/// Count the triangles whose corners are all numbers, but not all such as `f32` can hold, and the largest coordinate there. `exact` and `stored` tell where a
/// vertex is and where it comes to be.
pub(super) fn count_beyond_range(
    triangles: &[[u32; 3]],
    exact: impl Fn(u32) -> [f64; 3],
    stored: impl Fn(u32) -> Point,
    report: &mut ReadReport,
) {
    for triangle in triangles {
        let corners = triangle.map(&exact);
        let is_beyond = |v: &u32| !stored(*v).iter().all(|c| c.is_finite());
        if triangle.iter().any(is_beyond) && !corners.iter().flatten().any(|c| c.is_nan()) {
            report.out_of_range_triangles += 1;
            let largest = corners.iter().flatten().fold(0.0, |largest: f64, c| largest.max(c.abs()));
            report.largest_magnitude = report.largest_magnitude.max(largest);
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A patch of n × n cells of `cell`, its first corner at `at`.
    pub fn patch(n: u32, cell: f64, at: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let point = |i: u32, j: u32| [at[0] + f64::from(i) * cell, at[1], at[2] + f64::from(j) * cell];
        let positions = (0..=n).flat_map(|i| (0..=n).map(move |j| point(i, j))).collect();
        let cell = |i: u32, j: u32| {
            let a = i * (n + 1) + j;
            [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
        };
        (positions, (0..n).flat_map(|i| (0..n).flat_map(move |j| cell(i, j))).collect())
    }

    fn about(origin: [f64; 3], p: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|a| f64::from((p[a] - origin[a]) as f32) + origin[a])
    }

    #[test]
    fn a_far_patch_loses_its_shape_and_keeps_it_about_an_origin_of_its_own() {
        let (positions, triangles) = patch(20, 0.1, [500_123.26, 102.51, -4_649_776.77]);
        let exact = |v: u32| positions[v as usize];
        let lost = Loss::of(&triangles, usize::MAX, exact, |v| about([0.0; 3], exact(v)));
        assert!(lost.share > 0.9 && (0.1..0.3).contains(&lost.farthest) && (lost.edge - 0.1).abs() < 1e-6, "{lost:?}");
        let origin = local_origin(Bounds::of(positions.clone()));
        assert_eq!(origin, [500_124.0, 102.0, -4_649_776.0]);
        let kept = Loss::of(&triangles, usize::MAX, exact, |v| about(origin, exact(v)));
        assert!(kept.is_tolerable() && kept.share < 1e-5, "{kept:?}");
    }

    #[test]
    fn a_model_about_the_origin_keeps_its_shape_there() {
        let (positions, triangles) = patch(300, 0.1, [-20.0, 0.0, -7.0]);
        assert_eq!(local_origin(Bounds::of(positions.clone())), [0.0; 3]);
        let exact = |v: u32| positions[v as usize];
        let (all, some) = (
            Loss::of(&triangles, usize::MAX, exact, |v| about([0.0; 3], exact(v))),
            Loss::of(&triangles, Loss::SAMPLE, exact, |v| about([0.0; 3], exact(v))),
        );
        assert!(all.is_tolerable() && (all.share - some.share).abs() < 0.05 * all.share, "{all:?} {some:?}");
    }

    #[test]
    fn origins_are_floats_for_boxes_of_any_size() {
        for side in [0.0, 1e-30, 1e-3, 1.0, 777.0, 1e9, 1e38] {
            for at in [0.0, -3.7, 4_649_776.77, -1e12, 2e38] {
                let origin = local_origin(Bounds { min: [at; 3], max: [at + side; 3] });
                assert!(
                    origin.iter().all(|c| f64::from(*c as f32) == *c && c.is_finite()),
                    "{side} at {at}: {origin:?}"
                );
                assert!(origin.iter().all(|c| (c - at).abs() <= 2.0 * side + at.abs() * 1e-7 + 1.0), "{side} at {at}");
            }
        }
    }

    #[test]
    fn a_few_small_parts_count_and_slivers_do_not() {
        // A plain of triangles as long as 100, and at its end `small` of so many others, a hundredth as high as they are long.
        let of = |small: u32, long: f64| {
            let corner = move |v: u32| {
                let (triangle, k) = (v / 3, v % 3);
                let (x, [dx, dy]) = match triangle < small {
                    true => (f64::from(triangle) * long, [[0.0, 0.0], [long, 0.0], [0.0, long / 100.0]][k as usize]),
                    false => (f64::from(triangle) * 100.0, [[0.0, 0.0], [100.0, 0.0], [0.0, 100.0]][k as usize]),
                };
                [4.6e6 + x + dx, 5e5 + dy, 0.0]
            };
            let triangles: Vec<[u32; 3]> = (0..100_000).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
            Loss::of(&triangles, Loss::SAMPLE, corner, |v| corner(v).map(|c| f64::from(c as f32)))
        };
        let lost = of(100, 0.05);
        assert!(lost.share < Loss::MOST && !lost.is_tolerable(), "{lost:?}");
        assert!((0.8e-3..=1e-3).contains(&lost.gone), "{lost:?}");
        let slivers = of(100, 20.0);
        assert!(slivers.gone == 0.0 && slivers.is_tolerable() && lost.is_more_than(&slivers), "{slivers:?}");
    }

    #[test]
    fn triangles_without_edges_and_beyond_the_range_do_not_count() {
        let positions = [[0.0; 3], [1e39, 0.0, 0.0], [f64::NAN, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let at = |v: u32| positions[v as usize];
        let lost = Loss::of(&[[0, 0, 3], [0, 1, 3], [0, 2, 3], [0, 3, 4]], usize::MAX, at, |v| {
            at(v).map(|c| f64::from(c as f32))
        });
        assert_eq!(lost, Loss { edge: 1.0, ..Loss::default() });
        assert_eq!(Loss::of(&[[0, 0, 0]], usize::MAX, at, at), Loss::default());
    }
}
