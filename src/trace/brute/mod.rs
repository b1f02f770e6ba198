//! The oracle: every triangle of the scene tested without any tree, and the near cases decided exactly.
//!
//! It shares nothing with traversal: no tree, no box of a builder, another formula. To stay usable on millions of triangles it skips runs
//! of consecutive source triangles whose common box, widened by the margin below, the ray misses (`skip`).
//!
//! A decision has up to three steps.
//!
//! 1. `f64` with a margin (`probe`): the *slack* is how far, at most, the ray that traversal follows lies from the true one where they
//!    pass a triangle. A ray that keeps more than the slack away from all edges, and whose distance is in range by more than it may be off, is
//!    certain: every correct traversal in `f64` must come to the same end. That settles nearly all.
//! 2. Whole numbers (`exact`), where the ray and the triangle are known exactly: for instances at the identity, as in every one-level
//!    file of its own list, and for others with the matrix or the moved vertices that the file holds ([`Oracle::of_file`]). Hit or miss is then decided as geometry has it, edges and
//!    corners included, and `t_min ≤ t ≤ t_max` too; such hits and misses are [`Bare`](Standing::BareHit): a traversal that
//!    computes in `f64` may be off here, within the bound that `probe` states, and verdicts say so.
//! 3. Distances that may be equal are compared exactly as well.
//!
//! What is left is [`Unsure`](Standing::Unsure): rays so near to an edge of a moved instance that rounding its matrix to `f32` decides, asked
//! about a scene whose file is not at hand.

mod exactly;
mod probe;
mod skip;

use self::exactly::{ExactRay, Exactly};
use self::probe::{Map, Probe, Span};
use self::skip::Runs;
use super::FARTHEST;
use super::exact::{Meeting, Ratio};
use crate::cache::View;
use crate::exec::Executor;
use crate::geom::{Affine, Ray};
use crate::scene::Scene;
use std::cmp::Ordering;

/// A triangle of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Source {
    /// Index in [`Scene::instances`].
    pub instance: u32,
    /// Index in the mesh's triangles as read, after dropping.
    pub triangle: u32,
}

/// How the ray stands to a triangle that it does not certainly miss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Standing {
    /// It meets the triangle, by more than `f64` can be off.
    Hit,
    /// It meets the triangle exactly, but so near to an edge, to `t_min` or to `t_max` that `f64` may lose it.
    BareHit,
    /// It misses the triangle exactly, but so near that `f64` may find it.
    BareMiss,
    /// Rounding the instance's matrix to `f32` decides: both answers are right.
    Unsure,
}

/// Where a hit stands among all hits of its ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Order {
    /// The nearest; of several at the same distance the one of the smallest source.
    First,
    /// At exactly the same distance as the first.
    Equal,
    /// Farther than the first, but with the same distance in `f32`.
    Rounded,
    /// Farther than the first.
    Later,
    /// Its distance is known too roughly to tell, or it is no hit.
    Unknown,
}

/// A triangle that the ray meets, or may be found to meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The triangle.
    pub source: Source,
    /// How certain it is that the ray meets it.
    pub standing: Standing,
    /// Where the hit stands among those of the ray.
    pub order: Order,
    /// The distance, as well as `f64` knows it.
    pub t: f64,
    /// What a traversal in `f64` may compute for `t` lies between these.
    pub nearest: f64,
    /// The upper end of that interval.
    pub farthest: f64,
}

/// What brute force says of a ray: all candidates that a closest-hit traversal might return, the first hit first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// Every triangle that the ray does not certainly miss within its range; empty where nothing can be hit.
    pub candidates: Vec<Candidate>,
}

impl Answer {
    /// The hit that geometry and the rule for ties ask for. Where hits are [`Unsure`](Standing::Unsure), another may be right too.
    pub fn first(&self) -> Option<&Candidate> {
        self.candidates.first().filter(|c| c.order == Order::First)
    }

    /// The certain hit whose farthest distance is smallest: nothing beyond it may be returned.
    pub fn certain(&self) -> Option<&Candidate> {
        let certain = self.candidates.iter().filter(|c| c.standing == Standing::Hit);
        certain.min_by(|a, b| a.farthest.total_cmp(&b.farthest))
    }

    /// Whether some candidate stands so.
    pub fn has(&self, standing: Standing) -> bool {
        self.candidates.iter().any(|c| c.standing == standing)
    }
}

/// What an exact decision takes, in tests of a box or a triangle: a quarter of a microsecond, as profiles say.
const EXACT_WORK: u64 = 12;

/// Exact distances of hits.
struct Distances {
    /// Each once, the nearest first.
    apart: Vec<Ratio>,
    /// Which of these each hit has.
    of: Vec<usize>,
}

/// A scene ready to be asked.
pub struct Oracle<'a> {
    scene: &'a Scene,
    meshes: Vec<Runs>,
    places: Vec<Place>,
}

/// An instance.
struct Place {
    mesh: usize,
    /// By the scene's own matrix, with the slack that rounding it costs.
    map: Map,
    exactly: Exactly,
}

impl<'a> Oracle<'a> {
    /// An oracle about a scene. Rays through moved instances are judged up to the rounding of matrices to `f32`.
    ///
    /// # Panics
    /// Where the scene is not sound: see [`Scene::validate`].
    pub fn new(scene: &'a Scene, exec: &Executor) -> Oracle<'a> {
        let meshes = exec.map_range(scene.meshes.len(), |i| Runs::new(&scene.meshes[i]));
        let places = scene.instances.iter().map(|instance| {
            let mesh = instance.mesh as usize;
            let map = Map::rounded(&instance.transform, &meshes[mesh].bounds());
            let exactly = if map.is_identity() { Exactly::Identity } else { Exactly::Nothing };
            Place { mesh, map, exactly }
        });
        let places = places.collect();
        Oracle { scene, meshes, places }
    }

    /// An oracle about a scene and its file: where rounding decides, what the file holds is taken for exact. That is the instances' matrices of a
    /// two-level file, and the vertices of a one-level file, which are the scene's, moved and rounded once.
    ///
    /// A matrix that is wrong by more than rounding still makes wrong answers: what the scene's own matrix makes certain stays so.
    ///
    /// # Panics
    /// Where the scene is not sound: [`Scene::validate`] finds that.
    pub fn of_file(scene: &'a Scene, view: &View<'_>, exec: &Executor) -> Oracle<'a> {
        let mut oracle = Oracle::new(scene, exec);
        if view.tlas_nodes.is_empty() {
            for (place, instance) in oracle.places.iter_mut().zip(&scene.instances) {
                if matches!(place.exactly, Exactly::Nothing) {
                    let bounds = probe::moved(&instance.transform, &oracle.meshes[place.mesh].bounds());
                    let map = Map::stored(Affine::IDENTITY);
                    place.exactly = Exactly::Baked { map, to_world: instance.transform, bounds };
                }
            }
        }
        for record in view.instances {
            if let Some(place) = oracle.places.get_mut(record.id as usize)
                && matches!(place.exactly, Exactly::Nothing)
            {
                let matrix = record.world_to_object;
                place.exactly = Exactly::Stored { map: Map::stored(Affine::from_f32(&matrix)), matrix };
            }
        }
        oracle
    }

    /// The scene that the oracle was made for.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The answers to many rays.
    pub fn trace_all(&self, rays: &[Ray], exec: &Executor) -> Vec<Answer> {
        exec.map_range(rays.len(), |i| self.trace(&rays[i]))
    }

    /// What a ray meets between `t_min` and `t_max`, distances beyond 2¹²⁶ left out as traversal does.
    pub fn trace(&self, ray: &Ray) -> Answer {
        self.trace_counted(ray).0
    }

    /// [`Oracle::trace`], and what it took: boxes and triangles looked at, and [`EXACT_WORK`] for each exact decision. The same on every machine.
    pub(crate) fn trace_counted(&self, ray: &Ray) -> (Answer, u64) {
        let usable = ray.origin.iter().chain(&ray.direction).all(|v| v.is_finite())
            && ray.direction.iter().any(|d| *d != 0.0)
            && ray.t_min <= ray.t_max;
        if !usable {
            return (Answer::default(), 0);
        }
        let ray = &ray.until(ray.t_max.min(FARTHEST));
        let mut found = Vec::new();
        let mut limit = f64::from(ray.t_max);
        let work: u64 = (0..self.places.len()).map(|i| self.search(ray, i, &mut limit, &mut found)).sum();
        found.retain(|c| c.nearest <= limit);
        let compared = self.put_in_order(ray, &mut found);
        (Answer { candidates: found }, work + compared)
    }

    /// Add an instance's candidates and lower `limit` to the farthest distance of the nearest certain hit.
    fn search(&self, ray: &Ray, place_index: usize, limit: &mut f64, found: &mut Vec<Candidate>) -> u64 {
        let place = &self.places[place_index];
        let (mesh, runs) = (&self.scene.meshes[place.mesh], &self.meshes[place.mesh]);
        let probe = Probe::new(ray, &place.map, &runs.bounds());
        let mut exact = None;
        // Triangles that lie on one another often follow one another, and what is decided of one holds for all of them.
        let mut last = None;
        let mut decided_anew = 0;
        let tests = runs.visit(&probe, limit, |triangle, limit| {
            let corners = mesh.corners(triangle);
            let Some(span) = probe.test(corners) else { return };
            let alone = matches!(place.exactly, Exactly::Nothing | Exactly::Identity);
            let (span, standing) = if span.certain && alone {
                (span, Standing::Hit)
            } else {
                let known = last.filter(|(of, _)| *of == corners).map(|(_, decision)| decision);
                let decision = known.unwrap_or_else(|| {
                    decided_anew += 1;
                    let exact = exact.get_or_insert_with(|| ExactRay::new(ray, place, &runs.bounds()));
                    exact.decide(ray, span, place.exactly.corners(mesh, triangle))
                });
                last = Some((corners, decision));
                let Some(decided) = decision else { return };
                decided
            };
            if span.nearest <= *limit {
                if standing == Standing::Hit {
                    *limit = limit.min(span.farthest);
                }
                let source = Source { instance: place_index as u32, triangle: triangle as u32 };
                let Span { t, nearest, farthest, .. } = span;
                found.push(Candidate { source, standing, order: Order::Unknown, t, nearest, farthest });
            }
        });
        tests + decided_anew * EXACT_WORK
    }

    /// Find the nearest hit, exactly if need be, and say how the others stand to it. Returns the work of the exact decisions.
    fn put_in_order(&self, ray: &Ray, found: &mut [Candidate]) -> u64 {
        let is_hit = |c: &Candidate| matches!(c.standing, Standing::Hit | Standing::BareHit);
        found.sort_by(|a, b| {
            (is_hit(b).cmp(&is_hit(a))).then(a.farthest.total_cmp(&b.farthest)).then(a.source.cmp(&b.source))
        });
        let hits = found.partition_point(is_hit);
        let Some(reach) = found[..hits].first().map(|c| c.farthest) else { return 0 };
        let hits = &mut found[..hits];
        hits.iter_mut().for_each(|c| c.order = Order::Later);

        // Those that may be the nearest: usually one.
        let mut contenders: Vec<usize> = (0..hits.len()).filter(|i| hits[*i].nearest <= reach).collect();
        let mut work = 0;
        if contenders.len() > 1 {
            match self.distances(ray, hits, &contenders) {
                Some(Distances { apart, of }) => {
                    work = apart.len() as u64 * EXACT_WORK;
                    let least = &apart[0];
                    let standings: Vec<(f64, Order)> = apart
                        .iter()
                        .map(|t| match t.cmp(least) {
                            Ordering::Equal => (t.to_f64(), Order::Equal),
                            _ if t.to_f32() == least.to_f32() => (t.to_f64(), Order::Rounded),
                            _ => (t.to_f64(), Order::Later),
                        })
                        .collect();
                    let mut ranked: Vec<(usize, usize)> = of.into_iter().zip(contenders).collect();
                    ranked.sort_by_key(|(rank, i)| (*rank, hits[*i].source));
                    for (rank, i) in &ranked {
                        (hits[*i].t, hits[*i].order) = standings[*rank];
                    }
                    contenders = ranked.into_iter().map(|(_, i)| i).collect();
                }
                None => {
                    let first = hits[contenders[0]].t as f32;
                    for &i in &contenders {
                        let one_float = [hits[i].nearest, hits[i].farthest].iter().all(|t| *t as f32 == first);
                        hits[i].order = if one_float { Order::Rounded } else { Order::Unknown };
                    }
                }
            }
        }
        hits[contenders[0]].order = Order::First;
        hits.swap(0, contenders[0]);
        hits[1..].sort_by(|a, b| a.farthest.total_cmp(&b.farthest).then(a.source.cmp(&b.source)));
        work
    }

    /// At which exact distances a ray meets these hits; `None` where that of any is not known. Triangles of equal corners that follow one another
    /// are computed once: of tens of thousands on one another, each ray meets all.
    fn distances(&self, ray: &Ray, hits: &[Candidate], contenders: &[usize]) -> Option<Distances> {
        let corners_of = |source: Source| {
            let place = self.places.get(source.instance as usize)?;
            Some((source.instance, self.scene.meshes[place.mesh].corners(source.triangle as usize)))
        };
        let (mut computed, mut of): (Vec<Ratio>, Vec<usize>) = (Vec::new(), Vec::with_capacity(contenders.len()));
        let mut last = None;
        for source in contenders.iter().map(|i| hits[*i].source) {
            let corners = corners_of(source);
            if computed.is_empty() || corners != last {
                computed.push(self.meeting(ray, source)?.t);
            }
            last = corners;
            of.push(computed.len() - 1);
        }
        // Numbered from the nearest, equal ones alike.
        let mut ranked: Vec<usize> = (0..computed.len()).collect();
        ranked.sort_by(|a, b| computed[*a].cmp(&computed[*b]));
        let mut ranks = vec![0; computed.len()];
        let mut apart: Vec<Ratio> = Vec::new();
        for i in ranked {
            if apart.last().is_none_or(|t| *t != computed[i]) {
                apart.push(computed[i].clone());
            }
            ranks[i] = apart.len() - 1;
        }
        Some(Distances { apart, of: of.into_iter().map(|i| ranks[i]).collect() })
    }

    /// Between which distances a traversal may hit this very triangle, rounding allowed for; `None` where the ray certainly misses it. One
    /// test, however large the scene.
    pub fn reach(&self, ray: &Ray, source: Source) -> Option<(f64, f64)> {
        let place = self.places.get(source.instance as usize)?;
        let (mesh, runs) = (&self.scene.meshes[place.mesh], &self.meshes[place.mesh]);
        let ray = ray.until(ray.t_max.min(FARTHEST));
        let span = Probe::new(&ray, &place.map, &runs.bounds()).test(mesh.corners(source.triangle as usize))?;
        Some((span.nearest, span.farthest))
    }

    /// Where exactly the ray's line crosses a triangle, where it does and where that is known.
    pub fn meeting(&self, ray: &Ray, source: Source) -> Option<Meeting> {
        let place = self.places.get(source.instance as usize)?;
        let corners = place.exactly.corners(&self.scene.meshes[place.mesh], source.triangle as usize);
        place.exactly.line(ray)?.meet(corners)
    }
}

#[cfg(test)]
mod tests;
