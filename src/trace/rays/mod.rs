//! Ray sets: fair samples and seekers of trouble, the same on every machine for the same seed.

pub mod grid;
mod random;

pub use random::Random;

use crate::geom::vector::{cross, dot, sub};
use crate::geom::{Aabb, Ray};
use crate::scene::Scene;

/// What a set of rays is after.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RaySet {
    /// Between two random points of a sphere around the scene.
    Chords,
    /// Along ± x, y, z, with zeros of both signs in the direction; half of the origins share coordinates with vertices, so that
    /// rays run in the faces of boxes and through vertices and edges exactly.
    AxisAligned,
    /// At a vertex, from outside or from another vertex.
    Vertices,
    /// At the middle of an edge.
    EdgeMidpoints,
    /// From a point of a triangle in a cosine-weighted direction, `t_min` = 0: the origin lies within rounding of the surface.
    Surface,
    /// The same rays starting at 10⁻⁴ of the diagonal, as a renderer's bounces do: past their own triangle, so that what lies
    /// behind it is judged.
    Bounce,
    /// From a point of a triangle, as far as 10 % of the diagonal, starting at 10⁻⁴ of it.
    Occlusion,
}

impl RaySet {
    pub const ALL: [RaySet; 7] = [
        RaySet::Chords,
        RaySet::AxisAligned,
        RaySet::Vertices,
        RaySet::EdgeMidpoints,
        RaySet::Surface,
        RaySet::Bounce,
        RaySet::Occlusion,
    ];
}

/// A scene as a source of rays.
pub struct Sampler<'a> {
    scene: &'a Scene,
    /// Triangles in all instances before this one, and the total at the end.
    before: Vec<u64>,
    center: [f64; 3],
    radius: f64,
}

impl<'a> Sampler<'a> {
    pub fn new(scene: &'a Scene) -> Sampler<'a> {
        let mut before = vec![0];
        let mut bounds = Aabb::EMPTY;
        for instance in &scene.instances {
            let mesh = &scene.meshes[instance.mesh as usize];
            before.push(before[before.len() - 1] + mesh.triangles.len() as u64);
            let own = (0..mesh.triangles.len()).fold(Aabb::EMPTY, |b, i| b.union(mesh.triangle_box(i)));
            bounds = bounds.union(instance.transform.transform_box(&own));
        }
        let bounds = if bounds.is_empty() { Aabb { min: [-1.0; 3], max: [1.0; 3] } } else { bounds };
        let (min, max) = (bounds.min.map(f64::from), bounds.max.map(f64::from));
        let center = [0, 1, 2].map(|a| 0.5 * (min[a] + max[a]));
        let half = [0, 1, 2].map(|a| 0.5 * (max[a] - min[a]));
        Sampler { scene, before, center, radius: dot(half, half).sqrt() }
    }

    /// Half of the diagonal of the scene's box.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// `count` rays of a set. An empty scene gives chords of the unit box.
    pub fn rays(&self, set: RaySet, count: usize, seed: u64) -> Vec<Ray> {
        let mut random = Random::new(seed ^ (set as u64) << 32);
        (0..count).map(|_| self.ray(set, &mut random)).collect()
    }

    fn ray(&self, set: RaySet, random: &mut Random) -> Ray {
        match set {
            RaySet::Chords => self.toward(self.around(random), self.around(random)),
            RaySet::AxisAligned => self.axis_aligned(random),
            RaySet::Vertices => {
                let target = self.corners(random)[random.below(3) as usize];
                self.toward(self.somewhere(random), target)
            }
            RaySet::EdgeMidpoints => {
                let [a, b, _] = self.corners(random);
                self.toward(self.somewhere(random), [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])))
            }
            RaySet::Surface => self.off_surface(random),
            RaySet::Bounce => Ray { t_min: (2e-4 * self.radius) as f32, ..self.off_surface(random) },
            RaySet::Occlusion => {
                let ray = self.off_surface(random);
                Ray { t_min: (2e-4 * self.radius) as f32, t_max: (0.2 * self.radius) as f32, ..ray }
            }
        }
    }

    fn around(&self, random: &mut Random) -> [f64; 3] {
        let d = random.direction();
        [0, 1, 2].map(|a| self.center[a] + 1.1 * self.radius * d[a])
    }

    /// Outside, or at a vertex.
    fn somewhere(&self, random: &mut Random) -> [f64; 3] {
        if random.bits() & 1 == 0 { self.around(random) } else { self.corners(random)[0] }
    }

    fn toward(&self, from: [f64; 3], to: [f64; 3]) -> Ray {
        let origin = from.map(|v| v as f32);
        let direction = [0, 1, 2].map(|a| (to[a] - f64::from(origin[a])) as f32);
        if direction == [0.0; 3] { Ray::new(origin, [1.0, 0.0, 0.0]) } else { Ray::new(origin, direction) }
    }

    fn axis_aligned(&self, random: &mut Random) -> Ray {
        let mut origin = if random.bits() & 1 == 0 {
            [0, 1, 2].map(|a| (self.center[a] + self.radius * (2.0 * random.unit() - 1.0)) as f32)
        } else {
            let [a, b, c] = [0; 3].map(|_| self.corners(random)[random.below(3) as usize]);
            [a[0] as f32, b[1] as f32, c[2] as f32]
        };
        let axis = random.below(3) as usize;
        let positive = random.bits() & 1 == 0;
        let zeros = random.bits();
        let mut direction = [0, 1, 2].map(|a| if zeros >> a & 1 == 0 { 0.0 } else { -0.0f32 });
        direction[axis] = if positive { 1.0 } else { -1.0 };

        // Half start outside, the others where they are.
        if random.bits() & 1 == 0 {
            let back = if positive { -1.5 } else { 1.5 };
            origin[axis] = (self.center[axis] + back * self.radius) as f32;
        }
        Ray::new(origin, direction)
    }

    fn off_surface(&self, random: &mut Random) -> Ray {
        let [a, b, c] = self.corners(random);
        let (mut s, mut t) = (random.unit(), random.unit());
        if s + t > 1.0 {
            (s, t) = (1.0 - s, 1.0 - t);
        }
        let point = [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
        let normal = cross(sub(b, a), sub(c, a));
        let length = dot(normal, normal).sqrt();
        let sign = if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
        let unit = if length > 0.0 { normal.map(|n| sign * n / length) } else { [0.0, 0.0, sign] };
        cosine_ray(point, unit, random)
    }

    /// A random triangle of a random instance in world space.
    fn corners(&self, random: &mut Random) -> [[f64; 3]; 3] {
        let total = self.before[self.before.len() - 1];
        if total == 0 {
            return [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        }
        let pick = random.below(total);
        let at = self.before.partition_point(|&b| b <= pick) - 1;
        let instance = &self.scene.instances[at];
        let corners = self.scene.meshes[instance.mesh as usize].corners((pick - self.before[at]) as usize);
        corners.map(|p| instance.transform.transform_point(p.map(f64::from)))
    }
}

/// A ray from `point` into the hemisphere of the unit vector `normal`, with density proportional to the cosine: the normal plus
/// a point of the unit sphere.
pub fn cosine_ray(point: [f64; 3], normal: [f64; 3], random: &mut Random) -> Ray {
    let d = random.direction();
    let direction = [0, 1, 2].map(|a| (normal[a] + d[a]) as f32);
    let direction = if direction == [0.0; 3] { normal.map(|n| n as f32) } else { direction };
    Ray::new(point.map(|v| v as f32), direction)
}

/// A pinhole camera's rays, row by row: `width` × `height` rays through a screen that spans `tan_half` to each side of the view
/// direction horizontally.
pub fn camera(eye: [f64; 3], look_at: [f64; 3], up: [f64; 3], tan_half: f64, width: usize, height: usize) -> Vec<Ray> {
    let unit = |v: [f64; 3]| v.map(|c| c / dot(v, v).sqrt());
    let forward = unit(sub(look_at, eye));
    let right = unit(cross(forward, up));
    let above = cross(right, forward);
    let aspect = height as f64 / width as f64;
    let pixel = |y: usize, x: usize| {
        let h = tan_half * (2.0 * (x as f64 + 0.5) / width as f64 - 1.0);
        let v = tan_half * aspect * (1.0 - 2.0 * (y as f64 + 0.5) / height as f64);
        Ray::new(eye.map(|c| c as f32), [0, 1, 2].map(|a| (forward[a] + h * right[a] + v * above[a]) as f32))
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (y, x))).map(|(y, x)| pixel(y, x)).collect()
}
