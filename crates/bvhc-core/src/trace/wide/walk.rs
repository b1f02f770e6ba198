//! A ray's walk through wide trees.

use super::boxes::WideSlabs;
use super::record::WideRecord;
use super::scene::{WideTree, WideView};
use crate::geom::Ray;
use crate::layout::TriangleRecord;
use crate::simd::{Floats, Work};
use crate::trace::bounds::Bounds;
use crate::trace::hit::{Best, Hit, Malformed};
use crate::trace::intersect::EdgeRay;
use crate::trace::observe::Observer;
use crate::trace::place::Place;
use crate::trace::slab::{Conservative, Rule, Slabs};
use crate::trace::test::TriangleTest;
use crate::trace::traverse::through_levels;

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
                let test = EdgeRay::new(origin, direction);
                let slabs = Slabs::<Conservative>::new(origin, direction, &root.bounds(), ray.t_min);
                let walk = Walk::<V, N, T> {
                    door,
                    slabs: WideSlabs::new(door, &slabs),
                    test: &test,
                    t_min: f64::from(ray.t_min),
                    place: reached.place,
                    tree: &tree,
                };
                if tree.waiting as usize <= USUAL {
                    walk.go::<ANY, USUAL, O>(best, observer)
                } else {
                    walk.go::<ANY, MOST, O>(best, observer)
                }
            },
        )
    }
}

/// Children that may wait at once where nothing odd was built. Filling a longer stack with zeros would be felt by each ray.
const USUAL: usize = 96;
/// In any tree: seven of each level that a binary tree may have, and all of the node that is entered.
const MOST: usize = 7 * crate::layout::MAX_DEPTH as usize + 8;

/// A child put off, or taken up: its entry distance and its links.
#[derive(Clone, Copy, Default)]
struct Pending {
    near: f32,
    first: u32,
    count: u32,
}

/// The next child of those that a ray meets, by their bits.
#[inline(always)]
fn next_met<const N: usize>(node: &impl WideRecord<N>, near: &[f32; N], met: &mut u32) -> Option<Pending> {
    while *met != 0 {
        let lane = met.trailing_zeros() as usize % N;
        *met &= *met - 1;
        if let Some((first, count)) = node.links(lane) {
            return Some(Pending { near: near[lane], first, count });
        }
    }
    None
}

/// A ray at one tree.
struct Walk<'a, V: Floats<N>, const N: usize, T> {
    door: V::Door,
    slabs: WideSlabs<V, N>,
    test: &'a EdgeRay,
    t_min: f64,
    place: Place,
    tree: &'a WideTree<'a, T>,
}

impl<V: Floats<N>, const N: usize, T: WideRecord<N>> Walk<'_, V, N, T> {
    #[inline(always)]
    fn go<const ANY: bool, const STACK: usize, O: Observer>(
        &self,
        best: &mut Best,
        observer: &mut O,
    ) -> Result<bool, Malformed> {
        match self.test.axis() {
            0 => self.along::<ANY, STACK, 0, O>(best, observer),
            1 => self.along::<ANY, STACK, 1, O>(best, observer),
            _ => self.along::<ANY, STACK, 2, O>(best, observer),
        }
    }

    /// Visit the leaves that the ray meets, the nearest child of each node first, among equals the first.
    #[inline(always)]
    fn along<const ANY: bool, const STACK: usize, const AXIS: usize, O: Observer>(
        &self,
        best: &mut Best,
        observer: &mut O,
    ) -> Result<bool, Malformed> {
        let mut bounds = Bounds::of_wide(self.tree.nodes, self.tree.triangles);
        let mut stack = [Pending::default(); STACK];
        let mut height = 0;
        let mut farthest = Conservative::widened(best.limit);
        let mut end = V::splat(self.door, -farthest);
        let (mut first, mut count) = (0, 0);
        loop {
            if count == 0 {
                observer.inner_node();
                let node = bounds.enter_wide(first)?;
                let (near, mut met) = self.slabs.test(self.door, node, end);
                // A ray meets one or two children of most nodes: one is entered at once, and of two the farther one waits.
                if let Some(mut nearest) = next_met(node, &near, &mut met) {
                    let base = height;
                    while let Some(child) = next_met(node, &near, &mut met) {
                        let is_nearer = child.near < nearest.near;
                        let waits = if is_nearer { nearest } else { child };
                        nearest = if is_nearer { child } else { nearest };
                        if height >= STACK {
                            return too_deep();
                        }
                        // The nearest on top, and of equals the first: one that was the nearest comes before its equals, another after them.
                        let mut at = height;
                        while at > base
                            && (stack[at - 1].near < waits.near || (!is_nearer && stack[at - 1].near == waits.near))
                        {
                            stack[at] = stack[at - 1];
                            at -= 1;
                        }
                        stack[at] = waits;
                        height += 1;
                    }
                    (first, count) = (nearest.first, nearest.count);
                    continue;
                }
            } else {
                let items = bounds.leaf(first, count)?;
                if self.leaf::<ANY, AXIS, O>(first as usize, items, best, observer)? {
                    return Ok(true);
                }
                farthest = Conservative::widened(best.limit);
                end = V::splat(self.door, -farthest);
            }

            // Take up the next child that is not behind the best hit. No height is beyond the stack, which the remainder tells the compiler.
            loop {
                if height == 0 {
                    return Ok(false);
                }
                height -= 1;
                let next = stack[height % STACK];
                if next.near <= farthest {
                    (first, count) = (next.first, next.count);
                    break;
                }
            }
        }
    }

    /// The triangles of a leaf, four at a time: most misses are proved for all four at once.
    #[inline(always)]
    fn leaf<const ANY: bool, const AXIS: usize, O: Observer>(
        &self,
        start: usize,
        triangles: &[TriangleRecord],
        best: &mut Best,
        observer: &mut O,
    ) -> Result<bool, Malformed> {
        for (number, group) in triangles.chunks(4).enumerate() {
            let (first, last) = (start + 4 * number, group.len() - 1);
            group.iter().for_each(|_| observer.triangle());
            let mut some = [&group[0], &group[1.min(last)], &group[2.min(last)], &group[last]];
            if T::ORDERED {
                for lane in 0..4 {
                    let slot = self.slot(first + lane.min(last));
                    some[lane] = self.tree.triangles.get(slot).ok_or(Malformed::LeafOutOfRange {
                        first: slot as u32,
                        count: 1,
                        refs: self.tree.triangles.len(),
                    })?;
                }
            }
            let mut left = self.test.may_cross::<AXIS>(some) & ((1 << group.len()) - 1);
            while left != 0 {
                let lane = left.trailing_zeros() as usize % 4;
                left &= left - 1;
                if let Some(c) = self.test.decide::<AXIS>(some[lane]) {
                    let slot = self.slot(first + lane);
                    if self.place.offer(c, some[lane], slot, self.t_min, best, observer) && ANY {
                        return Ok(true);
                    }
                }
            }
        }
        Ok(false)
    }

    /// Which triangle of the tree a reference is.
    #[inline(always)]
    fn slot(&self, reference: usize) -> usize {
        if T::ORDERED { self.tree.order.get(reference).map_or(usize::MAX, |slot| *slot as usize) } else { reference }
    }
}

#[cold]
fn too_deep() -> Result<bool, Malformed> {
    Err(Malformed::TooDeep)
}
