//! A tree that can be changed: slots instead of records, with links up as well as down.
//!
//! Siblings stay side by side, slots `2k` and `2k + 1`, as in a [`Tree`]: one cache line holds both boxes that a search
//! asks for next, a node's sibling is one bit away, and one parent link serves both. Moving a subtree changes what three
//! slots hold and nothing else, so slots are neither made nor freed.

use super::links::{Links, NONE};
use super::slot::{LEAF, Slot};
use super::treelet::{Part, Treelet};
use super::volumes::Volumes;
use crate::build::binned::{area_scale, scaled_half_area};
use crate::exec::Executor;
use crate::tree::{MAX_DEPTH, Tree};

/// Slots that a task converts at once.
const CHUNK: usize = 1 << 14;

/// The tree under change.
pub struct WorkTree {
    /// The root, an unused slot, and the pairs, in no particular order.
    pub slots: Vec<Slot>,
    /// By pair: the slot that has it as its children.
    parents: Vec<u32>,
    /// By slot: no leaf below is more levels down. Exact after [`WorkTree::refit`].
    heights: Vec<u8>,
    /// By slot, [`CHANGED`] and [`TAKEN`].
    flags: Vec<u8>,
    /// The number of a leaf's references, by the place of its first one.
    leaf_counts: Vec<u8>,
    /// What edges are multiplied by before areas are taken.
    pub scale: f32,
    /// Sum of the inner nodes' areas: what moving subtrees changes of the SAH, but for the factor C_T.
    pub inner_area: f64,
    /// Slots with [`TAKEN`] set.
    taken: Vec<u32>,
}

/// The box, area and height of this slot are to be recomputed. Whatever is above a changed slot is changed, too.
const CHANGED: u8 = 1;
/// This batch has already given the slot another content.
const TAKEN: u8 = 2;

impl WorkTree {
    /// `None` where nothing can be gained: too few nodes, or a root box without a usable area.
    pub fn new(tree: &Tree, exec: &Executor) -> Option<WorkTree> {
        let scale = area_scale(&tree.bounds());
        let usable = scale.is_finite() && scale > 0.0 && scaled_half_area(&tree.bounds(), scale) > 0.0;
        if tree.nodes.len() < 4 || !usable {
            return None;
        }
        let mut slots: Vec<Slot> = bytemuck::zeroed_vec(tree.nodes.len());
        let areas = exec.map_chunks_mut(&mut slots, CHUNK, |chunk_index, chunk| {
            let mut inner_area = 0.0;
            for (slot, node) in chunk.iter_mut().zip(&tree.nodes[chunk_index * CHUNK..]) {
                let link = if node.is_leaf() { LEAF | node.first } else { node.first / 2 };
                *slot = Slot { min: node.min, link, max: node.max, area: 0.0 };
                slot.area = slot.lanes().scaled_half_area(scale);
                inner_area += if node.is_leaf() { 0.0 } else { f64::from(slot.area) };
            }
            inner_area
        });

        let Links { parents, heights, leaf_counts } = Links::of(tree, exec);
        let flags = vec![0u8; tree.nodes.len()];
        let inner_area = areas.iter().sum();
        Some(WorkTree { slots, parents, heights, flags, leaf_counts, scale, inner_area, taken: Vec::new() })
    }

    /// The slot above; none above the root.
    #[inline(always)]
    pub fn parent(&self, slot: u32) -> Option<u32> {
        match self.parents[slot as usize / 2] {
            NONE => None,
            parent => Some(parent),
        }
    }

    /// Take the subtree at `from` out and make it the sibling of what is at `to`, if that is still possible in this batch.
    ///
    /// `from`'s parent vanishes: what was beside `from` takes its slot. `to` becomes an inner node over `from` and, in the slot
    /// that was left, what it held before. Refused, with `false`, if an earlier move of the batch changed one of these
    /// slots, if it carried `to` into `from`'s own subtree, or if a leaf could come to lie deeper than [`MAX_DEPTH`].
    pub fn move_subtree(&mut self, from: u32, to: u32) -> bool {
        let sibling = from ^ 1;
        let Some(parent) = self.parent(from) else { return false };
        let slots = [from, sibling, parent, to];
        if to == parent || to == sibling || slots.iter().any(|&s| self.flags[s as usize] & TAKEN != 0) {
            return false;
        }

        // Follow the links up from the place aimed at: `from` must not be there, and there must be room below.
        let mut depth = 0;
        let mut above = to;
        while let Some(next) = self.parent(above) {
            if above == from {
                return false;
            }
            above = next;
            depth += 1;
        }
        let height = 1 + self.heights[from as usize].max(self.heights[to as usize]);
        if depth + u32::from(height) > MAX_DEPTH {
            return false;
        }

        self.inner_area -= f64::from(self.slots[parent as usize].area);
        self.put(parent, sibling);
        self.put(sibling, to);
        self.slots[to as usize].link = from / 2;
        self.slots[to as usize].area = 0.0;
        self.parents[from as usize / 2] = to;
        for slot in slots {
            self.flags[slot as usize] |= TAKEN;
            self.taken.push(slot);
        }
        self.mark_changed(parent);
        self.mark_changed(to);
        self.raise(to, height);
        true
    }

    /// Give `to` the content of `from`.
    fn put(&mut self, to: u32, from: u32) {
        let content = self.slots[from as usize];
        self.slots[to as usize] = content;
        self.heights[to as usize] = self.heights[from as usize];
        self.flags[to as usize] = self.flags[to as usize] & !CHANGED | self.flags[from as usize] & CHANGED;
        if !content.is_leaf() {
            self.parents[content.link as usize] = to;
        }
    }

    fn mark_changed(&mut self, slot: u32) {
        let mut at = Some(slot);
        while let Some(slot) = at.filter(|&s| self.flags[s as usize] & CHANGED == 0) {
            self.flags[slot as usize] |= CHANGED;
            at = self.parent(slot);
        }
    }

    /// Let heights from `slot` upward be bounds again.
    fn raise(&mut self, slot: u32, height: u8) {
        let (mut at, mut height) = (Some(slot), height);
        while let Some(slot) = at {
            if self.heights[slot as usize] >= height {
                return;
            }
            self.heights[slot as usize] = height;
            height += 1;
            at = self.parent(slot);
        }
    }

    /// Put a treelet together as it says. Its inner nodes' pairs are used anew; `placed` is told what stands in each of their slots now.
    /// Boxes, areas and the sum of them are right afterwards, heights in the treelet too, but not above it.
    pub fn put_together(&mut self, treelet: &Treelet, mut placed: impl FnMut(u32, Part)) {
        let front = treelet.front.iter().map(|&slot| (self.slots[slot as usize], self.heights[slot as usize]));
        let front: Vec<(Slot, u8)> = front.collect();
        let mut pairs: Vec<u32> = treelet.inner.iter().map(|&slot| self.slots[slot as usize].link).collect();
        for &slot in &treelet.inner {
            self.inner_area -= f64::from(self.slots[slot as usize].area);
        }
        self.put_set(treelet, &front, &mut pairs, treelet.inner[0], (1 << front.len()) - 1, &mut placed);
    }

    fn put_set(
        &mut self,
        treelet: &Treelet,
        front: &[(Slot, u8)],
        pairs: &mut Vec<u32>,
        at: u32,
        set: Part,
        placed: &mut impl FnMut(u32, Part),
    ) {
        placed(at, set);
        if set.count_ones() == 1 {
            let (content, height) = front[set.trailing_zeros() as usize];
            (self.slots[at as usize], self.heights[at as usize]) = (content, height);
            if !content.is_leaf() {
                self.parents[content.link as usize] = at;
            }
            return;
        }
        // As many sets of several as there are inner nodes.
        let Some(pair) = pairs.pop() else { return };
        self.parents[pair as usize] = at;
        self.slots[at as usize].link = pair;
        for (k, part) in treelet.parts(set).into_iter().enumerate() {
            self.put_set(treelet, front, pairs, 2 * pair + k as u32, part, placed);
        }
        let [first, second] = [0, 1].map(|k| self.slots[2 * pair as usize + k].lanes());
        let bounds = first.union(second);
        let area = bounds.scaled_half_area(self.scale);
        self.slots[at as usize].set_box(bounds);
        self.slots[at as usize].area = area;
        self.inner_area += f64::from(area);
        self.measure([at]);
    }

    /// Let the heights of these inner nodes follow from those of their children.
    pub fn measure(&mut self, slots: impl IntoIterator<Item = u32>) {
        for slot in slots {
            let [first, second] = self.slots[slot as usize].children().map(|child| self.heights[child as usize]);
            self.heights[slot as usize] = 1 + first.max(second);
        }
    }

    /// Let every slot have another area.
    pub fn set_areas(&mut self, area: impl Fn(&Slot) -> f32 + Sync, exec: &Executor) {
        let sums = exec.map_chunks_mut(&mut self.slots, CHUNK, |chunk_index, chunk| {
            // Slot 1 is none.
            let slots = chunk.iter_mut().enumerate().filter(|(i, _)| chunk_index * CHUNK + i != 1);
            slots.fold(0.0, |sum, (_, slot)| {
                slot.area = area(slot);
                sum + if slot.is_leaf() { 0.0 } else { f64::from(slot.area) }
            })
        });
        self.inner_area = sums.iter().sum();
    }

    /// End a batch: boxes, areas and heights above what was moved.
    pub fn refit(&mut self, volumes: &mut impl Volumes) {
        for slot in std::mem::take(&mut self.taken) {
            self.flags[slot as usize] &= !TAKEN;
        }
        if self.flags[0] & CHANGED != 0 {
            self.refit_below(0, volumes);
        }
    }

    /// As deep as the tree, which [`MAX_DEPTH`] bounds.
    fn refit_below(&mut self, slot: u32, volumes: &mut impl Volumes) {
        self.flags[slot as usize] &= !CHANGED;
        let before = self.slots[slot as usize];
        if before.is_leaf() {
            return;
        }
        let [first, second] = before.children();
        for child in [first, second] {
            if self.flags[child as usize] & CHANGED != 0 {
                self.refit_below(child, volumes);
            }
        }
        let area = volumes.enclose(&mut self.slots, slot);
        self.inner_area += f64::from(area) - f64::from(before.area);
        self.slots[slot as usize].area = area;
        self.heights[slot as usize] = 1 + self.heights[first as usize].max(self.heights[second as usize]);
    }

    /// A leaf's references, as a range of the tree that this one was made from.
    pub fn leaf_range(&self, leaf: &Slot) -> std::ops::Range<usize> {
        let first = (leaf.link & !LEAF) as usize;
        first..first + self.leaf_count(first)
    }

    /// How many references the leaf has that begins with this one; 0 where none does.
    pub fn leaf_count(&self, first: usize) -> usize {
        usize::from(self.leaf_counts[first])
    }

    /// No leaf below is more levels down than this.
    pub fn height(&self, slot: u32) -> u8 {
        self.heights[slot as usize]
    }
}
