//! Sorting by integer keys, as fast on many threads as on one, with a result that no thread count can change: the order
//! is total, so every way of sorting gives the same sequence.
//!
//! A most significant digit first radix sort. A run of items is dealt into buckets by where their keys stand between the smallest and the
//! largest key of the run, large buckets are dealt again, and what is left in small ones is sorted by insertion. Counting from
//! the range rather than from fixed bits suits both Morton codes of a scene that fills a corner of its box and the bit
//! patterns of floats, most of which share an exponent.

use crate::exec::Executor;

/// What can be sorted: the whole item is ordered, and its prefix never contradicts that order.
pub(super) trait RadixKey: bytemuck::Zeroable + Copy + Ord + Send + Sync {
    /// `a < b` implies `a.prefix() <= b.prefix()`.
    fn prefix(&self) -> u64;
}

/// A key above an index, say.
impl RadixKey for u64 {
    #[inline(always)]
    fn prefix(&self) -> u64 {
        *self
    }
}

/// Most bits of the digit that a run is dealt by. So many cursors still fit the first-level cache.
const DIGIT: u32 = 10;
const BUCKETS: usize = 1 << DIGIT;
/// Runs of at most so many items are sorted by insertion.
const SMALL: usize = 24;
/// Runs of at most so many items are not divided any more: they fit the second-level cache, with their copy.
const ALONE: usize = 1 << 14;
/// Items that one task counts and deals.
const CHUNK: usize = 1 << 15;

/// Sort in O(n log n) at worst, with a copy of the items as scratch memory.
pub(super) fn sort<T: RadixKey>(items: &mut [T], exec: &Executor) {
    if items.len() <= SMALL {
        return insert_each(items);
    }
    let mut scratch = bytemuck::zeroed_vec(items.len());
    if items.len() <= ALONE || exec.is_sequential() {
        deal_alone(items, &mut scratch, Place::Items);
        return insert_each(items);
    }
    exec.run(|| deal(items, &mut scratch, Place::Items, exec));
}

/// Where the items of a run are when it is dealt.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    /// Where they must be in the end.
    Items,
    Scratch,
}

/// Sort the run that stands at `place` so that it ends in `items`. Recurses at most as often as a prefix has digits, since
/// every time the range of prefixes shrinks by a factor of [`BUCKETS`].
fn deal<T: RadixKey>(items: &mut [T], scratch: &mut [T], place: Place, exec: &Executor) {
    let source: &[T] = if place == Place::Items { items } else { scratch };
    let Some(digit) = Digit::of_all(source, exec) else {
        // One prefix for all.
        if place == Place::Scratch {
            items.copy_from_slice(scratch);
        }
        return items.sort_unstable();
    };
    let (from, to, next): (&[T], &mut [T], Place) = match place {
        Place::Items => (items, scratch, Place::Scratch),
        Place::Scratch => (scratch, items, Place::Items),
    };
    let sizes = scatter(from, to, digit, exec);

    // Finish the buckets, as many together as make a task and the largest each by itself.
    let (mut items, mut scratch, mut sizes) = (items, scratch, sizes.as_slice());
    let mut jobs = Vec::new();
    while !sizes.is_empty() {
        let (mut count, mut total) = (1, sizes[0]);
        while count < sizes.len() && total + sizes[count] <= ALONE {
            total += sizes[count];
            count += 1;
        }
        jobs.push((cut(&mut items, total), cut(&mut scratch, total), &sizes[..count]));
        sizes = &sizes[count..];
    }
    exec.map(jobs, |_, (items, scratch, sizes)| {
        if items.len() > ALONE {
            return deal(items, scratch, next, exec);
        }
        let mut end = 0;
        for size in sizes {
            let run = end..end + size;
            deal_alone(&mut items[run.clone()], &mut scratch[run], next);
            end += size;
        }
        insert_each(items);
    });
}

/// [`deal`] on one thread, but for runs of up to [`SMALL`] items, which stand in their place as a whole only.
fn deal_alone<T: RadixKey>(items: &mut [T], scratch: &mut [T], place: Place) {
    let source: &[T] = if place == Place::Items { items } else { scratch };
    let digit = if items.len() > SMALL { Digit::of(Digit::range(source), items.len()) } else { None };
    let Some(digit) = digit else {
        if place == Place::Scratch {
            items.copy_from_slice(scratch);
        }
        if items.len() > SMALL {
            items.sort_unstable();
        }
        return;
    };
    let (from, to): (&[T], &mut [T]) = match place {
        Place::Items => (items, scratch),
        Place::Scratch => (scratch, items),
    };
    let mut ends = [0u32; BUCKETS];
    let ends = &mut ends[..digit.buckets];
    for item in from {
        ends[digit.bucket(item)] += 1;
    }
    let mut start = 0;
    for end in &mut *ends {
        start += std::mem::replace(end, start);
    }
    for item in from {
        let end = &mut ends[digit.bucket(item)];
        to[*end as usize] = *item;
        *end += 1;
    }
    if place == Place::Items {
        items.copy_from_slice(scratch);
    }
    let mut start = 0;
    for end in ends {
        let run = start..*end as usize;
        start = run.end;
        if run.len() > SMALL {
            deal_alone(&mut items[run.clone()], &mut scratch[run], Place::Items);
        }
    }
}

/// Sort items of which none is far from its place.
fn insert_each<T: RadixKey>(items: &mut [T]) {
    for i in 1..items.len() {
        let item = items[i];
        let mut to = i;
        while to > 0 && item < items[to - 1] {
            items[to] = items[to - 1];
            to -= 1;
        }
        items[to] = item;
    }
}

/// Which bucket a prefix belongs to.
#[derive(Clone, Copy)]
struct Digit {
    low: u64,
    shift: u32,
    /// A power of two.
    buckets: usize,
}

impl Digit {
    /// For a run of so many items between these prefixes, about four buckets for eight items; `None` where all are equal.
    fn of((low, high): (u64, u64), count: usize) -> Option<Digit> {
        let bits = (count.max(2).ilog2() - 1).min(DIGIT);
        let shift = (64 - (high.wrapping_sub(low)).leading_zeros()).saturating_sub(bits);
        (low < high).then_some(Digit { low, shift, buckets: 1 << bits })
    }

    fn of_all<T: RadixKey>(items: &[T], exec: &Executor) -> Option<Digit> {
        let ranges = exec.map_chunks(items, CHUNK, |_, chunk| Digit::range(chunk));
        let range = ranges.into_iter().fold((u64::MAX, 0), |a: (u64, u64), b| (a.0.min(b.0), a.1.max(b.1)));
        Digit::of(range, items.len())
    }

    /// The smallest and the largest prefix.
    fn range<T: RadixKey>(items: &[T]) -> (u64, u64) {
        items.iter().fold((u64::MAX, 0), |(low, high), item| (low.min(item.prefix()), high.max(item.prefix())))
    }

    #[inline(always)]
    fn bucket<T: RadixKey>(self, item: &T) -> usize {
        ((item.prefix() - self.low) >> self.shift) as usize & (self.buckets - 1)
    }
}

/// Copy every item into its bucket, keeping the order inside buckets; returns the buckets' sizes.
fn scatter<T: RadixKey>(from: &[T], to: &mut [T], digit: Digit, exec: &Executor) -> Vec<usize> {
    let counts = exec.map_chunks(from, CHUNK, |_, chunk| {
        let mut counts = vec![0u32; digit.buckets];
        for item in chunk {
            counts[digit.bucket(item)] += 1;
        }
        counts
    });

    // Give every chunk its own run of every bucket.
    let mut rest = to;
    let mut slots: Vec<Vec<&mut [T]>> = counts.iter().map(|_| Vec::with_capacity(digit.buckets)).collect();
    let mut sizes = Vec::with_capacity(digit.buckets);
    for bucket in 0..digit.buckets {
        for (slots, counts) in slots.iter_mut().zip(&counts) {
            slots.push(cut(&mut rest, counts[bucket] as usize));
        }
        sizes.push(counts.iter().map(|counts| counts[bucket] as usize).sum());
    }
    let jobs: Vec<(&[T], Vec<&mut [T]>)> = from.chunks(CHUNK).zip(slots).collect();
    exec.map(jobs, |_, (chunk, mut slots)| {
        for item in chunk {
            let slot = &mut slots[digit.bucket(item)];
            // As long as counted: never empty here.
            if let Some((first, others)) = std::mem::take(slot).split_first_mut() {
                *first = *item;
                *slot = others;
            }
        }
    });
    sizes
}

fn cut<'a, T>(slice: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (head, tail) = std::mem::take(slice).split_at_mut(count);
    *slice = tail;
    head
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A key and what it belongs to. Equal keys are in the order of their indices.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, bytemuck::Zeroable)]
    struct Keyed {
        key: u64,
        index: u32,
    }

    impl RadixKey for Keyed {
        fn prefix(&self) -> u64 {
            self.key
        }
    }

    /// A linear congruential generator: the same numbers everywhere.
    fn numbers(count: usize, seed: u64) -> Vec<u64> {
        let mut state = seed;
        let step = |_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state ^ state >> 29
        };
        (0..count).map(step).collect()
    }

    fn assert_sorts(name: &str, keys: impl Iterator<Item = u64>) {
        let items: Vec<Keyed> = keys.enumerate().map(|(i, key)| Keyed { key, index: i as u32 }).collect();
        let mut expected = items.clone();
        expected.sort();
        for jobs in [1, 2, 3] {
            let mut sorted = items.clone();
            sort(&mut sorted, &Executor::new(jobs).unwrap());
            assert!(sorted == expected, "{name} with {jobs} threads");
        }
    }

    #[test]
    fn keys_of_every_shape_are_sorted() {
        let count = 3 * CHUNK + 17;
        assert_sorts("63 random bits", numbers(count, 1).into_iter().map(|k| k >> 1));
        assert_sorts("all 64 bits", numbers(count, 2).into_iter());
        assert_sorts("few keys", numbers(count, 3).into_iter().map(|k| k % 3));
        assert_sorts("one key", std::iter::repeat_n(u64::MAX, count));
        assert_sorts("descending", (0..count as u64).rev());
        assert_sorts("far apart", (0..count as u64).map(|i| if i % 7 == 0 { u64::MAX - i % 5 } else { i % 5000 }));
        assert_sorts("a geometric series", (0..count as u64).map(|i| u64::MAX >> (i % 64)));
        assert_sorts("floats", numbers(count, 4).into_iter().map(|k| u64::from((k as f32 * 1e-19).to_bits())));
        for few in [0, 1, 2, 3, SMALL, SMALL + 1] {
            assert_sorts("a few", numbers(few, 5).into_iter());
        }
    }

    #[test]
    fn packed_keys_are_sorted() {
        let mut packed = numbers(CHUNK + 5, 6);
        let mut expected = packed.clone();
        expected.sort_unstable();
        sort(&mut packed, &Executor::sequential());
        assert!(packed == expected);
    }
}
