//! A ray's walk through wide trees.

use super::block::{LANES, TriangleBlock};
use super::boxes::WideSlabs;
use super::record::WideRecord;
use super::scene::{WideTree, WideView};
use super::stack::{Pending, Stack as Waiting};
use crate::geom::Ray;
use crate::layout::{TriangleRecord, View};
use crate::simd::{Floats, Work, prefetch};
use crate::trace::bounds::Bounds;
use crate::trace::hit::{Best, Hit, Malformed};
use crate::trace::intersect::{EdgeRay, Filter};
use crate::trace::observe::Observer;
use crate::trace::place::Place;
use crate::trace::slab::{Conservative, Rule};
use crate::trace::source::Records;
use crate::trace::test::{Crossing, TriangleTest};
use crate::trace::traverse::{Bottom, Stack, through_levels};

/// What a ray asks of a scene: its closest hit, or with `ANY` the first one found.
pub struct WideQuery<'a, const ANY: bool, const N: usize, T, O> {
    pub scene: &'a WideView<'a, N, T>,
    pub ray: &'a Ray,
    pub observer: &'a mut O,
}

impl<const ANY: bool, const N: usize, T: WideRecord<N>, O: Observer> Work<N> for WideQuery<'_, ANY, N, T, O> {
    type Out = Result<Option<Hit>, Malformed>;

    #[inline(always)]
    fn run<V: Floats<N>>(self, door: V::Door) -> Result<Option<Hit>, Malformed> {
        let WideQuery { scene, ray, observer } = self;
        through_levels::<EdgeRay, Conservative, O>(
            &scene.view,
            ray,
            observer,
            #[inline(always)]
            |reached, origin, direction, best, observer| {
                let blas = reached.blas;
                let tree = scene.tree(blas, reached.place.first_triangle, reached.tree.triangles);
                let tree = tree.ok_or(Malformed::TreeOutOfRange { tree: blas })?;
                let Some(root) = reached.tree.nodes.first() else { return Ok(false) };
                let slabs = WideSlabs::new(door, origin, direction, &root.bounds(), ray.t_min);
                let Some(slabs) = slabs else {
                    return in_binary::<ANY, O>(
                        &scene.view,
                        blas,
                        reached.place.instance,
                        [origin, direction],
                        ray.t_min,
                        best,
                        observer,
                    );
                };
                let test = EdgeRay::unfiltered(origin, direction);
                let walk = Walk::<V, N, T> {
                    door,
                    slabs,
                    filter: test.filter(),
                    test: &test,
                    t_min: f64::from(ray.t_min),
                    place: reached.place,
                    tree,
                };
                walk.go::<ANY, O>(best, observer)
            },
        )
    }
}

/// A ray of which no axis counts meets every box, those of lanes without a child too. A binary tree has no such lanes.
#[cold]
#[inline(never)]
fn in_binary<const ANY: bool, O: Observer>(
    view: &View<'_>,
    blas: usize,
    instance: Option<u32>,
    [origin, direction]: [[f64; 3]; 2],
    t_min: f32,
    best: &mut Best,
    observer: &mut O,
) -> Result<bool, Malformed> {
    let (Some(tree), Some(row)) = (view.blas(blas), view.blases.get(blas)) else {
        return Err(Malformed::TreeOutOfRange { tree: blas });
    };
    let place = Place { first_triangle: row.ref_offset as usize, instance };
    let bottom = Bottom { tree: Records { nodes: tree.nodes, items: tree.triangles }, place };
    bottom.trace::<ANY, EdgeRay, Conservative>(origin, direction, t_min, best, &mut Stack::new(), observer)
}

/// The next child of those that a ray meets, by their bits, of which one is set.
#[inline(always)]
fn next_met<const N: usize>(node: &impl WideRecord<N>, near: &[f32; N], met: &mut u32) -> Pending {
    let lane = met.trailing_zeros() as usize % N;
    *met &= *met - 1;
    let (first, count) = node.links(lane);
    Pending { near: near[lane], first, count }
}

/// A ray at one tree.
struct Walk<'a, V: Floats<N>, const N: usize, T> {
    door: V::Door,
    slabs: WideSlabs<V, N>,
    filter: Filter,
    test: &'a EdgeRay,
    t_min: f64,
    place: Place,
    tree: WideTree<'a, T>,
}

impl<'a, V: Floats<N>, const N: usize, T: WideRecord<N>> Walk<'a, V, N, T> {
    /// Visit the leaves that the ray meets, the nearest child of each node first, among equals the first.
    #[inline(always)]
    fn go<const ANY: bool, O: Observer>(&self, best: &mut Best, observer: &mut O) -> Result<bool, Malformed> {
        let mut bounds = Bounds::of_wide(self.tree.nodes, self.tree.triangles);
        let mut waiting = Waiting::new();
        let mut farthest = Conservative::widened(best.limit);
        let mut end = V::splat(self.door, -farthest);
        let (mut first, mut count) = (0, 0);
        loop {
            if count == 0 {
                observer.inner_node();
                let node = bounds.enter_wide(first)?;
                node.prefetch_links();
                let (near, mut met) = self.slabs.test(self.door, node, end);
                // A ray meets one or two children of most nodes: one is entered at once, and of two the farther one waits.
                if met != 0 {
                    let mut nearest = next_met(node, &near, &mut met);
                    let base = waiting.height();
                    while met != 0 {
                        let child = next_met(node, &near, &mut met);
                        let is_nearer = child.near < nearest.near;
                        let farther = if is_nearer { nearest } else { child };
                        nearest = if is_nearer { child } else { nearest };
                        self.prefetch(&farther);
                        // One that was the nearest comes before its equals, another after them.
                        if !waiting.put(base, farther, is_nearer) {
                            return too_deep();
                        }
                    }
                    (first, count) = (nearest.first, nearest.count);
                    continue;
                }
            } else {
                if self.leaf::<ANY, O>(&mut bounds, first, count, best, observer)? {
                    return Ok(true);
                }
                farthest = Conservative::widened(best.limit);
                end = V::splat(self.door, -farthest);
            }

            // Take up the next child that is not behind the best hit.
            loop {
                let Some(next) = waiting.pop() else { return Ok(false) };
                if next.near <= farthest {
                    (first, count) = (next.first, next.count);
                    break;
                }
            }
        }
    }

    /// Ask for what a child that waits begins with.
    #[inline(always)]
    fn prefetch(&self, child: &Pending) {
        let first = child.first as usize;
        if child.count == 0 {
            if let Some(node) = self.tree.nodes.get(first) {
                prefetch(node, size_of::<T>());
            }
        } else if T::IN_BLOCKS {
            if let Some(block) = self.tree.blocks.get(first / LANES) {
                prefetch(block, size_of::<TriangleBlock>());
            }
        } else if let Some(triangle) = self.tree.triangles.get(self.slot(first)) {
            prefetch(triangle, LANES * size_of::<TriangleRecord>());
        }
    }

    /// The triangles of a leaf, four at a time: most misses are proved for all four at once.
    #[inline(always)]
    fn leaf<const ANY: bool, O: Observer>(
        &self,
        bounds: &mut Bounds<'_, TriangleRecord, T>,
        first: u32,
        count: u32,
        best: &mut Best,
        observer: &mut O,
    ) -> Result<bool, Malformed> {
        bounds.count_items(count as usize)?;
        (0..count).for_each(|_| observer.triangle());
        let (mut at, mut left) = (first as usize, count as usize);
        while left > 0 {
            let gathered;
            let (block, some) = if T::IN_BLOCKS {
                let block = self.tree.blocks.get(at / LANES);
                (block.ok_or_else(|| out_of_range(at, self.tree.order.len()))?, left.min(LANES))
            } else {
                let run = self.run(at, left.min(LANES))?;
                gathered = TriangleBlock::new(run);
                (&gathered, run.len())
            };
            let mut met = block.may_cross(&self.filter) & (u32::MAX >> (32 - some));
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                let Some(c) = self.decide(&block.triangle(lane)) else { continue };
                let slot = self.slot(at + lane);
                if Place::accepts(&c, slot, self.t_min, best, observer) {
                    let triangle = self.tree.triangles.get(slot);
                    let triangle = triangle.ok_or_else(|| out_of_range(slot, self.tree.triangles.len()))?;
                    self.place.take(c, triangle, slot, best);
                    if ANY {
                        return Ok(true);
                    }
                }
            }
            (at, left) = (at + some, left - some);
        }
        Ok(false)
    }

    /// At most so many triangles of a leaf, from a reference on, that stand side by side in the tree, as those of a leaf usually do.
    #[inline(always)]
    fn run(&self, at: usize, most: usize) -> Result<&'a [TriangleRecord], Malformed> {
        let (slot, triangles) = (self.slot(at), self.tree.triangles);
        let mut count = 1;
        while count < most && self.slot(at + count) == slot.wrapping_add(count) {
            count += 1;
        }
        let run = triangles.get(slot..).and_then(|t| t.get(..count));
        run.ok_or_else(|| out_of_range(slot, triangles.len()))
    }

    /// Which triangle of the tree a reference is.
    #[inline(always)]
    fn slot(&self, reference: usize) -> usize {
        self.tree.order.get(reference).map_or(usize::MAX, |slot| *slot as usize)
    }

    #[inline(always)]
    fn decide(&self, triangle: &TriangleRecord) -> Option<Crossing> {
        match self.test.axis() {
            0 => self.test.decide::<0>(triangle),
            1 => self.test.decide::<1>(triangle),
            _ => self.test.decide::<2>(triangle),
        }
    }
}

#[cold]
#[inline(never)]
fn out_of_range(slot: usize, refs: usize) -> Malformed {
    Malformed::LeafOutOfRange { first: slot as u32, count: 1, refs }
}

#[cold]
fn too_deep() -> Result<bool, Malformed> {
    Err(Malformed::TooDeep)
}
