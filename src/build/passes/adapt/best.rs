//! The best tree over a handful of nodes.
//!
//! Every set of them could be a subtree. What each would be visited by is counted; then the best tree of every set follows from those of
//! its parts, smaller sets first, over all ways to divide it in two (dynamic programming, as in Karras and Aila, section 4).

use super::guide::{Guide, Segment, larger, smaller};
use crate::build::passes::treelet::{MOST, Part, SETS, Treelet};
use crate::build::passes::work_tree::WorkTree;
use crate::simd::{LaneBox, widest};
use crate::tree::MAX_DEPTH;

/// As if so many more rays had visited the treelet, which pass through everything: they are met in proportion to area. What is decided by
/// few rays would otherwise be decided by chance, and rays of other families than those that happen to come by would pay for it.
pub(super) const PSEUDO_RAYS: f32 = 400.0;
/// Visits that must be saved.
const LEAST_GAIN: f32 = 1.0;

/// What was found at a node.
pub struct Found {
    /// `None`: it is best as it is.
    pub treelet: Option<Treelet>,
    /// The rays that visit either child then.
    pub rays: [Vec<u32>; 2],
}

/// A coordinate of the boxes of all sets.
type Row = [f32; SETS];

/// One thread's memory.
pub struct Workshop {
    min: [Row; 3],
    max: [Row; 3],
    visits: [u32; SETS],
}

impl Default for Workshop {
    fn default() -> Workshop {
        Workshop { min: [[0.0; SETS]; 3], max: [[0.0; SETS]; 3], visits: [0; SETS] }
    }
}

impl Workshop {
    /// The best way to put the treelet at `root` together, `depth` levels below the tree's root, by what `rays`, all that meet it, visit.
    pub fn best(
        &mut self,
        tree: &WorkTree,
        visits: &[u32],
        guide: &Guide,
        depth: u32,
        root: u32,
        rays: &[u32],
    ) -> Found {
        let (inner, front) = grow(tree, visits, root);
        let treelet = (front.len() > 2).then(|| self.rearranged(tree, guide, rays, depth, inner, front)).flatten();
        let boxes = match &treelet {
            None => tree.slots[root as usize].children().map(|child| {
                let child = &tree.slots[child as usize];
                (child.min, child.max)
            }),
            Some(treelet) => {
                let all = (1 << treelet.front.len()) - 1;
                let half = usize::from(treelet.halves[all]);
                [half, all & !half].map(|part| (self.min.map(|row| row[part]), self.max.map(|row| row[part])))
            }
        };
        Found { treelet, rays: boxes.map(|(min, max)| guide.among(rays, &min, &max)) }
    }

    fn rearranged(
        &mut self,
        tree: &WorkTree,
        guide: &Guide,
        rays: &[u32],
        depth: u32,
        inner: Vec<u32>,
        front: Vec<u32>,
    ) -> Option<Treelet> {
        let sets: usize = 1 << front.len();
        let all = sets - 1;
        let prices = self.prices(tree, guide, rays, &front);

        // Smaller sets have smaller numbers than the sets that they are part of.
        let mut least = [0.0f32; SETS];
        let mut halves = [0u8; SETS];
        for set in 3..sets {
            if set.count_ones() < 2 {
                continue;
            }
            // One half holds the lowest bit, so that each division comes once.
            let lowest = set & set.wrapping_neg();
            let others = set & !lowest;
            let (mut best, mut best_half) = (f32::INFINITY, 0);
            let mut other = others;
            while other > 0 {
                let sum = least[other] + least[set & !other];
                if sum < best {
                    (best, best_half) = (sum, set & !other);
                }
                other = (other - 1) & others;
            }
            least[set] = best + prices[set];
            halves[set] = best_half as u8;
        }

        let treelet = Treelet { inner, front, halves, visits: self.visits };
        let gains = present_price(tree, &treelet, &prices) - least[all] > LEAST_GAIN;
        (gains && fits(tree, &treelet, all, depth)).then_some(treelet)
    }

    /// Visits of every set, those of imagined rays included; nothing for single nodes.
    fn prices(&mut self, tree: &WorkTree, guide: &Guide, rays: &[u32], front: &[u32]) -> Row {
        let sets = 1usize << front.len();
        let mut boxes = [LaneBox::EMPTY; SETS];
        for set in 1..sets {
            let lowest = set.trailing_zeros() as usize;
            let bounds = boxes[set & (set - 1)].union(tree.slots[front[lowest] as usize].lanes());
            boxes[set] = bounds;
            let (min, max) = (bounds.min.point(), bounds.max.point());
            for k in 0..3 {
                (self.min[k][set], self.max[k][set]) = (min[k], max[k]);
            }
        }
        // No box at all, which nothing meets.
        (self.min.iter_mut()).zip(&mut self.max).for_each(|(min, max)| (min[0], max[0]) = (f32::MAX, f32::MIN));
        self.count(guide, rays, sets);

        let areas = boxes.map(|b| b.scaled_half_area(tree.scale));
        let of_area = PSEUDO_RAYS / areas[sets - 1].max(f32::MIN_POSITIVE);
        let mut prices = [0.0; SETS];
        for set in (3..sets).filter(|set| set.count_ones() > 1) {
            prices[set] = self.visits[set] as f32 + of_area * areas[set];
        }
        prices
    }

    /// How many of the rays meet the box of each set.
    fn count(&mut self, guide: &Guide, rays: &[u32], sets: usize) {
        self.visits[..sets].fill(0);
        widest(
            #[inline(always)]
            || {
                for &ray in rays {
                    self.count_one(&guide.segments[ray as usize], sets);
                }
            },
        );
    }

    /// All boxes against one ray, so that it is the boxes which lie side by side in a register. Whichever plane of a slab the direction
    /// enters by is the same for all.
    #[inline(always)]
    fn count_one(&mut self, ray: &Segment, sets: usize) {
        let planes = [0, 1, 2].map(|k| match ray.inverse[k] < 0.0 {
            false => (&self.min[k][..sets], &self.max[k][..sets]),
            true => (&self.max[k][..sets], &self.min[k][..sets]),
        });
        let [(x0, x1), (y0, y1), (z0, z1)] = planes;
        let (o, i) = (ray.origin, ray.inverse);
        for (set, visits) in self.visits[..sets].iter_mut().enumerate() {
            let near = larger(larger((x0[set] - o[0]) * i[0], (y0[set] - o[1]) * i[1]), (z0[set] - o[2]) * i[2]);
            let far = smaller(smaller((x1[set] - o[0]) * i[0], (y1[set] - o[1]) * i[1]), (z1[set] - o[2]) * i[2]);
            *visits += u32::from(larger(near, 0.0) <= smaller(far, ray.end));
        }
    }
}

/// The inner nodes and the front of the treelet at `root`: what is visited most is opened, until there are enough.
fn grow(tree: &WorkTree, visits: &[u32], root: u32) -> (Vec<u32>, Vec<u32>) {
    let mut inner = vec![root];
    let mut front = tree.slots[root as usize].children().to_vec();
    while front.len() < MOST {
        let inner_ones = front.iter().enumerate().filter(|(_, slot)| !tree.slots[**slot as usize].is_leaf());
        let most = inner_ones.max_by_key(|(i, slot)| (visits[**slot as usize], std::cmp::Reverse(*i)));
        let Some((at, &slot)) = most else { break };
        inner.push(slot);
        let [first, second] = tree.slots[slot as usize].children();
        front[at] = first;
        front.push(second);
    }
    (inner, front)
}

/// What the treelet costs as it is.
fn present_price(tree: &WorkTree, treelet: &Treelet, prices: &Row) -> f32 {
    fn of(tree: &WorkTree, treelet: &Treelet, prices: &Row, slot: u32) -> (Part, f32) {
        if let Some(bit) = treelet.front.iter().position(|s| *s == slot) {
            return (1 << bit, 0.0);
        }
        let [(a, x), (b, y)] = tree.slots[slot as usize].children().map(|child| of(tree, treelet, prices, child));
        (a | b, x + y + prices[a | b])
    }
    of(tree, treelet, prices, treelet.inner[0]).1
}

/// Whether no leaf comes to lie too deep if the set stands `depth` levels below the tree's root.
fn fits(tree: &WorkTree, treelet: &Treelet, set: Part, depth: u32) -> bool {
    if set.count_ones() == 1 {
        let slot = treelet.front[set.trailing_zeros() as usize];
        return depth + u32::from(tree.height(slot)) <= MAX_DEPTH;
    }
    treelet.parts(set).into_iter().all(|part| fits(tree, treelet, part, depth + 1))
}
