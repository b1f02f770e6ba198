//! What rays hit, and the rays that go on from there.

use super::Camera;
use super::world::World;
use crate::geom::Ray;
use crate::geom::vector::{cross, dot, sub};
use crate::random::Random;
use crate::trace::closest_hit;
use crate::trace::rays::{barycentric, camera, cosine_ray};

/// How far from a surface rays start, and how far they look for occluders, as shares of the scene's diagonal.
const LIFT: f64 = 1e-4;
const OCCLUSION: f64 = 0.1;

/// Where a ray ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Struck {
    pub t: f32,
    point: [f64; 3],
    /// Of length 1, on the ray's side.
    pub normal: [f64; 3],
    /// Instance, geometry and primitive of what the ray hit; none of a point that was chosen.
    pub hit: Option<(Option<u32>, u32, u32)>,
}

impl Struck {
    /// A ray that goes on from there.
    pub fn ray(&self, direction: [f64; 3], diagonal: f64) -> Ray {
        let origin = [0, 1, 2].map(|k| self.point[k] + LIFT * diagonal * self.normal[k]);
        Ray::new(origin.map(|c| c as f32), direction.map(|c| c as f32))
    }
}

/// A random point of a triangle as if a ray had hit it, on either side; `None` where the triangle has no normal.
pub(super) fn surface(corners: &[[f32; 3]; 3], random: &mut Random) -> Option<Struck> {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let (ab, ac) = (sub(b, a), sub(c, a));
    let (u, v) = barycentric(random);
    let side = if random.coin() { 1.0 } else { -1.0 };
    let n = cross(ab, ac);
    let length = dot(n, n).sqrt();
    let point = [0, 1, 2].map(|k| a[k] + u * ab[k] + v * ac[k]);
    (length > 0.0).then(|| Struck { t: 0.0, point, normal: n.map(|v| side * v / length), hit: None })
}

/// What the ray hits first, if that has a normal. Rays are made for trees that were built or checked: in any other, what is malformed is
/// no surface to start from.
pub(super) fn strike(world: &World<'_>, ray: &Ray) -> Option<Struck> {
    let hit = closest_hit(world.view, ray).ok()??;
    let [a, b, c] = world.corners(&hit);
    let n = cross(sub(b, a), sub(c, a));
    let d = ray.direction.map(f64::from);
    let length = dot(n, n).sqrt();
    let facing = if dot(n, d) > 0.0 { -length } else { length };
    let point = [0, 1, 2].map(|k| f64::from(ray.origin[k]) + f64::from(hit.t) * d[k]);
    let id = (hit.instance, hit.geom, hit.prim);
    (length > 0.0).then(|| Struck { t: hit.t, point, normal: n.map(|v| v / facing), hit: Some(id) })
}

/// About `count` rays (the next lower square from each camera, and at least one unless there are to be none).
pub(super) fn camera_rays(cameras: &[Camera], count: usize) -> Vec<Ray> {
    let side = (((count / cameras.len().max(1)) as f64).sqrt() as usize).max(usize::from(count > 0));
    cameras.iter().flat_map(|c| camera(c.eye, c.look_at, c.up, c.tan_half, side, side)).collect()
}

/// One cosine-weighted bounce off each surface, over and over with other directions until there are `count`; none off nothing.
pub(super) fn bounces(surfaces: &[Struck], count: usize, diagonal: f64, random: &mut Random) -> Vec<Ray> {
    let lift = LIFT * diagonal;
    let one = |s: &Struck| cosine_ray([0, 1, 2].map(|k| s.point[k] + lift * s.normal[k]), s.normal, random);
    surfaces.iter().cycle().take(if surfaces.is_empty() { 0 } else { count }).map(one).collect()
}

/// The ray as one that looks for an occluder nearby, with a direction of length 1.
pub(super) fn toward_occluders(ray: Ray, diagonal: f64) -> Ray {
    let d = ray.direction.map(f64::from);
    let length = dot(d, d).sqrt();
    Ray { direction: d.map(|c| (c / length) as f32), ..ray }.until((OCCLUSION * diagonal) as f32)
}
