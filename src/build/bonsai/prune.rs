//! Opening what is large: the paper's mini-tree pruning.

use crate::build::exec::Executor;
use crate::build::top_down::output::{Piece, Stem};
use crate::tree::Node;

/// The tree of one group; the first pair of its nodes is unused.
pub(super) struct Mini {
    pub root: Node,
    pub piece: Piece,
}

/// What is left of the mini trees when all nodes are opened whose area is more than `ratio` times that of the average mini tree, in
/// their order; and the height of the highest mini tree.
pub(super) fn prune(minis: &[Mini], ratio: f32, exec: &Executor) -> (Vec<Stem>, u32) {
    let mean = minis.iter().map(|mini| half_area(&mini.root)).sum::<f64>() / minis.len() as f64;
    let limit = mean * f64::from(ratio);
    let parts = exec.map(minis.iter().collect(), |index, mini: &Mini| {
        let mut stems = Vec::new();
        let mut open = vec![mini.root];
        while let Some(node) = open.pop() {
            if !node.is_leaf() && half_area(&node) > limit {
                let pair = node.first as usize;
                open.extend([mini.piece.nodes[pair + 1], mini.piece.nodes[pair]]);
            } else {
                stems.push(Stem::of(node, index, &mini.piece));
            }
        }
        (stems, mini.piece.height(&mini.root))
    });
    let height = parts.iter().map(|(_, height)| *height).max().unwrap_or(0);
    (parts.into_iter().flat_map(|(stems, _)| stems).collect(), height)
}

/// Half the area in `f64`, which no finite box overflows.
fn half_area(node: &Node) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|a| f64::from(node.max[a]) - f64::from(node.min[a]));
    x * y + y * z + z * x
}
