//! A mesh's tree by one recipe, and the rays that it is adapted to.

use crate::build::passes::{self, Guide, Outcome};
use crate::build::{BuildError, BuildOptions, Progress, initial_tree};
use crate::exec::Executor;
use crate::scene::Mesh;
use crate::trace::Lent;
use crate::trace::probe::everywhere;
use crate::tree::Tree;

/// The tree by a method that is no search, with the passes that the options ask for.
///
/// # Errors
/// As [`initial_tree`].
pub fn recipe_tree(
    mesh: &Mesh,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Tree, BuildError> {
    let tree = initial_tree(mesh, options, exec, progress)?;
    let guide = guide_for(mesh, &tree, options, exec, progress);
    passes::run(tree, guide.as_ref(), options, exec, progress).map(Outcome::into_tree)
}

/// The rays that the options want a mesh's trees adapted to, if they do: `adapt` in each of three sets (see [`everywhere`]). Any tree of
/// the mesh helps to find them, and none changes them.
pub fn guide_for(
    mesh: &Mesh,
    tree: &Tree,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Option<Guide> {
    if options.adapt == 0 {
        return None;
    }
    progress.phase("adapt: rays");
    let lent = Lent::new(mesh, tree, exec);
    Some(Guide::new(&everywhere(&lent.view(), options.adapt as usize, exec)))
}
