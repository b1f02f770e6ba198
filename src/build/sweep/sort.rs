//! Sorting once: the order of the references' centres on an axis.

use crate::build::radix;
use crate::exec::Executor;

/// Items that a task makes or takes apart.
const CHUNK: usize = 1 << 15;

/// A number that orders as the float does; NaN has a place as well, whichever.
#[inline(always)]
pub(super) fn key_of(v: f32) -> u32 {
    let bits = v.to_bits();
    bits ^ (((bits as i32 >> 31) as u32) | 0x8000_0000)
}

/// Writes `0..order.len()` in ascending order of `key`, equal keys in ascending order of the index. `scratch` is for reuse.
pub(super) fn sort_by_key(
    order: &mut [u32],
    scratch: &mut Vec<u64>,
    exec: &Executor,
    key: impl Fn(usize) -> u32 + Sync,
) {
    scratch.clear();
    scratch.resize(order.len(), 0);
    exec.map_chunks_mut(scratch, CHUNK, |chunk_index, chunk| {
        let first = chunk_index * CHUNK;
        chunk.iter_mut().enumerate().for_each(|(i, p)| *p = u64::from(key(first + i)) << 32 | (first + i) as u64);
    });
    radix::sort(scratch, exec);
    exec.map_chunks_mut(order, CHUNK, |chunk_index, chunk| {
        chunk.iter_mut().zip(&scratch[chunk_index * CHUNK..]).for_each(|(to, from)| *to = *from as u32);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_order_as_floats_do() {
        let ascending = [f32::NEG_INFINITY, -1e38, -1.0, -1e-45, 0.0, 1e-45, 0.5, 1.0, f32::MAX, f32::INFINITY];
        assert!(ascending.map(key_of).is_sorted_by(|a, b| a < b));
    }

    #[test]
    fn equal_keys_stay_in_the_order_of_their_indices() {
        for count in [0, 1, 2, 1000, CHUNK, 2 * CHUNK + 77] {
            let key = |i: usize| (i as u32).wrapping_mul(2_654_435_761).rotate_left(13) % 7;
            let mut expected: Vec<u32> = (0..count as u32).collect();
            expected.sort_by_key(|&i| key(i as usize));
            for jobs in [1, 2] {
                let mut order = vec![0; count];
                sort_by_key(&mut order, &mut Vec::new(), &Executor::new(jobs).unwrap(), key);
                assert!(order == expected, "{count} items, {jobs} threads");
            }
        }
    }
}
