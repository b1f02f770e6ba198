use crate::build::{BuildError, BuildOptions, Progress};
use crate::exec::Executor;
use crate::scene::Mesh;
use crate::search::{self, Choice, recipe_tree};
use crate::tree::Tree;

/// One mesh's tree by the method that the options name, with the passes that they ask for.
///
/// # Errors
/// Where the mesh breaks what [`Mesh::validate`] asks for, the tree would be too large, or `progress` cancels.
pub fn build_tree(
    mesh: &Mesh,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Tree, BuildError> {
    decide_tree(mesh, options, exec, progress).map(|(tree, _)| tree)
}

/// [`build_tree`], and how a search came to it.
///
/// # Errors
/// As [`build_tree`].
pub fn decide_tree(
    mesh: &Mesh,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<(Tree, Option<Choice>), BuildError> {
    mesh.validate(0, exec)?;
    decide_sound(mesh, options, exec, progress)
}

/// [`decide_tree`] of a mesh that was looked at before.
#[inline(never)] // `benches/instructions.sh` counts what is below it by its name
pub(crate) fn decide_sound(
    mesh: &Mesh,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<(Tree, Option<Choice>), BuildError> {
    if options.method.is_search() {
        let (tree, choice) = search::build(mesh, options, exec, progress)?;
        return Ok((tree, Some(choice)));
    }
    recipe_tree(mesh, options, exec, progress).map(|tree| (tree, None))
}
