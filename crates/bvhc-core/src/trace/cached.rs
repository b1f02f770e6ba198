//! Asking an open file directly.

use super::batch::answer_all;
use super::wide::WideView;
use super::{BatchError, Hit, Malformed, TurnedView, any_hit, closest_hit};
use crate::cache::{Frame, Opened};
use crate::exec::Executor;
use crate::geom::Ray;
use crate::layout::{CompactNode, View};

impl View<'_> {
    /// The nearest hit of each of many rays, as [`closest_hit`](super::closest_hit) finds it, shared among the threads of `exec`.
    ///
    /// `hits[i]` becomes the answer to `rays[i]`, so both have one length.
    ///
    /// # Errors
    /// Where the lengths differ, and then no hit is touched. Where the tree is malformed: some hits are filled in then and others are not.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>], exec: &Executor) -> Result<(), BatchError> {
        answer_all(rays, hits, exec, |ray| closest_hit(self, ray))
    }
}

impl Frame<'_> {
    /// The nearest point where the ray meets the frame.
    ///
    /// # Errors
    /// Where the frame's trees are malformed, which opening at [`Validation::Tree`](crate::cache::Validation::Tree) rules out.
    pub fn closest_hit(&self, ray: &Ray) -> Result<Option<Hit>, Malformed> {
        closest_hit(&self.view(), ray)
    }

    /// Whether the ray meets anything.
    ///
    /// # Errors
    /// As [`Frame::closest_hit`].
    pub fn any_hit(&self, ray: &Ray) -> Result<bool, Malformed> {
        any_hit(&self.view(), ray)
    }

    /// [`View::closest_hits`] in this frame.
    ///
    /// # Errors
    /// As [`View::closest_hits`].
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>], exec: &Executor) -> Result<(), BatchError> {
        self.view().closest_hits(rays, hits, exec)
    }

    /// Which node of the source was hit; `None` where the file does not say.
    pub fn node(&self, hit: &Hit) -> Option<u32> {
        self.view().node(hit, |id| self.instance_record(id))
    }

    /// The normal of the triangle that was hit, as [`Opened::normal`] has it. Whether the part is mirrored the sequence says, by
    /// [`Frame::part`].
    pub fn normal(&self, hit: &Hit, is_mirrored: bool) -> Option<[f64; 3]> {
        self.view().normal(hit, is_mirrored, |id| self.instance_record(id))
    }
}

impl Opened<'_> {
    /// Which node of the source was hit: of the place where the mesh stands, or of that whose transform is in the positions. `None` where the file does not say.
    pub fn node(&self, hit: &Hit) -> Option<u32> {
        self.view().node(hit, |id| self.instance_record(id))
    }

    /// The normal of the triangle that a ray of this file hit, in world space and not of length 1: it points to the triangle's front,
    /// whatever instance or baked transform mirrors it. A ray comes from the front where its product with the direction is negative.
    ///
    /// `None` where the record that the hit names is no triangle of its part and number, as for most hits in another file.
    ///
    /// ```
    /// # use bvhc_core::{cache::Opened, geom::Ray, trace::Hit};
    /// fn is_from_front(cache: &Opened<'_>, ray: &Ray, hit: &Hit) -> Option<bool> {
    ///     let normal = cache.normal(hit)?;
    ///     Some((0..3).map(|axis| normal[axis] * f64::from(ray.direction[axis])).sum::<f64>() < 0.0)
    /// }
    /// ```
    pub fn normal(&self, hit: &Hit) -> Option<[f64; 3]> {
        self.view().normal(hit, self.is_mirrored(hit.geom), |id| self.instance_record(id))
    }

    /// The compact trees of the file with the scene that they are about; `None` in a file without them, and where their sections do not belong to it.
    pub fn compact(&self) -> Option<WideView<'_, 8, CompactNode>> {
        let (rows, view) = (self.compact_rows(), self.view());
        let order = self.compact_order();
        let is_of_file = !rows.is_empty() && rows.len() == view.blases.len() && order.len() == view.triangles.len();
        is_of_file.then(|| WideView { view, nodes: self.compact_nodes(), rows, order, blocks: &[] })
    }

    /// The tree of the file with its turned subtrees; `None` in a file without them.
    pub fn turned(&self) -> Option<TurnedView<'_>> {
        let (rows, nodes) = (self.turns(), self.turned_nodes());
        let is_of_file = !rows.is_empty() && !nodes.is_empty() && self.instances().is_empty();
        is_of_file.then(|| TurnedView { view: self.view(), rows, nodes, marks: self.turn_marks() })
    }

    /// The nearest point where the ray meets the scene; see [`closest_hit`](super::closest_hit). It is traced through the compact trees where the file
    /// has them, else through turned subtrees where it has those, with the same answer to the last bit; only the [record](Hit::triangle) of a triangle that stands in several leaves may then be
    /// another one of it.
    ///
    /// # Errors
    /// Where the tree is malformed, which only a file opened below [`Validation::Tree`](crate::cache::Validation::Tree) can be.
    pub fn closest_hit(&self, ray: &Ray) -> Result<Option<Hit>, Malformed> {
        match (self.compact(), self.turned()) {
            (Some(wide), _) => wide.closest_hit(ray),
            (None, Some(turned)) => turned.closest_hit(ray),
            (None, None) => closest_hit(&self.view(), ray),
        }
    }

    /// Whether the ray meets anything; see [`any_hit`](super::any_hit).
    ///
    /// # Errors
    /// As [`Opened::closest_hit`].
    pub fn any_hit(&self, ray: &Ray) -> Result<bool, Malformed> {
        match (self.compact(), self.turned()) {
            (Some(wide), _) => wide.any_hit(ray),
            (None, Some(turned)) => turned.any_hit(ray),
            (None, None) => any_hit(&self.view(), ray),
        }
    }

    /// The nearest hit of each of many rays, on all threads with the feature `rayon`, else on this one; see [`View::closest_hits`] and
    /// [`Opened::closest_hit`].
    ///
    /// # Errors
    /// As [`Opened::closest_hit`], and where there are not as many places for hits as rays.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) -> Result<(), BatchError> {
        match (self.compact(), self.turned()) {
            (Some(wide), _) => wide.closest_hits(rays, hits, &Executor::current()),
            (None, Some(turned)) => turned.closest_hits(rays, hits, &Executor::current()),
            (None, None) => self.view().closest_hits(rays, hits, &Executor::current()),
        }
    }
}
