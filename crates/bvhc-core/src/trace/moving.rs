//! The nodes and triangles of a tree between two frames, interpolated when a walk comes to them.

use super::bounds::Bounds;
use super::hit::Malformed;
use super::source::{Source, Tree};
use crate::cache::{BetweenTree, TriangleRecord};
use crate::geom::Mix;
use crate::layout::{IndexedTriangleRecord, Node};
use crate::simd::Register;

/// A tree at a time between.
#[derive(Clone, Copy)]
pub struct Moving<'a> {
    tree: BetweenTree<'a>,
    mix: Mix,
}

/// A walk over it. Bounds and links are those of the first end.
pub struct MovingWalk<'a> {
    bounds: Bounds<'a, IndexedTriangleRecord>,
    moving: Moving<'a>,
}

impl<'a> Moving<'a> {
    /// At a frame's own time it is that frame alone: what the other has cannot even change the sign of a zero.
    #[inline(always)]
    pub fn new(tree: BetweenTree<'a>, mix: Mix) -> Moving<'a> {
        let end = match mix.weights() {
            [_, 0.0] => 0,
            [0.0, _] => 1,
            _ => return Moving { tree, mix },
        };
        Moving { tree: BetweenTree { nodes: [tree.nodes[end]; 2], vertices: [tree.vertices[end]; 2], ..tree }, mix }
    }

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
pub struct MovingLeaf<'a> {
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
    use super::super::hit::Best;
    use super::super::intersect::EdgeRay;
    use super::super::observe::NoObserver;
    use super::super::place::Place;
    use super::super::slab::Conservative;
    use super::super::traverse::{Bottom, Stack};
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
            let got = Moving::new(tree, mix).node(&a, &b);
            let want = mix.bounds(&a.bounds(), &b.bounds());
            assert_eq!((got.bounds(), got.first, got.count), (want, a.first, a.count), "{a:?} {b:?} {mix:?}");
        }
    }

    #[test]
    fn triangles_are_mixed_as_points_are_and_keep_their_numbers() {
        let mut random = Random::new(6);
        for _ in 0..20_000 {
            let mut number = || [random.unit() as f32, -1e30, 3e-39, 0.0][random.below(4) as usize];
            let ends = [0; 2].map(|_| [0; 3].map(|_| [0; 3].map(|_| number())));
            // As a float it is NaN.
            let prim = 0x7fc0_1234;
            let record = IndexedTriangleRecord { corners: [2, 0, 1], prim, geom: 7, flags: 1 };
            let tree = BetweenTree {
                topology: 0,
                nodes: [&[]; 2],
                vertices: [&ends[0], &ends[1]],
                triangles: &[],
                first_triangle: 0,
            };
            let mix = Mix::new(random.unit() as f32).unwrap();
            let [v0, v1, v2] = [2, 0, 1].map(|v| mix.point(ends[0][v], ends[1][v]));
            let want = TriangleRecord { v0, prim, v1, geom: 7, v2, flags: 1 };
            assert_eq!(tree.at(&record, &mix), want, "{ends:?} {mix:?}");
        }
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
            let tree = Moving::new(tree, Mix::new(0.5).unwrap());
            let bottom = Bottom { tree, place: Place { first_triangle: 0, instance: None } };
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
