mod targets;
#[cfg(test)]
mod tests;

use super::RaySet;
use super::aim::{through_middle, toward};
use super::pinhole::Pinhole;
use crate::geom::vector::{cross, dot, sub};
use crate::geom::{Aabb, Ray};
use crate::random::Random;
use crate::scene::Scene;
use crate::trace::brute::Source;
use targets::Targets;

/// A scene as a source of rays.
pub struct Sampler<'a> {
    targets: Targets<'a>,
    center: [f64; 3],
    radius: f64,
}

/// How many cameras look; those of even number stand outside.
const CAMERAS: u64 = 8;

impl<'a> Sampler<'a> {
    /// Looks at every triangle once, for the bounds.
    ///
    /// # Panics
    /// Where the scene is not sound: [`Scene::validate`] finds that.
    pub fn new(scene: &'a Scene) -> Sampler<'a> {
        let mut bounds = Aabb::EMPTY;
        let boxes: Vec<Aabb> = (scene.meshes.iter())
            .map(|mesh| (0..mesh.triangles.len()).fold(Aabb::EMPTY, |b, i| b.union(mesh.triangle_box(i))))
            .collect();
        for instance in &scene.instances {
            bounds = bounds.union(instance.transform.transform_box(&boxes[instance.mesh as usize]));
        }
        let bounds = if bounds.is_empty() { Aabb { min: [-1.0; 3], max: [1.0; 3] } } else { bounds };
        let (min, max) = (bounds.min.map(f64::from), bounds.max.map(f64::from));
        let center = [0, 1, 2].map(|a| 0.5 * (min[a] + max[a]));
        let half = [0, 1, 2].map(|a| 0.5 * (max[a] - min[a]));
        Sampler { targets: Targets::new(scene), center, radius: dot(half, half).sqrt() }
    }

    /// Half of the diagonal of the scene's box.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// `count` rays of a set. An empty scene gives rays around the unit box.
    pub fn rays(&self, set: RaySet, count: usize, seed: u64) -> Vec<Ray> {
        let mut random = Random::new(set.seed(seed));
        let cameras: Vec<Pinhole> = match set {
            RaySet::Camera => (0..CAMERAS).map(|number| self.camera(number % 2 == 0, &mut random)).collect(),
            _ => Vec::new(),
        };
        (0..count).map(|_| self.ray(set, &cameras, &mut random)).collect()
    }

    /// `count` rays of all sets together, in their order, by [`RaySet::shares`].
    pub fn mixed(&self, count: u64, seed: u64) -> Vec<Ray> {
        let shares = RaySet::shares(&RaySet::ALL, count);
        RaySet::ALL.into_iter().zip(shares).flat_map(|(set, share)| self.rays(set, share as usize, seed)).collect()
    }

    /// The triangles that [`Sampler::rays`] aims at in [`RaySet::Triangles`], ray by ray; none in other sets and in an empty scene.
    pub fn targets(&self, set: RaySet, count: usize, seed: u64) -> Vec<Source> {
        if set != RaySet::Triangles || self.targets.is_empty() {
            return Vec::new();
        }
        let mut random = Random::new(set.seed(seed));
        (0..count).map(|_| self.at_triangle(&mut random).1).collect()
    }

    fn ray(&self, set: RaySet, cameras: &[Pinhole], random: &mut Random) -> Ray {
        match set {
            RaySet::Camera => {
                let camera = random.below(cameras.len() as u64) as usize;
                cameras[camera].ray(2.0 * random.unit() - 1.0, 2.0 * random.unit() - 1.0)
            }
            RaySet::Uniform => toward(self.around(random), self.around(random)),
            RaySet::Surface => self.off_surface(random),
            RaySet::Bounce => Ray { t_min: (2e-4 * self.radius) as f32, ..self.off_surface(random) },
            RaySet::Shadow => {
                let ray = self.off_surface(random);
                Ray { t_min: (2e-4 * self.radius) as f32, t_max: (0.2 * self.radius) as f32, ..ray }
            }
            RaySet::Vertices => {
                let target = self.corners(random)[random.below(3) as usize];
                self.at_middle(target, target, random)
            }
            RaySet::Edges => {
                let [a, b, _] = self.corners(random);
                let part = random.unit();
                match random.below(4) {
                    0 => toward(self.somewhere(random), [0, 1, 2].map(|k| a[k] + part * (b[k] - a[k]))),
                    _ => self.at_middle(a, b, random),
                }
            }
            RaySet::Axis => self.along_axis(random),
            RaySet::Planes => self.in_plane(random),
            RaySet::Nested => self.nested(random),
            RaySet::Far => self.far(random),
            RaySet::Grid => self.on_lattice(random),
            RaySet::Triangles => self.at_triangle(random).0,
        }
    }

    /// Looking at a point of the scene from outside, or from a point between two vertices.
    fn camera(&self, outside: bool, random: &mut Random) -> Pinhole {
        let eye = if outside {
            let d = random.direction();
            [0, 1, 2].map(|a| self.center[a] + 2.0 * self.radius * d[a])
        } else {
            self.between(random)
        };
        let wish = if outside { self.center } else { self.corners(random)[0] };
        let look_at = if wish == eye { [eye[0], eye[1], eye[2] - 1.0] } else { wish };

        // Up is any direction but that of the view.
        let view = sub(look_at, eye);
        let up = if view[0] == 0.0 && view[2] == 0.0 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        Pinhole::new(eye, look_at, up, if outside { 0.5 } else { 1.0 }, 0.75)
    }

    fn around(&self, random: &mut Random) -> [f64; 3] {
        let d = random.direction();
        [0, 1, 2].map(|a| self.center[a] + 1.1 * self.radius * d[a])
    }

    /// Outside, or at a vertex.
    fn somewhere(&self, random: &mut Random) -> [f64; 3] {
        if random.coin() { self.around(random) } else { self.corners(random)[0] }
    }

    /// In the middle between two vertices.
    fn between(&self, random: &mut Random) -> [f64; 3] {
        let (a, b) = (self.corners(random)[0], self.corners(random)[1]);
        [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]))
    }

    /// At `(a + b) / 2`: half of the rays exactly, where `f32` can say so.
    fn at_middle(&self, a: [f64; 3], b: [f64; 3], random: &mut Random) -> Ray {
        let from = self.somewhere(random);
        let exact = random.coin().then(|| through_middle(from, a.map(|v| v as f32), b.map(|v| v as f32)));
        exact.flatten().unwrap_or_else(|| toward(from, [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]))))
    }

    /// At a point inside a triangle, from anywhere or from about its own size away, and which triangle that is: any of a mesh, in any of its
    /// instances, so that each record of a file gets its share.
    fn at_triangle(&self, random: &mut Random) -> (Ray, Source) {
        let (source, [a, b, c]) = self.targets.of_meshes(random);
        let (s, t) = barycentric(random);
        let point = [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
        let from = if random.coin() {
            self.somewhere(random)
        } else {
            let (e, d) = (sub(b, a), random.direction());
            let size = dot(e, e).sqrt();
            [0, 1, 2].map(|k| point[k] + 0.5 * size * d[k])
        };
        (toward(from, point), source)
    }

    fn along_axis(&self, random: &mut Random) -> Ray {
        let mut origin = if random.coin() {
            [0, 1, 2].map(|a| (self.center[a] + self.radius * (2.0 * random.unit() - 1.0)) as f32)
        } else {
            let [a, b, c] = [0; 3].map(|_| self.corners(random)[random.below(3) as usize]);
            [a[0] as f32, b[1] as f32, c[2] as f32]
        };
        let axis = random.below(3) as usize;
        let positive = random.coin();
        let mut direction = random.zeros();
        direction[axis] = if positive { 1.0 } else { -1.0 };

        // Half start outside, the others where they are.
        if random.coin() {
            let back = if positive { -1.5 } else { 1.5 };
            origin[axis] = (self.center[axis] + back * self.radius) as f32;
        }
        Ray::new(origin, direction)
    }

    /// Between two points of the plane in which a vertex lies: of flat triangles' own planes where there are such.
    fn in_plane(&self, random: &mut Random) -> Ray {
        let flat_axis = |t: &[[f64; 3]; 3]| (0..3).find(|&a| t[0][a] == t[1][a] && t[1][a] == t[2][a]);
        let mut triangle = self.corners(random);
        for _ in 0..8 {
            if flat_axis(&triangle).is_some() {
                break;
            }
            triangle = self.corners(random);
        }
        let axis = flat_axis(&triangle).unwrap_or(random.below(3) as usize);
        let other = self.corners(random)[random.below(3) as usize];
        let target = if random.coin() { triangle[random.below(3) as usize] } else { other };
        let mut ray = toward(self.somewhere(random), target);
        ray.origin[axis] = triangle[0][axis] as f32;
        ray.direction[axis] = random.zeros()[0];
        if ray.direction.iter().all(|d| *d == 0.0) {
            ray.direction[(axis + 1) % 3] = 1.0;
        }
        ray
    }

    fn nested(&self, random: &mut Random) -> Ray {
        let origin = match random.below(4) {
            0 => self.corners(random)[0],
            1 => {
                // The middle of a triangle's box.
                let c = self.corners(random);
                [0, 1, 2].map(|a| {
                    let (lo, hi) = (c[0][a].min(c[1][a]).min(c[2][a]), c[0][a].max(c[1][a]).max(c[2][a]));
                    0.5 * (lo + hi)
                })
            }
            _ => self.between(random),
        };
        let origin = origin.map(|v| v as f32);
        let ray = match random.below(3) {
            0 => Ray::new(origin, random.direction().map(|d| d as f32)),
            1 => toward(origin.map(f64::from), self.corners(random)[0]),
            _ => {
                let mut direction = random.zeros();
                direction[random.below(3) as usize] = if random.coin() { 1.0 } else { -1.0 };
                Ray::new(origin, direction)
            }
        };
        // A quarter ends early, another starts behind itself.
        let squared: f64 = ray.direction.iter().map(|d| f64::from(*d) * f64::from(*d)).sum();
        let reach = (0.1 * self.radius / squared.sqrt()) as f32;
        match random.below(4) {
            0 => ray.until(reach),
            1 => Ray { t_min: -reach, ..ray },
            _ => ray,
        }
    }

    /// Along an axis, so that the scene is not missed for lack of bits, or at a vertex.
    fn far(&self, random: &mut Random) -> Ray {
        // From the farthest places a ray meets every box, since f32 cannot tell them apart: few rays come from there.
        let diagonals = [1e7, 1e5, 1e5, 1e5, 1e3, 1e3, 1e3, 1e3][random.below(8) as usize];
        let away = diagonals * 2.0 * self.radius.max(1e-30);
        let target = self.corners(random);
        let target = if random.coin() { target[0] } else { [0, 1, 2].map(|k| 0.5 * (target[0][k] + target[1][k])) };
        if random.coin() {
            let axis = random.below(3) as usize;
            let mut origin = target.map(|v| v as f32);
            let mut direction = random.zeros();
            direction[axis] = if random.coin() { 1.0 } else { -1.0 };
            origin[axis] = (target[axis] - f64::from(direction[axis]) * away) as f32;
            return Ray::new(origin, direction);
        }
        let d = random.direction();
        toward([0, 1, 2].map(|a| target[a] + away * d[a]), target)
    }

    /// From a point of a lattice of 25³ points around the scene, in steps of a power of two. Where the scene's coordinates lie on the lattice
    /// too, nothing but the last division rounds.
    fn on_lattice(&self, random: &mut Random) -> Ray {
        let step = power_of_two_below(self.radius / 8.0);
        let origin = [0, 1, 2].map(|a| {
            let middle = (self.center[a] / step).round();
            ((middle + f64::from(random.whole(12))) * step) as f32
        });
        let most = if random.coin() { 8 } else { 1 };
        let mut direction = [0; 3].map(|_| random.whole(most));
        if direction.iter().all(|d| *d == 0.0) {
            direction = [0.0, -0.0, 1.0];
        }
        Ray::new(origin, direction)
    }

    fn off_surface(&self, random: &mut Random) -> Ray {
        let [a, b, c] = self.corners(random);
        let (s, t) = barycentric(random);
        let point = [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
        let normal = cross(sub(b, a), sub(c, a));
        let length = dot(normal, normal).sqrt();
        let sign = if random.coin() { 1.0 } else { -1.0 };
        let unit = if length > 0.0 { normal.map(|n| sign * n / length) } else { [0.0, 0.0, sign] };
        cosine_ray(point, unit, random)
    }

    /// The corners of a random triangle of a random instance in world space.
    fn corners(&self, random: &mut Random) -> [[f64; 3]; 3] {
        self.targets.of_instances(random).1
    }
}

/// Weights of two edges, for a point evenly spread over a triangle.
pub(crate) fn barycentric(random: &mut Random) -> (f64, f64) {
    let (s, t) = (random.unit(), random.unit());
    if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) }
}

/// The largest power of two that is not above `v`, and at least 2⁻¹⁰⁰.
fn power_of_two_below(v: f64) -> f64 {
    f64::from_bits(v.max(2f64.powi(-100)).to_bits() & 0x7FF0_0000_0000_0000)
}

/// A ray from `point` into the hemisphere of the unit vector `normal`, with density proportional to the cosine: the normal plus
/// a point of the unit sphere.
pub(crate) fn cosine_ray(point: [f64; 3], normal: [f64; 3], random: &mut Random) -> Ray {
    let d = random.direction();
    let direction = [0, 1, 2].map(|a| (normal[a] + d[a]) as f32);
    let direction = if direction == [0.0; 3] { normal.map(|n| n as f32) } else { direction };
    Ray::new(point.map(|v| v as f32), direction)
}
