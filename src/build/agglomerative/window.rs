//! Every cluster's best match among its neighbours in the order.
//!
//! The measure of a pair is the area of its common box, with a rank in the lowest bits: the distance in the order, and a bit
//! that tells the neighbour before from the one behind. So pairs that share a cluster are never equal, and the pair with the
//! smallest measure of all is always a mutual best match; and where all areas are equal, the first cluster matches the second, the
//! third the fourth, and half of them merge in every round.

use crate::build::prim_ref::PrimRef;

/// Widest window to either side.
pub(super) const MAX_RADIUS: usize = 31;
/// Bits of a measure that hold the rank. The area keeps 17 bits of its fraction.
const RANK: u32 = 63;
/// Pairs that are measured together for one distance: all their planes stay in the first-level cache.
const BLOCK: usize = 512;

/// No neighbour: the only cluster.
pub(super) const NONE: u32 = u32::MAX;

/// The index of the best match of each cluster from `start` on, as many as `partners` has places.
///
/// Edges are multiplied by `scale` first: no area over- or underflows.
pub(super) fn best_matches(clusters: &[PrimRef], start: usize, radius: usize, scale: f32, partners: &mut [u32]) {
    // Pairs are found at their first cluster, which may lie before `start`.
    let first = start.saturating_sub(radius);
    let end = start + partners.len();
    let mut best =
        Best { of_first: vec![f32::INFINITY; end - first], of_second: vec![f32::INFINITY; end - first + radius] };
    let mut planes = Planes::default();
    for block in (first..end).step_by(BLOCK) {
        let last = (block + BLOCK).min(end);
        planes.load(&clusters[block..(last + radius).min(clusters.len())], scale);
        for distance in 1..=radius {
            let pairs = last.min(clusters.len().saturating_sub(distance)).saturating_sub(block);
            let at = block - first;
            let of_first = &mut best.of_first[at..at + pairs];
            let of_second = &mut best.of_second[at + distance..at + distance + pairs];
            planes.measure(block as u32, distance, of_first, of_second);
        }
    }
    for (i, partner) in partners.iter_mut().enumerate() {
        let at = start + i - first;
        *partner = partner_of((start + i) as u32, smaller(best.of_first[at], best.of_second[at]));
    }
}

/// The least measure of each cluster so far: as the first of a pair, and as the second.
struct Best {
    of_first: Vec<f32>,
    of_second: Vec<f32>,
}

fn rank(first: u32, distance: u32) -> u32 {
    // Of `m` and `m + distance` exactly one has this bit.
    (2 * distance) | (first >> distance.trailing_zeros() & 1)
}

fn partner_of(cluster: u32, measure: f32) -> u32 {
    if measure == f32::INFINITY {
        return NONE;
    }
    let distance = (measure.to_bits() & RANK) >> 1;
    if rank(cluster, distance) == measure.to_bits() & RANK { cluster + distance } else { cluster - distance }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The planes of some clusters' boxes in columns, so that plain loops over them become vector code: minima, then maxima.
struct Planes {
    columns: [[f32; BLOCK + MAX_RADIUS]; 6],
}

impl Default for Planes {
    fn default() -> Self {
        Planes { columns: [[0.0; BLOCK + MAX_RADIUS]; 6] }
    }
}

impl Planes {
    fn load(&mut self, clusters: &[PrimRef], scale: f32) {
        for (i, c) in clusters.iter().enumerate() {
            for axis in 0..3 {
                self.columns[axis][i] = c.min[axis] * scale;
                self.columns[axis + 3][i] = c.max[axis] * scale;
            }
        }
    }

    /// Measure each pair of clusters at this distance; `base` is the index of the first column.
    #[inline(never)]
    fn measure(&self, base: u32, distance: usize, of_first: &mut [f32], of_second: &mut [f32]) {
        let pairs = of_first.len();
        let [x0, y0, z0, x1, y1, z1] = self.columns.each_ref().map(|c| &c[..pairs]);
        let [u0, v0, w0, u1, v1, w1] = self.columns.each_ref().map(|c| &c[distance..distance + pairs]);
        let of_second = &mut of_second[..pairs];
        let (shift, rank) = (distance.trailing_zeros(), 2 * distance as u32);
        for i in 0..pairs {
            let x = larger(x1[i], u1[i]) - smaller(x0[i], u0[i]);
            let y = larger(y1[i], v1[i]) - smaller(y0[i], v0[i]);
            let z = larger(z1[i], w1[i]) - smaller(z0[i], w0[i]);
            let area = x * y + y * z + z * x;
            let side = (base + i as u32) >> shift & 1;
            let measure = f32::from_bits(area.to_bits() & !RANK | rank | side);
            of_first[i] = smaller(measure, of_first[i]);
            of_second[i] = smaller(measure, of_second[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;

    fn clusters(count: u32, at: impl Fn(u32) -> f32) -> Vec<PrimRef> {
        let point = |i: u32| [at(i), 0.5 * at(i), 0.0];
        (0..count).map(|i| PrimRef::new(&Aabb::from_points(&[point(i), [at(i) + 0.1, 0.0, 1.0]]), i)).collect()
    }

    fn matches(clusters: &[PrimRef], radius: usize) -> Vec<u32> {
        let mut partners = vec![0; clusters.len()];
        best_matches(clusters, 0, radius, 1.0, &mut partners);
        partners
    }

    #[test]
    fn equal_clusters_match_in_pairs() {
        for radius in [1, 2, 7, 31] {
            for count in [2, 3, 40, 2000] {
                let partners = matches(&clusters(count, |_| 1.0), radius);
                for (i, partner) in partners.iter().enumerate().take(count as usize / 2 * 2) {
                    assert_eq!(*partner, i as u32 ^ 1);
                }
            }
        }
        assert_eq!(matches(&clusters(1, |_| 0.0), 8), [NONE]);
    }

    #[test]
    fn matches_are_those_of_plain_search_and_some_are_mutual() {
        let scattered = clusters(3000, |i| (i.wrapping_mul(2_654_435_761) >> 12) as f32 * 1e-5 + i as f32 * 0.01);
        for radius in [1, 5, 16, 31] {
            let partners = matches(&scattered, radius);
            let measure = |i: usize, j: usize| {
                let area = scattered[i].bounds().union(scattered[j].bounds()).half_area();
                let (i, j) = (i.min(j) as u32, i.max(j) as u32);
                area.to_bits() & !RANK | rank(i, j - i)
            };
            for i in 0..scattered.len() {
                let window = i.saturating_sub(radius)..(i + radius + 1).min(scattered.len());
                let best = window.filter(|j| *j != i).min_by_key(|j| measure(i, *j)).unwrap();
                assert_eq!(partners[i] as usize, best, "cluster {i}, radius {radius}");
            }
            assert!((0..partners.len()).any(|i| partners[partners[i] as usize] as usize == i));
        }
    }

    #[test]
    fn a_part_of_the_clusters_has_the_matches_of_the_whole() {
        let scattered = clusters(2000, |i| (i.wrapping_mul(2_654_435_761) >> 12) as f32 * 1e-5);
        let whole = matches(&scattered, 9);
        for (start, len) in [(0, 5), (3, 700), (511, 2), (1500, 500)] {
            let mut part = vec![0; len];
            best_matches(&scattered, start, 9, 1.0, &mut part);
            assert_eq!(part, whole[start..start + len]);
        }
    }
}
