//! [`Subtree`]: what hangs below one node, as a scene of its own.

use crate::cache::{BlasRecord, View};
use crate::tree::Node;

/// One tree of a file from one of its nodes down.
pub struct Subtree {
    nodes: Vec<Node>,
    blas: [BlasRecord; 1],
}

impl Subtree {
    /// Below record `node` of `NODE`. `None` where no node of a tree has this number: the second record of each tree is unused.
    pub fn of(view: &View<'_>, node: u64) -> Option<Subtree> {
        let is_there = |blas: &&BlasRecord| {
            node.checked_sub(blas.node_offset).is_some_and(|local| local < u64::from(blas.node_count) && local != 1)
        };
        let number = view.blases.iter().position(|blas| is_there(&blas))?;
        let blas = view.blases[number];
        let mut nodes = view.blas(number)?.nodes.to_vec();
        // Children are numbered from the tree's own start, so the root's record can hold any of its nodes.
        let root = *nodes.get((node - blas.node_offset) as usize)?;
        *nodes.first_mut()? = root;
        let blas = BlasRecord { min: root.min, max: root.max, node_offset: 0, ..blas };
        Some(Subtree { nodes, blas: [blas] })
    }

    /// It alone, in the space of its tree, beside the records of the file that it comes from.
    pub fn view<'v>(&'v self, file: &View<'v>) -> View<'v> {
        View { nodes: &self.nodes, blases: &self.blas, tlas_nodes: &[], instances: &[], ..*file }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::Step;

    fn triangles(view: &View<'_>) -> Vec<u32> {
        let mut found = Vec::new();
        view.blas(0)
            .unwrap()
            .visit(|at| {
                found.extend(at.triangles.iter().map(|t| t.prim));
                Step::Descend
            })
            .unwrap();
        found.sort_unstable();
        found
    }

    #[test]
    fn two_children_share_their_parent_s_triangles() {
        let strip = |i: u32| [[i as f32, 0.0, 0.0], [i as f32, 1.0, 0.0]];
        let positions: Vec<[f32; 3]> = (0..40).flat_map(strip).collect();
        let triangles_of: Vec<[u32; 3]> = (0..78).map(|i| [i, i + 1, i + 2]).collect();
        let built = crate::Build::new(&positions, &triangles_of).unwrap().run().unwrap();
        let view = built.view();
        let below = |node: u64| triangles(&Subtree::of(&view, node).unwrap().view(&view));
        let first = u64::from(view.nodes[0].first);
        let mut halves = [below(first), below(first + 1)].concat();
        halves.sort_unstable();
        assert!(halves == below(0) && halves.len() >= 78);
        assert!(Subtree::of(&view, 1).is_none() && Subtree::of(&view, view.nodes.len() as u64).is_none());
    }
}
