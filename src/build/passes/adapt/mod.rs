//! Adaptation: the tree is fitted to what rays meet, where the SAH fits it to rays that come from everywhere and pass through everything.
//!
//! In a room most rays end at its walls and never see what is behind; how often a box is visited is then not in proportion to its
//! area. So rays are traced between places of the scene, and from the root downward small parts of the tree, *treelets*, are put
//! together anew such that the fewest boxes are visited by them (Karras and Aila, "Fast Parallel Construction of High-Quality Bounding Volume
//! Hierarchies", 2013, with visits in the place of areas; that rays may stand there is from Bittner and Havran, "RDH: Ray Distribution
//! Heuristics for Construction of Spatial Data Structures", 2009). Where few rays come, areas decide as before.
//!
//! `guide` holds the rays and counts visits, `best` finds the best of all trees over a handful of nodes, and here is the way
//! down: treelets of one level lie in different subtrees, so they are found side by side, reading only, and then put in place one by one.

mod best;
mod guide;

use self::best::{Found, Workshop};
pub use self::guide::Guide;
use super::treelet::Treelet;
use super::work_tree::WorkTree;
use crate::build::error::BuildError;
use crate::build::progress::Progress;
use crate::exec::Executor;

/// Nodes that fewer rays visit stay as they are, with all below: areas would decide there.
const LEAST_RAYS: usize = 128;

/// Nodes of one level that a ray visits on average, so that time stays bounded where everything overlaps everything. In real scenes it is
/// a handful; beyond, the nodes that come last on the level stay as they are.
const MOST_VISITED: usize = 32;

/// A node whose treelet is next, and the rays that visit it.
struct Site {
    slot: u32,
    rays: Vec<u32>,
}

/// Put treelets together anew; returns how many were changed. Time grows with the rays times the depth, and hardly with the tree.
pub fn adapt(
    tree: &mut WorkTree,
    guide: &Guide,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<usize, BuildError> {
    progress.phase("adapt: visits");
    let mut visits = guide.visits(tree, exec);
    progress.phase("adapt: treelets");
    // A second way down finds other treelets, and next to nothing in them.
    descend(tree, &mut visits, guide, exec, progress)
}

/// Once from the root to where few rays come. Keeps `visits`, by slot, what they are.
fn descend(
    tree: &mut WorkTree,
    visits: &mut [u32],
    guide: &Guide,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<usize, BuildError> {
    let root = &tree.slots[0];
    let mut level = vec![Site { slot: 0, rays: guide.among(&guide.all(), &root.min, &root.max) }];
    level.retain(|site| site.rays.len() >= LEAST_RAYS);
    let (mut depth, mut changed, mut seen) = (0, 0, Vec::new());
    while !level.is_empty() {
        if progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        let slots: Vec<u32> = level.iter().map(|site| site.slot).collect();
        let found = {
            let (tree, visits) = (&*tree, &*visits);
            exec.map_with(level, Workshop::default, |workshop, _, site| {
                workshop.best(tree, visits, guide, depth, site.slot, &site.rays)
            })
        };
        level = Vec::new();
        for (&slot, Found { treelet, rays }) in slots.iter().zip(found) {
            if let Some(treelet) = treelet {
                changed += 1;
                put_together(tree, visits, &treelet);
            }
            let children = tree.slots[slot as usize].children();
            for (slot, rays) in children.into_iter().zip(rays) {
                if rays.len() >= LEAST_RAYS && !tree.slots[slot as usize].is_leaf() {
                    level.push(Site { slot, rays });
                }
            }
        }
        let mut left = MOST_VISITED * guide.segments.len();
        level.retain(|site| {
            let fits = site.rays.len() <= left;
            left -= if fits { site.rays.len() } else { 0 };
            fits
        });
        seen.extend(slots);
        depth += 1;
    }
    tree.measure(seen.into_iter().rev());
    Ok(changed)
}

fn put_together(tree: &mut WorkTree, visits: &mut [u32], treelet: &Treelet) {
    let of_front: Vec<u32> = treelet.front.iter().map(|&slot| visits[slot as usize]).collect();
    tree.put_together(treelet, |slot, part| {
        visits[slot as usize] = match part.count_ones() {
            1 => of_front[part.trailing_zeros() as usize],
            _ => treelet.visits[part],
        };
    });
}

#[cfg(test)]
mod tests;
