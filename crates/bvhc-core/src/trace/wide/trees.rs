use super::collapse::Collapse;
#[cfg(any(test, feature = "testing"))]
use super::emit::Greedy;
use super::emit::{Shape, emit};
use super::plan::Plan;
use super::scene::WideView;
use crate::layout::{BlasView, View, WideNode, WideRow};
use crate::trace::hit::Malformed;

/// The wide trees of a scene in memory: one for each tree over triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WideTrees<const N: usize> {
    /// The nodes, tree after tree, and in each tree a node before those below it.
    pub nodes: Vec<WideNode<N>>,
    /// One row for each tree of the view that they were made of, in its order.
    pub rows: Vec<WideRow>,
}

impl<const N: usize> WideTrees<N> {
    /// Collapse all trees over triangles, on this thread, in time that grows as their size does. `N` is 4 or 8.
    ///
    /// The same trees give the same nodes on every machine.
    ///
    /// # Errors
    /// Where records are no tree, which a file that was opened at [`Validation::Tree`](crate::cache::Validation::Tree) has none of, nor what was built.
    pub fn new(view: &View<'_>, collapse: &Collapse) -> Result<WideTrees<N>, Malformed> {
        const { assert!(N == 4 || N == 8, "a wide node has 4 or 8 lanes") };
        WideTrees::shaped(view, |tree| Plan::new::<N>(tree, collapse))
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
        let (mut nodes, mut rows) = (Vec::new(), Vec::new());
        for tree in view.trees() {
            let tree = tree?;
            let start = nodes.len();
            let waiting = emit(&tree, &shape_of(&tree)?, &mut nodes);
            rows.push(WideRow { node_offset: start as u64, node_count: (nodes.len() - start) as u32, waiting });
        }
        Ok(WideTrees { nodes, rows })
    }

    /// These trees with what they were made of: what rays are traced through.
    pub fn view<'a>(&'a self, of: &View<'a>) -> WideView<'a, N> {
        WideView { view: *of, nodes: &self.nodes, rows: &self.rows, order: &[] }
    }
}
