//! Where the rays of families start and where they go.

use super::{FAMILIES, Family};
use crate::cache::View;
use crate::exec::Executor;
use crate::geom::vector::{cross, dot, sub};
use crate::geom::{Aabb, Ray};
use crate::random::Random;
use crate::trace::probe::bounce::{Struck, bounces, camera_rays, strike, surface, toward_occluders};
use crate::trace::probe::camera::subject;
use crate::trace::probe::world::World;
use crate::trace::probe::{CHUNK, Camera};

/// Triangles that surfaces are chosen from, at most: of more, every second, third and so on.
const MOST_TRIANGLES: usize = 1 << 19;
/// Eyes stand no farther than this share of the diagonal from a surface that nothing stands opposite to.
const OPEN: f64 = 0.25;
/// Cameras outside mean nothing where they see fewer than one in so many of the triangles that as many inside see.
const CLOSED: usize = 8;
/// Directions of far lights.
const LIGHTS: usize = 16;
/// Tries to find a line that meets the scene's box.
const TRIES: usize = 16;

/// What all families are made from.
pub(super) struct Maker<'v> {
    world: World<'v>,
    /// What nearly all triangles are in.
    subject: Aabb,
    diagonal: f64,
    count: usize,
    random: Random,
    exec: &'v Executor,
}

impl<'v> Maker<'v> {
    pub fn new(view: &'v View<'v>, count: usize, seed: u64, exec: &'v Executor) -> Maker<'v> {
        let world = World::new(view);
        let diagonal = world.diagonal();
        Maker { world, subject: subject(view), diagonal, count, random: Random::new(seed), exec }
    }

    /// By family, in the order of [`Family::ALL`].
    pub fn families(mut self) -> [Vec<Ray>; FAMILIES] {
        let outside = self.outside();
        let from_outside = self.struck(&outside);
        let inside = self.inside(&from_outside);
        let from_inside = self.struck(&inside);

        let is_closed = CLOSED * variety(&from_outside) < variety(&from_inside);
        let seen: Vec<Struck> = match is_closed {
            true => from_inside,
            false => some(&from_outside, self.count / 2).chain(some(&from_inside, self.count / 2)).collect(),
        };
        let bounce = bounces(&seen, self.count, self.diagonal, &mut self.random);
        let occlusion = bounces(&seen, self.count, self.diagonal, &mut self.random);
        let light = self.light(&seen);

        let triangles = self.world.triangles(MOST_TRIANGLES);
        let (area, each) = (self.by_area(&triangles), self.by_triangle(&triangles));
        let [area, each] = [area, each].map(|points| bounces(&points, self.count, self.diagonal, &mut self.random));
        let chords = self.chords();

        let mut sets = [const { Vec::new() }; FAMILIES];
        sets[Family::Outside as usize] = if is_closed { Vec::new() } else { outside };
        sets[Family::Inside as usize] = inside;
        sets[Family::Bounce as usize] = bounce;
        let near = |ray| toward_occluders(ray, self.diagonal);
        sets[Family::Occlusion as usize] = occlusion.into_iter().map(near).collect();
        sets[Family::Light as usize] = light;
        sets[Family::Area as usize] = area;
        sets[Family::Triangles as usize] = each;
        sets[Family::Chords as usize] = chords;
        let is_finite = |ray: &Ray| ray.origin.iter().chain(&ray.direction).all(|c| c.is_finite());
        sets.iter_mut().for_each(|rays| rays.retain(is_finite));
        sets
    }

    /// From a sphere around the subject, as far from its middle as it is long, to anywhere in its box.
    fn outside(&mut self) -> Vec<Ray> {
        let (min, extent) = (self.subject.min.map(f64::from), self.subject_extent());
        let (radius, middle) = (dot(extent, extent).sqrt(), self.middle());
        let random = &mut self.random;
        let one = |_| {
            let direction = random.direction();
            let eye = [0, 1, 2].map(|k| middle[k] + radius * direction[k]);
            let aim = [0, 1, 2].map(|k| min[k] + random.unit() * extent[k]);
            let ahead = sub(aim, eye);
            let length = dot(ahead, ahead).sqrt();
            let forward = if length > 0.0 { ahead.map(|c| c / length) } else { direction };
            Ray::new(eye.map(|c| c as f32), forward.map(|c| c as f32))
        };
        if radius > 0.0 { (0..self.count).map(one).collect() } else { Vec::new() }
    }

    /// Light that bounces off what cameras see crosses the space in which cameras can stand. Eyes stand at random points of such rays, of the
    /// first bounce and of the second, and only where something stands opposite, if there is such a place.
    fn inside(&mut self, from_outside: &[Struck]) -> Vec<Ray> {
        let views = camera_rays(&Camera::around(self.world.view), self.count / 4);
        let seeds: Vec<Struck> =
            some(from_outside, self.count / 4).chain(some(&self.struck(&views), self.count / 4)).collect();
        let first = bounces(&seeds, self.count / 2, self.diagonal, &mut self.random);
        let second = bounces(&self.struck(&first), self.count / 2, self.diagonal, &mut self.random);
        let light = self.cut_off([first, second].concat());
        let is_between = |ray: &&Ray| ray.t_max.is_finite();
        let between: Vec<&Ray> = light.iter().filter(is_between).collect();
        let along: Vec<&Ray> = if between.is_empty() { light.iter().collect() } else { between };
        let (diagonal, random) = (self.diagonal, &mut self.random);
        let one = |i: usize| {
            let ray = along[i % along.len()];
            let d = ray.direction.map(f64::from);
            let most = if ray.t_max.is_finite() { f64::from(ray.t_max) } else { OPEN * diagonal / dot(d, d).sqrt() };
            let reach = most * random.unit();
            let eye = [0, 1, 2].map(|k| (f64::from(ray.origin[k]) + reach * d[k]) as f32);
            Ray::new(eye, random.direction().map(|c| c as f32))
        };
        (0..if along.is_empty() { 0 } else { self.count }).map(one).collect()
    }

    /// To one of a few lights far away, the next one that stands on the surface's side.
    fn light(&mut self, seen: &[Struck]) -> Vec<Ray> {
        let lights: Vec<[f64; 3]> = (0..LIGHTS).map(|_| self.random.direction()).collect();
        let of = |(i, s): (usize, Struck)| {
            let ahead = (0..LIGHTS).map(|k| lights[(i + k) % LIGHTS]);
            ahead.into_iter().find(|light| dot(*light, s.normal) > 0.0).map(|light| s.ray(light, self.diagonal))
        };
        some(seen, self.count).enumerate().filter_map(of).collect()
    }

    /// Points of the surface, each part of it as likely.
    fn by_area(&mut self, triangles: &[[[f32; 3]; 3]]) -> Vec<Struck> {
        let mut sum = 0.0;
        let before: Vec<f64> = triangles
            .iter()
            .map(|corners| {
                sum += area(corners);
                sum
            })
            .collect();
        if !(sum > 0.0 && sum.is_finite()) {
            return Vec::new();
        }
        let share = sum / self.count as f64;
        let at = |at: f64| before.partition_point(|sum| *sum <= at).min(triangles.len() - 1);
        let random = &mut self.random;
        (0..self.count).filter_map(|i| surface(&triangles[at((i as f64 + random.unit()) * share)], random)).collect()
    }

    /// Points of the surface, each triangle as likely.
    fn by_triangle(&mut self, triangles: &[[[f32; 3]; 3]]) -> Vec<Struck> {
        let share = triangles.len() as f64 / self.count as f64;
        let random = &mut self.random;
        let one = |i: usize| {
            let at = ((i as f64 + random.unit()) * share) as usize;
            surface(triangles.get(at)?, random)
        };
        (0..self.count).filter_map(one).collect()
    }

    /// Lines between two random points of a sphere around the subject, those that meet its box.
    fn chords(&mut self) -> Vec<Ray> {
        let (extent, middle, subject) = (self.subject_extent(), self.middle(), self.subject);
        let radius = 0.5 * dot(extent, extent).sqrt();
        let random = &mut self.random;
        let mut line = || {
            let [a, b] = [random.direction(), random.direction()];
            let start = [0, 1, 2].map(|k| middle[k] + radius * a[k]);
            (start, sub(b, a))
        };
        let one = |_| {
            let met = (0..TRIES).map(|_| line()).find(|(start, ahead)| meets(&subject, *start, *ahead))?;
            let length = dot(met.1, met.1).sqrt();
            Some(Ray::new(met.0.map(|c| c as f32), met.1.map(|c| (c / length) as f32)))
        };
        if radius > 0.0 { (0..self.count).filter_map(one).collect() } else { Vec::new() }
    }

    fn subject_extent(&self) -> [f64; 3] {
        sub(self.subject.max.map(f64::from), self.subject.min.map(f64::from))
    }

    fn middle(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| 0.5 * (f64::from(self.subject.min[k]) + f64::from(self.subject.max[k])))
    }

    /// What the rays hit.
    fn struck(&self, rays: &[Ray]) -> Vec<Struck> {
        let hits = self.exec.map_chunks(rays, CHUNK, |_, chunk| {
            chunk.iter().filter_map(|ray| strike(&self.world, ray)).collect::<Vec<_>>()
        });
        hits.concat()
    }

    /// The rays up to what they hit.
    fn cut_off(&self, mut rays: Vec<Ray>) -> Vec<Ray> {
        self.exec.map_chunks_mut(&mut rays, CHUNK, |_, chunk| {
            for ray in chunk {
                if let Some(struck) = strike(&self.world, ray) {
                    ray.t_max = struck.t;
                }
            }
        });
        rays
    }
}

/// How many different triangles rays hit.
fn variety(struck: &[Struck]) -> usize {
    let mut hits: Vec<_> = struck.iter().map(|struck| struck.hit).collect();
    hits.sort_unstable();
    hits.dedup();
    hits.len()
}

/// About so many of the surfaces, from all over.
fn some(surfaces: &[Struck], count: usize) -> impl Iterator<Item = Struck> + '_ {
    let count = if surfaces.is_empty() { 0 } else { count };
    (0..count).map(move |i| surfaces[i * surfaces.len() / count])
}

/// Twice the area of a triangle.
fn area(corners: &[[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let n = cross(sub(b, a), sub(c, a));
    dot(n, n).sqrt()
}

/// Whether a line meets a box.
fn meets(b: &Aabb, start: [f64; 3], ahead: [f64; 3]) -> bool {
    let (mut near, mut far) = (0.0f64, f64::INFINITY);
    for k in 0..3 {
        let [low, high] = [b.min[k], b.max[k]].map(|plane| f64::from(plane) - start[k]);
        if ahead[k] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
            continue;
        }
        let (s, t) = (low / ahead[k], high / ahead[k]);
        (near, far) = (near.max(s.min(t)), far.min(s.max(t)));
    }
    near <= far
}
