use super::block::{LANES, TriangleBlock};
use super::collapse::Collapse;
#[cfg(any(test, feature = "testing"))]
use super::emit::Greedy;
use super::emit::{Shape, emit};
use super::plan::Plan;
use super::scene::WideView;
use crate::layout::{BlasView, MAX_LEAF, TriangleRecord, View, WideNode, WideRow};
use crate::trace::hit::Malformed;

/// The wide trees of a scene in memory: one for each tree over triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WideTrees<const N: usize> {
    /// The nodes, tree after tree, and in each tree a node before those below it.
    pub nodes: Vec<WideNode<N>>,
    /// One row for each tree of the view that they were made of, in its order.
    pub rows: Vec<WideRow>,
    /// The triangle of its tree that each reference is. Leaves name references by their numbers here, where they stand leaf after leaf, in the order of nodes and
    /// lanes. Each leaf begins a block of four, and what is left of its last one is `u32::MAX`.
    pub order: Vec<u32>,
    /// The triangles of each four references: 36 bytes a triangle where all four lanes are used.
    pub blocks: Vec<TriangleBlock>,
}

impl<const N: usize> WideTrees<N> {
    /// Collapse all trees over triangles, on this thread, in time that grows as their size does. `N` is 4 or 8. No leaf gets more than
    /// [`MAX_LEAF`] triangles, whatever `collapse` says.
    ///
    /// The same trees give the same nodes on every machine.
    ///
    /// # Errors
    /// Where records are no tree, which a file that was opened at [`Validation::Tree`](crate::cache::Validation::Tree) has none of, nor what was built.
    pub fn new(view: &View<'_>, collapse: &Collapse) -> Result<WideTrees<N>, Malformed> {
        const { assert!(N == 4 || N == 8, "a wide node has 4 or 8 lanes") };
        let collapse = Collapse { max_leaf: collapse.max_leaf.min(MAX_LEAF), ..*collapse };
        WideTrees::shaped(view, |tree| Plan::new::<N>(tree, &collapse))
    }

    /// By pulling up the largest child, as other libraries do: a yardstick for [`Collapse`].
    ///
    /// # Errors
    /// As [`WideTrees::new`].
    #[cfg(any(test, feature = "testing"))]
    pub fn greedy(view: &View<'_>) -> Result<WideTrees<N>, Malformed> {
        WideTrees::shaped(view, Greedy::new)
    }

    fn shaped<'v, S: Shape>(
        view: &View<'v>,
        shape_of: impl Fn(&BlasView<'v>) -> Result<S, Malformed>,
    ) -> Result<WideTrees<N>, Malformed> {
        let mut out = WideTrees { nodes: Vec::new(), rows: Vec::new(), order: Vec::new(), blocks: Vec::new() };
        for tree in view.trees() {
            let tree = tree?;
            let start = out.nodes.len();
            let waiting = emit(&tree, &shape_of(&tree)?, &mut out.nodes);
            let node_count = (out.nodes.len() - start) as u32;
            out.rows.push(WideRow { node_offset: start as u64, node_count, waiting });
            out.fill_blocks(start, tree.triangles)?;
        }
        Ok(out)
    }

    /// Put the triangles of leaves into blocks, from a node on, and name them by their places there.
    fn fill_blocks(&mut self, start: usize, triangles: &[TriangleRecord]) -> Result<(), Malformed> {
        for node in &mut self.nodes[start..] {
            for (first, count) in node.first.iter_mut().zip(node.count).filter(|(_, count)| *count > 0) {
                let some = triangles.get(*first as usize..).and_then(|t| t.get(..count as usize));
                let (Some(some), Ok(place)) = (some, u32::try_from(self.order.len())) else {
                    return Err(Malformed::LeafOutOfRange { first: *first, count, refs: triangles.len() });
                };
                self.order.extend(*first..*first + count);
                *first = place;
                self.blocks.extend(some.chunks(LANES).map(TriangleBlock::new));
                self.order.resize(self.blocks.len() * LANES, u32::MAX);
            }
        }
        Ok(())
    }

    /// These trees with what they were made of: what rays are traced through.
    pub fn view<'a>(&'a self, of: &View<'a>) -> WideView<'a, N> {
        WideView { view: *of, nodes: &self.nodes, rows: &self.rows, order: &self.order, blocks: &self.blocks }
    }
}
