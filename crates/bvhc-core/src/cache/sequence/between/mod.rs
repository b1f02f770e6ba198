//! What lies between two frames: their trees, vertices and instances, matched.
//!
//! ```text
//! open: two placements ─▶ instances of one id ─▶ pairs of poses of one topology
//! fit:  boxes of the top level that hold each instance at all times between
//! ```
//!
//! Nothing is copied that the file has as it is needed: triangles stay numbers of vertices, and boxes and vertices are interpolated when a ray asks.

mod fit;
mod open;

use std::borrow::Cow;

use super::moment::{fraction, seconds_of};
use crate::geom::{Affine, Mix};
use crate::layout::{FrameRecord, IndexedTriangleRecord, InstanceRecord, Node, TriangleRecord, side_flags};
use crate::simd::Register;

/// The time between two frames of a sequence, open for rays.
///
/// A ray has a time of its own, a *fraction* from 0, at the first frame, to 1, at the second; [`Between::fraction`] makes it of seconds. Vertices,
/// boxes and the numbers of instances' matrices go linearly from the one frame to the other, as [`Mix`] computes. A rotation is therefore a chord and
/// not an arc: what shall turn farther between two frames needs frames in between.
///
/// ```no_run
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use bvhc_core::{Ray, Sequence};
///
/// let sequence = Sequence::open("heli.bvhc")?;
/// let shutter = sequence.between(12, 13)?; // opened once, for all rays and threads
/// let ray = Ray::new([0.25, 0.25, -2.0], [0.0, 0.0, 1.0]);
/// for sample in 0..16 {
///     let hit = shutter.closest_hit(&ray, (sample as f32 + 0.5) / 16.0)?;
/// #   _ = hit;
/// }
/// # Ok(())
/// # }
/// ```
///
/// The trees are those of the first frame, with two boxes a node. The tree over the instances has boxes that hold its instances at all times.
#[derive(Clone, Debug)]
pub struct Between<'s> {
    records: [FrameRecord; 2],
    tlas_nodes: Vec<Node>,
    instances: Vec<BetweenInstance>,
    /// For each id its instance.
    by_id: Vec<u32>,
    trees: Vec<Pair>,
    contents: Vec<Content<'s>>,
    triangles: &'s [IndexedTriangleRecord],
    sides: &'s [u32],
}

/// Two poses of one topology.
#[derive(Clone, Debug)]
struct Pair {
    topology: u32,
    /// For each end its content.
    ends: [usize; 2],
    /// Where its triangles stand among all of the file.
    refs: std::ops::Range<usize>,
}

/// Nodes and vertices of one pose.
#[derive(Clone, Debug)]
struct Content<'s> {
    nodes: Cow<'s, [Node]>,
    vertices: Cow<'s, [[f32; 3]]>,
}

/// An instance on its way from one frame to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BetweenInstance {
    /// The record of the one frame and of the other. Their `id` is the same, and `blas` is a row of [`Sequence::poses`](super::Frames::poses).
    pub ends: [InstanceRecord; 2],
    /// What [`Between::tree`] knows its tree by.
    pub tree: u32,
}

/// A tree on its way from one frame to another: one shape, and for each end its boxes and vertices.
#[derive(Clone, Copy, Debug)]
pub struct BetweenTree<'a> {
    /// Row of [`Sequence::topologies`](super::Frames::topologies).
    pub topology: u32,
    /// The nodes at each end. They are as many, and refer to the same.
    pub nodes: [&'a [Node]; 2],
    /// The vertices at each end, as many.
    pub vertices: [&'a [[f32; 3]]; 2],
    /// In leaf order, corners by number of vertex.
    pub triangles: &'a [IndexedTriangleRecord],
    /// The number of the first of them in [`Sequence::indexed_triangles`](super::Frames::indexed_triangles).
    pub first_triangle: usize,
}

impl Between<'_> {
    /// Number and time of the two frames.
    pub fn frames(&self) -> &[FrameRecord; 2] {
        &self.records
    }

    /// The fraction at so many seconds: `None` for times that do not lie between those of the two frames, and where these have none.
    pub fn fraction(&self, seconds: f64) -> Option<f32> {
        let [start, end] = &self.records;
        fraction(seconds, seconds_of(start)?, seconds_of(end)?)
    }

    /// The tree over the instances: that of the first frame, with boxes in world space that hold what is below them at every time between.
    pub fn tlas_nodes(&self) -> &[Node] {
        &self.tlas_nodes
    }

    /// In the order of that tree's leaves.
    pub fn instances(&self) -> &[BetweenInstance] {
        &self.instances
    }

    /// The place in [`Between::instances`] of the instance with this number in the scene.
    pub fn instance_record(&self, id: u32) -> Option<usize> {
        self.by_id.get(id as usize).map(|record| *record as usize)
    }

    /// How many trees there are: one for each pair of poses that an instance shows.
    pub fn tree_count(&self) -> usize {
        self.trees.len()
    }

    /// The tree with this number, counted from 0.
    #[inline]
    pub fn tree(&self, number: usize) -> Option<BetweenTree<'_>> {
        let pair = self.trees.get(number)?;
        let [a, b] = [self.contents.get(pair.ends[0])?, self.contents.get(pair.ends[1])?];
        Some(BetweenTree {
            topology: pair.topology,
            nodes: [&a.nodes, &b.nodes],
            vertices: [&a.vertices, &b.vertices],
            triangles: self.triangles.get(pair.refs.clone())?,
            first_triangle: pair.refs.start,
        })
    }

    /// Whether a transform that was baked into the part's positions mirrors: of a row of [`Sequence::geoms`](super::Frames::geoms).
    pub fn is_mirrored(&self, geom: u32) -> bool {
        self.sides.get(geom as usize).is_some_and(|side| side & side_flags::MIRRORED != 0)
    }
}

impl BetweenInstance {
    /// Whether it stands where it is: its matrix is the same at both ends, though its triangles may move.
    #[inline]
    pub fn stands(&self) -> bool {
        self.ends[0].object_to_world == self.ends[1].object_to_world
    }

    /// From the tree's space to the world: each number of the matrix is interpolated in `f64`. It has no inverse where the instance goes through a
    /// plane, as one that turns by half or is mirrored does.
    pub fn object_to_world(&self, mix: &Mix) -> Affine {
        let [a, b] = [0, 1].map(|end| Affine::from_f32(&self.ends[end].object_to_world));
        let [first, second] = mix.weights();
        let number = |r: usize, c: usize| first * a.rows[r][c] + second * b.rows[r][c];
        if self.stands() { a } else { Affine { rows: [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| number(r, c))) } }
    }
}

impl BetweenTree<'_> {
    /// A triangle as it stands at that time.
    #[inline(always)]
    pub fn at(&self, triangle: &IndexedTriangleRecord, mix: &Mix) -> TriangleRecord {
        let [a, b] = self.vertices;
        let [first, second] = mix.weights();
        let wide = |[x, y, z]: [f32; 3]| Register::of([x, y, z, 0.0]);
        // Opening found every corner, so this finds it there too. In the fourth lane stands an integer of the record.
        let row = |v: u32, word: u32| {
            let (a, b) = (a.get(v as usize).copied(), b.get(v as usize).copied());
            let (a, b) = (a.unwrap_or([f32::NAN; 3]), b.unwrap_or([f32::NAN; 3]));
            (wide(a).mix(wide(b), first, second) ^ Register::of([0.0, 0.0, 0.0, f32::from_bits(word)])).array()
        };
        let ([v0, v1, v2], IndexedTriangleRecord { prim, geom, flags, .. }) = (triangle.corners, *triangle);
        bytemuck::cast([row(v0, prim), row(v1, geom), row(v2, flags)])
    }
}
