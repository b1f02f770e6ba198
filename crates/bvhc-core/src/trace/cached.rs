//! Asking an open file directly.

use super::{Hit, Malformed, NoObserver, try_any_hit, try_closest_hit};
use crate::cache::Opened;
use crate::geom::Ray;

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
}
