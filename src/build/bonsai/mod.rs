//! Bonsai: many small sweep trees, pruned and gathered under one (Ganestam, Barringer, Doggett and Akenine-Möller, "Bonsai: Rapid
//! Bounding Volume Hierarchy Generation using Mini Trees", 2015).
//!
//! References are divided roughly into groups that the second-level cache holds; each group becomes a *mini tree* by the
//! [sweep](super::sweep). Mini trees are *pruned*: nodes that are large beside the average mini tree are opened, since they show that
//! the rough division cut badly there. What is left, the *stems*, goes under a top tree, again by the sweep.

mod groups;
mod prune;

use self::groups::Group;
use self::prune::{Mini, prune};
use super::error::BuildError;
use super::prim_ref::PrimRefs;
use super::progress::Progress;
use super::recipe::options::BuildOptions;
use super::sweep::{Buffers, Sweep};
use super::top_down::driver::{Driver, Limits, check_slots};
use super::top_down::output::{Grown, Piece, Stem, splice};
use super::top_down::strategy::NodeTask;
use crate::exec::Executor;
use crate::tree::{MAX_DEPTH, Tree};

/// Deepest leaf of a mini tree. A group's balanced tree has at most a dozen levels, and a top tree of as many stems as a tree can have
/// references fits into what is left of [`MAX_DEPTH`].
const MINI_DEPTH: u32 = 28;

/// The tree over `input`; `share` is what it counts for in [`Progress::advance`].
pub(super) fn build(
    mut input: PrimRefs,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
    share: u64,
) -> Result<Tree, BuildError> {
    check_slots(input.refs.len())?;
    progress.phase("groups");
    let mut groups = exec.run(|| groups::divide(&mut input.refs, input.centroids, exec));
    if groups.len() <= 1 {
        // One mini tree is the whole.
        let Some(group) = groups.pop() else { return Ok(Tree::default()) };
        let (pair, root, piece) = mini_tree(group, MAX_DEPTH, options, progress, share)?;
        return Ok(Grown::Whole { pair, root, piece }.into_tree(exec));
    }

    progress.phase("mini trees");
    // Each group counts for its part of the progress, rounded so that the sum is exact.
    let total = input_len(&groups);
    let mut before = 0;
    let shares = groups.into_iter().map(|group| {
        let part = |refs: usize| (u128::from(share) * refs as u128 / total as u128) as u64;
        let first = before;
        before += group.refs.len();
        (part(before) - part(first), group)
    });
    let minis = exec.map(shares.collect(), |_, (share, group)| {
        if progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        let (_, root, piece) = mini_tree(group, MINI_DEPTH, options, progress, share)?;
        Ok(Mini { root, piece })
    });
    let minis = minis.into_iter().collect::<Result<Vec<Mini>, BuildError>>()?;
    drop(input);

    progress.phase("prune");
    let (stems, height) = exec.run(|| prune(&minis, options.prune, exec));
    progress.phase("top tree");
    let top = top_tree(&stems, MAX_DEPTH - height, options, exec, progress)?;
    progress.phase("put together");
    let pieces: Vec<&Piece> = minis.iter().map(|mini| &mini.piece).collect();
    Ok(exec.run(|| splice(&top, &stems, &pieces, exec)))
}

fn input_len(groups: &[Group]) -> usize {
    groups.iter().map(|group| group.refs.len()).sum()
}

/// The tree of one group, with a pair reserved for the root.
fn mini_tree(
    group: Group,
    max_depth: u32,
    options: &BuildOptions,
    progress: &dyn Progress,
    share: u64,
) -> Result<(u32, crate::tree::Node, Piece), BuildError> {
    let exec = Executor::sequential();
    let Group { refs, bounds, centroids } = group;
    let sweep = Sweep::new(options);
    let driver = Driver::new(&sweep, Limits { max_leaf: options.max_leaf, max_depth }, &exec, progress);
    let root = NodeTask { bounds, centroids, live: refs.len(), depth: 0 };
    let mut buffers = Buffers::sorted(refs, &exec);
    let mut piece = Piece::for_refs(refs.len());
    let pair = piece.reserve_pair();
    let root = driver.grow(root, buffers.all(refs), &mut piece, share);
    driver.finish((pair, root, piece))
}

/// The tree over the stems: one stem a leaf, and no leaf deeper than `max_depth`.
fn top_tree(
    stems: &[Stem],
    max_depth: u32,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Tree, BuildError> {
    let boxes: Vec<_> = stems.iter().map(|stem| stem.root.bounds()).collect();
    let input = PrimRefs::of_boxes(&boxes, exec);
    let root = NodeTask { bounds: input.bounds, centroids: input.centroids, live: boxes.len(), depth: 0 };
    let sweep = Sweep::over_subtrees(options);
    let driver = Driver::new(&sweep, Limits { max_leaf: 1, max_depth }, exec, progress);
    let mut buffers = exec.run(|| Buffers::sorted(&input.refs, exec));
    let grown = driver.grow_all(root, buffers.all(&input.refs), 0)?;
    Ok(grown.into_tree(exec))
}
