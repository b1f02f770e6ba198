/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The point is `origin + t·direction` of the ray that was asked, in world space.
    pub t: f32,
    /// Weight of the triangle's second corner: the point is `(1 − u − v)·v0 + u·v1 + v·v2`.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
    /// Number of the triangle in its source mesh.
    pub prim: u32,
    /// Row of the file's `GEOM` table.
    pub geom: u32,
    /// Index of the instance in the scene's order; `None` in a one-level file.
    pub instance: Option<u32>,
    /// Index in [`View::triangles`](crate::cache::View::triangles). Where a triangle stands in several leaves, the first of
    /// those that the ray found it in.
    pub triangle: usize,
}

/// What makes a tree unfit for traversal. Never seen in a file that was opened with its topology checked; traversal looks
/// for itself nevertheless, so that no file makes it panic, read out of bounds or run on for ever.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Malformed {
    #[error(
        "Traversal stopped: an inner node names children {first} and the next, but there are {nodes} records.\nhelp: bvhc check FILE"
    )]
    ChildOutOfRange { first: u32, nodes: usize },
    #[error(
        "Traversal stopped: a leaf names {count} references from {first} on, but a leaf has at most 255 and there are {refs}.\nhelp: bvhc check FILE"
    )]
    LeafOutOfRange { first: u32, count: u32, refs: usize },
    #[error(
        "Traversal stopped: instance record {instance} names BLAS {blas}, which is not there or lies outside its sections.\nhelp: bvhc check FILE"
    )]
    BlasOutOfRange { instance: usize, blas: u32 },
    #[error("Traversal stopped: the tree is deeper than {limit}.\nhelp: bvhc check FILE", limit = crate::tree::MAX_DEPTH)]
    TooDeep,
    #[error(
        "Traversal stopped: more inner nodes were entered than there are ({nodes} records), so some have two parents.\nhelp: bvhc check FILE"
    )]
    NotATree { nodes: usize },
}

/// The best hit so far, with the distance that decides in `f64`.
///
/// Order: smaller `t` first; among equal `t` the smaller (instance, geometry, primitive). All of it is a function of the ray
/// and the triangle alone, so the winner does not depend on the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Best {
    pub t: f64,
    /// `t` widened upward to `f32`: what boxes are culled by.
    pub limit: f32,
    pub hit: Option<Hit>,
}

impl Best {
    pub fn none_until(t_max: f32) -> Best {
        Best { t: f64::from(t_max), limit: t_max, hit: None }
    }

    /// Take `hit` at distance `t` if it comes before what is there.
    #[inline]
    pub fn offer(&mut self, t: f64, hit: Hit) {
        let comes_first = match &self.hit {
            None => t <= self.t,
            Some(old) => t < self.t || (t == self.t && key(&hit) < key(old)),
        };
        if comes_first {
            *self = Best { t, limit: crate::geom::round_up(t), hit: Some(hit) };
        }
    }
}

fn key(hit: &Hit) -> (Option<u32>, u32, u32, usize) {
    (hit.instance, hit.geom, hit.prim, hit.triangle)
}
