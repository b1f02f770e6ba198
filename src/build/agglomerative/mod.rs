//! Bottom-up construction: the method `agglomerative` (Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding
//! Volume Hierarchy Construction", 2018).
//!
//! References stand in the order of a Morton curve. In each round every cluster looks for its best match, the one with
//! which it has the smallest common box, among its neighbours in that order; clusters that are each other's best match become
//! one, in the place of the first. When one cluster is left, subtrees that are dearer than a leaf are made leaves.
//!
//! `morton` makes the order, `window` finds matches, `rounds` merges, `emit` writes the tree.

mod emit;
mod morton;
mod rounds;
mod window;

use super::cost::Sah;
use super::error::BuildError;
use super::exec::Executor;
use super::prim_ref::PrimRefs;
use super::progress::Progress;
use super::recipe::options::BuildOptions;
use super::top_down::driver::check_slots;
use crate::tree::Tree;

/// Widest window: a distance and one bit more share six bits with an area.
pub(super) const MAX_RADIUS: u32 = window::MAX_RADIUS as u32;

/// Bytes that a build holds at its peak for every reference, beside the reference itself and the tree: clusters of two rounds,
/// partners, and merges.
pub(super) const BYTES_PER_REF: u64 = 112;

/// Build the tree over all references. `share` is what it counts for in [`Progress::advance`].
pub(super) fn build(
    input: PrimRefs,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
    share: u64,
) -> Result<Tree, BuildError> {
    check_slots(input.refs.len())?;
    if input.refs.is_empty() {
        return Ok(Tree::default());
    }
    let bounds = input.bounds;
    progress.phase("sort");
    let (refs, scratch) = exec.run(|| morton::sort(input.refs, &input.centroids, exec));
    let rules = rounds::Rules {
        sah: Sah { traversal: options.traversal_cost, intersection: options.intersection_cost },
        max_leaf: options.max_leaf.clamp(1, 255),
        radius: options.radius.clamp(1, MAX_RADIUS) as usize,
        scale: rounds::scale_of(&bounds),
    };
    progress.phase("merge");
    let forest = exec.run(|| rounds::cluster(&refs, scratch, &rules, exec, progress, share))?;
    progress.phase("put together");
    emit::emit(&refs, &forest, options, exec)
}
