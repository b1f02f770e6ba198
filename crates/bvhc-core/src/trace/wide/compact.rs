use super::collapse::Collapse;
use super::scene::WideView;
use super::trees::WideTrees;
use crate::layout::{CompactNode, View, WideNode, WideRow};
use crate::trace::hit::Malformed;

/// The wide trees of a scene in a third of the bytes: boxes on grids of eight bits, rounded outward, so that rays find the same hits in them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CompactTrees {
    /// The nodes, tree after tree: in each tree the root, then the children of a node one behind the other, before those below the first of them.
    pub nodes: Vec<CompactNode>,
    /// One row for each tree.
    pub rows: Vec<WideRow>,
    /// The triangle of the tree that each reference of its nodes is; those of a tree stand where its triangles do. A permutation, since the leaves
    /// of a node are named by one number.
    pub order: Vec<u32>,
}

impl CompactTrees {
    /// Collapse all trees over triangles by the usual costs: what files of this crate have.
    ///
    /// # Errors
    /// As [`WideTrees::new`].
    pub fn of(view: &View<'_>) -> Result<CompactTrees, Malformed> {
        Ok(CompactTrees::new(&WideTrees::new(view, &Collapse::default())?))
    }

    /// The same trees, node by node.
    ///
    /// # Panics
    /// Where rows, nodes and order do not belong together, as those of [`WideTrees::new`] do.
    pub fn new(wide: &WideTrees<8>) -> CompactTrees {
        let mut out = CompactTrees::default();
        for row in &wide.rows {
            let start = row.node_offset as usize;
            out.add(&wide.nodes[start..start + row.node_count as usize], row.waiting, &wide.order);
        }
        out
    }

    fn add(&mut self, wide: &[WideNode<8>], waiting: u32, order: &[u32]) {
        let (start, first_ref) = (self.nodes.len(), self.order.len());
        self.rows.push(WideRow { node_offset: start as u64, node_count: wide.len() as u32, waiting });
        self.nodes.resize(start + wide.len(), CompactNode::default());
        // Where a wide node goes.
        let (mut pending, mut next) = (vec![(0, 0)], 1);
        pending.truncate(wide.len());
        while let Some((from, to)) = pending.pop() {
            let (node, below) = (&wide[from], pending.len());
            let children = node.children();
            let mut compact = CompactNode {
                first_node: next,
                first_ref: (self.order.len() - first_ref) as u32,
                ..CompactNode::default()
            };
            let boxes = [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| node.bounds(lane));
            compact.set_boxes(&boxes[..children]);
            for lane in 0..children {
                let (first, count) = (node.first[lane], node.count[lane]);
                compact.counts[lane] = count as u8;
                if count == 0 {
                    pending.push((first as usize, next));
                    next += 1;
                } else {
                    self.order.extend(&order[first as usize..][..count as usize]);
                }
            }
            pending[below..].reverse();
            self.nodes[start + to as usize] = compact;
        }
    }

    /// These trees with what they were made of: what rays are traced through.
    pub fn view<'a>(&'a self, of: &View<'a>) -> WideView<'a, 8, CompactNode> {
        WideView { view: *of, nodes: &self.nodes, rows: &self.rows, order: &self.order, blocks: &[] }
    }
}
