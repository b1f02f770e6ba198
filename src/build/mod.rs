//! Building: a [`Mesh`] becomes a [`Tree`]: methods and passes.
//!
//! What traces rays to build better stands above this room: [`search`](crate::search) finds the rays that trees are adapted to and tries
//! several recipes, and [`compile`](crate::compile) does all of it for whole scenes.
//!
//! Four roles never mix. The *driver* owns the recursion, node emission, the depth guarantee and leaf creation; a
//! *strategy* (binned, spatial, sweep) answers one question, where to split this range; *cost* is the only place that knows
//! the SAH; the *executor* is the only place that knows threads. A method name is a recipe in the *registry*, which
//! also feeds the help and the build key. *Passes* improve a finished tree, whichever method made it. [`motion`] makes trees for
//! meshes that move.

mod agglomerative;
mod binned;
mod bonsai;
mod cost;
mod error;
#[cfg(test)]
mod level_tests;
pub mod motion;
pub mod oabb;
pub(crate) mod passes;
mod presplit;
mod prim_ref;
mod progress;
mod radix;
mod recipe;
mod spatial;
mod sweep;
pub(crate) mod tlas;
mod top_down;

pub use crate::exec::Executor;
pub use error::{BuildError, Remedy};
pub use progress::{NoProgress, Progress};
pub use recipe::names::Named;
#[cfg(feature = "cli")]
pub(crate) use recipe::names::nearest;
pub use recipe::options::{Axes, BuildOptions, Clip, HullBasis, Levels, Method, Preset, Purpose};
#[cfg(feature = "cli")]
pub(crate) use recipe::registry::PRESETS;
pub use recipe::registry::{METHODS, MethodInfo};
pub use recipe::row::{Kind, OptionInfo, Spelling};
#[cfg(feature = "cli")]
pub(crate) use recipe::settings::Setting;
pub use recipe::table::{OPTIONS, option};
pub(crate) use top_down::driver::MAX_REFS;

use crate::scene::Mesh;
use crate::tree::Tree;
use binned::Binned;
use prim_ref::{PrimRef, PrimRefs};
use spatial::{Spatial, budgeted_slots};
use top_down::driver;

/// The tree that the options' method makes, before any pass.
///
/// A search is no method to build by: of what it tries, spatial splits are what it could only mean.
///
/// # Errors
/// Where the tree would have more references than there are numbers for, or `progress` cancels.
pub(crate) fn initial_tree(
    mesh: &Mesh,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Tree, BuildError> {
    let count = mesh.triangles.len();
    progress.phase("references");
    match options.method {
        Method::Binned => {
            let refs = references(mesh, options, exec)?;
            let live = refs.refs.len();
            driver::build(refs, live, &Binned::new(options), options.max_leaf, exec, progress, count as u64)
        }
        Method::Agglomerative => {
            let refs = references(mesh, options, exec)?;
            agglomerative::build(refs, options, exec, progress, count as u64)
        }
        Method::Oabb => oabb::build(mesh, options, exec, progress, count as u64),
        Method::Sbvh | Method::Auto | Method::Best => {
            let slots = budgeted_slots(count, options.split_budget);
            driver::check_slots(slots)?;
            let slack = slots - count;
            let refs = PrimRefs::of_mesh(mesh, slack, exec);
            let strategy = Spatial::new(mesh, &refs.bounds, options);
            driver::build(refs, count, &strategy, options.max_leaf, exec, progress, count as u64)
        }
        Method::Bonsai => bonsai::build(references(mesh, options, exec)?, options, exec, progress, count as u64),
        Method::Sweep => sweep::build(references(mesh, options, exec)?, options, exec, progress, count as u64),
    }
}

/// Bytes that the method sets aside before it builds a tree over so many triangles: the references with their duplicates, and what
/// it holds beside them.
pub(crate) fn bytes_to_reserve(triangles: usize, options: &BuildOptions) -> u64 {
    let references = match options.method {
        Method::Sbvh | Method::Auto | Method::Best => budgeted_slots(triangles, options.split_budget),
        Method::Binned | Method::Bonsai | Method::Sweep | Method::Agglomerative => {
            presplit::budgeted(triangles, options.presplit)
        }
        Method::Oabb => triangles,
    };
    let beside = match options.method {
        Method::Sweep => sweep::BYTES_PER_REF,
        Method::Agglomerative => agglomerative::BYTES_PER_REF,
        Method::Oabb => oabb::BYTES_PER_REF,
        Method::Binned | Method::Bonsai | Method::Sbvh | Method::Auto | Method::Best => 0,
    };
    (references as u64).saturating_mul(size_of::<PrimRef>() as u64 + beside)
}

/// The references of a mesh, large triangles cut before where the options say so.
fn references(mesh: &Mesh, options: &BuildOptions, exec: &Executor) -> Result<PrimRefs, BuildError> {
    driver::check_slots(presplit::budgeted(mesh.triangles.len(), options.presplit))?;
    Ok(presplit::references(mesh, options.presplit, exec))
}
