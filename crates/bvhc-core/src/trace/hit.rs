use crate::geom::Affine;
use crate::geom::vector::{cross, sub};
use crate::layout::{NO_NODE, View};

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The point is `origin + t·direction` of the ray that was asked, in world space.
    ///
    /// It is decided in `f64` and rounded to the nearest `f32`, which may lie before the triangle: a ray that shall still meet it ends at
    /// `t.next_up()`.
    pub t: f32,
    /// Weight of the triangle's second corner: the point is `(1 − u − v)·v0 + u·v1 + v·v2`.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
    /// Number of the triangle in its source mesh.
    pub prim: u32,
    /// Row of the file's `GEOM` table.
    pub geom: u32,
    /// Number of the instance in the scene's order, which is not the order of the records: `Cache::instance_record` finds the record of this
    /// number. `None` in a one-level file.
    pub instance: Option<u32>,
    /// Index in [`View::triangles`](crate::cache::View::triangles). Where a triangle stands in several leaves, the first of
    /// those that the ray found it in.
    pub triangle: usize,
}

impl View<'_> {
    /// Which node of the source a hit is at: of the place where the mesh stands, or of that whose transform is in the positions. `None` where it is not
    /// told. `record` finds the record of an instance by the number that hits have.
    pub fn node(&self, hit: &Hit, record: impl FnOnce(u32) -> Option<usize>) -> Option<u32> {
        let baked = self.geoms.get(hit.geom as usize)?.baked_node;
        let placed = || self.instances.get(record(hit.instance?)?).map(|instance| instance.node);
        let node = if baked == NO_NODE { placed()? } else { baked };
        (node != NO_NODE).then_some(node)
    }

    /// The normal of the triangle that was hit, in world space and not of length 1. It points to the front, where `is_mirrored` says of the hit's part what
    /// [`Opened::is_mirrored`](crate::cache::Opened::is_mirrored) does. `record` finds the record of an instance by the number that hits have. `None` where
    /// the record that the hit names is no triangle of its part and number: some hits in other trees are told so, not all.
    pub fn normal(&self, hit: &Hit, is_mirrored: bool, record: impl FnOnce(u32) -> Option<usize>) -> Option<[f64; 3]> {
        let triangle = self.triangles.get(hit.triangle).filter(|t| (t.geom, t.prim) == (hit.geom, hit.prim))?;
        let [v0, v1, v2] = triangle.corners().map(|p| p.map(f64::from));
        let turn = if is_mirrored { -1.0 } else { 1.0 };
        let n = cross(sub(v1, v0), sub(v2, v0)).map(|c| turn * c);
        let Some(id) = hit.instance else { return Some(n) };
        // A normal goes into the world by the transposed inverse: the columns of the way back.
        let rows = Affine::from_f32(&self.instances.get(record(id)?)?.world_to_object).rows;
        Some([0, 1, 2].map(|i| rows[0][i] * n[0] + rows[1][i] * n[1] + rows[2][i] * n[2]))
    }
}

/// What makes a tree unfit for traversal. Never seen in a file that was opened with its topology checked; traversal looks
/// for itself nevertheless, so that no file makes it panic, read out of bounds or run on for ever.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Malformed {
    /// An inner node names children beyond the records.
    ChildOutOfRange {
        /// First child that it names.
        first: u32,
        /// Records of the tree.
        nodes: usize,
    },
    /// A leaf names references beyond those of the tree, or more than 255.
    LeafOutOfRange {
        /// First reference that it names.
        first: u32,
        /// How many it names.
        count: u32,
        /// References of the tree.
        refs: usize,
    },
    /// An instance names a tree that is not there, or one outside of its sections.
    BlasOutOfRange {
        /// Record of the instance.
        instance: usize,
        /// The tree that it names.
        blas: u32,
    },
    /// A row of `BLAS` names records outside of its sections.
    TreeOutOfRange {
        /// Number of the row.
        tree: usize,
    },
    /// The tree is deeper than [`MAX_DEPTH`](crate::layout::MAX_DEPTH).
    TooDeep,
    /// More inner nodes were entered than there are, so some have two parents; or leaves overlap.
    NotATree {
        /// Records of the tree.
        nodes: usize,
    },
}

impl std::fmt::Display for Malformed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("cannot trace: ")?;
        match *self {
            Malformed::ChildOutOfRange { first, nodes } => {
                write!(f, "an inner node names children {first} and the next, but there are {nodes} records")
            }
            Malformed::LeafOutOfRange { first, count, refs } => write!(
                f,
                "a leaf names {count} references from {first} on, but a leaf has at most 255 and there are {refs}"
            ),
            Malformed::BlasOutOfRange { instance, blas } => write!(
                f,
                "instance record {instance} names BLAS {blas}, which is not there or lies outside its sections"
            ),
            Malformed::TreeOutOfRange { tree } => write!(f, "row {tree} of BLAS names records outside of its sections"),
            Malformed::TooDeep => write!(f, "the tree is deeper than {}", crate::layout::MAX_DEPTH),
            Malformed::NotATree { nodes } => {
                write!(f, "more inner nodes were entered than there are ({nodes} records), so some have two parents")
            }
        }
    }
}

impl std::error::Error for Malformed {}

/// Why many rays at once have no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BatchError {
    /// There is not one place for each answer. No ray was traced.
    Lengths {
        /// Rays that were given.
        rays: usize,
        /// Places for hits.
        hits: usize,
    },
    /// The tree is unfit for traversal.
    Malformed(Malformed),
}

impl From<Malformed> for BatchError {
    fn from(malformed: Malformed) -> BatchError {
        BatchError::Malformed(malformed)
    }
}

impl std::fmt::Display for BatchError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            BatchError::Lengths { rays, hits } => {
                write!(f, "cannot trace: there are {rays} rays and places for {hits} hits; each ray needs one")
            }
            BatchError::Malformed(malformed) => malformed.fmt(f),
        }
    }
}

impl std::error::Error for BatchError {}

/// The best hit so far, with the distance that decides in `f64`.
///
/// Order: smaller `t` first; among equal `t` the smaller (instance, geometry, primitive). All of it is a function of the ray
/// and the triangle alone, so the winner does not depend on the tree.
#[derive(Clone, Copy, Debug)]
pub struct Best {
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
