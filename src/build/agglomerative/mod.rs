//! Bottom-up construction: the method `agglomerative` (Meister and Bittner, "Parallel Locally-Ordered Clustering for Bounding
//! Volume Hierarchy Construction", 2018).
//!
//! References stand in the order of a Morton curve. In each round every cluster looks for its best match, the one with
//! which it has the smallest common box, among its neighbours in that order; clusters that are each other's best match become
//! one, in the place of the first. Rounds are made in groups of neighbours until a group is a few clusters; those are put in groups anew,
//! and so on, until one cluster is left. Subtrees that are dearer than a leaf are leaves.
//!
//! `morton` makes the order, `levels` the groups, `group` merges, `window` finds matches, `pairs` sees that enough of them merge, `forest` is
//! what comes of it, `emit` writes the tree, and `deep` does where the forest goes too deep.

mod deep;
mod emit;
pub(super) mod forest;
mod group;
mod levels;
pub(super) mod morton;
pub(super) mod pairs;
mod window;

use super::error::{BuildError, Remedy};
use super::prim_ref::PrimRefs;
use super::progress::Progress;
use super::recipe::options::BuildOptions;
use super::top_down::driver::check_slots;
use crate::exec::Executor;
use crate::tree::{MAX_DEPTH, Tree};

/// Bytes that a build holds at its peak for every reference, beside the reference itself and the tree: its place in the order, its key
/// and a copy of that.
pub(super) const BYTES_PER_REF: u64 = 48;

/// Build the tree over all references. `share` is what it counts for in [`Progress::advance`].
pub(super) fn build(
    input: PrimRefs,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
    share: u64,
) -> Result<Tree, BuildError> {
    check_slots(input.refs.len())?;
    check_numbers(input.refs.len() as u64)?;
    if input.refs.is_empty() {
        return Ok(Tree::default());
    }
    let rules = forest::Rules::new(options, &input.bounds);
    progress.phase("sort");
    let refs = exec.run(|| morton::sort(input.refs, &input.centroids, exec));
    progress.phase("merge");
    let forest = exec.run(|| levels::cluster(&refs, &rules, exec, progress, share))?;
    progress.phase("put together");
    Ok(tree_of(&forest, options, exec))
}

/// The tree that a forest stands for, no deeper than trees may be.
pub(super) fn tree_of(forest: &forest::Forest, options: &BuildOptions, exec: &Executor) -> Tree {
    if forest.root.weight.height > MAX_DEPTH {
        return deep::emit(forest, options, exec);
    }
    emit::emit(forest, exec)
}

/// Refuse more references than there are numbers for, which references and merges share.
fn check_numbers(references: u64) -> Result<(), BuildError> {
    if references <= levels::MOST_REFS {
        return Ok(());
    }
    Err(BuildError::TooLarge {
        what: "one agglomerative tree (references)",
        needed: references,
        limit: levels::MOST_REFS,
        remedy: Remedy::Bonsai,
    })
}
