//! The order in which clusters look for their neighbours: along a Morton curve through the references' centres.

use crate::build::exec::Executor;
use crate::build::prim_ref::PrimRef;
use crate::build::radix::{self, Keyed};

/// Bits of a code per axis.
const BITS: u32 = 21;
/// References that one task codes or moves.
const CHUNK: usize = 1 << 14;
/// Runs of equal codes up to this length stay in the order of the references: any window holds them whole.
const MAX_TIES: usize = 4;

/// The references in the order of their centres' Morton codes, equal centres in the order that they come in.
///
/// Where many references share a cell of the finest grid, as a small model does in a large scene, the cell gets a grid of its
/// own, and so on until centres are told apart or equal.
pub(super) fn sort(refs: Vec<PrimRef>, exec: &Executor) -> Vec<PrimRef> {
    let mut keys = vec![Keyed::default(); refs.len()];
    exec.map_chunks_mut(&mut keys, CHUNK, |chunk_index, chunk| {
        for (i, key) in chunk.iter_mut().enumerate() {
            key.index = (chunk_index * CHUNK + i) as u32;
        }
    });
    code_and_sort(&mut keys, &refs, exec);

    // Give every run of equal codes a grid of its own. A run lies within one cell, so its box shrinks 2²¹ times at least with every
    // grid, and all of the range of `f32` needs no more than a dozen.
    let mut open = Vec::new();
    push_ties(&keys, 0, &mut open);
    while let Some((start, end)) = open.pop() {
        if code_and_sort(&mut keys[start..end], &refs, exec) {
            push_ties(&keys[start..end], start, &mut open);
        }
    }

    let mut sorted = vec![bytemuck::Zeroable::zeroed(); refs.len()];
    exec.map_chunks_mut(&mut sorted, CHUNK, |chunk_index, chunk| {
        for (slot, key) in chunk.iter_mut().zip(&keys[chunk_index * CHUNK..]) {
            *slot = refs[key.index as usize];
        }
    });
    sorted
}

/// Code the keys by a grid over the box of their centres, and sort them; `false` where all centres are equal.
fn code_and_sort(keys: &mut [Keyed], refs: &[PrimRef], exec: &Executor) -> bool {
    let Some(grid) = Grid::over(keys, refs, exec) else { return false };
    exec.map_chunks_mut(keys, CHUNK, |_, chunk| {
        for key in chunk {
            key.key = grid.code(center2(&refs[key.index as usize]));
        }
    });
    radix::sort(keys, exec);
    true
}

/// The runs of more than [`MAX_TIES`] equal codes, as ranges that count from `base`.
fn push_ties(keys: &[Keyed], base: usize, open: &mut Vec<(usize, usize)>) {
    let mut start = 0;
    while start < keys.len() {
        let mut end = start + 1;
        while end < keys.len() && keys[end].key == keys[start].key {
            end += 1;
        }
        if end - start > MAX_TIES {
            open.push((base + start, base + end));
        }
        start = end;
    }
}

/// Twice the centre, exact but for the last bit of a double.
fn center2(r: &PrimRef) -> [f64; 3] {
    [0, 1, 2].map(|a| f64::from(r.min[a]) + f64::from(r.max[a]))
}

/// Cubic cells: 2²¹ along the longest side.
struct Grid {
    low: [f64; 3],
    per_unit: f64,
}

impl Grid {
    fn over(keys: &[Keyed], refs: &[PrimRef], exec: &Executor) -> Option<Grid> {
        let boxes = exec.map_chunks(keys, CHUNK, |_, chunk| {
            chunk.iter().fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), key| {
                let c = center2(&refs[key.index as usize]);
                ([0, 1, 2].map(|a| low[a].min(c[a])), [0, 1, 2].map(|a| high[a].max(c[a])))
            })
        });
        let (low, high) = boxes.into_iter().fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |x, y| {
            ([0, 1, 2].map(|a| x.0[a].min(y.0[a])), [0, 1, 2].map(|a| x.1[a].max(y.1[a])))
        });
        let extent = (0..3).map(|a| high[a] - low[a]).fold(0.0, f64::max);
        (extent > 0.0).then(|| Grid { low, per_unit: f64::from(1u32 << BITS) / extent })
    }

    fn code(&self, center2: [f64; 3]) -> u64 {
        let cell = |a: usize| (((center2[a] - self.low[a]) * self.per_unit) as u64).min((1 << BITS) - 1);
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
    use crate::geom::Aabb;

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
            let sorted = sort(refs.clone(), &Executor::new(jobs).unwrap());
            assert!(sorted.is_sorted_by(|a, b| a.min[0] <= b.min[0]));
        }
    }

    #[test]
    fn a_geometric_series_is_in_order() {
        let refs: Vec<PrimRef> = (0..149u32).map(|i| point([0.5f32.powi(i as i32), 0.0, 0.0], i)).collect();
        let sorted = sort(refs, &Executor::sequential());
        // But for a run too short to matter.
        assert!(sorted.windows(MAX_TIES + 1).all(|w| w[0].min[0] < w[MAX_TIES].min[0]));
    }

    #[test]
    fn equal_centres_keep_their_order_and_huge_ones_do_not_overflow() {
        let same = sort((0..5000).map(|i| point([1.0, 2.0, 3.0], i)).collect(), &Executor::sequential());
        assert!(same.iter().enumerate().all(|(i, r)| r.prim == i as u32));
        let huge = sort(
            vec![point([3e38; 3], 0), point([-3e38; 3], 1), point([0.0; 3], 2), point([1e38, 3e38, 0.0], 3)],
            &Executor::sequential(),
        );
        assert_eq!(huge[0].prim, 1);
    }
}
