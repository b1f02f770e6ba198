//! [`Below`]: what hangs below one node, as the records of a file of its own.

use crate::cache::{BlasRecord, TriangleRecord, View};
use crate::tree::Node;

/// A node and all below it, in canonical order and without the records of other nodes. It stands in the space of its tree.
pub struct Below {
    nodes: Vec<Node>,
    triangles: Vec<TriangleRecord>,
    blas: [BlasRecord; 1],
}

/// The second record of a tree.
const UNUSED: Node = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };

impl Below {
    /// Below record `node` of `NODE`. `None` where no node of a tree has this number: the second record of each tree is unused.
    pub fn of(view: &View<'_>, node: u64) -> Option<Below> {
        let local = |blas: &BlasRecord| {
            node.checked_sub(blas.node_offset).filter(|local| *local < u64::from(blas.node_count) && *local != 1)
        };
        let (number, local) = view.blases.iter().enumerate().find_map(|(i, blas)| Some((i, local(blas)?)))?;
        let tree = view.blas(number)?;
        let root = *tree.nodes.get(local as usize)?;
        let (mut nodes, mut triangles) = (vec![root, UNUSED], Vec::new());
        let mut pending = vec![0];
        while let Some(at) = pending.pop() {
            let Node { first, count, .. } = nodes[at];
            if count > 0 {
                nodes[at].first = triangles.len() as u32;
                triangles.extend_from_slice(tree.triangles.get(first as usize..)?.get(..count as usize)?);
            } else {
                let pair = nodes.len();
                nodes[at].first = pair as u32;
                nodes.extend_from_slice(tree.nodes.get(first as usize..)?.get(..2)?);
                pending.extend([pair + 1, pair]);
            }
        }
        let blas = BlasRecord {
            min: root.min,
            max: root.max,
            node_count: nodes.len() as u32,
            ref_count: triangles.len() as u32,
            node_offset: 0,
            ref_offset: 0,
            ..view.blases[number]
        };
        Some(Below { nodes, triangles, blas: [blas] })
    }

    /// It alone, beside the parts of the file that it comes from.
    pub fn view<'v>(&'v self, file: &View<'v>) -> View<'v> {
        View {
            nodes: &self.nodes,
            triangles: &self.triangles,
            blases: &self.blas,
            tlas_nodes: &[],
            instances: &[],
            ..*file
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::page::pack;

    #[test]
    fn a_node_has_its_own_triangles_in_canonical_order() {
        let positions: Vec<[f32; 3]> = (0..82u16).map(|i| [f32::from(i), f32::from(i % 2), 0.0]).collect();
        let triangles: Vec<[u32; 3]> = (0..80).map(|i| [i, i + 1, i + 2]).collect();
        let built = crate::Build::new(&positions, &triangles).unwrap().run().unwrap();
        let view = built.view();
        let (first, whole) = (u64::from(view.nodes[0].first), view.triangles.len());
        let counts: Vec<usize> = [first, first + 1]
            .into_iter()
            .map(|node| {
                let below = Below::of(&view, node).unwrap();
                pack(&below.view(&view)).unwrap().counts.triangles
            })
            .collect();
        assert_eq!(counts.iter().sum::<usize>(), whole);
        assert!(Below::of(&view, 1).is_none() && Below::of(&view, view.nodes.len() as u64).is_none());
    }
}
