//! Verdicts: what traversal found against what brute force knows.

use super::brute::{Answer, Candidate, Oracle, Source};
use super::{Hit, closest_hit};
use crate::cache::{NO_NODE, View};
use crate::geom::Ray;
use rayon::prelude::*;

/// How one ray's hit stands to the [`Answer`] of brute force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The nearest certain hit, or nothing where there is nothing.
    Agree,
    /// Another certain hit at the same distance, within what rounding allows.
    Tie,
    /// A triangle whose edge the ray passes within rounding, or nothing where only such triangles are met: either is right.
    Grazing,
    /// Nothing, where something is certainly hit.
    Missed,
    /// A triangle beyond the nearest certain hit.
    Farther,
    /// A triangle that the ray certainly misses at that distance.
    False,
}

impl Verdict {
    pub fn is_right(self) -> bool {
        matches!(self, Verdict::Agree | Verdict::Tie | Verdict::Grazing)
    }
}

/// How many rays got which verdict, and the first that was wrong.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub agree: u64,
    pub tie: u64,
    pub grazing: u64,
    pub missed: u64,
    pub farther: u64,
    pub false_hits: u64,
    /// Rays that hit something.
    pub hits: u64,
    pub first_wrong: Option<Wrong>,
}

/// A wrong answer with all that is needed to replay it.
#[derive(Clone, Debug)]
pub struct Wrong {
    pub index: usize,
    pub ray: Ray,
    pub verdict: Verdict,
    pub hit: Option<Hit>,
    pub answer: Answer,
}

impl Tally {
    pub fn rays(&self) -> u64 {
        self.agree + self.tie + self.grazing + self.wrong()
    }

    pub fn wrong(&self) -> u64 {
        self.missed + self.farther + self.false_hits
    }

    fn add(&mut self, verdict: Verdict) {
        let count = match verdict {
            Verdict::Agree => &mut self.agree,
            Verdict::Tie => &mut self.tie,
            Verdict::Grazing => &mut self.grazing,
            Verdict::Missed => &mut self.missed,
            Verdict::Farther => &mut self.farther,
            Verdict::False => &mut self.false_hits,
        };
        *count += 1;
    }
}

/// Trace every ray through `view` and judge it by `answers`, which [`Oracle::trace_all`] gave for the same rays.
pub fn compare(view: &View<'_>, oracle: &Oracle<'_>, rays: &[Ray], answers: &[Answer]) -> Tally {
    let one = |(ray, answer): (&Ray, &Answer)| {
        let hit = closest_hit(view, ray);
        (judge(view, oracle, answer, hit.as_ref()), hit)
    };
    let judged: Vec<(Verdict, Option<Hit>)> = rays.par_iter().zip(answers).map(one).collect();
    let mut tally = Tally::default();
    for (index, (verdict, hit)) in judged.into_iter().enumerate() {
        tally.add(verdict);
        tally.hits += u64::from(hit.is_some());
        if !verdict.is_right() && tally.first_wrong.is_none() {
            tally.first_wrong = Some(Wrong { index, ray: rays[index], verdict, hit, answer: answers[index].clone() });
        }
    }
    tally
}

/// Judge one hit.
pub fn judge(view: &View<'_>, oracle: &Oracle<'_>, answer: &Answer, hit: Option<&Hit>) -> Verdict {
    let Some(hit) = hit else {
        return match answer.certain() {
            Some(_) => Verdict::Missed,
            None if answer.candidates.is_empty() => Verdict::Agree,
            None => Verdict::Grazing,
        };
    };

    // The hit's distance was rounded to f32 once.
    let t = f64::from(hit.t);
    let rounding = t.abs() * 2f64.powi(-24) + f64::from(f32::from_bits(1));
    let within = |c: &Candidate| c.nearest - rounding <= t && t <= c.farthest + rounding;
    if answer.certain().is_some_and(|c| t > c.farthest + rounding) {
        return Verdict::Farther;
    }
    let same = |c: &&Candidate| within(c) && names(view, oracle, hit, c.source);
    match answer.candidates.iter().find(same) {
        None => Verdict::False,
        Some(c) if !c.certain => Verdict::Grazing,
        Some(c) if answer.certain() == Some(c) => Verdict::Agree,
        Some(_) => Verdict::Tie,
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
