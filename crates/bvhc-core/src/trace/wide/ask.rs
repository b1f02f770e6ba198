//! What rays may ask of a scene with wide trees.

use super::record::WideRecord;
use super::scene::WideView;
use super::walk::WideQuery;
use crate::exec::Executor;
use crate::geom::Ray;
use crate::simd::{Runs, Widest};
use crate::trace::batch::answer_all;
use crate::trace::hit::{BatchError, Hit, Malformed};
use crate::trace::observe::{NoObserver, Observer};

impl<const N: usize, T: WideRecord<N>> WideView<'_, N, T>
where
    Widest: Runs<N>,
{
    /// The nearest hit, the same to the last bit as [`closest_hit`](crate::trace::closest_hit) finds it in [`WideView::view`]; only the
    /// [record](Hit::triangle) of a triangle that stands in several leaves may be another one of it.
    ///
    /// # Errors
    /// Where records are no tree, as there.
    pub fn closest_hit(&self, ray: &Ray) -> Result<Option<Hit>, Malformed> {
        self.try_closest_hit(ray, &mut NoObserver)
    }

    /// Whether the ray meets anything, as [`any_hit`](crate::trace::any_hit) says it.
    ///
    /// # Errors
    /// Where records are no tree, as there.
    pub fn any_hit(&self, ray: &Ray) -> Result<bool, Malformed> {
        self.try_any_hit(ray, &mut NoObserver)
    }

    /// [`WideView::closest_hit`] of many rays, shared among the threads of `exec`: `hits[i]` becomes the answer to `rays[i]`.
    ///
    /// # Errors
    /// Where the lengths differ, and then no hit is touched. Where records are no tree: some hits are filled in then and others are not.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>], exec: &Executor) -> Result<(), BatchError> {
        answer_all(rays, hits, exec, |ray| self.closest_hit(ray))
    }

    /// [`WideView::closest_hit`] with an observer that counts: a wide node that is entered is one inner node.
    ///
    /// # Errors
    /// As there.
    pub fn try_closest_hit(&self, ray: &Ray, observer: &mut impl Observer) -> Result<Option<Hit>, Malformed> {
        Widest::run(WideQuery::<false, N, T, _> { scene: self, ray, observer })
    }

    /// [`WideView::any_hit`] with an observer that counts.
    ///
    /// # Errors
    /// As there.
    pub fn try_any_hit(&self, ray: &Ray, observer: &mut impl Observer) -> Result<bool, Malformed> {
        Ok(Widest::run(WideQuery::<true, N, T, _> { scene: self, ray, observer })?.is_some())
    }
}
