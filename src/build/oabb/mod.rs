//! Bottom-up construction by boxes that lie along what they hold: the method `oabb` (Aston, "Agglomerative Building and Traversal of an Object
//! Aligned Bounding Volume Hierarchy", 2018).
//!
//! Each triangle has a box in its own basis. In each round every cluster proposes to the neighbour with which it has the smallest common box,
//! and those that propose to each other become one. The common box lies along one of both, whichever is less, as its author has it; so all
//! boxes lie along some triangle, and grow with every change of basis. With `fit` the basis is looked for anew.
//!
//! The tree that comes of it is one of boxes along the axes: what the oriented ones decide is which triangles are together.
//!
//! All else is as in `agglomerative`: neighbours on a Morton curve, in place of all others; enough
//! pairs in every round, also where none propose to each other; and the depth. `clusters` merges, `matching` finds pairs, and
//! `outline` is what boxes are fitted around.

mod clusters;
mod matching;
mod outline;
#[cfg(test)]
mod tests;

pub use clusters::{Clusters, cluster};

use super::agglomerative::forest::Forest;
use super::agglomerative::tree_of;
use super::error::BuildError;
use super::progress::Progress;
use super::recipe::options::BuildOptions;
use crate::exec::Executor;
use crate::scene::Mesh;
use crate::tree::Tree;

/// Bytes that a build holds at its peak for every triangle, beside its reference and the tree: two oriented boxes, the moments of two
/// surfaces, what is still to be merged, merges, and its place in the order.
pub(super) const BYTES_PER_REF: u64 = 750;

/// Build the tree over all triangles. `share` is what it counts for in [`Progress::advance`].
pub(super) fn build(
    mesh: &Mesh,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
    share: u64,
) -> Result<Tree, BuildError> {
    let clusters = cluster(mesh, options, exec, progress)?;
    progress.advance(share);
    progress.phase("put together");
    let Some((refs, merges, root)) = clusters.into_parts() else { return Ok(Tree::default()) };
    Ok(tree_of(&Forest { refs: &refs, merges, root }, options, exec))
}
