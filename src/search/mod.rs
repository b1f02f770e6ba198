//! Searches: the methods that try several recipes on a mesh and keep the tree that measured rays like best.
//!
//! What a tree is worth is what [families of rays](crate::trace::probe::Family) cost in it, a count without the noise of any clock: the
//! same mesh and options give the same tree on every machine with any number of threads. `best` tries a fixed list. `auto`
//! climbs from the cheapest recipe and stops where what it measured says that the rest cannot pay. Both write down what they
//! tried, what they saw and why they stopped.
//!
//! `tree` builds by one recipe, adaptation included, `gauge` measures, `verdict` says which tree is best by what was measured, `recipes` names
//! what can be tried, `ladder` decides what is tried next, `choice` is the written record.

mod choice;
mod gauge;
mod ladder;
mod progress;
mod recipes;
mod tree;
mod verdict;

#[cfg(feature = "cli")]
pub(crate) use choice::NAMED_RECIPE;
pub use choice::{Choice, Lead, Refusal, Trial, notes};
pub(crate) use tree::recipe_tree;
pub use verdict::Regret;

use self::ladder::Contest;
use self::progress::Portion;
use self::recipes::Start;
use crate::build::{BuildError, BuildOptions, Method, Progress};
use crate::exec::Executor;
use crate::scene::Mesh;
use crate::tree::Tree;

/// Below so many triangles a tree is built quicker than anything is measured: no search tries several.
pub const LEAST_TRIANGLES: usize = 512;

/// The tree that the search of `options.method` ends with, and how it came to it. At most one tree beside the one that is worked
/// on is kept.
pub(crate) fn build(
    mesh: &Mesh,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<(Tree, Choice), BuildError> {
    let count = mesh.triangles.len();
    if count < LEAST_TRIANGLES {
        let rung = Start::SbvhMoved.plain();
        let tree = recipe_tree(mesh, &rung.options(options, 0), exec, progress)?;
        let reason = format!("under {LEAST_TRIANGLES} triangles measuring costs more than it finds");
        return Ok((tree, Choice::unmeasured(rung, options, count, reason)));
    }
    let portion = Portion::new(progress, ladder::MOST_BUILDS);
    let mut contest = Contest::new(mesh, options, exec, &portion);
    let reason = match options.method {
        Method::Auto => ladder::climb(&mut contest)?,
        _ => ladder::try_all(&mut contest)?,
    };
    let found = contest.end(reason)?;
    portion.finish(count as u64);
    Ok(found)
}

/// Recipes of which a search may take any, adapted or not: what it must have memory for.
pub(crate) fn candidates(options: &BuildOptions) -> Vec<BuildOptions> {
    Start::ALL.iter().map(|start| start.plain().options(options, 0)).collect()
}

#[cfg(test)]
mod tests;
