//! A mesh's tree by one recipe, and the rays that it is adapted to.

use super::gauge::{FORMING, Gauge, Measure, rays_for, serves};
use super::verdict::harm;
use crate::build::passes::{self, Guide, Outcome};
use crate::build::{BuildError, BuildOptions, Progress, initial_tree};
use crate::exec::Executor;
use crate::scene::Mesh;
use crate::trace::Lent;
use crate::trace::probe::FamilyRays;
use crate::tree::Tree;

/// The tree by a method that is no search, with the passes that the options ask for. Adaptation is taken back where it does
/// [harm](super::verdict::harm) by other rays than those that it was formed by.
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
    if options.adapt == 0 {
        return passes::run(tree, None, options, exec, progress).map(Outcome::into_tree);
    }
    let moved = BuildOptions { collapse: false, ..options.clone() };
    let mut tree = passes::run(tree, None, &moved, exec, progress)?.into_tree();
    progress.phase("adapt: judge");
    let mut gauge = Gauge::new(mesh, rays_for(mesh, exec), exec).serving(options.purpose);
    let before = gauge.measure(&tree);
    let guide = guide_for(mesh, &tree, &before, &mut None, options, exec, progress);
    let alone = BuildOptions { reinsert: 0, ..moved };
    if let Some(adapted) = passes::improved(&tree, guide, &alone, exec, progress)? {
        progress.phase("adapt: judge");
        if harm(&before, &gauge.measure(&adapted)).is_none() {
            tree = adapted;
        }
    }
    let rest = BuildOptions { reinsert: 0, ..options.clone() };
    passes::run(tree, None, &rest, exec, progress).map(Outcome::into_tree)
}

/// The rays that the options want this tree adapted to: up to `adapt` of each family that serves the purpose, of each as many as weigh the same
/// by what others of it pay in the tree. Whatever the tree, they are taken from the same ones, which `forming` keeps. `None` where no rays
/// were asked what they pay.
pub fn guide_for(
    mesh: &Mesh,
    tree: &Tree,
    paid: &Measure,
    forming: &mut Option<FamilyRays>,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Option<Guide> {
    let cost = paid.cost.as_ref()?;
    progress.phase("adapt: rays");
    let lent = Lent::new(mesh, tree, exec);
    let view = lent.view();
    let rays = forming.get_or_insert_with(|| {
        let mut rays = FamilyRays::new(&view, options.adapt as usize, FORMING, exec);
        rays.retain(|family| serves(family, options.purpose));
        rays
    });
    Some(Guide::new(&rays.balanced(cost).cut_off(&view, exec)))
}
