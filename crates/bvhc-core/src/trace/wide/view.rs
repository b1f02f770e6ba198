use super::trees::WideRow;
use super::walk::{WideBottom, WideQuery};
use crate::geom::Ray;
use crate::layout::{View, WideNode};
use crate::simd::{Runs, Widest};
use crate::trace::hit::{Hit, Malformed};
use crate::trace::observe::{NoObserver, Observer};

/// A scene with wide trees, as borrowed slices: what rays are traced through.
#[derive(Clone, Copy, Debug)]
pub struct WideView<'a, const N: usize> {
    /// The scene: triangles, rows of trees, and the tree over the instances, which stays binary.
    pub view: View<'a>,
    /// The wide nodes of all trees.
    pub nodes: &'a [WideNode<N>],
    /// One row for each tree.
    pub rows: &'a [WideRow],
}

impl<const N: usize> WideView<'_, N>
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

    /// [`WideView::closest_hit`] with an observer that counts: a wide node that is entered is one inner node.
    ///
    /// # Errors
    /// As there.
    pub fn try_closest_hit(&self, ray: &Ray, observer: &mut impl Observer) -> Result<Option<Hit>, Malformed> {
        Widest::run(WideQuery::<false, N, _> { scene: self, ray, observer })
    }

    /// [`WideView::any_hit`] with an observer that counts.
    ///
    /// # Errors
    /// As there.
    pub fn try_any_hit(&self, ray: &Ray, observer: &mut impl Observer) -> Result<bool, Malformed> {
        Ok(Widest::run(WideQuery::<true, N, _> { scene: self, ray, observer })?.is_some())
    }
}

impl<'a, const N: usize> WideView<'a, N> {
    /// The nodes of one tree, or `None` where its row leads out of the records.
    #[inline(always)]
    pub(super) fn tree(&self, blas: usize) -> Option<WideBottom<'a, N>> {
        let row = self.rows.get(blas)?;
        let start = usize::try_from(row.node_offset).ok()?;
        let nodes = self.nodes.get(start..start.checked_add(row.node_count as usize)?)?;
        Some(WideBottom { nodes, waiting: row.waiting })
    }
}
