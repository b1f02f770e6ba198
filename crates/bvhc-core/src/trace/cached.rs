//! Asking an open file directly.

use super::{Hit, Malformed, NoObserver, try_any_hit, try_closest_hit};
use crate::cache::Opened;
use crate::exec::Executor;
use crate::geom::Ray;
use crate::layout::View;

/// Rays of one task: enough to outweigh its start, few enough that threads end together.
const CHUNK: usize = 1 << 10;

impl View<'_> {
    /// The nearest hit of each of many rays, as [`closest_hit`](super::closest_hit) finds it, shared among the threads of `exec`.
    ///
    /// `hits[i]` becomes the answer to `rays[i]`; where the slices differ in length, what the longer one has more stays as it is.
    ///
    /// # Errors
    /// Where the tree is malformed; some hits are filled in then and others are not.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>], exec: &Executor) -> Result<(), Malformed> {
        let count = rays.len().min(hits.len());
        let chunks = exec.map_chunks_mut(&mut hits[..count], CHUNK, |chunk, some| {
            some.iter_mut().zip(&rays[chunk * CHUNK..]).try_for_each(|(hit, ray)| {
                *hit = try_closest_hit(self, ray, &mut NoObserver)?;
                Ok(())
            })
        });
        chunks.into_iter().collect()
    }
}

impl Opened<'_> {
    /// The nearest point where the ray meets the scene; see [`closest_hit`](super::closest_hit).
    ///
    /// # Errors
    /// Where the tree is malformed, which only a file opened below [`Validation::Tree`](crate::cache::Validation::Tree) can be.
    pub fn closest_hit(&self, ray: &Ray) -> Result<Option<Hit>, Malformed> {
        try_closest_hit(&self.view(), ray, &mut NoObserver)
    }

    /// Whether the ray meets anything; see [`any_hit`](super::any_hit).
    ///
    /// # Errors
    /// As [`Opened::closest_hit`].
    pub fn any_hit(&self, ray: &Ray) -> Result<bool, Malformed> {
        try_any_hit(&self.view(), ray, &mut NoObserver)
    }

    /// The nearest hit of each of many rays, on all threads; see [`View::closest_hits`].
    ///
    /// # Errors
    /// As [`Opened::closest_hit`].
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) -> Result<(), Malformed> {
        self.view().closest_hits(rays, hits, &Executor::current())
    }
}
