//! What a crossing becomes where a tree stands.

use super::hit::{Best, Hit};
use super::observe::Observer;
use super::test::Crossing;
use crate::layout::TriangleRecord;

/// Where a tree over triangles stands.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Where its triangles start among all.
    pub first_triangle: usize,
    pub instance: Option<u32>,
}

impl Place {
    /// Offer a crossing of the triangle in a slot of the tree; true if it lies in range.
    #[inline(always)]
    pub fn offer(
        self,
        c: Crossing,
        triangle: &TriangleRecord,
        slot: usize,
        t_min: f64,
        best: &mut Best,
        observer: &mut impl Observer,
    ) -> bool {
        let accepted = Place::accepts(&c, slot, t_min, best, observer);
        if accepted {
            self.take(c, triangle, slot, best);
        }
        accepted
    }

    /// Whether a crossing lies in range, up to the best one.
    #[inline(always)]
    pub fn accepts(c: &Crossing, slot: usize, t_min: f64, best: &Best, observer: &mut impl Observer) -> bool {
        let accepted = c.t >= t_min && c.t <= best.t;
        observer.crossing(slot, c.t, accepted);
        accepted
    }

    /// Take a crossing in range, if it comes before the best one.
    #[inline(always)]
    pub fn take(self, c: Crossing, triangle: &TriangleRecord, slot: usize, best: &mut Best) {
        best.offer(c.t, self.hit(c, triangle, slot));
    }

    fn hit(self, c: Crossing, triangle: &TriangleRecord, slot: usize) -> Hit {
        Hit {
            t: c.t as f32,
            u: (c.u / c.sum) as f32,
            v: (c.v / c.sum) as f32,
            prim: triangle.prim,
            geom: triangle.geom,
            instance: self.instance,
            triangle: self.first_triangle + slot,
        }
    }
}
