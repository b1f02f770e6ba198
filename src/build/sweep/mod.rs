//! Full sweep SAH: every plane between two neighbouring centres, on all three axes (MacDonald and Booth, "Heuristics for Ray Tracing
//! Using Space Subdivision", 1990).
//!
//! The axes are sorted once, before the recursion, and every split keeps the three orders by a stable partition, so that the whole
//! tree costs O(n log n) and is the same as if each node were sorted anew (Ganestam, Barringer, Doggett and Akenine-Möller, "Bonsai:
//! Rapid Bounding Volume Hierarchy Generation using Mini Trees", 2015, section 4). Nodes of up to four references try every
//! partition, as the binned method does.

mod orders;
mod planes;
mod sort;
#[cfg(test)]
pub(super) mod tests;

pub(super) use self::orders::{BYTES_PER_REF, Buffers, Orders};

use super::binned::{EXHAUSTIVE, area_scale, best_subset, scaled_half_area};
use super::cost::Sah;
use super::error::BuildError;
use super::prim_ref::PrimRefs;
use super::progress::Progress;
use super::recipe::options::BuildOptions;
use super::top_down::driver::{Driver, Limits, check_slots};
use super::top_down::range::Splitter;
use super::top_down::strategy::{Decision, NodeTask};
use crate::exec::Executor;
use crate::tree::{MAX_DEPTH, Tree};

/// The method `sweep`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sweep {
    sah: Sah,
    max_leaf: usize,
}

/// The tree over `input`; `share` is what it counts for in [`Progress::advance`].
pub(super) fn build(
    input: PrimRefs,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
    share: u64,
) -> Result<Tree, BuildError> {
    let live = input.refs.len();
    check_slots(live)?;
    if live == 0 {
        return Ok(Tree::default());
    }
    let root = NodeTask { bounds: input.bounds, centroids: input.centroids, live, depth: 0 };
    let sweep = Sweep::new(options);
    let driver = Driver::new(&sweep, Limits { max_leaf: options.max_leaf, max_depth: MAX_DEPTH }, exec, progress);
    progress.phase("sort");
    let mut buffers = exec.run(|| Buffers::sorted(&input.refs, exec));
    progress.phase("split");
    let grown = driver.grow_all(root, buffers.all(&input.refs), share)?;
    progress.phase("put together");
    drop((input, buffers));
    Ok(grown.into_tree(exec))
}

impl Sweep {
    pub fn new(options: &BuildOptions) -> Sweep {
        Sweep {
            sah: Sah { traversal: options.traversal_cost, intersection: options.intersection_cost },
            max_leaf: options.max_leaf as usize,
        }
    }

    /// One reference a leaf, each of which stands for a finished subtree.
    pub fn over_subtrees(options: &BuildOptions) -> Sweep {
        Sweep { max_leaf: 1, ..Sweep::new(options) }
    }

    /// Whether a node is better a leaf, or at least better not split here. A split of this weight gains nothing where each child
    /// is as large as its parent: no other plane does better, and the driver's halves are at least balanced.
    fn refuses(&self, node: &NodeTask, weight: f32, scale: f32) -> bool {
        let area = scaled_half_area(&node.bounds, scale);
        weight >= area * node.live as f32
            || node.live <= self.max_leaf && self.sah.prefers_leaf(node.live, weight, area)
    }
}

impl Splitter<Orders<'_>> for Sweep {
    fn split(&self, node: &NodeTask, range: &mut Orders<'_>, exec: &Executor) -> Decision {
        let scale = area_scale(&node.bounds);
        if node.live <= EXHAUSTIVE {
            let refs = range.few();
            return match best_subset(&refs[..node.live], scale) {
                Some((subset, weight, bounds)) if !self.refuses(node, weight, scale) => {
                    let (left, right) = range.divide_few(subset, bounds);
                    Decision::Split { left, right }
                }
                _ => Decision::Leaf,
            };
        }
        range.come_close();
        match planes::best(range, scale, exec) {
            Some(plane) if !self.refuses(node, plane.weight, scale) => {
                let (left, right) = range.divide(&plane, exec);
                Decision::Split { left, right }
            }
            _ => Decision::Leaf,
        }
    }
}
