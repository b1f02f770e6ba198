//! Opening what is large: the paper's mini-tree pruning.

use crate::build::top_down::output::{Piece, Stem};
use crate::exec::Executor;
use crate::tree::Node;

/// The tree of one group; the first pair of its nodes is unused.
pub(super) struct Mini {
    pub root: Node,
    pub piece: Piece,
}

/// Of so many references there is one stem at most. Where boxes all reach over each other nearly every node is large, and the top tree
/// over them would be a second tree over everything, in time and in memory.
const REFS_PER_STEM: usize = 8;

/// What is left of the mini trees when all nodes are opened whose area is more than `ratio` times that of the average mini tree, in
/// their order; and the height of the highest mini tree. The ratio doubles until there is no more than a stem for every
/// [`REFS_PER_STEM`] references, or a stem a mini tree.
pub(super) fn prune(minis: &[Mini], ratio: f32, exec: &Executor) -> (Vec<Stem>, u32) {
    let mean = minis.iter().map(|mini| half_area(&mini.root)).sum::<f64>() / minis.len() as f64;
    let largest = minis.iter().map(|mini| half_area(&mini.root)).fold(0.0, f64::max);
    let most = minis.iter().map(|mini| mini.piece.refs.len()).sum::<usize>() / REFS_PER_STEM;
    let heights = exec.map(minis.iter().collect(), |_, mini: &Mini| mini.piece.height(&mini.root));
    let height = heights.into_iter().max().unwrap_or(0);

    let mut limit = mean * f64::from(ratio);
    loop {
        let parts = exec.map(minis.iter().collect(), |index, mini| open(index, mini, limit, most));
        let count: usize = parts.iter().map(Vec::len).sum();
        if count <= most.max(minis.len()) || limit >= largest {
            let mut stems = Vec::with_capacity(count);
            stems.extend(parts.into_iter().flatten());
            return (stems, height);
        }
        limit = (2.0 * limit).max(largest * 1e-6);
    }
}

/// The stems of one mini tree, in its order; not all where there are more than `most`.
fn open(index: usize, mini: &Mini, limit: f64, most: usize) -> Vec<Stem> {
    let mut stems = Vec::new();
    let mut open = vec![mini.root];
    while let Some(node) = open.pop()
        && stems.len() <= most
    {
        if !node.is_leaf() && half_area(&node) > limit {
            let pair = node.first as usize;
            open.extend([mini.piece.nodes[pair + 1], mini.piece.nodes[pair]]);
        } else {
            stems.push(Stem::of(node, index, &mini.piece));
        }
    }
    stems
}

/// Half the area in `f64`, which no finite box overflows.
fn half_area(node: &Node) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|a| f64::from(node.max[a]) - f64::from(node.min[a]));
    x * y + y * z + z * x
}
