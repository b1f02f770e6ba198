//! Traversal of a tree whose subtrees may lie along axes of their own.
//!
//! A ray is turned where it comes to such a subtree: its origin and direction become coordinates along the axes, and its `t` stays. Triangles are tested
//! as they are, by the ray as it is, so hits are those of the tree along the axes of the scene, to the last bit.
//!
//! No turned box rejects what the triangle test accepts. Write `u = 2⁻⁵³`, `P` for the largest coordinate of the tree's root and `O` for that of
//! the ray's origin. Rows of axes have length 1, up to 2⁻²⁰ or so, so products of a vector with them are at most √3 times its largest coordinate. A
//! coordinate is three exact products and two sums in `f64`: the origin's is off by `2.01u · √3 · O`, and `t` times the direction's by
//! `2.01u · √3 · (P + O)`, since a ray that hits at `t` went at most `P + O` along each axis. What `f64` loses in the triangle test is at most
//! `2u · (P + O)` an axis ([`slab`](super::slab)), which turned is √3 times as much. Together that is below `16u · (P + O)`, or
//! 2⁻⁴⁹ of the coordinates. The slabs move the origin apart by 2⁻⁴⁸ of what they are told to be the largest coordinate in play, and are told
//! `2 · (P + O)`: four times as much. The turned numbers are then a ray like one that an instance maps. Boxes hold their triangles exactly
//! ([`Polygon::along`](crate::geom::clip::Polygon::along)). That a turned direction has a component of another sign, or none, where exact arithmetic
//! has a tiny one, is in this too: the bound is on where the ray is, and not on the direction.
//!
//! Coordinates beyond 2¹²⁰ might leave the range of `f32` when they are turned. Then the tree along the axes of the scene is walked.

use super::batch::answer_all;
use super::bounds::Bounds;
use super::hit::{BatchError, Best, Hit, Malformed};
use super::intersect::EdgeRay;
use super::observe::{NoObserver, Observer};
use super::place::Place;
use super::slab::{Conservative, Rule, Slabs};
use super::test::TriangleTest;
use super::traverse::{self, FARTHEST, is_usable};
use crate::exec::Executor;
use crate::geom::vector::dot;
use crate::geom::{Aabb, Ray, round_up};
use crate::layout::{BlasView, MAX_DEPTH, NEST, Node, TriangleRecord, TurnRecord, View, marks_of};
use crate::refit::{Held, turned_nodes};

/// 2¹²⁰.
const LARGEST: f32 = f32::from_bits((127 + 120) << 23);

/// A scene of one tree with its turned subtrees, whatever they are stored in.
#[derive(Clone, Copy, Debug)]
pub struct TurnedView<'a> {
    /// The tree along the axes of the scene.
    pub view: View<'a>,
    /// The turned subtrees, in the order of their nodes.
    pub rows: &'a [TurnRecord],
    /// Their nodes.
    pub nodes: &'a [Node],
    /// [`marks_of`](crate::layout::marks_of) the rows.
    pub marks: &'a [u64],
}

/// The turned subtrees of a tree, in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Turns {
    /// `OROW`.
    pub rows: Vec<TurnRecord>,
    /// `ONOD`.
    pub nodes: Vec<Node>,
    marks: Vec<u64>,
}

impl Turns {
    /// Fit boxes to what is below some nodes of a tree. Rows state axes, `first` and `end` alone, in ascending order of `first`; where their nodes begin
    /// is put into them.
    ///
    /// `None` where rows name what is not below a node of the tree.
    pub fn new(tree: &BlasView<'_>, mut rows: Vec<TurnRecord>, exec: &Executor) -> Option<Turns> {
        let (mut outer, mut next): (Option<TurnRecord>, u32) = (None, 0);
        for row in &mut rows {
            match outer.filter(|outer| outer.holds(row)) {
                Some(outer) => row.node_offset = outer.node_offset + (row.first - outer.first),
                None => {
                    row.node_offset = next;
                    next = next.checked_add(row.end.checked_sub(row.first)?)?;
                    outer = Some(*row);
                }
            }
        }
        let (nodes, marks) = (turned_nodes(tree, &rows, Held::Part, exec)?, marks_of(&rows, tree.nodes.len()));
        Some(Turns { rows, nodes, marks })
    }

    /// With the scene that they are of.
    pub fn view<'a>(&'a self, of: &View<'a>) -> TurnedView<'a> {
        TurnedView { view: *of, rows: &self.rows, nodes: &self.nodes, marks: &self.marks }
    }
}

impl<'a> TurnedView<'a> {
    /// The nearest hit, which is that of [`closest_hit`](super::closest_hit) to the last bit; only the [record](Hit::triangle) of a triangle that stands
    /// in several leaves may be another one of it.
    ///
    /// # Errors
    /// As [`closest_hit`](super::closest_hit), and where rows lead out of the records.
    pub fn closest_hit(&self, ray: &Ray) -> Result<Option<Hit>, Malformed> {
        self.trace::<false, _>(ray, &mut NoObserver)
    }

    /// Whether the ray meets anything.
    ///
    /// # Errors
    /// As [`TurnedView::closest_hit`].
    pub fn any_hit(&self, ray: &Ray) -> Result<bool, Malformed> {
        Ok(self.trace::<true, _>(ray, &mut NoObserver)?.is_some())
    }

    /// The nearest hit of each of many rays, shared among the threads of `exec`.
    ///
    /// # Errors
    /// As [`View::closest_hits`].
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>], exec: &Executor) -> Result<(), BatchError> {
        answer_all(rays, hits, exec, |ray| self.closest_hit(ray))
    }

    /// Closest hit, or with `ANY` the first one found, with an observer that counts. Nodes and slots that it is told of are those of the tree.
    ///
    /// # Errors
    /// As [`TurnedView::closest_hit`].
    pub fn trace<const ANY: bool, O: Observer>(&self, ray: &Ray, observer: &mut O) -> Result<Option<Hit>, Malformed> {
        let Some(walk) = Walk::new(self, ray)? else {
            return traverse::trace::<ANY, EdgeRay, Conservative, O>(&self.view, ray, observer);
        };
        let test = EdgeRay::new(walk.origin, walk.direction);
        let mut best = Best::none_until(ray.t_max.min(FARTHEST));
        match test.axis() {
            0 => walk.run::<ANY, 0, O>(&test, &mut best, observer)?,
            1 => walk.run::<ANY, 1, O>(&test, &mut best, observer)?,
            _ => walk.run::<ANY, 2, O>(&test, &mut best, observer)?,
        };
        Ok(best.hit)
    }
}

/// A ray on its way.
struct Walk<'a> {
    of: &'a TurnedView<'a>,
    tree: BlasView<'a>,
    place: Place,
    origin: [f64; 3],
    direction: [f64; 3],
    t_min: f32,
    /// Twice the largest coordinates in play, as a box.
    reach: Aabb,
}

/// The ray in the coordinates of a subtree, and the subtree's records.
#[derive(Clone, Copy)]
struct Frame<'a> {
    slabs: Slabs<Conservative>,
    nodes: &'a [Node],
    /// The record of the tree whose twin is the first of them.
    first: u32,
}

impl<'a> Frame<'a> {
    #[inline(always)]
    fn pair(&self, first: u32) -> Result<&'a [Node; 2], Malformed> {
        let own = first.wrapping_sub(self.first) as usize;
        let pair = self.nodes.get(own..).and_then(|nodes| nodes.first_chunk::<2>());
        pair.ok_or(Malformed::ChildOutOfRange { first, nodes: self.nodes.len() })
    }

    #[inline(always)]
    fn links(&self, index: u32) -> Result<(u32, u32), Malformed> {
        let node = self.nodes.get(index.wrapping_sub(self.first) as usize);
        let node = node.ok_or(Malformed::ChildOutOfRange { first: index, nodes: self.nodes.len() })?;
        Ok((node.first, node.count))
    }
}

/// A node put off: where the ray enters it, its record, and how deep the turns lie in one another that it was come to by.
#[derive(Clone, Copy)]
struct Pending {
    near: f32,
    node: u32,
    turns: u32,
}

impl<'a> Walk<'a> {
    /// `None` where the tree along the axes of the scene must do.
    fn new(of: &'a TurnedView<'a>, ray: &Ray) -> Result<Option<Walk<'a>>, Malformed> {
        let view = &of.view;
        if !is_usable(ray) || !view.tlas_nodes.is_empty() || view.blases.is_empty() || of.rows.is_empty() {
            return Ok(None);
        }
        let tree = view.blas(0).ok_or(Malformed::BlasOutOfRange { instance: 0, blas: 0 })?;
        let Some(root) = tree.nodes.first() else { return Ok(None) };
        let most = |values: &[f32]| values.iter().fold(0.0f32, |most, v| most.max(v.abs()));
        let (plane, coordinate) = (most(&root.min).max(most(&root.max)), most(&ray.origin));
        // Written so that NaN is refused too.
        if !(plane <= LARGEST && coordinate <= LARGEST) {
            return Ok(None);
        }
        let reach = round_up(2.0 * (f64::from(plane) + f64::from(coordinate)));
        Ok(Some(Walk {
            of,
            tree,
            place: Place { first_triangle: view.blases[0].ref_offset as usize, instance: None },
            origin: ray.origin.map(f64::from),
            direction: ray.direction.map(f64::from),
            t_min: ray.t_min,
            reach: Aabb { min: [-reach; 3], max: [reach; 3] },
        }))
    }

    /// The ray turned for the subtree that begins with a pair.
    fn turned(&self, first: u32) -> Result<Frame<'a>, Malformed> {
        let lost = Malformed::ChildOutOfRange { first, nodes: self.of.nodes.len() };
        let Ok(place) = self.of.rows.binary_search_by_key(&first, |row| row.first) else { return Err(lost) };
        let row = &self.of.rows[place];
        let (start, count) = (row.node_offset as usize, row.end.saturating_sub(row.first) as usize);
        let nodes = self.of.nodes.get(start..).and_then(|nodes| nodes.get(..count)).ok_or(lost)?;
        let axes = row.axes.map(|axis| axis.map(f64::from));
        let [origin, direction] = [self.origin, self.direction].map(|v| axes.map(|axis| dot(axis, v)));
        Ok(Frame { slabs: Slabs::new(origin, direction, &self.reach, self.t_min), nodes, first })
    }

    #[inline(always)]
    fn is_turned(&self, first: u32) -> bool {
        let pair = first / 2;
        self.of.marks.get(pair as usize / 64).is_some_and(|word| word >> (pair % 64) & 1 != 0)
    }

    /// As `traverse::walk`, with a ray for each turn that the walk is in.
    fn run<const ANY: bool, const AXIS: usize, O: Observer>(
        &self,
        test: &EdgeRay,
        best: &mut Best,
        observer: &mut O,
    ) -> Result<bool, Malformed> {
        let tree = &self.tree;
        let Some(root) = tree.nodes.first() else { return Ok(false) };
        let slabs = Slabs::<Conservative>::new(self.origin, self.direction, &root.bounds(), self.t_min);
        let met = slabs.meets(root, best.limit);
        observer.root(met);
        if !met {
            return Ok(false);
        }
        let mut frames = [Frame { slabs, nodes: tree.nodes, first: 0 }; NEST + 1];
        let mut turns = 0usize;
        let mut stack = [Pending { near: 0.0, node: 0, turns: 0 }; MAX_DEPTH as usize];
        let mut depth = 0usize;
        // Ends the walk on every input: each step in is counted against the tree's own records.
        let mut bounds = Bounds::new(tree.nodes, tree.triangles);
        let (mut reach, mut farthest) = (slabs.reach(best.limit), Conservative::widened(best.limit));
        let (mut first, mut count) = (root.first, root.count);
        loop {
            if count == 0 {
                observer.inner_node();
                bounds.enter(first)?;
                if self.is_turned(first) {
                    turns += 1;
                    let frame = frames.get_mut(turns).ok_or(Malformed::TooDeep)?;
                    *frame = self.turned(first)?;
                    observer.turn();
                }
                let frame = &frames[turns];
                let pair = frame.pair(first)?;
                let (near, hits) = frame.slabs.pair(pair, reach);
                observer.pair(first, near, hits);
                let nearer = match hits {
                    0b01 => Some(0),
                    0b10 => Some(1),
                    0b11 => {
                        let nearer = usize::from(near[1] < near[0]);
                        let put_off = stack.get_mut(depth).ok_or(Malformed::TooDeep)?;
                        let node = first + (1 - nearer as u32);
                        *put_off = Pending { near: near[1 - nearer], node, turns: turns as u32 };
                        depth += 1;
                        Some(nearer)
                    }
                    _ => None,
                };
                if let Some(nearer) = nearer {
                    (first, count) = (pair[nearer].first, pair[nearer].count);
                    continue;
                }
            } else {
                let triangles = bounds.leaf(first, count)?;
                if self.leaf::<ANY, AXIS, O>(test, first as usize, triangles, best, observer) {
                    return Ok(true);
                }
                (reach, farthest) = (slabs.reach(best.limit), Conservative::widened(best.limit));
            }

            // Take up the next node that is not behind the best hit. What is put off within a turn is taken up before the turn is left, so the
            // ray of each turn above is still there.
            loop {
                if depth == 0 {
                    return Ok(false);
                }
                depth -= 1;
                let pending = stack[depth];
                observer.resume(pending.node, pending.near, !(pending.near <= farthest));
                if pending.near <= farthest {
                    turns = pending.turns as usize;
                    (first, count) = frames[turns].links(pending.node)?;
                    break;
                }
            }
        }
    }

    fn leaf<const ANY: bool, const AXIS: usize, O: Observer>(
        &self,
        test: &EdgeRay,
        start: usize,
        triangles: &[TriangleRecord],
        best: &mut Best,
        observer: &mut O,
    ) -> bool {
        let t_min = f64::from(self.t_min);
        for (i, triangle) in triangles.iter().enumerate() {
            observer.triangle();
            if let Some(c) = test.crossing::<AXIS>(triangle)
                && self.place.offer(c, triangle, start + i, t_min, best, observer)
                && ANY
            {
                return true;
            }
        }
        false
    }
}
