//! Building: a [`Mesh`] becomes a [`Tree`], a [`Scene`](crate::scene::Scene)
//! becomes an [`Accel`](crate::tree::Accel).
//!
//! Four roles never mix. The *driver* owns the recursion, node emission, the depth guarantee and leaf creation; a
//! *strategy* (binned, spatial, sweep) answers one question, where to split this range; *cost* is the only place that knows
//! the SAH; the *executor* is the only place that knows threads. A method name is a recipe in the *registry*, which
//! also feeds `--help` and the build key. *Passes* improve a finished tree, whichever method made it.

mod agglomerative;
mod binned;
mod bonsai;
mod compile;
mod cost;
mod error;
pub mod passes;
mod presplit;
mod prim_ref;
mod progress;
mod radix;
mod recipe;
mod search;
mod spatial;
mod sweep;
mod top_down;
#[cfg(test)]
mod wide_door;

pub use crate::exec::Executor;
pub use binned::{Binned, ObjectSplit, area_scale, scaled_half_area};
pub use compile::{
    LaidOut, MAX_INSTANCES, Placing, bytes_to_reserve, compile, compile_laid_out, lay_out, primitives_to_build, tlas,
};
pub use cost::Sah;
pub use error::{BuildError, Remedy};
pub use prim_ref::{PrimRef, PrimRefs};
pub use progress::{NoProgress, Progress};
pub use recipe::names::{Named, nearest};
pub use recipe::options::{Axes, BuildOptions, Clip, Levels, MAX_ADAPT, Method, Preset};
pub use recipe::registry::{METHODS, MethodInfo, PRESETS, PresetInfo};
pub use recipe::row::{InKey, Kind, OptionInfo, Readers, Spelling};
pub use recipe::settings::Setting;
pub use recipe::table::{OPTIONS, option};
pub use search::{Choice, Trial, notes};
pub use spatial::{Spatial, budgeted_slots};
pub use top_down::driver;
pub use top_down::partition::bounds_of;
pub use top_down::strategy::{Child, Decision, NodeTask, Strategy};

use crate::scene::Mesh;
use crate::tree::Tree;

/// One mesh's tree by the method that the options name.
///
/// # Errors
/// Where the mesh breaks what [`Mesh::validate`] asks for, an option is out of its range, or the tree would be too large.
pub fn build_tree(
    mesh: &Mesh,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Tree, BuildError> {
    mesh.validate(0, exec)?;
    decide_tree(mesh, options, exec, progress).map(|(tree, _)| tree)
}

/// [`build_tree`], and how a search came to it.
pub fn decide_tree(
    mesh: &Mesh,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<(Tree, Option<Choice>), BuildError> {
    if options.method.is_search() {
        let (tree, choice) = search::build(mesh, options, exec, progress)?;
        return Ok((tree, Some(choice)));
    }
    compile_tree(mesh, options, exec, progress).map(|tree| (tree, None))
}

/// A tree by a method that is no search.
fn compile_tree(
    mesh: &Mesh,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Tree, BuildError> {
    let count = mesh.triangles.len();
    progress.phase("references");
    let tree = match options.method {
        Method::Binned => {
            let refs = references(mesh, options, exec)?;
            let live = refs.refs.len();
            driver::build(refs, live, &Binned::new(options), options.max_leaf, exec, progress, count as u64)?
        }
        Method::Agglomerative => {
            let refs = references(mesh, options, exec)?;
            agglomerative::build(refs, options, exec, progress, count as u64)?
        }
        // A search is no way to build: of what it tries, spatial splits are what this could only mean.
        Method::Sbvh | Method::Auto | Method::Best => {
            let slots = budgeted_slots(count, options.split_budget);
            driver::check_slots(slots)?;
            let slack = slots - count;
            let refs = PrimRefs::of_mesh(mesh, slack, exec);
            let strategy = Spatial::new(mesh, &refs.bounds, options);
            driver::build(refs, count, &strategy, options.max_leaf, exec, progress, count as u64)?
        }
        Method::Bonsai => bonsai::build(references(mesh, options, exec)?, options, exec, progress, count as u64)?,
        Method::Sweep => sweep::build(references(mesh, options, exec)?, options, exec, progress, count as u64)?,
    };
    let guide = passes::guide_for(mesh, &tree, options, exec, progress);
    passes::run(tree, guide.as_ref(), options, exec, progress).map(passes::Outcome::into_tree)
}

/// The references of a mesh, large triangles cut before where the options say so.
fn references(mesh: &Mesh, options: &BuildOptions, exec: &Executor) -> Result<PrimRefs, BuildError> {
    driver::check_slots(presplit::budgeted(mesh.triangles.len(), options.presplit))?;
    Ok(presplit::references(mesh, options.presplit, exec))
}
