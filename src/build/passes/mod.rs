//! Passes: what is done to a finished tree, whichever method made it.
//!
//! A pass turns a [`Tree`] into a better one over the same references. It moves boxes and leaves, not triangles, so it works
//! on trees with split references as on others: a leaf's box, clipped or not, moves as it is, and every box above is the
//! union of two. Passes work on a `WorkTree`, whose nodes can be moved, and end with the emission of canonical order, which
//! also makes leaves of subtrees where that is cheaper. Reinsertion looks at areas; `adapt`, which comes after it, at rays.
//! `poses` is reinsertion for a mesh that moves.

mod adapt;
mod emit;
mod links;
mod poses;
mod reinsert;
mod search;
mod slot;
#[cfg(test)]
mod tests;
mod treelet;
mod volumes;
mod work_tree;

pub use self::adapt::Guide;
use self::emit::{Collapse, emit};
pub use self::poses::{MOST_POSES, ScaledPose, bytes_per_node, over_poses};
use self::volumes::OneBox;
use self::work_tree::WorkTree;
use super::cost::Sah;
use super::error::BuildError;
use super::progress::Progress;
use super::recipe::options::BuildOptions;
use crate::exec::Executor;
use crate::tree::Tree;

/// Do the passes that the options ask for.
///
/// `guide` holds the rays that the tree is adapted to, and is given up as soon as it is; without one it is not adapted, whatever the options say. The result depends on tree, guide and options alone, not on the executor. But for what
/// rays decide, its SAH, with the options' costs, is not above the tree's. Its depth is within [`MAX_DEPTH`](crate::tree::MAX_DEPTH) as the tree's must be. References stay in their leaves, but for
/// leaves that are joined, which hold each triangle once.
pub fn run(
    tree: Tree,
    guide: Option<Guide>,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Outcome, BuildError> {
    let Some(work) = changed(&tree, guide, options, exec, progress)? else { return Ok(Outcome::Same(tree)) };
    // Two trees are enough to hold while the third is written.
    let Tree { nodes, refs } = tree;
    drop(nodes);
    Ok(Outcome::Better(put_together(&work, &refs, options, exec)))
}

/// What the passes made of a tree.
pub enum Outcome {
    Same(Tree),
    Better(Tree),
}

impl Outcome {
    pub fn into_tree(self) -> Tree {
        match self {
            Outcome::Same(tree) | Outcome::Better(tree) => tree,
        }
    }
}

/// [`run`] beside the tree that it starts from; `None` where it would be that tree.
pub fn improved(
    tree: &Tree,
    guide: Option<Guide>,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Option<Tree>, BuildError> {
    let work = changed(tree, guide, options, exec, progress)?;
    Ok(work.map(|work| put_together(&work, &tree.refs, options, exec)))
}

/// The tree with its subtrees moved; `None` where nothing is to be written anew.
fn changed(
    tree: &Tree,
    guide: Option<Guide>,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Option<WorkTree>, BuildError> {
    if options.reinsert == 0 && guide.is_none() && !options.collapse {
        return Ok(None);
    }
    progress.phase("reinsert: links");
    let Some(mut work) = WorkTree::new(tree, exec) else { return Ok(None) };
    let before = work.inner_area;
    let mut one = OneBox { scale: work.scale };
    exec.run(|| reinsert::reinsert(&mut work, &mut one, options.reinsert, exec, progress))?;

    // Moves of one round can spoil each other's gain. If so little is left of it that rounding could be all, stay.
    let is_better = work.inner_area < before * (1.0 - 1e-6);
    if !is_better && options.reinsert > 0 {
        work = match WorkTree::new(tree, exec) {
            Some(work) => work,
            None => return Ok(None),
        };
    }
    let is_adapted = match guide {
        Some(guide) => adapt::adapt(&mut work, &guide, exec, progress)? > 0,
        None => false,
    };
    if !is_better && !is_adapted && !options.collapse {
        return Ok(None);
    }
    if progress.is_cancelled() {
        return Err(BuildError::Cancelled);
    }
    progress.phase("reinsert: put together");
    Ok(Some(work))
}

fn put_together(work: &WorkTree, refs: &[u32], options: &BuildOptions, exec: &Executor) -> Tree {
    let sah = Sah { traversal: options.traversal_cost, intersection: options.intersection_cost };
    let collapse = options.collapse.then_some(Collapse { sah, max_leaf: options.max_leaf as usize });
    emit(work, refs, collapse, exec)
}
