use super::aim::{through_middle, toward};
use super::pinhole::Pinhole;
use super::{Random, RaySet};
use crate::geom::vector::{cross, dot, sub};
use crate::geom::{Aabb, Point, Ray};
use crate::scene::Scene;
use crate::trace::brute::Source;

/// A scene as a source of rays.
pub struct Sampler<'a> {
    scene: &'a Scene,
    /// Triangles in all instances before this one, and the total at the end.
    before: Vec<u64>,
    /// Triangles in all meshes that have an instance before this one, and the total at the end; and each mesh's instances.
    before_mesh: Vec<u64>,
    places: Vec<Vec<u32>>,
    center: [f64; 3],
    radius: f64,
}

/// How many cameras look; those of even number stand outside.
const CAMERAS: u64 = 8;

impl<'a> Sampler<'a> {
    pub fn new(scene: &'a Scene) -> Sampler<'a> {
        let mut before = vec![0];
        let mut bounds = Aabb::EMPTY;
        let boxes: Vec<Aabb> = (scene.meshes.iter())
            .map(|mesh| (0..mesh.triangles.len()).fold(Aabb::EMPTY, |b, i| b.union(mesh.triangle_box(i))))
            .collect();
        let mut places = vec![Vec::new(); scene.meshes.len()];
        for (number, instance) in scene.instances.iter().enumerate() {
            let mesh = instance.mesh as usize;
            places[mesh].push(number as u32);
            before.push(before[before.len() - 1] + scene.meshes[mesh].triangles.len() as u64);
            bounds = bounds.union(instance.transform.transform_box(&boxes[mesh]));
        }
        let mut before_mesh = vec![0];
        for (mesh, places) in scene.meshes.iter().zip(&places) {
            let triangles = if places.is_empty() { 0 } else { mesh.triangles.len() as u64 };
            before_mesh.push(before_mesh[before_mesh.len() - 1] + triangles);
        }
        let bounds = if bounds.is_empty() { Aabb { min: [-1.0; 3], max: [1.0; 3] } } else { bounds };
        let (min, max) = (bounds.min.map(f64::from), bounds.max.map(f64::from));
        let center = [0, 1, 2].map(|a| 0.5 * (min[a] + max[a]));
        let half = [0, 1, 2].map(|a| 0.5 * (max[a] - min[a]));
        Sampler { scene, before, before_mesh, places, center, radius: dot(half, half).sqrt() }
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
        if set != RaySet::Triangles || self.total() == 0 {
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
        let (source, [a, b, c]) = match self.before_mesh[self.before_mesh.len() - 1] {
            0 => self.pick(random),
            total => {
                let pick = random.below(total);
                let mesh = self.before_mesh.partition_point(|&b| b <= pick) - 1;
                let places = &self.places[mesh];
                let instance = places[random.below(places.len() as u64) as usize];
                self.at(instance as usize, pick - self.before_mesh[mesh])
            }
        };
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
        self.pick(random).1
    }

    /// Triangles in all instances.
    fn total(&self) -> u64 {
        self.before[self.before.len() - 1]
    }

    /// A random triangle of a random instance, and its corners in world space.
    fn pick(&self, random: &mut Random) -> (Source, [[f64; 3]; 3]) {
        if self.total() == 0 {
            return (Source { instance: 0, triangle: 0 }, [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        }
        let pick = random.below(self.total());
        let at = self.before.partition_point(|&b| b <= pick) - 1;
        self.at(at, pick - self.before[at])
    }

    fn at(&self, at: usize, triangle: u64) -> (Source, [[f64; 3]; 3]) {
        let instance = &self.scene.instances[at];
        let corners: [Point; 3] = self.scene.meshes[instance.mesh as usize].corners(triangle as usize);
        let source = Source { instance: at as u32, triangle: triangle as u32 };
        (source, corners.map(|p| instance.transform.transform_point(p.map(f64::from))))
    }
}

/// Weights of two edges, for a point evenly spread over a triangle.
fn barycentric(random: &mut Random) -> (f64, f64) {
    let (s, t) = (random.unit(), random.unit());
    if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) }
}

/// The largest power of two that is not above `v`, and at least 2⁻¹⁰⁰.
fn power_of_two_below(v: f64) -> f64 {
    f64::from_bits(v.max(2f64.powi(-100)).to_bits() & 0x7FF0_0000_0000_0000)
}

/// A ray from `point` into the hemisphere of the unit vector `normal`, with density proportional to the cosine: the normal plus
/// a point of the unit sphere.
pub fn cosine_ray(point: [f64; 3], normal: [f64; 3], random: &mut Random) -> Ray {
    let d = random.direction();
    let direction = [0, 1, 2].map(|a| (normal[a] + d[a]) as f32);
    let direction = if direction == [0.0; 3] { normal.map(|n| n as f32) } else { direction };
    Ray::new(point.map(|v| v as f32), direction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Affine;
    use crate::scene::{Instance, Mesh};
    use crate::trace::exact::meet;
    use std::cmp::Ordering;

    /// Triangles all over a cube, some of them flat, in two places.
    fn scene() -> Scene {
        let mut random = Random::new(11);
        let mut mesh = Mesh::default();
        for i in 0..60 {
            let at = [0; 3].map(|_| random.unit());
            for _ in 0..3 {
                let d = random.direction();
                let mut p = [0, 1, 2].map(|a| (at[a] + 0.2 * d[a]) as f32);
                if i % 3 == 0 {
                    p[i % 2] = at[i % 2] as f32;
                }
                mesh.positions.push(p);
            }
            mesh.triangles.push([3 * i as u32, 3 * i as u32 + 1, 3 * i as u32 + 2]);
        }
        let moved = Affine { rows: [[0.0, -1.5, 0.0, 2.0], [1.5, 0.0, 0.0, 0.3], [0.0, 0.0, 1.5, -0.25]] };
        let place = |transform| Instance { mesh: 0, transform, node: 0, name: String::new() };
        Scene { meshes: vec![mesh], instances: vec![place(Affine::IDENTITY), place(moved)], ..Scene::default() }
    }

    fn bits(rays: &[Ray]) -> String {
        let mut hasher = blake3::Hasher::new();
        for ray in rays {
            let numbers = ray.origin.iter().chain(&ray.direction).chain([&ray.t_min, &ray.t_max]);
            numbers.for_each(|v| _ = hasher.update(&v.to_le_bytes()));
        }
        hasher.finalize().to_hex()[..16].to_string()
    }

    #[test]
    fn a_seed_always_gives_the_same_bits() {
        let scene = scene();
        let sampler = Sampler::new(&scene);
        let found: Vec<(&str, String)> = RaySet::ALL.map(|set| (set.name(), bits(&sampler.rays(set, 500, 42)))).into();
        let expected = [
            ("camera", "0f71f694eb3a23b4"),
            ("uniform", "e2effe6fe533c86d"),
            ("surface", "512c71b10753f6d1"),
            ("bounce", "921cc3eccdd2de71"),
            ("shadow", "3494e0036b1abd01"),
            ("triangles", "c5e724832dc9d411"),
            ("vertices", "725d991e4064893e"),
            ("edges", "9a4a5781a7f437ab"),
            ("axis", "de8a7301e84b4182"),
            ("planes", "d38942f9ce2cc9cc"),
            ("nested", "985886cba441d3f4"),
            ("far", "6a2b8be1944c9f04"),
            ("grid", "aba9424f784b8c02"),
        ];
        assert_eq!(found, expected.map(|(name, hash)| (name, hash.to_string())));
    }

    #[test]
    fn every_ray_can_be_traced_whatever_the_scene() {
        let (scene, empty) = (scene(), Scene::default());
        let point = Scene {
            meshes: vec![Mesh { positions: vec![[1.0; 3]], triangles: vec![[0; 3]], ..Mesh::default() }],
            instances: vec![Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() }],
            ..Scene::default()
        };
        for scene in [&scene, &empty, &point] {
            for set in RaySet::ALL {
                for ray in Sampler::new(scene).rays(set, 300, 5) {
                    assert!(ray.origin.iter().chain(&ray.direction).all(|v| v.is_finite()), "{set:?} {ray:?}");
                    assert!(ray.direction.iter().any(|d| *d != 0.0) && ray.t_min <= ray.t_max, "{set:?} {ray:?}");
                }
            }
        }
    }

    /// How many of a hundred rays of a set pass a corner or an edge of the first instance exactly.
    fn exact_aims(set: RaySet) -> usize {
        let mut scene = scene();
        scene.instances.truncate(1);
        let mesh = &scene.meshes[0];
        let rays = Sampler::new(&scene).rays(set, 400, 3);
        let touches = |ray: &&Ray| {
            (0..mesh.triangles.len())
                .filter_map(|i| meet(ray, mesh.corners(i)))
                .any(|m| [&m.u, &m.v, &m.w].into_iter().any(|weight| weight.compare(0.0) == Some(Ordering::Equal)))
        };
        rays.iter().filter(touches).count() / 4
    }

    #[test]
    fn targets_are_what_rays_are_aimed_at() {
        let mut scene = scene();
        scene.instances.truncate(1);
        let sampler = Sampler::new(&scene);
        let (rays, targets) = (sampler.rays(RaySet::Triangles, 400, 3), sampler.targets(RaySet::Triangles, 400, 3));
        assert_eq!(rays.len(), targets.len());
        let is_met =
            |ray: &Ray, target: &Source| meet(ray, scene.meshes[0].corners(target.triangle as usize)).is_some();
        let met = rays.iter().zip(&targets).filter(|(ray, target)| target.instance == 0 && is_met(ray, target)).count();
        assert!(met > 380, "{met}");
        assert!(sampler.targets(RaySet::Camera, 4, 3).is_empty());
        assert!(Sampler::new(&Scene::default()).targets(RaySet::Triangles, 4, 3).is_empty());
    }

    #[test]
    fn many_aims_are_exact() {
        assert!(exact_aims(RaySet::Vertices) > 30, "{}", exact_aims(RaySet::Vertices));
        assert!(exact_aims(RaySet::Edges) > 5, "{}", exact_aims(RaySet::Edges));
    }

    #[test]
    fn sets_are_what_they_say() {
        let scene = scene();
        let sampler = Sampler::new(&scene);
        let rays = |set| sampler.rays(set, 400, 8);
        assert!(rays(RaySet::Axis).iter().all(|r| r.direction.iter().filter(|d| **d == 0.0).count() == 2));
        assert!(rays(RaySet::Planes).iter().all(|r| r.direction.contains(&0.0)));
        assert!(rays(RaySet::Grid).iter().all(|r| r.direction.iter().all(|d| d.fract() == 0.0 && d.abs() <= 8.0)));
        assert!(rays(RaySet::Surface).iter().all(|r| r.t_min == 0.0 && r.t_max == f32::INFINITY));
        assert!(rays(RaySet::Shadow).iter().all(|r| r.t_max < f32::INFINITY && r.t_min > 0.0));
        let distance = |r: &Ray| sub(r.origin.map(f64::from), sampler.center).map(|c| c * c).iter().sum::<f64>().sqrt();
        assert!(rays(RaySet::Far).iter().all(|r| distance(r) > 1900.0 * sampler.radius()));
        assert!(rays(RaySet::Far).iter().any(|r| distance(r) > 1.9e7 * sampler.radius()));
        assert!(rays(RaySet::Nested).iter().all(|r| distance(r) <= 1.001 * sampler.radius()));
        assert!(rays(RaySet::Camera).iter().any(|r| distance(r) > 1.9 * sampler.radius()));
        assert!(rays(RaySet::Camera).iter().any(|r| distance(r) < sampler.radius()));
    }
}
