//! Closest hit and any hit over a [`View`].

use super::hit::{Best, Hit, Malformed};
use super::intersect::EdgeRay;
use super::observe::{Fault, NoObserver, Observer, makes};
use super::place::Place;
use super::slab::{Conservative, Rule, Slabs};
use super::source::{Records, Source, Tree};
use super::test::TriangleTest;
use crate::cache::{BlasView, TriangleRecord, View};
use crate::geom::{Aabb, Ray};
use crate::layout::MAX_DEPTH;
use std::borrow::Borrow;

/// The nearest point where the ray meets the scene with `t_min <= t <= t_max`, both sides of a triangle alike.
///
/// Among hits of equal distance the one of smallest (instance, geometry, primitive) wins, whatever the tree. A ray with a NaN, infinite
/// or zero direction, or a NaN anywhere, meets nothing, and distances beyond 2¹²⁶ do not count.
///
/// # Errors
/// Where the walk comes upon records that are no tree, which a miss must not be taken for. A file that was opened at
/// [`Validation::Tree`](crate::cache::Validation::Tree) has none such, nor has what was built.
pub fn closest_hit(view: &View<'_>, ray: &Ray) -> Result<Option<Hit>, Malformed> {
    try_closest_hit(view, ray, &mut NoObserver)
}

/// Whether the ray meets anything with `t_min <= t <= t_max`: the question of a shadow ray, which ends at the first triangle
/// found.
///
/// # Errors
/// As [`closest_hit`].
pub fn any_hit(view: &View<'_>, ray: &Ray) -> Result<bool, Malformed> {
    try_any_hit(view, ray, &mut NoObserver)
}

/// [`closest_hit`] with an observer that counts.
///
/// # Errors
/// As [`closest_hit`].
pub fn try_closest_hit(view: &View<'_>, ray: &Ray, observer: &mut impl Observer) -> Result<Option<Hit>, Malformed> {
    trace::<false, EdgeRay, Conservative, _>(view, ray, observer)
}

/// [`any_hit`] with an observer that counts.
///
/// # Errors
/// As [`closest_hit`].
pub fn try_any_hit(view: &View<'_>, ray: &Ray, observer: &mut impl Observer) -> Result<bool, Malformed> {
    Ok(trace::<true, EdgeRay, Conservative, _>(view, ray, observer)?.is_some())
}

/// 2¹²⁶. Beyond, a ray parallel to a slab could not be told from one that reaches it late.
pub const FARTHEST: f32 = f32::from_bits((127 + 126) << 23);

/// Closest hit, or with `ANY` the first one found, by the triangle test `T` and the box test under rule `R`.
pub fn trace<const ANY: bool, T: TriangleTest, R: Rule, O: Observer>(
    view: &View<'_>,
    ray: &Ray,
    observer: &mut O,
) -> Result<Option<Hit>, Malformed> {
    let mut stack = Stack::new();
    through_levels::<T, R, O>(view, ray, observer, |reached, origin, direction, best, observer| {
        let tree = Records { nodes: reached.tree.nodes, items: reached.tree.triangles };
        let bottom = Bottom { tree, place: reached.place };
        bottom.trace::<ANY, T, R>(origin, direction, ray.t_min, best, &mut stack, observer)
    })
}

/// A tree over triangles that a ray has come to.
pub struct Reached<'a> {
    /// Number of its row in `BLAS`.
    pub blas: usize,
    pub tree: BlasView<'a>,
    pub place: Place,
}

/// Bring a ray to each tree over triangles that it may meet, mapped into the tree's space, until `tree` says that it is enough.
#[inline(always)]
pub fn through_levels<'a, T: TriangleTest, R: Rule, O: Observer>(
    view: &View<'a>,
    ray: &Ray,
    observer: &mut O,
    mut tree: impl FnMut(Reached<'a>, [f64; 3], [f64; 3], &mut Best, &mut O) -> Result<bool, Malformed>,
) -> Result<Option<Hit>, Malformed> {
    if !is_usable(ray) {
        return Ok(None);
    }
    let mut best = Best::none_until(ray.t_max.min(FARTHEST));
    let (origin, direction) = (wide(ray.origin), wide(ray.direction));
    if view.tlas_nodes.is_empty() {
        if !view.blases.is_empty() {
            let one = view.blas(0).ok_or(Malformed::BlasOutOfRange { instance: 0, blas: 0 })?;
            let place = Place { first_triangle: view.blases[0].ref_offset as usize, instance: None };
            tree(Reached { blas: 0, tree: one, place }, origin, direction, &mut best, observer)?;
        }
    } else {
        let slabs = slabs_for::<R, _>(observer, origin, direction, &view.tlas_nodes[0].bounds(), ray.t_min);
        let mut top_stack = Stack::new();
        walk(
            &Records { nodes: view.tlas_nodes, items: view.instances },
            &slabs,
            &mut best,
            &mut top_stack,
            observer,
            |start, some, best, observer| {
                for (i, instance) in some.iter().enumerate() {
                    let (index, blas) = (start + i, instance.blas as usize);
                    let one =
                        view.blas(blas).ok_or(Malformed::BlasOutOfRange { instance: index, blas: instance.blas })?;
                    let first_triangle = view.blases[blas].ref_offset as usize;
                    let (origin, direction) = T::to_object(instance, origin, direction);
                    let place = Place { first_triangle, instance: Some(instance.id) };
                    observer.instance();
                    observer.enter(index);
                    if tree(Reached { blas, tree: one, place }, origin, direction, best, observer)? {
                        return Ok(true);
                    }
                    observer.leave();
                }
                Ok(false)
            },
        )?;
    }
    Ok(best.hit)
}

/// Written out: mapping an array is a call where it stands in code for wider vectors.
#[inline(always)]
fn wide([x, y, z]: [f32; 3]) -> [f64; 3] {
    [f64::from(x), f64::from(y), f64::from(z)]
}

/// Whether a ray may meet anything.
#[inline(always)]
pub fn is_usable(ray: &Ray) -> bool {
    // Zeros unless one of them is infinite or NaN: one question instead of six.
    let ([a, b, c], [d, e, f]) = (ray.origin, ray.direction);
    (a * 0.0 + b * 0.0) + (c * 0.0 + d * 0.0) + (e * 0.0 + f * 0.0) == 0.0
        && ray.direction != [0.0; 3]
        && ray.t_min <= ray.t_max
}

/// A tree over triangles under traversal.
pub struct Bottom<T> {
    pub tree: T,
    pub place: Place,
}

impl<S> Bottom<S>
where
    S: Tree<Source: Source<Items: IntoIterator<Item: Borrow<TriangleRecord>>>>,
{
    /// Improve `best`; with `ANY`, true as soon as something is hit.
    pub fn trace<const ANY: bool, T: TriangleTest, R: Rule>(
        &self,
        origin: [f64; 3],
        direction: [f64; 3],
        t_min: f32,
        best: &mut Best,
        stack: &mut Stack,
        observer: &mut impl Observer,
    ) -> Result<bool, Malformed> {
        let Some(root) = self.tree.root() else { return Ok(false) };
        let test = T::new(origin, direction);
        let slabs = slabs_for::<R, _>(observer, origin, direction, &root.borrow().bounds(), t_min);
        match test.axis() {
            0 => self.trace_along::<ANY, 0, T, R>(&test, &slabs, t_min, best, stack, observer),
            1 => self.trace_along::<ANY, 1, T, R>(&test, &slabs, t_min, best, stack, observer),
            _ => self.trace_along::<ANY, 2, T, R>(&test, &slabs, t_min, best, stack, observer),
        }
    }

    fn trace_along<const ANY: bool, const AXIS: usize, T: TriangleTest, R: Rule>(
        &self,
        test: &T,
        slabs: &Slabs<R>,
        t_min: f32,
        best: &mut Best,
        stack: &mut Stack,
        observer: &mut impl Observer,
    ) -> Result<bool, Malformed> {
        let t_min = f64::from(t_min);
        walk(&self.tree, slabs, best, stack, observer, |start, triangles, best, observer| {
            for (i, triangle) in triangles.into_iter().enumerate() {
                let triangle = triangle.borrow();
                observer.triangle();
                if let Some(c) = test.crossing::<AXIS>(triangle)
                    && self.place.offer(c, triangle, start + i, t_min, best, observer)
                    && ANY
                {
                    return Ok(true);
                }
            }
            Ok(false)
        })
    }
}

/// A node put off: its entry distance and its record.
#[derive(Clone, Copy)]
struct Pending {
    near: f32,
    node: u32,
}

/// One far child a level, and no leaf lies deeper than [`MAX_DEPTH`].
pub struct Stack {
    entries: [Pending; STACK],
}

const STACK: usize = MAX_DEPTH as usize;

impl Stack {
    #[inline(always)]
    pub fn new() -> Stack {
        Stack { entries: [Pending { near: 0.0, node: 0 }; STACK] }
    }
}

/// Visit the leaves that the ray meets, near child first, until `leaf` says that it is enough.
///
/// `leaf` gets the number of its first item and its items. The walk ends on every input: see [`Bounds`](super::bounds::Bounds).
#[inline(always)]
pub fn walk<S: Tree, R: Rule, O: Observer>(
    tree: &S,
    slabs: &Slabs<R>,
    best: &mut Best,
    stack: &mut Stack,
    observer: &mut O,
    mut leaf: impl FnMut(usize, <S::Source as Source>::Items, &mut Best, &mut O) -> Result<bool, Malformed>,
) -> Result<bool, Malformed> {
    let Some(root) = tree.root() else { return Ok(false) };
    let root = root.borrow();
    let met = slabs.meets(root, best.limit);
    observer.root(met);
    if !met {
        return Ok(false);
    }
    let (mut reach, mut farthest) = (slabs.reach(best.limit), R::widened(best.limit));
    let (mut first, mut count) = (root.first, root.count);
    let mut depth = 0;
    let mut source = tree.source();
    loop {
        if count == 0 {
            // Enter an inner node: test both children, go on with the nearer and put the other off.
            observer.inner_node();
            let pair = source.enter(first)?;
            let pair = pair.borrow();
            let (mut near, hits) = slabs.pair(pair, reach);
            if makes(observer, Fault::Order) {
                near.swap(0, 1);
            }
            observer.pair(first, near, hits);
            // Asked bit by bit: a choice of four at once would become a jump through a table.
            if hits & 0b01 != 0 {
                if hits & 0b10 == 0 {
                    (first, count) = (pair[0].first, pair[0].count);
                    continue;
                }
                if depth >= STACK {
                    return too_deep();
                }
                if near[1] < near[0] {
                    keep_branch();
                    stack.entries[depth] = Pending { near: near[0], node: first };
                    (first, count) = (pair[1].first, pair[1].count);
                } else {
                    stack.entries[depth] = Pending { near: near[1], node: first + 1 };
                    (first, count) = (pair[0].first, pair[0].count);
                }
                depth += 1;
                continue;
            }
            if hits & 0b10 != 0 {
                keep_branch();
                (first, count) = (pair[1].first, pair[1].count);
                continue;
            }
        } else {
            let items = source.leaf(first, count)?;
            if leaf(first as usize, items, best, observer)? {
                return Ok(true);
            }
            (reach, farthest) = (slabs.reach(best.limit), R::widened(best.limit));
        }

        // Take up the next node that is not behind the best hit. No depth is beyond the stack, which the remainder tells the compiler.
        loop {
            if depth == 0 {
                return Ok(false);
            }
            depth -= 1;
            let pending = stack.entries[depth % STACK];
            observer.resume(pending.node, pending.near, !(pending.near <= farthest));
            if pending.near <= farthest {
                (first, count) = source.links(pending.node)?;
                break;
            }
        }
    }
}

/// The ray made ready for the boxes of one tree.
#[inline(always)]
pub fn slabs_for<R: Rule, O: Observer>(
    observer: &O,
    origin: [f64; 3],
    direction: [f64; 3],
    bounds: &Aabb,
    t_min: f32,
) -> Slabs<R> {
    let slabs = Slabs::<R>::new(origin, direction, bounds, t_min);
    if makes(observer, Fault::SignOfZero) { slabs.entering_by_sign(direction) } else { slabs }
}

/// Keep the compiler from turning the branch that this stands in into a choice of values. Processors guess branches and
/// load the next pair while the test still runs; a choice waits for it.
#[inline(always)]
fn keep_branch() {
    std::sync::atomic::compiler_fence(std::sync::atomic::Ordering::SeqCst);
}

#[cold]
fn too_deep() -> Result<bool, Malformed> {
    Err(Malformed::TooDeep)
}
