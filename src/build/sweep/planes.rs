//! The cheapest plane between two neighbouring centres, over all three axes.
//!
//! Left of a plane that moves rightward the box only grows, right of it it only shrinks, and so do both sides' weights, rounding
//! included. A stretch of planes can therefore weigh no less than the left side at its start and the right side at its end, and is
//! passed over where that is already more than a plane known elsewhere. (An early exit once the partial cost has lost is in
//! madmann91/bvh's sweep builder; here it works from both sides and for any stretch.) Large nodes first take the unions of some 64
//! blocks an axis and look closer only at those blocks that can hold the best plane. The result is that of the plain sweep, to the bit.

use super::orders::{Orders, Plane, Table};
use crate::build::cost::Sah;
use crate::exec::Executor;
use crate::simd::{LaneBox, Lanes};

/// Blocks that a stretch is divided into.
const BLOCKS: usize = 64;
/// References of a block at least.
const BLOCK: usize = 8;
/// Stretches of at most so many planes are swept one by one.
const PLAIN: usize = 64;
const ROOM: usize = PLAIN + 4;
/// From so many references on, blocks are tasks.
const CHUNKED: usize = 1 << 15;

/// The plane of least weight; of equal ones the first on the first axis. `None` where no weight is a finite number.
pub(super) fn best(orders: &Orders<'_>, scale: f32, exec: &Executor) -> Option<Plane> {
    let order = |axis: usize| -> &[u32] { &*orders.by_axis[axis] };
    let count = order(0).len();
    let scale = Lanes::splat(scale);
    let sweep = |axis| Sweep { order: order(axis), table: orders.table, axis, scale };
    let sweeps = [sweep(0), sweep(1), sweep(2)];
    let all = Stretch { start: 0, end: count, before: LaneBox::EMPTY, behind: LaneBox::EMPTY };
    match count {
        0..=8 => return plain::<12>(&sweeps, &all),
        9..=16 => return plain::<20>(&sweeps, &all),
        17..=32 => return plain::<36>(&sweeps, &all),
        33..=PLAIN => return plain::<ROOM>(&sweeps, &all),
        _ => {}
    }

    let mut best = Best::default();
    let mut sides = Sides::EMPTY;
    let cuts = if count < CHUNKED {
        sweeps.each_ref().map(|sweep| Cut::new(sweep, &all))
    } else {
        let jobs: Vec<_> = sweeps.iter().flat_map(|sweep| all.blocks().map(move |block| (sweep, block))).collect();
        let unions = exec.map(jobs, |_, (sweep, block)| sweep.union(block));
        let mut parts = unions.chunks(unions.len() / 3);
        sweeps.each_ref().map(|sweep| Cut::of_unions(sweep, &all, parts.next().unwrap_or_default()))
    };
    for cut in &cuts {
        best.bound = cut.least.min(best.bound);
    }
    for (sweep, cut) in sweeps.iter().zip(&cuts) {
        sweep.look_closer(&all, cut, &mut sides, &mut best);
    }
    best.plane
}

/// The best plane so far, and a weight that some plane is known to have.
struct Best {
    plane: Option<Plane>,
    bound: f32,
}

impl Default for Best {
    fn default() -> Best {
        Best { plane: None, bound: f32::INFINITY }
    }
}

impl Best {
    fn weight(&self) -> f32 {
        self.plane.map_or(f32::INFINITY, |p| p.weight)
    }
}

/// Planes `start..end` of an order, plane `i` standing before reference `i`.
struct Stretch {
    start: usize,
    end: usize,
    /// Box of the references before `start`, and of those from `end` on.
    before: LaneBox,
    behind: LaneBox,
}

impl Stretch {
    fn step(&self) -> usize {
        (self.end - self.start).div_ceil(BLOCKS).max(BLOCK)
    }

    fn blocks(&self) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
        let (step, end) = (self.step(), self.end);
        (self.start..end).step_by(step).map(move |at| at..end.min(at + step))
    }
}

/// A stretch divided into blocks.
struct Cut {
    /// Boxes of all references before each block, and from its start on.
    before: [LaneBox; BLOCKS + 4],
    from: [LaneBox; BLOCKS + 4],
    /// Both sides' weights at each block's first plane; with one more entry, the end.
    left: [f32; BLOCKS + 4],
    right: [f32; BLOCKS + 4],
    /// Least weight of a block's first plane.
    least: f32,
    blocks: usize,
}

impl Cut {
    fn new(sweep: &Sweep, stretch: &Stretch) -> Cut {
        let mut unions = [LaneBox::EMPTY; BLOCKS];
        let mut blocks = 0;
        for block in stretch.blocks() {
            unions[blocks % BLOCKS] = sweep.union(block);
            blocks += 1;
        }
        Cut::of_unions(sweep, stretch, &unions[..blocks])
    }

    fn of_unions(sweep: &Sweep, stretch: &Stretch, unions: &[LaneBox]) -> Cut {
        let blocks = unions.len().min(BLOCKS);
        let mut cut = Cut {
            before: [LaneBox::EMPTY; BLOCKS + 4],
            from: [LaneBox::EMPTY; BLOCKS + 4],
            left: [0.0; BLOCKS + 4],
            right: [0.0; BLOCKS + 4],
            least: f32::INFINITY,
            blocks,
        };
        let (mut before, mut from) = (stretch.before, stretch.behind);
        cut.from[blocks] = from;
        for i in 0..blocks {
            let j = blocks - 1 - i;
            cut.before[i] = before;
            before = before.union(unions[i]);
            from = from.union(unions[j]);
            cut.from[j] = from;
        }
        cut.before[blocks] = before;

        let (step, count) = (stretch.step(), sweep.order.len());
        for first in (0..=blocks).step_by(4) {
            let at = [0, 1, 2, 3].map(|k| (stretch.start + (first + k) * step).min(stretch.end));
            let [left, right] = sweep.weights(&cut.before, &cut.from, first, at, count);
            cut.left[first..first + 4].copy_from_slice(&left.0);
            cut.right[first..first + 4].copy_from_slice(&right.0);
        }
        for i in 0..blocks {
            let weight = cut.left[i] + cut.right[i];
            cut.least = if weight < cut.least { weight } else { cut.least };
        }
        // Nothing weighs nothing, where arithmetic says NaN.
        if stretch.start == 0 {
            cut.left[0] = 0.0;
        }
        if stretch.end == count {
            cut.right[blocks] = 0.0;
        }
        cut
    }
}

/// One axis' order.
struct Sweep<'a> {
    order: &'a [u32],
    table: Table<'a>,
    axis: usize,
    scale: Lanes,
}

impl Sweep<'_> {
    /// Box of a run of references. Four at a time, since one would wait for the minimum before it.
    fn union(&self, run: std::ops::Range<usize>) -> LaneBox {
        let mut boxes = [LaneBox::EMPTY; 4];
        let fours = self.order[run].chunks_exact(4);
        for &id in fours.remainder() {
            boxes[0] = boxes[0].union(self.table.bounds(id));
        }
        for four in fours {
            for (b, &id) in boxes.iter_mut().zip(four) {
                *b = b.union(self.table.bounds(id));
            }
        }
        boxes[0].union(boxes[1]).union(boxes[2].union(boxes[3]))
    }

    /// Both sides' weights of the four planes `at`, whose boxes stand in `before` and `from` at `first`.
    #[inline(always)]
    fn weights(&self, before: &[LaneBox], from: &[LaneBox], first: usize, at: [usize; 4], count: usize) -> [Lanes; 2] {
        let four = |boxes: &[LaneBox]| [boxes[first], boxes[first + 1], boxes[first + 2], boxes[first + 3]];
        let left = LaneBox::scaled_half_areas(four(before), self.scale);
        let right = LaneBox::scaled_half_areas(four(from), self.scale);
        [
            Sah::side_weights(left, Lanes::of_counts(at.map(|i| i as i32))),
            Sah::side_weights(right, Lanes::of_counts(at.map(|i| (count - i) as i32))),
        ]
    }

    /// Sweep the blocks of a stretch that can hold a better plane than is known.
    fn look_closer(&self, stretch: &Stretch, cut: &Cut, sides: &mut Sides<ROOM>, best: &mut Best) {
        for (i, block) in stretch.blocks().enumerate().take(cut.blocks) {
            let floor = cut.left[i] + cut.right[i + 1];
            if floor > best.bound || floor >= best.weight() {
                continue;
            }
            let part = Stretch { start: block.start, end: block.end, before: cut.before[i], behind: cut.from[i + 1] };
            if block.len() <= PLAIN {
                self.plain(&part, sides, best);
            } else {
                let cut = Cut::new(self, &part);
                best.bound = cut.least.min(best.bound);
                self.look_closer(&part, &cut, sides, best);
            }
        }
    }

    /// Weigh every plane of a stretch, at most `CAP - 4`.
    #[inline(always)]
    fn plain<const CAP: usize>(&self, stretch: &Stretch, sides: &mut Sides<CAP>, best: &mut Best) {
        let ids = &self.order[stretch.start..stretch.end];
        let planes = ids.len().min(CAP - 4);
        let (mut left, mut right) = (stretch.before, stretch.behind);
        let places = sides.before.iter_mut().zip(sides.from[..planes].iter_mut().rev());
        for ((before, from), (&first, &last)) in places.zip(ids.iter().zip(ids.iter().rev())) {
            *before = left;
            left = left.union(self.table.bounds(first));
            right = right.union(self.table.bounds(last));
            *from = right;
        }

        // The plane before the first reference of all has a NaN for its weight, and so have those behind the last: no box times no
        // references. A NaN is less than nothing.
        sides.before[planes..planes + 4].fill(LaneBox::EMPTY);
        sides.from[planes..planes + 4].fill(LaneBox::EMPTY);
        let count = self.order.len();
        let (mut least, mut found) = (Lanes::splat(f32::INFINITY), Lanes::splat(0.0));
        let fours = sides.before.chunks_exact(4).zip(sides.from.chunks_exact(4));
        for (four, (before, from)) in fours.take(planes.div_ceil(4)).enumerate() {
            let at = [0, 1, 2, 3].map(|k| (stretch.start + 4 * four + k).min(count));
            let [left, right] = self.weights(before, from, 0, at, count);
            let weight = left.plus(right);
            found = weight.if_less(least, Lanes::splat((4 * four) as f32), found);
            least = weight.min(least);
        }
        let mut winner: Option<(f32, usize)> = None;
        for lane in 0..4 {
            let candidate = (least.0[lane], found.0[lane] as usize + lane);
            if candidate.0 < f32::INFINITY && winner.is_none_or(|w| candidate < w) {
                winner = Some(candidate);
            }
        }
        if let Some((weight, at)) = winner
            && weight < best.weight()
        {
            let bounds = [sides.before[at], sides.from[at]];
            best.plane = Some(Plane { axis: self.axis, left: stretch.start + at, weight, bounds });
        }
    }
}

/// Room for the boxes left and right of each plane of a stretch.
struct Sides<const CAP: usize> {
    before: [LaneBox; CAP],
    from: [LaneBox; CAP],
}

impl<const CAP: usize> Sides<CAP> {
    const EMPTY: Self = Sides { before: [LaneBox::EMPTY; CAP], from: [LaneBox::EMPTY; CAP] };
}

/// Weigh every plane of a small node.
#[inline(never)]
fn plain<const CAP: usize>(sweeps: &[Sweep; 3], all: &Stretch) -> Option<Plane> {
    let (mut best, mut sides) = (Best::default(), Sides::<CAP>::EMPTY);
    for sweep in sweeps {
        sweep.plain(all, &mut sides, &mut best);
    }
    best.plane
}
