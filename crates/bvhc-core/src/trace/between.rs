//! Rays between two frames: the walk of still files over nodes and triangles that are interpolated when the walk comes to them.
//!
//! Nothing is added to boxes for that. A box and the vertices in it are interpolated by the same expression, which keeps their order to the bit
//! ([`Mix`]), so at any time a box contains the rounded vertices below it, as a stored box does; and the walk and the triangle test see no
//! difference. The top level has boxes that hold an instance at all times.

use super::bounds::Bounds;
use super::hit::{BatchError, Best, Hit, Malformed};
use super::intersect::EdgeRay;
use super::observe::NoObserver;
use super::slab::Conservative;
use super::source::{Records, Source, Tree};
use super::traverse::{Bottom, FARTHEST, Stack, is_usable, slabs_for, walk};
use crate::cache::{Between, BetweenInstance, BetweenTree, TriangleRecord};
use crate::exec::Executor;
use crate::geom::vector::{cross, dot, sub};
use crate::geom::{Affine, Mix, Ray};
use crate::layout::{IndexedTriangleRecord, Node};
use crate::simd::Register;

/// Rays of one task: enough to outweigh its start, few enough that threads end together.
const CHUNK: usize = 1 << 10;

impl Between<'_> {
    /// The nearest point where the ray meets the scene at that time: a fraction from 0, at the first frame, to 1, at the second.
    ///
    /// At 0 and at 1 hits are those of the frames, bit for bit. [`Hit::geom`] is a row of [`Sequence::geoms`](crate::cache::Frames::geoms), and
    /// [`Hit::triangle`] an index into [`Sequence::indexed_triangles`](crate::cache::Frames::indexed_triangles), so hits of all times can be compared; a
    /// [`Frame`](crate::cache::Frame) numbers its own.
    ///
    /// At another time than from 0 to 1, and at NaN, nothing is met: it belongs to other frames. An instance that goes through a plane between the
    /// frames, as one that turns by half does, is not met at the times when its matrix has no inverse: those at which the determinant is
    /// below 2⁻³² of the terms that it is summed from.
    ///
    /// # Errors
    /// As [`closest_hit`](super::closest_hit).
    pub fn closest_hit(&self, ray: &Ray, fraction: f32) -> Result<Option<Hit>, Malformed> {
        trace::<false>(self, ray, fraction)
    }

    /// Whether the ray meets anything at that time; see [`Between::closest_hit`].
    ///
    /// # Errors
    /// As [`closest_hit`](super::closest_hit).
    pub fn any_hit(&self, ray: &Ray, fraction: f32) -> Result<bool, Malformed> {
        Ok(trace::<true>(self, ray, fraction)?.is_some())
    }

    /// The nearest hit of each of many rays, each at a time of its own, shared among the threads of `exec`; see [`Between::closest_hit`].
    ///
    /// `hits[i]` becomes the answer to `rays[i]`, so both have one length.
    ///
    /// # Errors
    /// As [`View::closest_hits`](crate::layout::View::closest_hits).
    pub fn closest_hits(
        &self,
        rays: &[(Ray, f32)],
        hits: &mut [Option<Hit>],
        exec: &Executor,
    ) -> Result<(), BatchError> {
        if rays.len() != hits.len() {
            return Err(BatchError::Lengths { rays: rays.len(), hits: hits.len() });
        }
        let chunks = exec.map_chunks_mut(hits, CHUNK, |chunk, some| {
            some.iter_mut().zip(&rays[chunk * CHUNK..]).try_for_each(|(hit, (ray, fraction))| {
                *hit = self.closest_hit(ray, *fraction)?;
                Ok(())
            })
        });
        chunks.into_iter().collect()
    }

    /// The normal of the triangle that a ray hit at that time, in world space and not of length 1; it points to the front, as that of
    /// [`Opened::normal`](crate::cache::Opened::normal). `None` for a hit in another file or at another time.
    pub fn normal(&self, hit: &Hit, fraction: f32) -> Option<[f64; 3]> {
        let mix = Mix::new(fraction)?;
        let instance = self.instances().get(self.instance_record(hit.instance?)?)?;
        let tree = self.tree(instance.tree as usize)?;
        let slot = hit.triangle.checked_sub(tree.first_triangle)?;
        let triangle = tree.at(tree.triangles.get(slot).filter(|t| t.geom == hit.geom)?, &mix);
        let [v0, v1, v2] = triangle.corners().map(|p| p.map(f64::from));
        let turn = if self.is_mirrored(hit.geom) { -1.0 } else { 1.0 };
        let n = cross(sub(v1, v0), sub(v2, v0)).map(|c| turn * c);
        // A normal goes into the world by the transposed inverse: the columns of the way back.
        let rows = instance.way_back(&mix)?.linear;
        Some([0, 1, 2].map(|i| rows[0][i] * n[0] + rows[1][i] * n[1] + rows[2][i] * n[2]))
    }
}

fn trace<const ANY: bool>(between: &Between<'_>, ray: &Ray, fraction: f32) -> Result<Option<Hit>, Malformed> {
    let Some(mix) = Mix::new(fraction).filter(|_| is_usable(ray)) else { return Ok(None) };
    let Some(root) = between.tlas_nodes().first() else { return Ok(None) };
    let mut best = Best::none_until(ray.t_max.min(FARTHEST));
    let (origin, direction) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
    let slabs = slabs_for::<Conservative, _>(&NoObserver, origin, direction, &root.bounds(), ray.t_min);
    let (mut top_stack, mut stack) = (Stack::new(), Stack::new());
    walk(
        &Records { nodes: between.tlas_nodes(), items: between.instances() },
        &slabs,
        &mut best,
        &mut top_stack,
        &mut NoObserver,
        |start, some, best, observer| {
            for (i, instance) in some.iter().enumerate() {
                let blas = instance.tree;
                let tree = between.tree(blas as usize);
                let tree = tree.ok_or(Malformed::BlasOutOfRange { instance: start + i, blas })?;
                let Some((origin, direction)) = instance.to_object(&mix, origin, direction) else { continue };
                let tree = tree.where_it_counts(&mix);
                let first_triangle = tree.first_triangle;
                let bottom = Bottom { tree: Moving { tree, mix }, first_triangle, instance: Some(instance.ends[0].id) };
                if bottom
                    .trace::<ANY, EdgeRay, Conservative>(origin, direction, ray.t_min, best, &mut stack, observer)?
                {
                    return Ok(true);
                }
            }
            Ok(false)
        },
    )?;
    Ok(best.hit)
}

/// The way of a ray into the space of an instance's tree: `linear · (p − from) + to`.
struct WayBack {
    linear: [[f64; 3]; 3],
    from: [f64; 3],
    to: [f64; 3],
}

impl BetweenInstance {
    /// Origin and direction of a ray in the space of the instance's tree at that time. `t` stays what it is, since nothing is normalised.
    ///
    /// The stored inverse serves at both ends, and at all times where the instance [stands](BetweenInstance::stands); between, the interpolated
    /// matrix is inverted in `f64`. `None` where it has no inverse: see [`Between::closest_hit`].
    #[inline]
    pub fn to_object(&self, mix: &Mix, origin: [f64; 3], direction: [f64; 3]) -> Option<([f64; 3], [f64; 3])> {
        let way = self.way_back(mix)?;
        let linear = |v: [f64; 3], r: usize| dot(way.linear[r], v);
        let origin = sub(origin, way.from);
        let origin = [0, 1, 2].map(|r| linear(origin, r) + way.to[r]);
        let direction = [0, 1, 2].map(|r| linear(direction, r));
        let usable = origin.iter().chain(&direction).all(|v| v.is_finite()) && direction != [0.0; 3];
        usable.then_some((origin, direction))
    }

    #[inline]
    fn way_back(&self, mix: &Mix) -> Option<WayBack> {
        let [first, second] = mix.weights();
        if self.stands() || first == 0.0 || second == 0.0 {
            let end = usize::from(first == 0.0);
            let [x, y, z] = Affine::from_f32(&self.ends[end].world_to_object).rows;
            let linear = [x, y, z].map(|[a, b, c, _]| [a, b, c]);
            return Some(WayBack { linear, from: [0.0; 3], to: [x[3], y[3], z[3]] });
        }
        let [x, y, z] = self.object_to_world(mix).rows;
        let linear = inverse([x, y, z].map(|[a, b, c, _]| [a, b, c]))?;
        Some(WayBack { linear, from: [x[3], y[3], z[3]], to: [0.0; 3] })
    }
}

/// The inverse of three rows, unless they are as good as flat: where the terms of the determinant cancel to 2⁻³² of themselves, what is
/// left of them is too rough to send a ray back by. The way of a ray may then be off by 2⁻¹⁸ of the distance to the instance and no more.
#[inline]
fn inverse(m: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let minor = |r0: usize, c0: usize, r1: usize, c1: usize| (m[r0][c0] * m[r1][c1], m[r0][c1] * m[r1][c0]);
    let (mut determinant, mut terms) = (0.0, 0.0);
    for c in 0..3 {
        let (p, q) = minor(1, (c + 1) % 3, 2, (c + 2) % 3);
        determinant += m[0][c] * (p - q);
        terms += m[0][c].abs() * (p.abs() + q.abs());
    }
    const FLAT: f64 = 1.0 / (1u64 << 32) as f64;
    // False for NaN too.
    if !(determinant.abs() > terms * FLAT) {
        return None;
    }
    let entry = |r: usize, c: usize| {
        let (p, q) = minor((c + 1) % 3, (r + 1) % 3, (c + 2) % 3, (r + 2) % 3);
        (p - q) / determinant
    };
    Some([0, 1, 2].map(|r| [0, 1, 2].map(|c| entry(r, c))))
}

impl<'a> BetweenTree<'a> {
    /// At a frame's own time, that frame alone: what the other has cannot even change the sign of a zero.
    #[inline(always)]
    fn where_it_counts(self, mix: &Mix) -> BetweenTree<'a> {
        let end = match mix.weights() {
            [_, 0.0] => 0,
            [0.0, _] => 1,
            _ => return self,
        };
        BetweenTree { nodes: [self.nodes[end]; 2], vertices: [self.vertices[end]; 2], ..self }
    }
}

/// A tree at a time between.
#[derive(Clone, Copy)]
struct Moving<'a> {
    tree: BetweenTree<'a>,
    mix: Mix,
}

/// A walk over it. Bounds and links are those of the first end.
struct MovingWalk<'a> {
    bounds: Bounds<'a, IndexedTriangleRecord>,
    moving: Moving<'a>,
}

impl Moving<'_> {
    /// A node of the first end with its box between that and its like at the other.
    #[inline(always)]
    fn node(&self, a: &Node, b: &Node) -> Node {
        let [first, second] = self.mix.weights();
        let [a, b]: [[Register; 2]; 2] = [a, b].map(|n| bytemuck::cast::<Node, [[f32; 4]; 2]>(*n).map(Register::of));
        // The integers in the fourth lanes are put back: as floats they would be denormal, which is slow.
        let mixed = [0, 1].map(|k| {
            let (p, q) = (a[k].axes(), b[k].axes());
            (p.mix(q, first, second) ^ (a[k] ^ p)).array()
        });
        bytemuck::cast(mixed)
    }
}

impl<'a> Tree for Moving<'a> {
    type Node = Node;
    type Source = MovingWalk<'a>;

    #[inline(always)]
    fn root(&self) -> Option<Node> {
        let [a, b] = self.tree.nodes;
        Some(self.node(a.first()?, b.first()?))
    }

    #[inline(always)]
    fn source(&self) -> MovingWalk<'a> {
        MovingWalk { bounds: Bounds::new(self.tree.nodes[0], self.tree.triangles), moving: *self }
    }
}

impl<'a> Source for MovingWalk<'a> {
    type Pair = [Node; 2];
    type Items = MovingLeaf<'a>;

    #[inline(always)]
    fn links(&self, index: u32) -> Result<(u32, u32), Malformed> {
        self.bounds.links(index)
    }

    #[inline(always)]
    fn enter(&mut self, first: u32) -> Result<[Node; 2], Malformed> {
        let [a, b] = self.bounds.enter(first)?;
        let nodes = self.moving.tree.nodes[1];
        let Some([c, d]) = nodes.get(first as usize..).and_then(|n| n.first_chunk::<2>()) else {
            return Err(Malformed::ChildOutOfRange { first, nodes: nodes.len() });
        };
        Ok([self.moving.node(a, c), self.moving.node(b, d)])
    }

    #[inline(always)]
    fn leaf(&mut self, first: u32, count: u32) -> Result<MovingLeaf<'a>, Malformed> {
        Ok(MovingLeaf { triangles: self.bounds.leaf(first, count)?.iter(), moving: self.moving })
    }
}

/// The triangles of a leaf, made one after the other.
struct MovingLeaf<'a> {
    triangles: std::slice::Iter<'a, IndexedTriangleRecord>,
    moving: Moving<'a>,
}

impl Iterator for MovingLeaf<'_> {
    type Item = TriangleRecord;

    #[inline(always)]
    fn next(&mut self) -> Option<TriangleRecord> {
        let triangle = self.triangles.next()?;
        Some(self.moving.tree.at(triangle, &self.moving.mix))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use bytemuck::Zeroable;

    #[test]
    fn nodes_are_mixed_as_boxes_are_and_keep_their_links() {
        let mut random = Random::new(4);
        let tree = BetweenTree { topology: 0, nodes: [&[]; 2], vertices: [&[]; 2], triangles: &[], first_triangle: 0 };
        for _ in 0..20_000 {
            let mut node = || Node {
                min: [0; 3].map(|_| f32::from_bits(random.bits() as u32)).map(|v| if v.is_finite() { v } else { 0.5 }),
                first: random.bits() as u32,
                max: [0; 3].map(|_| random.unit() as f32),
                count: random.below(256) as u32,
            };
            let (a, b) = (node(), node());
            let mix = Mix::new(random.unit() as f32).unwrap();
            let got = Moving { tree, mix }.node(&a, &b);
            let want = mix.bounds(&a.bounds(), &b.bounds());
            assert_eq!((got.bounds(), got.first, got.count), (want, a.first, a.count), "{a:?} {b:?} {mix:?}");
        }
    }

    #[test]
    fn an_inverse_undoes_its_matrix_unless_that_is_flat() {
        let turned = |f: f64| [[1.0 - 2.0 * f, 0.1, 0.0], [0.0, 1.0 - 2.0 * f, 0.0], [0.3, 0.0, 1.0]];
        for f in [0.0, 0.25, 0.499, 0.7] {
            let (m, back) = (turned(f), inverse(turned(f)).unwrap());
            for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                let product = dot(m[r], [back[0][c], back[1][c], back[2][c]]);
                assert!((product - f64::from(u8::from(r == c))).abs() < 1e-9, "{f}: {m:?} {back:?}");
            }
        }
        let third = 1.0 / 3.0;
        let cancelling = [[1.0, third, 0.0], [3.0, 3.0 * third + 1e-12, 0.0], [0.0, 0.0, 1.0]];
        for flat in [turned(0.5), cancelling, [[0.0; 3]; 3], [[f64::NAN; 3]; 3], [[f64::INFINITY; 3]; 3]] {
            assert_eq!(inverse(flat), None, "{flat:?}");
        }
        // Small is not flat.
        assert!(inverse([[1e-40, 0.0, 0.0], [0.0, 1e-40, 0.0], [0.0, 0.0, 1e-40]]).is_some());
    }

    /// Links of the two ends that differ, and ends of other lengths, are no reason to read where nothing is.
    #[test]
    fn a_walk_over_ends_that_do_not_match_ends() {
        let node = |first, count| Node { min: [-1.0; 3], first, max: [1.0; 3], count };
        let first = [node(2, 0), Node::zeroed(), node(0, 1), node(1, 1)];
        let triangle = IndexedTriangleRecord { corners: [0, 1, 9], ..Zeroable::zeroed() };
        let triangles = [triangle; 2];
        let vertices = [[0.0; 3]; 3];
        for (nodes, others, want) in [
            (&first[..], &first[..], Ok(false)),
            (&first, &[node(9, 0), node(9, 0), node(0, 255), node(7, 0)], Ok(false)),
            (&first, &first[..2], Err(Malformed::ChildOutOfRange { first: 2, nodes: 2 })),
            (&first, &[], Ok(false)),
            (&[node(0, 0), node(0, 0)], &first, Err(Malformed::NotATree { nodes: 2 })),
            (&[node(0, 3), node(0, 0)], &first, Err(Malformed::LeafOutOfRange { first: 0, count: 3, refs: 2 })),
        ] {
            let tree = BetweenTree {
                topology: 0,
                nodes: [nodes, others],
                vertices: [&vertices; 2],
                triangles: &triangles,
                first_triangle: 0,
            };
            let tree = Moving { tree, mix: Mix::new(0.5).unwrap() };
            let bottom = Bottom { tree, first_triangle: 0, instance: None };
            let (origin, direction) = ([0.1, 0.2, -5.0], [0.0, 0.0, 1.0]);
            let (mut best, mut stack) = (Best::none_until(9.0), Stack::new());
            let got = bottom.trace::<false, EdgeRay, Conservative>(
                origin,
                direction,
                0.0,
                &mut best,
                &mut stack,
                &mut NoObserver,
            );
            assert_eq!(got, want, "{nodes:?} {others:?}");
        }
    }
}
