//! The references of a node in three orders, one an axis, and the stable partition that keeps them.

use super::sort::{key_of, sort_by_key};
use crate::build::binned::{EXHAUSTIVE, Subset};
use crate::build::prim_ref::PrimRef;
use crate::build::top_down::range::Range;
use crate::build::top_down::strategy::{Child, NodeTask};
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::simd::LaneBox;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Nodes of up to so many references get a copy of them that the second-level cache holds, instead of reaching into the whole
/// scene's.
const CLOSE: usize = 1 << 12;
/// From so many references on, a node is partitioned in chunks of [`CHUNK`]: constants, so that nothing depends on threads.
const CHUNKED: usize = 1 << 16;
const CHUNK: usize = 1 << 13;

/// Everything that a sweep allocates, once for the whole tree.
pub(in crate::build) struct Buffers {
    by_axis: [Vec<u32>; 3],
    spare: Vec<u32>,
    notes: Vec<AtomicU32>,
    /// Copies of the references, and notes for them; empty where the references are few enough as they are.
    near: Vec<PrimRef>,
    near_notes: Vec<AtomicU32>,
}

/// Bytes of [`Buffers`] for each reference, and of the sort that fills them.
pub(in crate::build) const BYTES_PER_REF: u64 =
    (size_of::<PrimRef>() + 4 * size_of::<u32>() + 2 * size_of::<u32>() + 16) as u64;

fn notes(count: usize) -> Vec<AtomicU32> {
    (0..count).map(|_| AtomicU32::new(0)).collect()
}

impl Buffers {
    /// The orders of `refs`, sorted.
    pub fn sorted(refs: &[PrimRef], exec: &Executor) -> Buffers {
        let count = refs.len();
        let mut by_axis = [0; 3].map(|_| vec![0; count]);
        let mut scratch = Vec::new();
        for (axis, order) in by_axis.iter_mut().enumerate() {
            sort_by_key(order, &mut scratch, exec, |i| key_of(refs[i].min[axis] + refs[i].max[axis]));
        }
        let near = if count > CLOSE { count } else { 0 };
        Buffers {
            by_axis,
            spare: vec![0; count],
            notes: notes(count),
            near: bytemuck::zeroed_vec(near),
            near_notes: notes(near),
        }
    }

    /// The range of all references; `refs` are those that were sorted.
    pub fn all<'a>(&'a mut self, refs: &'a [PrimRef]) -> Orders<'a> {
        let [x, y, z] = &mut self.by_axis;
        let near = (!self.near.is_empty()).then_some((self.near.as_mut_slice(), self.near_notes.as_slice()));
        Orders { by_axis: [x, y, z], spare: &mut self.spare, table: Table { refs, notes: &self.notes }, near }
    }
}

/// What the orders' numbers mean.
#[derive(Clone, Copy)]
pub(super) struct Table<'a> {
    refs: &'a [PrimRef],
    /// A word for each reference: the side it goes to, or its new number. Atomic because tasks note things about references that
    /// stand between each other's; each belongs to one node only.
    notes: &'a [AtomicU32],
}

impl Table<'_> {
    #[inline(always)]
    pub fn bounds(&self, id: u32) -> LaneBox {
        self.refs[id as usize].lanes()
    }

    #[inline(always)]
    fn note(&self, id: u32) -> u32 {
        self.notes[id as usize].load(Relaxed)
    }

    #[inline(always)]
    fn set_note(&self, id: u32, note: u32) {
        self.notes[id as usize].store(note, Relaxed);
    }

    /// Box of these references' doubled centres, given in the order of their centres on each axis.
    #[inline]
    fn centroids(&self, by_axis: [&[u32]; 3]) -> Aabb {
        let mut centroids = Aabb::EMPTY;
        for axis in 0..3 {
            if let (Some(first), Some(last)) = (by_axis[axis].first(), by_axis[axis].last()) {
                let [first, last] = [&self.refs[*first as usize], &self.refs[*last as usize]];
                centroids.min[axis] = first.min[axis] + first.max[axis];
                centroids.max[axis] = last.min[axis] + last.max[axis];
            }
        }
        centroids
    }
}

/// The references `..left` of one axis' order against the others.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub axis: usize,
    pub left: usize,
    /// [`Sah::weight`](crate::build::cost::Sah::weight) with areas scaled.
    pub weight: f32,
    pub bounds: [LaneBox; 2],
}

/// A node's references, each in all three orders. Below [`EXHAUSTIVE`] references only the first order is kept up.
pub(in crate::build) struct Orders<'a> {
    pub(super) by_axis: [&'a mut [u32]; 3],
    pub(super) table: Table<'a>,
    spare: &'a mut [u32],
    /// Where a closer copy of the references can be made.
    near: Option<(&'a mut [PrimRef], &'a [AtomicU32])>,
}

impl Orders<'_> {
    /// Copy the references of a small node to one place, and number them from 0. Their orders stay.
    pub(super) fn come_close(&mut self) {
        let count = self.by_axis[0].len();
        if count > CLOSE {
            return;
        }
        let Some((refs, notes)) = self.near.take() else { return };
        let [first, others @ ..] = &mut self.by_axis;
        for (new, (id, to)) in first.iter_mut().zip(refs.iter_mut()).enumerate() {
            *to = self.table.refs[*id as usize];
            self.table.set_note(*id, new as u32);
            *id = new as u32;
        }
        for id in others.iter_mut().flat_map(|order| order.iter_mut()) {
            *id = self.table.note(*id);
        }
        self.table = Table { refs, notes };
    }

    /// The references of a node of at most [`EXHAUSTIVE`], in the first order.
    pub(super) fn few(&self) -> [PrimRef; EXHAUSTIVE] {
        let mut refs = [bytemuck::Zeroable::zeroed(); EXHAUSTIVE];
        for (to, id) in refs.iter_mut().zip(self.by_axis[0].iter()) {
            *to = self.table.refs[*id as usize];
        }
        refs
    }

    /// Put the subset's members first.
    pub(super) fn divide_few(&mut self, subset: Subset, bounds: [Aabb; 2]) -> (Child, Child) {
        let order = &mut *self.by_axis[0];
        let mut old = [0; EXHAUSTIVE];
        let old = &mut old[..order.len()];
        old.copy_from_slice(order);
        let (mut left, mut right) = (0, subset.len());
        for (i, &id) in old.iter().enumerate() {
            let at = if subset.has(i) { &mut left } else { &mut right };
            order[*at] = id;
            *at += 1;
        }
        let child = |ids: &[u32], bounds: Aabb| {
            let centroids = ids.iter().fold(LaneBox::EMPTY, |b, &id| {
                let r = self.table.bounds(id);
                b.grow(r.min.plus(r.max))
            });
            Child { bounds, centroids: centroids.aabb(), live: ids.len(), slots: ids.len() }
        };
        let (left_ids, right_ids) = self.by_axis[0].split_at(left);
        (child(left_ids, bounds[0]), child(right_ids, bounds[1]))
    }

    /// Carry out a split: in all orders the left references come first, and stay in order.
    pub(super) fn divide(&mut self, plane: &Plane, exec: &Executor) -> (Child, Child) {
        let table = self.table;
        let count = self.by_axis[0].len();
        let (left, right) = self.by_axis[plane.axis].split_at(plane.left);
        if count < CHUNKED {
            left.iter().for_each(|&id| table.set_note(id, 1));
            right.iter().for_each(|&id| table.set_note(id, 0));
        } else {
            exec.map_chunks(left, CHUNK, |_, ids| ids.iter().for_each(|&id| table.set_note(id, 1)));
            exec.map_chunks(right, CHUNK, |_, ids| ids.iter().for_each(|&id| table.set_note(id, 0)));
        }
        for axis in (0..3).filter(|&a| a != plane.axis) {
            let (order, spare) = (&mut self.by_axis[axis], &mut self.spare);
            if count < CHUNKED {
                partition(order, spare, plane.left, table);
            } else {
                partition_chunks(order, spare, plane.left, table, exec);
            }
            std::mem::swap(order, spare);
        }
        let child = |side: usize, live: usize, by_axis: [&[u32]; 3]| Child {
            bounds: plane.bounds[side].aabb(),
            centroids: table.centroids(by_axis),
            live,
            slots: live,
        };
        let [x, y, z] = &self.by_axis;
        let (x, y, z) = (x.split_at(plane.left), y.split_at(plane.left), z.split_at(plane.left));
        (child(0, plane.left, [x.0, y.0, z.0]), child(1, count - plane.left, [x.1, y.1, z.1]))
    }
}

/// Copy an order with those first that were noted to go left, of which there are `left`.
fn partition(order: &[u32], to: &mut [u32], left: usize, table: Table) {
    // Both cursors stay within the slice; the remainder only tells the compiler that.
    let (mut left, mut right) = (0, left);
    let count = to.len();
    for &id in order {
        let goes_left = table.note(id) as usize;
        let at = if goes_left != 0 { left } else { right };
        if at < count {
            to[at] = id;
        }
        left += goes_left;
        right += 1 - goes_left;
    }
}

/// [`partition`], each chunk into its own two runs.
fn partition_chunks(order: &[u32], to: &mut [u32], left: usize, table: Table, exec: &Executor) {
    let counts = exec.map_chunks(order, CHUNK, |_, ids| ids.iter().map(|&id| table.note(id) as usize).sum::<usize>());
    let (mut lefts, mut rights) = to.split_at_mut(left);
    let mut jobs = Vec::with_capacity(counts.len());
    for (ids, count) in order.chunks(CHUNK).zip(counts) {
        let (to_left, rest) = std::mem::take(&mut lefts).split_at_mut(count);
        lefts = rest;
        let (to_right, rest) = std::mem::take(&mut rights).split_at_mut(ids.len() - count);
        rights = rest;
        jobs.push((ids, to_left, to_right));
    }
    exec.map(jobs, |_, (ids, to_left, to_right)| {
        let (mut to_left, mut to_right) = (to_left.iter_mut(), to_right.iter_mut());
        for &id in ids {
            let to = if table.note(id) != 0 { to_left.next() } else { to_right.next() };
            if let Some(to) = to {
                *to = id;
            }
        }
    });
}

impl Range for Orders<'_> {
    #[inline]
    fn cut(self, left_slots: usize) -> (Self, Self) {
        // Spelt out: as a closure over the array it is not inlined, and this happens at every node.
        let [x, y, z] = self.by_axis;
        let (x, y, z) = (x.split_at_mut(left_slots), y.split_at_mut(left_slots), z.split_at_mut(left_slots));
        let (left_spare, right_spare) = self.spare.split_at_mut(left_slots);
        let (left_near, right_near) = match self.near {
            Some((refs, notes)) => {
                let (refs, notes) = (refs.split_at_mut(left_slots), notes.split_at(left_slots));
                (Some((refs.0, notes.0)), Some((refs.1, notes.1)))
            }
            None => (None, None),
        };
        let table = self.table;
        (
            Orders { by_axis: [x.0, y.0, z.0], spare: left_spare, table, near: left_near },
            Orders { by_axis: [x.1, y.1, z.1], spare: right_spare, table, near: right_near },
        )
    }

    fn prims(&self, live: usize) -> impl Iterator<Item = u32> + '_ {
        self.by_axis[0][..live].iter().map(|&id| self.table.refs[id as usize].prim)
    }

    fn halve(&mut self, node: &NodeTask) -> (Child, Child) {
        let extent = node.centroids.extent();
        let axis = (1..3).fold(0, |best, a| if extent[a] > extent[best] { a } else { best });
        let left = node.live.div_ceil(2);
        if node.live <= EXHAUSTIVE {
            let refs = self.few();
            let refs = &refs[..node.live];
            let key = |i: usize| (key_of(refs[i].center2()[axis]), refs[i].prim);
            let rank = |i: usize| (0..node.live).filter(|&j| key(j) < key(i)).count();
            let subset = Subset::of((0..node.live).filter(|&i| rank(i) < left));
            let side = |left: bool| {
                let members = (0..node.live).filter(|&i| subset.has(i) == left);
                members.fold(LaneBox::EMPTY, |b, i| b.union(refs[i].lanes())).aabb()
            };
            return self.divide_few(subset, [side(true), side(false)]);
        }
        let union = |ids: &[u32]| ids.iter().fold(LaneBox::EMPTY, |b, &id| b.union(self.table.bounds(id)));
        let (left_ids, right_ids) = self.by_axis[axis].split_at(left);
        let plane = Plane { axis, left, weight: f32::NAN, bounds: [union(left_ids), union(right_ids)] };
        self.divide(&plane, &Executor::sequential())
    }
}
