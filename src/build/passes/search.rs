//! Where a subtree would fit best: branch and bound over the whole tree, reading only.
//!
//! Taking a node out saves its parent and shrinks the boxes above; putting it beside another node costs a new parent and
//! widens the boxes above that. The search climbs from the node, and at each level looks into the other child's subtree,
//! carrying along what has been saved up to there (Meister and Bittner, "Parallel Reinsertion for Bounding Volume
//! Hierarchy Optimization", 2018, section 4). Beside the places in those subtrees it weighs the nodes above the node
//! itself, whose price is known on the way.

use super::volumes::Volumes;
use super::work_tree::WorkTree;
use crate::tree::MAX_DEPTH;

/// A subtree and a better place for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// By how much the sum of the inner nodes' areas falls if this is the only move.
    pub gain: f32,
    pub from: u32,
    /// The node that becomes the sibling.
    pub to: u32,
}

/// Pairs that one search may look at, so that time stays bounded where everything overlaps everything. Searches on real
/// scenes look at fewer than ten.
const MAX_PAIRS: u32 = 128;

/// One thread's search.
pub struct Search<'a, V: Volumes> {
    tree: &'a WorkTree,
    volumes: &'a V,
    /// Moves that gain no more than this are not worth making.
    least: f32,
    node: V::Held,
    node_area: f32,
    /// The most that is gained so far, and where.
    best: f32,
    best_place: Option<u32>,
    pairs_left: u32,
    /// Pairs put off, each with what is saved there before the node's own area is paid.
    put_off: Vec<(f32, u32)>,
}

impl<'a, V: Volumes> Search<'a, V> {
    pub fn new(tree: &'a WorkTree, volumes: &'a V, least: f32) -> Search<'a, V> {
        let put_off = Vec::with_capacity(MAX_DEPTH as usize);
        Search {
            tree,
            volumes,
            least,
            node: volumes.held(&tree.slots[0]),
            node_area: 0.0,
            best: 0.0,
            best_place: None,
            pairs_left: 0,
            put_off,
        }
    }

    /// The best place for the subtree at `from`, if it is better than where it is.
    pub fn best_move(&mut self, from: u32) -> Option<Move> {
        let (tree, volumes) = (self.tree, self.volumes);
        let parent = tree.parent(from)?;
        let slot = &tree.slots[from as usize];
        (self.node, self.node_area) = (volumes.held(slot), slot.area);
        (self.best, self.best_place, self.pairs_left) = (self.least, None, MAX_PAIRS);

        // Below the sibling. Beside it is where the node is.
        let mut saved = tree.slots[parent as usize].area;
        let sibling = &tree.slots[(from ^ 1) as usize];
        self.enter(from ^ 1, saved, volumes.area_with(sibling, &self.node));

        let mut left = volumes.held(sibling);
        // Where what is left takes up as much as the whole did, so it does further up.
        let mut is_whole = false;
        let mut at = parent;
        while let Some(above) = tree.parent(at) {
            let beside = at ^ 1;
            let slot = &tree.slots[beside as usize];
            let both = volumes.area_with(slot, &self.node);
            self.offer(beside, saved - both);
            self.enter(beside, saved, both);

            // What remains of the node above once the subtree is gone, and the place beside that.
            let whole = tree.slots[above as usize].area;
            let shrinks = if is_whole { 0.0 } else { whole - volumes.join(slot, &mut left) };
            saved += shrinks;
            self.offer(above, saved - whole);
            is_whole = is_whole || (shrinks <= 0.0 && volumes.is(&tree.slots[above as usize], &left));

            // A box that does not shrink keeps those above it from shrinking.
            if shrinks <= 0.0 && saved - self.node_area <= self.best {
                break;
            }
            at = above;
        }
        self.best_place.map(|to| Move { gain: self.best, from, to })
    }

    #[inline(always)]
    fn offer(&mut self, place: u32, gain: f32) {
        if gain > self.best {
            (self.best, self.best_place) = (gain, Some(place));
        }
    }

    /// Look below a node whose box would have the area `both` with the subtree in it. What it does not widen costs nothing,
    /// not even rounding.
    #[inline(always)]
    fn enter(&mut self, place: u32, saved: f32, both: f32) {
        let slot = &self.tree.slots[place as usize];
        let saved = saved - (both - slot.area);
        if !slot.is_leaf() && saved - self.node_area > self.best {
            self.look_below(saved, slot.link);
        }
    }

    /// Branch and bound below a pair's parent. No place there gains more than what is saved so far less the node's own area,
    /// because the new parent is at least that large.
    fn look_below(&mut self, mut saved: f32, mut pair: u32) {
        let (tree, volumes, node, node_area) = (self.tree, self.volumes, self.node, self.node_area);
        loop {
            if self.pairs_left == 0 {
                self.put_off.clear();
                return;
            }
            self.pairs_left -= 1;
            let [first, second] = [2 * pair, 2 * pair + 1].map(|slot| &tree.slots[slot as usize]);
            let with_first = volumes.area_with(first, &node);
            let with_second = volumes.area_with(second, &node);
            self.offer(2 * pair, saved - with_first);
            self.offer(2 * pair + 1, saved - with_second);

            // Go on where more is left, and come back to the other child.
            let first_saved = saved - (with_first - first.area);
            let second_saved = saved - (with_second - second.area);
            let enter_first = !first.is_leaf() && first_saved - node_area > self.best;
            let enter_second = !second.is_leaf() && second_saved - node_area > self.best;
            match (enter_first, enter_second) {
                (true, true) if second_saved > first_saved => {
                    self.put_off.push((first_saved, first.link));
                    (saved, pair) = (second_saved, second.link);
                }
                (true, true) => {
                    self.put_off.push((second_saved, second.link));
                    (saved, pair) = (first_saved, first.link);
                }
                (true, false) => (saved, pair) = (first_saved, first.link),
                (false, true) => (saved, pair) = (second_saved, second.link),
                (false, false) => loop {
                    let Some((bound, link)) = self.put_off.pop() else { return };
                    if bound - node_area > self.best {
                        (saved, pair) = (bound, link);
                        break;
                    }
                },
            }
        }
    }
}
