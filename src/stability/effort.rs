//! How thoroughly scenes are judged.

use serde::Serialize;

/// How thoroughly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Effort {
    /// Triangles of each scene, about, the smaller size first.
    pub sizes: [usize; 2],
    /// Rays in each of three sets for costs.
    pub rays: usize,
    /// Rays for hits, each of which brute force judges over all triangles.
    pub judged_rays: usize,
    /// How often each recipe is built for its time; 0 asks for none.
    pub rounds: u32,
}
