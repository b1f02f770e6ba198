use super::record::WideRecord;
use super::row::WideRow;
use super::walk::{WideQuery, WideTree};
use crate::exec::Executor;
use crate::geom::Ray;
use crate::layout::{TriangleRecord, View, WideNode};
use crate::simd::{Runs, Widest};
use crate::trace::batch::answer_all;
use crate::trace::hit::{BatchError, Hit, Malformed};
use crate::trace::observe::{NoObserver, Observer};

/// A scene with wide trees, as borrowed slices: what rays are traced through.
#[derive(Clone, Copy, Debug)]
pub struct WideView<'a, const N: usize, T = WideNode<N>> {
    /// The scene: triangles, rows of trees, and the tree over the instances, which stays binary.
    pub view: View<'a>,
    /// The wide nodes of all trees.
    pub nodes: &'a [T],
    /// One row for each tree.
    pub rows: &'a [WideRow],
    /// Of [`CompactTrees`](super::CompactTrees) the triangle behind each reference; empty for others, whose references are those of the view.
    pub order: &'a [u32],
}

impl<const N: usize, T: WideRecord<N>> WideView<'_, N, T>
where
    Widest: Runs<N>,
{
    /// The nearest hit, the same to the last bit as [`closest_hit`](crate::trace::closest_hit) finds it in [`WideView::view`]; only the
    /// [record](Hit::triangle) of a triangle that stands in several leaves may be another one of it.
    ///
    /// # Errors
    /// Where records are no tree, as there.
    pub fn closest_hit(&self, ray: &Ray) -> Result<Option<Hit>, Malformed> {
        self.try_closest_hit(ray, &mut NoObserver)
    }

    /// Whether the ray meets anything, as [`any_hit`](crate::trace::any_hit) says it.
    ///
    /// # Errors
    /// Where records are no tree, as there.
    pub fn any_hit(&self, ray: &Ray) -> Result<bool, Malformed> {
        self.try_any_hit(ray, &mut NoObserver)
    }

    /// [`WideView::closest_hit`] of many rays, shared among the threads of `exec`: `hits[i]` becomes the answer to `rays[i]`.
    ///
    /// # Errors
    /// Where the lengths differ, and then no hit is touched. Where records are no tree: some hits are filled in then and others are not.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>], exec: &Executor) -> Result<(), BatchError> {
        answer_all(rays, hits, exec, |ray| self.closest_hit(ray))
    }

    /// [`WideView::closest_hit`] with an observer that counts: a wide node that is entered is one inner node.
    ///
    /// # Errors
    /// As there.
    pub fn try_closest_hit(&self, ray: &Ray, observer: &mut impl Observer) -> Result<Option<Hit>, Malformed> {
        Widest::run(WideQuery::<false, N, T, _> { scene: self, ray, observer })
    }

    /// [`WideView::any_hit`] with an observer that counts.
    ///
    /// # Errors
    /// As there.
    pub fn try_any_hit(&self, ray: &Ray, observer: &mut impl Observer) -> Result<bool, Malformed> {
        Ok(Widest::run(WideQuery::<true, N, T, _> { scene: self, ray, observer })?.is_some())
    }
}

impl<'a, const N: usize, T: WideRecord<N>> WideView<'a, N, T> {
    /// One tree, over the triangles of the view from `first_triangle` on; `None` where its row leads out of the records.
    #[inline(always)]
    pub(super) fn tree(
        &self,
        blas: usize,
        first_triangle: usize,
        triangles: &'a [TriangleRecord],
    ) -> Option<WideTree<'a, T>> {
        let row = self.rows.get(blas)?;
        let start = usize::try_from(row.node_offset).ok()?;
        let nodes = self.nodes.get(start..start.checked_add(row.node_count as usize)?)?;
        let order = match T::ORDERED {
            true => self.order.get(first_triangle..first_triangle.checked_add(triangles.len())?)?,
            false => &[],
        };
        Some(WideTree { nodes, waiting: row.waiting, triangles, order })
    }
}
