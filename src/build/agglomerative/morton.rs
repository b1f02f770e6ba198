//! The order in which clusters look for their neighbours: along a Morton curve through the references' centres.

use crate::build::prim_ref::PrimRef;
use crate::build::radix;
use crate::exec::Executor;
use crate::geom::Aabb;
use std::ops::Range;

/// Most bits of a code per axis.
const BITS: u32 = 21;
/// References that one task codes or moves.
const CHUNK: usize = 1 << 14;
/// Runs of equal codes up to this length stay in the order of the references: any window holds them whole.
const MAX_TIES: usize = 4;

/// For runs that are too short to divide.
static ALONE: Executor = Executor::sequential();

/// How a code and, in the low bits, the number of its reference share 64 bits: half the memory of a pair, and quicker to compare.
#[derive(Clone, Copy)]
struct Packing {
    index_bits: u32,
    bits_per_axis: u32,
}

impl Packing {
    fn of(count: usize) -> Packing {
        let index_bits = usize::BITS - count.leading_zeros();
        Packing { index_bits, bits_per_axis: ((u64::BITS - index_bits) / 3).min(BITS) }
    }

    fn code(self, key: u64) -> u64 {
        key >> self.index_bits
    }

    fn index(self, key: u64) -> usize {
        (key & ((1 << self.index_bits) - 1)) as usize
    }
}

/// The references in the order of their centres' Morton codes, equal centres in the order that they come in.
///
/// Where many references share a cell of the finest grid, as a small model does in a large scene, the cell gets a grid of its
/// own, and so on until centres are told apart or equal.
/// `centroids` is the box of the doubled centres as far as floats tell.
pub(in crate::build) fn sort(refs: Vec<PrimRef>, centroids: &Aabb, exec: &Executor) -> Vec<PrimRef> {
    let packing = Packing::of(refs.len());
    let grid = Grid::over_box(centroids.min.map(f64::from), centroids.max.map(f64::from), packing);
    let mut keys = exec.generate(refs.len(), |i| {
        let code = grid.as_ref().map_or(0, |grid| grid.code(center2(&refs[i])));
        code << packing.index_bits | i as u64
    });
    match grid {
        Some(_) => radix::sort(&mut keys, exec),
        None => _ = code_and_sort(&mut keys, &refs, packing, exec),
    }

    // Give every run of equal codes a grid of its own. A run lies within one cell, so its box shrinks many times with every grid.
    let mut open = ties(&keys, 0, packing, exec);
    while !open.is_empty() {
        let (mut rest, mut at) = (keys.as_mut_slice(), 0);
        let mut runs = Vec::with_capacity(open.len());
        for range in open {
            let (run, behind) = std::mem::take(&mut rest)[range.start - at..].split_at_mut(range.len());
            runs.push((range.start, run));
            (rest, at) = (behind, range.end);
        }
        let found = exec.map(runs, |_, (start, run)| {
            let exec = if run.len() > CHUNK { exec } else { &ALONE };
            if code_and_sort(run, &refs, packing, exec) { ties(run, start, packing, exec) } else { Vec::new() }
        });
        open = found.concat();
    }
    exec.generate(refs.len(), |i| refs[packing.index(keys[i])])
}

/// Code the keys by a grid over the box of their centres, and sort them; `false` where all centres are equal.
fn code_and_sort(keys: &mut [u64], refs: &[PrimRef], packing: Packing, exec: &Executor) -> bool {
    let Some(grid) = Grid::over(keys, refs, packing, exec) else { return false };
    exec.map_chunks_mut(keys, CHUNK, |_, chunk| {
        for key in chunk {
            let index = packing.index(*key);
            *key = grid.code(center2(&refs[index])) << packing.index_bits | index as u64;
        }
    });
    radix::sort(keys, exec);
    true
}

/// The runs of more than [`MAX_TIES`] equal codes in order, as ranges that count from `base`.
fn ties(keys: &[u64], base: usize, packing: Packing, exec: &Executor) -> Vec<Range<usize>> {
    let code = |i: usize| packing.code(keys[i]);
    let found = exec.map_chunks(keys, CHUNK, |chunk_index, chunk| {
        let mut runs = Vec::new();
        let mut start = chunk_index * CHUNK;
        let chunk_end = start + chunk.len();
        // A run that comes in from the chunk before is that one's.
        while start > 0 && start < chunk_end && code(start) == code(start - 1) {
            start += 1;
        }
        while start < chunk_end {
            // Sorted: one look tells whether enough are equal.
            if start + MAX_TIES >= keys.len() || code(start + MAX_TIES) != code(start) {
                start += 1;
                continue;
            }
            let mut end = start + MAX_TIES + 1;
            while end < keys.len() && code(end) == code(start) {
                end += 1;
            }
            runs.push(base + start..base + end);
            start = end;
        }
        runs
    });
    found.concat()
}

/// Twice the centre, exact but for the last bit of a double.
fn center2(r: &PrimRef) -> [f64; 3] {
    [0, 1, 2].map(|a| f64::from(r.min[a]) + f64::from(r.max[a]))
}

/// Cubic cells, a power of two along the longest side.
struct Grid {
    low: [f64; 3],
    per_unit: f64,
    last: u64,
}

impl Grid {
    fn over(keys: &[u64], refs: &[PrimRef], packing: Packing, exec: &Executor) -> Option<Grid> {
        let boxes = exec.map_chunks(keys, CHUNK, |_, chunk| {
            chunk.iter().fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), key| {
                let c = center2(&refs[packing.index(*key)]);
                ([0, 1, 2].map(|a| low[a].min(c[a])), [0, 1, 2].map(|a| high[a].max(c[a])))
            })
        });
        let (low, high) = boxes.into_iter().fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |x, y| {
            ([0, 1, 2].map(|a| x.0[a].min(y.0[a])), [0, 1, 2].map(|a| x.1[a].max(y.1[a])))
        });
        Grid::over_box(low, high, packing)
    }

    /// `None` over a box of no extent, or of none that a number tells.
    fn over_box(low: [f64; 3], high: [f64; 3], packing: Packing) -> Option<Grid> {
        let extent = (0..3).map(|a| high[a] - low[a]).fold(0.0, f64::max);
        let cells = 1u32 << packing.bits_per_axis;
        let usable = low.iter().chain(&high).all(|v| v.is_finite()) && extent > 0.0;
        usable.then(|| Grid { low, per_unit: f64::from(cells) / extent, last: u64::from(cells - 1) })
    }

    fn code(&self, center2: [f64; 3]) -> u64 {
        let cell = |a: usize| (((center2[a] - self.low[a]) * self.per_unit) as u64).min(self.last);
        spread(cell(0)) << 2 | spread(cell(1)) << 1 | spread(cell(2))
    }
}

/// Put two zeros before each of 21 bits.
fn spread(v: u64) -> u64 {
    let v = (v | v << 32) & 0x001f_0000_0000_ffff;
    let v = (v | v << 16) & 0x001f_0000_ff00_00ff;
    let v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
    let v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
    (v | v << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::prim_ref::bounds_of;

    fn sorted(refs: Vec<PrimRef>, exec: &Executor) -> Vec<PrimRef> {
        let (_, centroids) = bounds_of(&refs);
        sort(refs, &centroids, exec)
    }

    fn point(at: [f32; 3], prim: u32) -> PrimRef {
        PrimRef::new(&Aabb { min: at, max: at }, prim)
    }

    #[test]
    fn bits_are_spread() {
        for bit in 0..BITS {
            assert_eq!(spread(1 << bit), 1 << (3 * bit));
        }
        assert_eq!(spread((1 << BITS) - 1).count_ones(), BITS);
    }

    #[test]
    fn a_cluster_smaller_than_a_cell_is_in_order_too() {
        // 1000 points within 1e-9 of a scene of 1e6, and two far corners.
        let mut refs: Vec<PrimRef> = (0..1000u32).map(|i| point([(i * 7919 % 1000) as f32 * 1e-12; 3], i)).collect();
        refs.push(point([-5e5; 3], 1000));
        refs.push(point([5e5; 3], 1001));
        for jobs in [1, 3] {
            let sorted = sorted(refs.clone(), &Executor::new(jobs).unwrap());
            assert!(sorted.is_sorted_by(|a, b| a.min[0] <= b.min[0]));
        }
    }

    #[test]
    fn a_geometric_series_is_in_order() {
        let refs: Vec<PrimRef> = (0..149u32).map(|i| point([0.5f32.powi(i as i32), 0.0, 0.0], i)).collect();
        let sorted = sorted(refs, &Executor::sequential());
        // But for a run too short to matter.
        assert!(sorted.windows(MAX_TIES + 1).all(|w| w[0].min[0] < w[MAX_TIES].min[0]));
    }

    #[test]
    fn equal_centres_keep_their_order_and_huge_ones_do_not_overflow() {
        let same = sorted((0..5000).map(|i| point([1.0, 2.0, 3.0], i)).collect(), &Executor::sequential());
        assert!(same.iter().enumerate().all(|(i, r)| r.prim == i as u32));
        let huge = sorted(
            vec![point([3e38; 3], 0), point([-3e38; 3], 1), point([0.0; 3], 2), point([1e38, 3e38, 0.0], 3)],
            &Executor::sequential(),
        );
        assert_eq!(huge[0].prim, 1);
    }
}
