//! Rays between two frames: the walk of still files over nodes and triangles that are interpolated when the walk comes to them.
//!
//! Nothing is added to boxes for that. A box and the vertices in it are interpolated by the same expression, which keeps their order to the bit
//! ([`Mix`]), so at any time a box contains the rounded vertices below it, as a stored box does; and the walk and the triangle test see no
//! difference. The top level has boxes that hold an instance at all times.

use super::batch::answer_all;
use super::hit::{BatchError, Best, Hit, Malformed};
use super::intersect::EdgeRay;
use super::moving::Moving;
use super::observe::NoObserver;
use super::place::Place;
use super::slab::Conservative;
use super::source::Records;
use super::traverse::{Bottom, FARTHEST, Stack, is_usable, slabs_for, walk};
use super::way_back::way_back;
use crate::cache::Between;
use crate::exec::Executor;
use crate::geom::vector::{cross, sub};
use crate::geom::{Mix, Ray};

impl Between<'_> {
    /// The nearest point where the ray meets the scene at that time: a fraction from 0, at the first frame, to 1, at the second.
    ///
    /// At 0 and at 1 hits are those of the frames, bit for bit. [`Hit::geom`] is a row of [`Sequence::geoms`](crate::cache::Frames::geoms), and
    /// [`Hit::triangle`] an index into [`Sequence::indexed_triangles`](crate::cache::Frames::indexed_triangles), so hits of all times can be compared; a
    /// [`Frame`](crate::cache::Frame) numbers its own.
    ///
    /// At another time than from 0 to 1, and at NaN, nothing is met: it belongs to other frames. An instance that goes through a plane between the
    /// frames, as one that turns by half does, is not met at the times when its matrix has no inverse: those at which the determinant is
    /// below 2⁻³² of the terms that it is summed from.
    ///
    /// # Errors
    /// As [`closest_hit`](super::closest_hit).
    pub fn closest_hit(&self, ray: &Ray, fraction: f32) -> Result<Option<Hit>, Malformed> {
        trace::<false>(self, ray, fraction)
    }

    /// Whether the ray meets anything at that time; see [`Between::closest_hit`].
    ///
    /// # Errors
    /// As [`closest_hit`](super::closest_hit).
    pub fn any_hit(&self, ray: &Ray, fraction: f32) -> Result<bool, Malformed> {
        Ok(trace::<true>(self, ray, fraction)?.is_some())
    }

    /// The nearest hit of each of many rays, each at a time of its own, shared among the threads of `exec`; see [`Between::closest_hit`].
    ///
    /// `hits[i]` becomes the answer to `rays[i]`, so both have one length.
    ///
    /// # Errors
    /// As [`View::closest_hits`](crate::layout::View::closest_hits).
    pub fn closest_hits(
        &self,
        rays: &[(Ray, f32)],
        hits: &mut [Option<Hit>],
        exec: &Executor,
    ) -> Result<(), BatchError> {
        answer_all(rays, hits, exec, |(ray, fraction)| self.closest_hit(ray, *fraction))
    }

    /// The normal of the triangle that a ray hit at that time, in world space and not of length 1; it points to the front, as that of
    /// [`Opened::normal`](crate::cache::Opened::normal). `None` where the record that the hit names is no triangle of its
    /// part and number, as for most hits in another file.
    pub fn normal(&self, hit: &Hit, fraction: f32) -> Option<[f64; 3]> {
        let mix = Mix::new(fraction)?;
        let instance = self.instances().get(self.instance_record(hit.instance?)?)?;
        let tree = self.tree(instance.tree as usize)?;
        let slot = hit.triangle.checked_sub(tree.first_triangle)?;
        let triangle = tree.at(tree.triangles.get(slot).filter(|t| (t.geom, t.prim) == (hit.geom, hit.prim))?, &mix);
        let [v0, v1, v2] = triangle.corners().map(|p| p.map(f64::from));
        let turn = if self.is_mirrored(hit.geom) { -1.0 } else { 1.0 };
        let n = cross(sub(v1, v0), sub(v2, v0)).map(|c| turn * c);
        // A normal goes into the world by the transposed inverse: the columns of the way back.
        let rows = way_back(instance, &mix)?.linear;
        Some([0, 1, 2].map(|i| rows[0][i] * n[0] + rows[1][i] * n[1] + rows[2][i] * n[2]))
    }
}

fn trace<const ANY: bool>(between: &Between<'_>, ray: &Ray, fraction: f32) -> Result<Option<Hit>, Malformed> {
    let Some(mix) = Mix::new(fraction).filter(|_| is_usable(ray)) else { return Ok(None) };
    let Some(root) = between.tlas_nodes().first() else { return Ok(None) };
    let mut best = Best::none_until(ray.t_max.min(FARTHEST));
    let (origin, direction) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
    let slabs = slabs_for::<Conservative, _>(&NoObserver, origin, direction, &root.bounds(), ray.t_min);
    let (mut top_stack, mut stack) = (Stack::new(), Stack::new());
    walk(
        &Records { nodes: between.tlas_nodes(), items: between.instances() },
        &slabs,
        &mut best,
        &mut top_stack,
        &mut NoObserver,
        |start, some, best, observer| {
            for (i, instance) in some.iter().enumerate() {
                let blas = instance.tree;
                let tree = between.tree(blas as usize);
                let tree = tree.ok_or(Malformed::BlasOutOfRange { instance: start + i, blas })?;
                let Some((origin, direction)) = instance.to_object(&mix, origin, direction) else { continue };
                let place = Place { first_triangle: tree.first_triangle, instance: Some(instance.ends[0].id) };
                let bottom = Bottom { tree: Moving::new(tree, mix), place };
                if bottom
                    .trace::<ANY, EdgeRay, Conservative>(origin, direction, ray.t_min, best, &mut stack, observer)?
                {
                    return Ok(true);
                }
            }
            Ok(false)
        },
    )?;
    Ok(best.hit)
}
