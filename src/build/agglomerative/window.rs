//! Every cluster's best match among its neighbours in the order.
//!
//! The measure of a pair is the area of its common box, with a rank in the lowest bits: the distance in the order, and a bit
//! that tells the neighbour before from the one behind. So pairs that share a cluster are never equal, and the pair with the
//! smallest measure of all is always a mutual best match; and where all areas are equal, the first cluster matches the second, the
//! third the fourth, and half of them merge in every round.

use super::forest::Rules;
use crate::geom::Aabb;

/// Bits of a measure that hold the rank. The area keeps 17 bits of its fraction.
const RANK: u32 = 63;
/// Most clusters that are looked at together: all their planes stay in the first-level cache.
pub(super) const SIZE: usize = 1 << 10;

/// Clusters' boxes with each plane in a column of its own, so that plain loops over them become vector code.
pub(super) struct Window {
    /// Minima, then maxima.
    planes: [[f32; SIZE]; 6],
    /// The least measure of each cluster so far: as the first of a pair, and as the second.
    of_first: [f32; SIZE],
    of_second: [f32; SIZE],
}

impl Default for Window {
    fn default() -> Self {
        Window { planes: [[0.0; SIZE]; 6], of_first: [0.0; SIZE], of_second: [0.0; SIZE] }
    }
}

impl Window {
    #[inline(always)]
    pub fn put(&mut self, i: usize, bounds: &Aabb) {
        for axis in 0..3 {
            self.planes[axis][i % SIZE] = bounds.min[axis];
            self.planes[axis + 3][i % SIZE] = bounds.max[axis];
        }
    }

    #[inline(always)]
    pub fn bounds(&self, i: usize) -> Aabb {
        let planes = self.planes.each_ref().map(|column| column[i % SIZE]);
        Aabb { min: [planes[0], planes[1], planes[2]], max: [planes[3], planes[4], planes[5]] }
    }

    /// Move these clusters to the front. They are in ascending order.
    #[inline(always)]
    pub fn keep(&mut self, kept: &[u32]) {
        for column in &mut self.planes {
            keep(column, kept);
        }
    }

    /// The index of the best match of each of the first `count` clusters, and its own where none has an area that is a number.
    ///
    /// Edges are scaled first: no area over- or underflows.
    #[inline(always)]
    pub fn best_matches(&mut self, count: usize, rules: &Rules, partners: &mut [u32; SIZE]) {
        self.of_first[..count].fill(f32::INFINITY);
        self.of_second[..count].fill(f32::INFINITY);
        for distance in 1..=rules.radius.min(count.saturating_sub(1)) {
            self.measure(count - distance, distance, rules.scale);
        }
        for i in 0..count {
            let (first, second) = (self.of_first[i], self.of_second[i]);
            // Never equal but where both are infinite, and then the distance is 0.
            let distance = (smaller(first, second).to_bits() & RANK) >> 1;
            partners[i] = if first < second { i as u32 + distance } else { i as u32 - distance };
        }
    }

    /// Measure each of the first `pairs` clusters with the one at this distance behind it.
    #[inline(always)]
    fn measure(&mut self, pairs: usize, distance: usize, scale: f32) {
        let [x0, y0, z0, x1, y1, z1] = self.planes.each_ref().map(|c| &c[..pairs]);
        let [u0, v0, w0, u1, v1, w1] = self.planes.each_ref().map(|c| &c[distance..distance + pairs]);
        let of_first = &mut self.of_first[..pairs];
        let of_second = &mut self.of_second[distance..distance + pairs];
        let shift = distance.trailing_zeros();
        for i in 0..pairs {
            let x = (larger(x1[i], u1[i]) - smaller(x0[i], u0[i])) * scale;
            let y = (larger(y1[i], v1[i]) - smaller(y0[i], v0[i])) * scale;
            let z = (larger(z1[i], w1[i]) - smaller(z0[i], w0[i])) * scale;
            let area = x * y + y * z + z * x;
            // Of clusters `m` and `m + distance` exactly one has this bit.
            let rank = (2 * distance as u32) | (i as u32 >> shift & 1);
            let measure = f32::from_bits(area.to_bits() & !RANK | rank);
            of_first[i] = smaller(measure, of_first[i]);
            of_second[i] = smaller(measure, of_second[i]);
        }
    }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Move what is kept to the front. The places are in ascending order.
#[inline(always)]
pub(super) fn keep<T: Copy>(column: &mut [T; SIZE], kept: &[u32]) {
    for (to, from) in kept.iter().enumerate() {
        column[to % SIZE] = column[*from as usize % SIZE];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::cost::Sah;

    fn boxes(count: u32, at: impl Fn(u32) -> f32) -> Vec<Aabb> {
        let point = |i: u32| [at(i), 0.5 * at(i), 0.0];
        (0..count).map(|i| Aabb::from_points(&[point(i), [at(i) + 0.1, 0.0, 1.0]])).collect()
    }

    fn matches(boxes: &[Aabb], radius: usize) -> Vec<u32> {
        let sah = Sah { traversal: 1.2, intersection: 1.0 };
        let (mut window, mut partners) = (Window::default(), [0; SIZE]);
        boxes.iter().enumerate().for_each(|(i, b)| window.put(i, b));
        window.best_matches(boxes.len(), &Rules { sah, max_leaf: 8, radius, scale: 1.0 }, &mut partners);
        partners[..boxes.len()].to_vec()
    }

    #[test]
    fn equal_clusters_match_in_pairs() {
        for radius in [1, 2, 7, 31] {
            for count in [2, 3, 40, SIZE as u32] {
                let partners = matches(&boxes(count, |_| 1.0), radius);
                for (i, partner) in partners.iter().enumerate().take(count as usize / 2 * 2) {
                    assert_eq!(*partner, i as u32 ^ 1);
                }
            }
        }
        assert_eq!(matches(&boxes(1, |_| 0.0), 8), [0]);
    }

    #[test]
    fn matches_are_those_of_plain_search_and_some_are_mutual() {
        let scattered =
            boxes(SIZE as u32 - 3, |i| (i.wrapping_mul(2_654_435_761) >> 12) as f32 * 1e-5 + i as f32 * 0.01);
        for radius in [1, 5, 16, 31] {
            let partners = matches(&scattered, radius);
            let measure = |i: usize, j: usize| {
                let area = scattered[i].union(scattered[j]).half_area();
                let (i, j) = (i.min(j) as u32, i.max(j) as u32);
                let distance = j - i;
                area.to_bits() & !RANK | (2 * distance) | (i >> distance.trailing_zeros() & 1)
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
    fn boxes_of_no_area_that_is_a_number_match_themselves() {
        let huge = |i: u32| Aabb { min: [-3e38; 3], max: [3e38, 3e38, i as f32] };
        assert_eq!(matches(&(0..5).map(huge).collect::<Vec<_>>(), 3), [0, 1, 2, 3, 4]);
    }
}
