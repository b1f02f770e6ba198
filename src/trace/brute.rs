//! The oracle: every triangle of the source scene tested in `f64`, with a margin that says how sure the answer is.
//!
//! It shares nothing with traversal: no tree, no file, no box of a builder, another formula. To stay usable on millions of
//! triangles it skips runs of `BLOCK` consecutive source triangles whose common box, widened by the same margin, the ray misses.
//!
//! **The margin.** A file holds what the scene says up to rounding: `f32` matrices, or `f32` vertices baked by them. So the oracle asks
//! how far, at most, the ray that traversal follows lies from the true one where they pass a triangle. With `u = 2⁻²⁴`, an instance's
//! true map `M x + m`, its inverse `W x + w`, and `X` the largest coordinate of the mesh per axis, rounding `M`, `m` and then the inverse
//! moves a point in object space by at most, per axis,
//!
//! ```text
//! u · [ 2·|W|·(|M|·X + |m|) + |w| ]        times 1.01 for the second order; zero for the identity
//! ```
//!
//! and so does rounding a baked vertex, which is one of the terms. To this comes the arithmetic of both sides, `2⁻⁴⁸` of the largest
//! coordinate in play. The sum is the *slack*: an edge is passed on a certain side if the ray keeps more than the slack
//! away from it, and a distance is known within slack over the cosine.

use crate::geom::vector::{cross, dot, sub};
use crate::geom::{Affine, Ray};
use crate::scene::{Mesh, Scene};
use rayon::prelude::*;

/// Consecutive source triangles that share a skip box.
const BLOCK: usize = 128;

/// A triangle of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Source {
    /// Index in [`Scene::instances`].
    pub instance: u32,
    /// Index in the mesh's triangles as read, after dropping.
    pub triangle: u32,
}

/// A triangle that the ray meets, or may meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    pub source: Source,
    /// The distance lies between these.
    pub nearest: f64,
    pub farthest: f64,
    /// False for a ray that passes within the slack of an edge, or whose distance may lie outside of `t_min ..= t_max`.
    pub certain: bool,
}

/// What brute force says of a ray: all candidates that a correct closest-hit traversal might return, nearest certain one first,
/// the others by source.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    pub candidates: Vec<Candidate>,
}

impl Answer {
    /// The certain hit whose farthest distance is smallest: nothing beyond it may be returned.
    pub fn certain(&self) -> Option<&Candidate> {
        self.candidates.first().filter(|c| c.certain)
    }
}

/// A scene ready to be asked.
pub struct Oracle<'a> {
    scene: &'a Scene,
    meshes: Vec<Blocks>,
    places: Vec<Place>,
}

/// Skip boxes of a mesh, in its own space: min and max per block, then of all.
struct Blocks {
    boxes: Vec<[[f64; 3]; 2]>,
    all: [[f64; 3]; 2],
}

struct Place {
    mesh: usize,
    to_object: Affine,
    /// The slack's share that does not depend on the ray.
    slack: f64,
}

impl<'a> Oracle<'a> {
    pub fn new(scene: &'a Scene) -> Oracle<'a> {
        let meshes: Vec<Blocks> = scene.meshes.par_iter().map(Blocks::new).collect();
        let places = scene.instances.iter().map(|instance| {
            let mesh = instance.mesh as usize;
            let to_object = instance.transform.inverse().unwrap_or(Affine::IDENTITY);
            let slack = matrix_slack(&instance.transform, &to_object, &meshes[mesh].all);
            Place { mesh, to_object, slack }
        });
        let places = places.collect();
        Oracle { scene, meshes, places }
    }

    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The answers to many rays, on all threads.
    pub fn trace_all(&self, rays: &[Ray]) -> Vec<Answer> {
        rays.par_iter().map(|ray| self.trace(ray)).collect()
    }

    pub fn trace(&self, ray: &Ray) -> Answer {
        let mut found: Vec<Candidate> = Vec::new();
        let mut limit = f64::from(ray.t_max);
        if ray.direction == [0.0; 3] {
            return Answer::default();
        }
        for (i, place) in self.places.iter().enumerate() {
            let mesh = &self.scene.meshes[place.mesh];
            let blocks = &self.meshes[place.mesh];
            let probe = Probe::new(ray, place, &blocks.all);
            if !probe.meets(&blocks.all, limit) {
                continue;
            }
            for (b, bounds) in blocks.boxes.iter().enumerate() {
                if !probe.meets(bounds, limit) {
                    continue;
                }
                for triangle in b * BLOCK..((b + 1) * BLOCK).min(mesh.triangles.len()) {
                    let source = Source { instance: i as u32, triangle: triangle as u32 };
                    if let Some(candidate) = probe.test(mesh.corners(triangle), source)
                        && candidate.nearest <= limit
                    {
                        if candidate.certain {
                            limit = limit.min(candidate.farthest);
                        }
                        found.push(candidate);
                    }
                }
            }
        }

        // Keep what may come before the nearest certain hit, and put that one first.
        found.retain(|c| c.nearest <= limit);
        found.sort_by(|a, b| {
            (b.certain.cmp(&a.certain)).then(a.farthest.total_cmp(&b.farthest)).then(a.source.cmp(&b.source))
        });
        Answer { candidates: found }
    }
}

impl Blocks {
    fn new(mesh: &Mesh) -> Blocks {
        let boxes: Vec<[[f64; 3]; 2]> = mesh
            .triangles
            .chunks(BLOCK)
            .map(|run| bounds(run.iter().flatten().map(|&v| mesh.positions[v as usize].map(f64::from))))
            .collect();
        let all = bounds(boxes.iter().flatten().copied());
        Blocks { boxes, all }
    }
}

fn bounds(points: impl Iterator<Item = [f64; 3]>) -> [[f64; 3]; 2] {
    points.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[lo, hi], p| {
        [[0, 1, 2].map(|a| lo[a].min(p[a])), [0, 1, 2].map(|a| hi[a].max(p[a]))]
    })
}

/// The formula at the head of this file, as the length of the vector.
fn matrix_slack(to_world: &Affine, to_object: &Affine, mesh: &[[f64; 3]; 2]) -> f64 {
    if *to_world == Affine::IDENTITY || mesh[0][0] > mesh[1][0] {
        return 0.0;
    }
    let reach = [0, 1, 2].map(|a| mesh[0][a].abs().max(mesh[1][a].abs()));
    let apply = |m: &Affine, v: [f64; 3]| m.rows.map(|r| r[0].abs() * v[0] + r[1].abs() * v[1] + r[2].abs() * v[2]);
    let linear = apply(to_world, reach);
    let world = [0, 1, 2].map(|a| linear[a] + to_world.rows[a][3].abs());
    let back = apply(to_object, world);
    length([0, 1, 2].map(|a| 1.01 * 2f64.powi(-24) * (2.0 * back[a] + to_object.rows[a][3].abs())))
}

/// A ray in an instance's space.
struct Probe {
    origin: [f64; 3],
    direction: [f64; 3],
    speed: f64,
    slack: f64,
    t_min: f64,
    t_max: f64,
}

impl Probe {
    fn new(ray: &Ray, place: &Place, mesh: &[[f64; 3]; 2]) -> Probe {
        let origin = place.to_object.transform_point(ray.origin.map(f64::from));
        let direction = place.to_object.transform_vector(ray.direction.map(f64::from));

        // What the map's own arithmetic sums up, before anything cancels, counts as a coordinate in play.
        let largest = |v: [f64; 3]| v[0].abs().max(v[1].abs()).max(v[2].abs());
        let summed = place.to_object.rows.map(|r| {
            let o = ray.origin.map(|c| f64::from(c).abs());
            r[0].abs() * o[0] + r[1].abs() * o[1] + r[2].abs() * o[2] + r[3].abs()
        });
        let coordinates = largest(summed) + largest(mesh[0]) + largest(mesh[1]);
        Probe {
            origin,
            direction,
            speed: length(direction),
            slack: place.slack + 2f64.powi(-48) * coordinates,
            t_min: f64::from(ray.t_min),
            t_max: f64::from(ray.t_max),
        }
    }

    /// Whether the ray may pass the box, widened by the slack, before `limit`. The factor covers the arithmetic of this test.
    fn meets(&self, [min, max]: &[[f64; 3]; 2], limit: f64) -> bool {
        let (mut near, mut far) = (self.t_min, limit);
        for (a, &d) in self.direction.iter().enumerate() {
            let (lo, hi) = (min[a] - self.slack - self.origin[a], max[a] + self.slack - self.origin[a]);
            if d == 0.0 {
                if lo > 0.0 || hi < 0.0 {
                    return false;
                }
                continue;
            }
            let (x, y) = (lo / d, hi / d);
            near = near.max(x.min(y) - 1e-14 * x.abs().max(y.abs()));
            far = far.min(x.max(y) + 1e-14 * x.abs().max(y.abs()));
        }
        near <= far
    }

    /// `None` if the ray certainly misses.
    ///
    /// The origin is moved along the ray to the triangle, so that products are of the triangle's size. The sides are the moments
    /// `d · (p × q)`, twice the areas that the edges span with the ray when seen along it. Moving two corners by up to the slack each changes
    /// an area by at most `slack·(|p| + |q|) + slack²`.
    fn test(&self, corners: [[f32; 3]; 3], source: Source) -> Option<Candidate> {
        let v = corners.map(|p| p.map(f64::from));
        let d = self.direction.map(|c| c / self.speed);
        let center = [0, 1, 2].map(|a| (v[0][a] + v[1][a] + v[2][a]) / 3.0);
        let along = dot(sub(center, self.origin), d);
        let start = [0, 1, 2].map(|a| self.origin[a] + along * d[a]);
        let p = v.map(|c| sub(c, start));
        let slack = self.slack + 2f64.powi(-48) * along.abs();
        let reach = p.map(length);
        let (mut left, mut right, mut unsure) = (false, false, false);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let moment = dot(d, cross(p[i], p[j]));
            let margin = slack * (reach[i] + reach[j]) + slack * slack;
            let (to_left, to_right) = (moment > margin, moment < -margin);
            left |= to_left;
            right |= to_right;
            unsure |= !to_left && !to_right;
        }
        if left && right {
            return None;
        }

        // A certain crossing has one distance, known within slack over the cosine; any other lies somewhere in the triangle.
        let depths = p.map(|c| dot(c, d));
        let mut nearest = along + depths.into_iter().fold(f64::INFINITY, f64::min) - slack;
        let mut farthest = along + depths.into_iter().fold(f64::NEG_INFINITY, f64::max) + slack;
        if !unsure {
            let normal = cross(sub(v[1], v[0]), sub(v[2], v[0]));
            let facing = dot(normal, d);
            let distance = along + dot(normal, p[0]) / facing;
            let spread = slack * (length(normal) / facing.abs()) + slack;
            nearest = nearest.max(distance - spread);
            farthest = farthest.min(distance + spread);
        }
        let (nearest, farthest) = (nearest / self.speed, farthest / self.speed);
        if farthest < self.t_min || nearest > self.t_max {
            return None;
        }
        let certain = !unsure && nearest >= self.t_min && farthest <= self.t_max;
        Some(Candidate { source, nearest, farthest, certain })
    }
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}
