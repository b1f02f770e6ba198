//! Verdicts: what traversal found against what brute force knows.

use super::brute::{Answer, Candidate, Oracle, Order, Source, Standing};
use super::{Hit, Malformed, closest_hit};
use crate::cache::{NO_NODE, View};
use crate::exec::Executor;
use crate::geom::Ray;

/// How one ray's hit stands to the [`Answer`] of brute force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Verdict {
    /// The nearest hit, the first of several at one distance; or nothing where there is nothing.
    Agree,
    /// Another triangle at the very distance of the nearest hit, or at a distance that is the same `f32`: shared edges and corners,
    /// coincident triangles.
    Tie,
    /// Not what exact arithmetic says, but within what `f64` may be off ([`brute`](super::brute) states the bound): a triangle lost or found whose edge, or
    /// whose distance limit, the ray passes within 2⁻⁴⁸ of the largest coordinate in play, or the farther of two that lie so near to each other.
    Grazing,
    /// So near to an edge of a moved instance that rounding its matrix to `f32` decides, and the file's matrix is not at hand: either answer is
    /// right.
    Unsure,
    /// Nothing, where something is certainly hit.
    Missed,
    /// A triangle beyond the nearest certain hit.
    Farther,
    /// A triangle that the ray certainly misses at that distance.
    False,
}

impl Verdict {
    /// Whether a correct traversal may answer so.
    pub fn is_right(self) -> bool {
        !matches!(self, Verdict::Missed | Verdict::Farther | Verdict::False)
    }
}

/// How many rays got which verdict, and the first that was wrong.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// [`Verdict::Agree`].
    pub agree: u64,
    /// [`Verdict::Tie`].
    pub tie: u64,
    /// [`Verdict::Grazing`].
    pub grazing: u64,
    /// [`Verdict::Unsure`].
    pub unsure: u64,
    /// [`Verdict::Missed`].
    pub missed: u64,
    /// [`Verdict::Farther`].
    pub farther: u64,
    /// [`Verdict::False`].
    pub false_hits: u64,
    /// Rays that hit something.
    pub hits: u64,
    /// Of the rays in their order, so that it is the same for any number of threads.
    pub first_wrong: Option<Wrong>,
}

/// A wrong answer with all that is needed to replay it.
#[derive(Clone, Debug)]
pub struct Wrong {
    /// Number of the ray among those that were compared.
    pub index: usize,
    /// What was asked.
    pub ray: Ray,
    /// One of those that are not right.
    pub verdict: Verdict,
    /// What traversal answered.
    pub hit: Option<Hit>,
    /// What brute force knows.
    pub answer: Answer,
}

impl Tally {
    /// How many rays were judged.
    pub fn rays(&self) -> u64 {
        self.agree + self.tie + self.grazing + self.unsure + self.wrong()
    }

    /// How many answers no correct traversal gives.
    pub fn wrong(&self) -> u64 {
        self.missed + self.farther + self.false_hits
    }

    /// Count one more.
    pub fn add(&mut self, verdict: Verdict) {
        let count = match verdict {
            Verdict::Agree => &mut self.agree,
            Verdict::Tie => &mut self.tie,
            Verdict::Grazing => &mut self.grazing,
            Verdict::Unsure => &mut self.unsure,
            Verdict::Missed => &mut self.missed,
            Verdict::Farther => &mut self.farther,
            Verdict::False => &mut self.false_hits,
        };
        *count += 1;
    }
}

/// Trace every ray through `view` and judge it by `answers`, which [`Oracle::trace_all`] gave for the same rays.
///
/// # Errors
/// Where the tree is malformed: that of the first ray whose walk came upon it.
pub fn compare(
    view: &View<'_>,
    oracle: &Oracle<'_>,
    rays: &[Ray],
    answers: &[Answer],
    exec: &Executor,
) -> Result<Tally, Malformed> {
    let judged = exec.map_range(rays.len().min(answers.len()), |i| {
        let hit = closest_hit(view, &rays[i])?;
        Ok((judge(view, oracle, &answers[i], hit.as_ref()), hit))
    });
    let mut tally = Tally::default();
    for (index, found) in judged.into_iter().enumerate() {
        let (verdict, hit) = found?;
        tally.add(verdict);
        tally.hits += u64::from(hit.is_some());
        if !verdict.is_right() && tally.first_wrong.is_none() {
            tally.first_wrong = Some(Wrong { index, ray: rays[index], verdict, hit, answer: answers[index].clone() });
        }
    }
    Ok(tally)
}

/// Judge the nearest hit that was found.
pub fn judge(view: &View<'_>, oracle: &Oracle<'_>, answer: &Answer, hit: Option<&Hit>) -> Verdict {
    let Some(hit) = hit else { return judge_any(answer, false) };

    let (t, rounding) = distance(hit);
    let within = |c: &Candidate| c.nearest - rounding <= t && t <= c.farthest + rounding;
    if answer.certain().is_some_and(|c| t > c.farthest + rounding) {
        return Verdict::Farther;
    }
    let same = |c: &&Candidate| within(c) && names(view, oracle, hit, c.source);
    let Some(found) = answer.candidates.iter().find(same) else { return Verdict::False };
    match (found.standing, found.order) {
        (Standing::BareMiss, _) => Verdict::Grazing,
        (Standing::Unsure, _) => Verdict::Unsure,
        (_, Order::First) => Verdict::Agree,
        (_, Order::Equal | Order::Rounded) => Verdict::Tie,
        (_, Order::Later) => Verdict::Grazing,
        (_, Order::Unknown) => Verdict::Unsure,
    }
}

/// A hit's distance, and what rounding it to `f32` once may have cost.
fn distance(hit: &Hit) -> (f64, f64) {
    let t = f64::from(hit.t);
    (t, t.abs() * 2f64.powi(-24) + f64::from(f32::from_bits(1)))
}

/// Whether a hit may be one of the triangle `source`, which it names: what can be said of it without all other triangles.
pub fn stands(oracle: &Oracle<'_>, ray: &Ray, source: Source, hit: &Hit) -> bool {
    let (t, rounding) = distance(hit);
    oracle.reach(ray, source).is_some_and(|(nearest, farthest)| nearest - rounding <= t && t <= farthest + rounding)
}

/// Whether an answer leaves out a triangle that the ray may meet: there is no hit, or one that is farther. Like [`stands`], of this one
/// triangle alone; where it says yes, the oracle must be asked.
pub(crate) fn passes_over(oracle: &Oracle<'_>, ray: &Ray, source: Source, hit: Option<&Hit>) -> bool {
    let Some((_, farthest)) = oracle.reach(ray, source) else { return false };
    hit.is_none_or(|hit| {
        let (t, rounding) = distance(hit);
        t > farthest + rounding
    })
}

/// Judge whether anything was found: the answer to a shadow ray, or no hit.
pub(crate) fn judge_any(answer: &Answer, found: bool) -> Verdict {
    let (hit, bare_hit) = (answer.has(Standing::Hit), answer.has(Standing::BareHit));
    let (bare_miss, unsure) = (answer.has(Standing::BareMiss), answer.has(Standing::Unsure));
    match found {
        true if hit || bare_hit => Verdict::Agree,
        true if unsure => Verdict::Unsure,
        true if bare_miss => Verdict::Grazing,
        true => Verdict::False,
        false if hit => Verdict::Missed,
        false if bare_hit => Verdict::Grazing,
        false if unsure => Verdict::Unsure,
        false => Verdict::Agree,
    }
}

/// Whether a hit's ids are those of a source triangle, at whatever distance.
pub fn names(view: &View<'_>, oracle: &Oracle<'_>, hit: &Hit, source: Source) -> bool {
    let scene = oracle.scene();
    let instance = &scene.instances[source.instance as usize];
    let mesh = &scene.meshes[instance.mesh as usize];
    let part = mesh.parts.partition_point(|p| p.first_triangle + p.triangle_count <= source.triangle);
    let (Some(part), Some(geom)) = (mesh.parts.get(part), view.geoms.get(hit.geom as usize)) else { return false };

    // A one-level file tells copies of a part apart by the node that was baked into them.
    let node = part.baked_node.unwrap_or(instance.node);
    hit.instance.is_none_or(|id| id == source.instance)
        && hit.prim == mesh.source_prim(source.triangle as usize)
        && (geom.source_mesh, geom.source_part) == (part.source_mesh, part.source_part)
        && (geom.baked_node == NO_NODE || geom.baked_node == node)
}
