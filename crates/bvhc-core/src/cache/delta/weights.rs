use std::collections::VecDeque;
use std::sync::Arc;

use crate::geom::Point;

/// Vertices before a vertex that say how it moves.
pub const NEIGHBOURS: usize = 8;

/// For each vertex of a topology how much the motion of each of the eight vertices before it counts, the nearest one first; 0 where there is none.
///
/// They follow from the first pose of the topology. Where vertices that stand near each other there move by one affine map, such as a bone's, the weighted
/// sum of their motions is the vertex's own. The map is fitted by least squares with weights that fall with the squared distance, and a small
/// ridge keeps it bounded where the vertices lie in a plane or a line.
///
/// The operations and their order are those of the specification, and all are exactly rounded: every reader computes the same bits.
#[derive(Clone, Debug)]
pub struct Weights(Vec<[f64; NEIGHBOURS]>);

impl Weights {
    /// From the vertices of a topology's first pose.
    pub fn of(first: &[Point]) -> Weights {
        Weights((0..first.len()).map(|v| weights(first, v)).collect())
    }

    /// Those of one vertex.
    pub fn at(&self, vertex: usize) -> &[f64; NEIGHBOURS] {
        self.0.get(vertex).unwrap_or(&[0.0; NEIGHBOURS])
    }

    /// Bytes that are held for so many vertices.
    pub fn bytes(vertices: u64) -> u64 {
        vertices * size_of::<[f64; NEIGHBOURS]>() as u64
    }
}

/// The weights of the topologies that were asked for last: whatever a file has, memory holds a few.
#[derive(Debug, Default)]
pub struct Kept(VecDeque<(u32, Arc<Weights>)>);

impl Kept {
    const MOST: usize = 8;

    /// Those of a topology, whose first pose has these vertices.
    pub fn weights(&mut self, topology: u32, first: &[Point]) -> Arc<Weights> {
        if let Some((_, known)) = self.0.iter().find(|(of, _)| *of == topology) {
            return known.clone();
        }
        let new = Arc::new(Weights::of(first));
        if self.0.len() == Kept::MOST {
            self.0.pop_front();
        }
        self.0.push_back((topology, new.clone()));
        new
    }
}

/// 2⁻⁴⁰: two vertices in one place do not count infinitely.
const NEAR: f64 = 1.0 / (1u64 << 40) as f64;
/// 2⁻¹⁰ of the trace, the ridge of a plane.
const RIDGE: f64 = 1.0 / 1024.0;
/// 2⁻²⁴, the ridge where all are in one place.
const FLOOR: f64 = 1.0 / (1u64 << 24) as f64;

fn weights(first: &[Point], v: usize) -> [f64; NEIGHBOURS] {
    let count = v.min(NEIGHBOURS);
    let mut weights = [0.0; NEIGHBOURS];
    if count == 0 {
        return weights;
    }
    // Where the neighbours stand, seen from the vertex.
    let mut offsets = [[0.0; 3]; NEIGHBOURS];
    let mut squares = [0.0; NEIGHBOURS];
    let mut farthest = 0.0;
    let here = first[v].map(f64::from);
    for k in 0..count {
        let there = first[v - 1 - k].map(f64::from);
        let d = [there[0] - here[0], there[1] - here[1], there[2] - here[2]];
        offsets[k] = d;
        squares[k] = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        farthest = if squares[k] > farthest { squares[k] } else { farthest };
    }
    let mut near = [0.0; NEIGHBOURS];
    let (mut sum, mut mean) = (0.0, [0.0; 3]);
    for k in 0..count {
        near[k] = if farthest > 0.0 { 1.0 / (squares[k] + NEAR * farthest) } else { 1.0 };
        sum += near[k];
        for axis in 0..3 {
            mean[axis] += near[k] * offsets[k][axis];
        }
    }
    mean = mean.map(|m| m / sum);
    // The scatter of the neighbours about their mean: xx xy xz yy yz zz.
    let mut s = [0.0; 6];
    for k in 0..count {
        let d = [offsets[k][0] - mean[0], offsets[k][1] - mean[1], offsets[k][2] - mean[2]];
        for (entry, (i, j)) in s.iter_mut().zip([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]) {
            *entry += near[k] * d[i] * d[j];
        }
    }
    let ridge = (s[0] + s[3] + s[5]) * RIDGE + FLOOR;
    s[0] += ridge;
    s[3] += ridge;
    s[5] += ridge;
    let slope = solve(&s, mean);
    for k in 0..count {
        let d = [offsets[k][0] - mean[0], offsets[k][1] - mean[1], offsets[k][2] - mean[2]];
        weights[k] = near[k] * (1.0 / sum - (d[0] * slope[0] + d[1] * slope[1] + d[2] * slope[2]));
    }
    weights
}

/// The solution of a symmetric system, whose matrix is given as xx xy xz yy yz zz, by L·D·Lᵀ.
fn solve(s: &[f64; 6], b: [f64; 3]) -> [f64; 3] {
    let [xx, xy, xz, yy, yz, zz] = *s;
    let (l10, l20) = (xy / xx, xz / xx);
    let d1 = yy - l10 * xy;
    let t = yz - l10 * xz;
    let l21 = t / d1;
    let d2 = zz - l20 * xz - l21 * t;
    let y1 = b[1] - l10 * b[0];
    let y2 = b[2] - l20 * b[0] - l21 * y1;
    let z = y2 / d2;
    let y = y1 / d1 - l21 * z;
    let x = b[0] / xx - l10 * y - l20 * z;
    [x, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// What the weights predict for a vertex whose neighbours moved by `motion`.
    fn predicted(weights: &Weights, v: usize, motion: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (k, weight) in weights.at(v).iter().enumerate().take(v) {
            let m = motion(v - 1 - k);
            (0..3).for_each(|axis| sum[axis] += weight * m[axis]);
        }
        sum
    }

    #[test]
    fn affine_motion_is_predicted() {
        let mut random = Random::new(7);
        let points: Vec<Point> = (0..200).map(|_| [(); 3].map(|()| random.unit() as f32)).collect();
        let weights = Weights::of(&points);
        let turned = |v: usize| {
            let [x, y, z] = points[v].map(f64::from);
            [0.3 * y - 0.1 * x + 2.0, 0.2 * z - 0.3 * x - 1.0, 0.5 * x + 0.05 * y]
        };
        for v in 8..200 {
            let (got, right) = (predicted(&weights, v, turned), turned(v));
            let off = (0..3).map(|axis| (got[axis] - right[axis]).abs()).fold(0.0, f64::max);
            assert!(off < 0.02, "{v}: {got:?} {right:?}");
            // What all do alike is exact but for rounding.
            let shift = predicted(&weights, v, |_| [4.0, -3.0, 0.5]);
            assert!((shift[0] - 4.0).abs() < 1e-9 && (shift[2] - 0.5).abs() < 1e-9, "{shift:?}");
        }
    }

    #[test]
    fn weights_stay_bounded_where_vertices_are_in_a_line_in_a_place_or_far_away() {
        let lines: Vec<Point> = (0..20).map(|i| [i as f32, 2.0 * i as f32, 0.0]).collect();
        let places = vec![[1.5; 3]; 20];
        let mixed: Vec<Point> = (0..20).map(|i| [(i / 4) as f32, 0.0, 1e-30 * i as f32]).collect();
        let far: Vec<Point> = (0..20).map(|i| [3e38 * (i % 2) as f32, -3e38, 1e-45 * i as f32]).collect();
        for points in [lines, places, mixed, far] {
            let weights = Weights::of(&points);
            for v in 1..20 {
                let at = weights.at(v);
                let sum: f64 = at.iter().sum();
                assert!(at.iter().all(|w| w.abs() < 100.0) && (sum - 1.0).abs() < 1e-6, "{v}: {at:?}");
            }
        }
        assert_eq!(Weights::of(&[[0.0; 3]]).at(0), &[0.0; NEIGHBOURS]);
        assert_eq!(Weights::of(&[]).at(3), &[0.0; NEIGHBOURS]);
    }
}
