//! Reinsertion: nodes that stand badly are taken out and put where they cost least (Bittner, Hapala and Havran, "Fast
//! Insertion-Based Optimization of Bounding Volume Hierarchies", 2013).
//!
//! All searches of a round read the same tree, so they run side by side (Meister and Bittner, "Parallel Reinsertion for
//! Bounding Volume Hierarchy Optimization", 2018); the moves are then made one after the other, the largest gain first,
//! ties in the order of the slots, and one that an earlier move of the round stands in the way of waits for the next round.
//! So the result does not depend on the number of threads.
//!
//! Where the papers choose the nodes of a batch by their areas, here every node is asked in every round, but only for a
//! move that gains more than a threshold, which falls from round to round. The threshold is where the branch and bound
//! starts from, so a node that cannot gain as much is done with after a look or two: large gains are made first, and none
//! is missed because the node that makes it is small.

use super::search::{Move, Search};
use super::volumes::Volumes;
use super::work_tree::WorkTree;
use crate::build::error::BuildError;
use crate::build::progress::Progress;
use crate::build::radix;
use crate::exec::Executor;

/// The first and the last round's threshold, in units of what a node's area contributes on average.
const THRESHOLDS: [f64; 2] = [4.0, 0.1];
/// From here on the tree is as good as it will be, when a round lowers the sum of the inner areas by less than this
/// share of it …
const LEAST_GAIN: f64 = 2e-4;
/// … with a threshold no higher than this.
const FINE: f64 = 1.0;
/// Slots that a task searches for. A constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1 << 10;

/// Move subtrees, in at most so many rounds. Each costs O(n · depth) at worst.
pub fn reinsert<V: Volumes>(
    tree: &mut WorkTree,
    volumes: &mut V,
    rounds: u32,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<(), BuildError> {
    for round in 0..rounds {
        if progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        progress.phase("reinsert: search");
        let threshold = threshold(round, rounds);
        let before = tree.inner_area;
        let least = threshold * before / tree.slots.len() as f64;
        let moves = find_moves(tree, &*volumes, least as f32, exec);
        progress.phase("reinsert: move");
        for Move { from, to, .. } in moves {
            tree.move_subtree(from, to);
        }
        progress.phase("reinsert: refit");
        tree.refit(volumes);
        if threshold <= FINE && before - tree.inner_area < LEAST_GAIN * before {
            break;
        }
    }
    Ok(())
}

/// Falls from the first to the last value by about the same factor from round to round. A polynomial, because a power does
/// not have the same bits on every machine.
fn threshold(round: u32, rounds: u32) -> f64 {
    let [first, last] = THRESHOLDS;
    let left = 1.0 - f64::from(round) / f64::from(rounds.max(2) - 1);
    last + (first - last) * (left * left * left)
}

/// The best move of every node that has one, the largest gain first.
fn find_moves<V: Volumes>(tree: &WorkTree, volumes: &V, least: f32, exec: &Executor) -> Vec<Move> {
    let found = exec.map_chunks(&tree.slots, CHUNK, |chunk_index, chunk| {
        let start = (chunk_index * CHUNK) as u32;
        let mut search = Search::new(tree, volumes, least);
        // The root has no place, and slot 1 is none.
        let slots = start.max(2)..start + chunk.len() as u32;
        slots.filter_map(|from| search.best_move(from)).collect::<Vec<_>>()
    });
    let found = found.concat();
    // Gains are positive, so their bits stand in the order of their values.
    let mut order: Vec<u64> =
        (found.iter().enumerate()).map(|(i, m)| u64::from(!m.gain.to_bits()) << 32 | i as u64).collect();
    radix::sort(&mut order, exec);
    order.into_iter().map(|key| found[key as u32 as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_fall_from_the_first_to_the_last() {
        for rounds in [1u32, 2, 3, 8, 100] {
            let all: Vec<f64> = (0..rounds).map(|round| threshold(round, rounds)).collect();
            assert!(all.is_sorted_by(|a, b| a > b), "{all:?}");
            assert_eq!(all[0], 4.0);
            assert!(rounds == 1 || all[rounds as usize - 1] == 0.1, "{all:?}");
        }
    }
}
