use crate::geom::{Aabb, Point};

/// How far, relative to the largest coordinate, a point may lie outside of a box and still count as inside: it allows for the
/// rounding of this file's own `f64` arithmetic (2⁻⁵³ an operation) and is far below one unit in the last place of the `f32`
/// boxes (2⁻²⁴), so that a clipper that rounds inward is found.
const SLACK: f64 = 1.0 / (1u64 << 46) as f64;

/// Finds holes; keeps its list of intervals from one triangle to the next.
#[derive(Default)]
pub struct Cover {
    pieces: Vec<(f64, f64)>,
}

impl Cover {
    /// A point of the triangle that lies in none of the boxes, if one is found.
    ///
    /// Corners are compared exactly. Along each edge the boxes cut out intervals, whose union must be the whole edge. For two
    /// boxes that is a proof for the whole triangle: a point that a line parts from the one box and another line from the
    /// other lies in a wedge free of both, and a wedge leaves the triangle through its edges. For more boxes a few points
    /// inside are tried as well.
    pub fn hole(&mut self, corners: [Point; 3], boxes: &[Aabb]) -> Option<[f64; 3]> {
        for p in corners {
            if !boxes.iter().any(|b| b.contains(&Aabb { min: p, max: p })) {
                return Some(p.map(f64::from));
            }
        }
        let [a, b, c] = corners.map(|p| p.map(f64::from));
        let largest = [a, b, c].iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        let slack = largest * SLACK;
        let gap = [(a, b), (b, c), (c, a)].into_iter().find_map(|(p, q)| self.gap_on_edge(p, q, boxes, slack));
        if gap.is_some() || boxes.len() <= 2 {
            return gap;
        }
        INSIDE.iter().map(|w| blend(a, b, c, *w)).find(|p| !boxes.iter().any(|b| holds(b, p, slack)))
    }

    /// The first point from `p` to `q` where no box is.
    fn gap_on_edge(&mut self, p: [f64; 3], q: [f64; 3], boxes: &[Aabb], slack: f64) -> Option<[f64; 3]> {
        // Most edges lie in one box.
        if boxes.iter().any(|b| holds(b, &p, slack) && holds(b, &q, slack)) {
            return None;
        }
        // Cut the edge by each box (the slab method), sort the pieces, and look for a hole between them.
        let inverse = [0, 1, 2].map(|i| 1.0 / (q[i] - p[i]));
        self.pieces.clear();
        self.pieces.extend(boxes.iter().filter_map(|b| piece(p, inverse, b, slack)));
        self.pieces.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut reached = 0.0f64;
        for (enter, leave) in &self.pieces {
            if *enter > reached + ROUNDING {
                break;
            }
            reached = reached.max(*leave);
        }
        (reached < 1.0 - ROUNDING).then(|| [0, 1, 2].map(|i| p[i] + (q[i] - p[i]) * reached))
    }
}

/// Rounding of the intervals' ends, which lie between 0 and 1.
const ROUNDING: f64 = 1e-14;

/// Barycentric weights of the points that are tried inside.
const INSIDE: [[f64; 3]; 4] =
    [[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], [0.5, 0.25, 0.25], [0.25, 0.5, 0.25], [0.25, 0.25, 0.5]];

fn blend(a: [f64; 3], b: [f64; 3], c: [f64; 3], w: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] * w[0] + b[i] * w[1] + c[i] * w[2])
}

fn holds(b: &Aabb, p: &[f64; 3], slack: f64) -> bool {
    (0..3).all(|i| f64::from(b.min[i]) - slack <= p[i] && p[i] <= f64::from(b.max[i]) + slack)
}

/// Where the edge from `p` runs through the box; `inverse` is one over the edge's extent.
fn piece(p: [f64; 3], inverse: [f64; 3], b: &Aabb, slack: f64) -> Option<(f64, f64)> {
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for i in 0..3 {
        let (low, high) = (f64::from(b.min[i]) - slack, f64::from(b.max[i]) + slack);
        if inverse[i].is_infinite() {
            if p[i] < low || high < p[i] {
                return None;
            }
            continue;
        }
        let (s, t) = ((low - p[i]) * inverse[i], (high - p[i]) * inverse[i]);
        enter = enter.max(s.min(t));
        leave = leave.min(s.max(t));
    }
    (enter <= leave).then_some((enter, leave))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uncovered(corners: [Point; 3], boxes: &[Aabb]) -> Option<[f64; 3]> {
        Cover::default().hole(corners, boxes)
    }

    const TRIANGLE: [Point; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    fn slab(min_x: f32, max_x: f32, max_y: f32) -> Aabb {
        Aabb { min: [min_x, 0.0, 0.0], max: [max_x, max_y, 0.0] }
    }

    #[test]
    fn two_halves_cover_and_a_hair_between_them_does_not() {
        assert_eq!(uncovered(TRIANGLE, &[slab(0.0, 1.0, 4.0), slab(1.0, 4.0, 3.0)]), None);
        let hair = uncovered(TRIANGLE, &[slab(0.0, 1.0, 4.0), slab(1.0f32.next_up(), 4.0, 3.0)]);
        assert!(hair.is_some_and(|p| (p[0] - 1.0).abs() < 1e-6), "{hair:?}");
    }

    #[test]
    fn a_missing_corner_and_a_low_clip_are_found() {
        assert_eq!(uncovered(TRIANGLE, &[slab(0.0, 1.0, 4.0), slab(1.0, 3.5, 3.0)]), Some([4.0, 0.0, 0.0]));
        // The upper edge leaves the left box at x = 1 with y = 3, but the right box ends at y = 2.9.
        assert!(uncovered(TRIANGLE, &[slab(0.0, 1.0, 4.0), slab(1.0, 4.0, 2.9)]).is_some());
    }
}
