//! Errors counted: each ray by each arithmetic against the oracle's answer.

use crate::cache::{InstanceRecord, View};
use crate::exec::Executor;
use crate::geom::Ray;
use crate::trace::arithmetic::{Arithmetic, closest_hit_by, is_real};
use crate::trace::brute::{Answer, Candidate, Oracle, Standing};
use crate::trace::compare::names;
use crate::trace::{Hit, Malformed};
use serde::ser::{Serialize, SerializeStruct, Serializer};

/// Wrong answers among so many. Ties are right, and so is either answer where what the best `f64` arithmetic can be off decides, or rounding an instance's
/// matrix ([`brute`](crate::trace::brute) states the bounds).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[non_exhaustive]
pub struct Errors {
    /// How many were judged.
    pub rays: u64,
    /// Nothing, where something is certainly hit.
    pub missed: u64,
    /// A triangle that the ray crosses, but behind the nearest.
    pub farther: u64,
    /// A triangle that the ray does not cross, or not where it counts.
    pub false_hits: u64,
}

impl Errors {
    /// Of all three kinds.
    pub fn wrong(&self) -> u64 {
        self.missed + self.farther + self.false_hits
    }

    /// Wrong answers among a million rays.
    pub fn per_million(&self) -> f64 {
        if self.rays == 0 { 0.0 } else { self.wrong() as f64 * 1e6 / self.rays as f64 }
    }
}

/// Errors of distances, in units in the last place of the true distance as an `f32`, of hits that the oracle is certain of.
///
/// The oracle knows a distance within an interval (a point but for the rounding of instance matrices); what counts is how far the hit lies outside of it, so
/// no error is overstated. Rounding once to `f32` costs up to half a unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Distance {
    /// Ascending.
    ulps: Vec<f32>,
}

impl Distance {
    /// How many hits were compared.
    pub fn hits(&self) -> u64 {
        self.ulps.len() as u64
    }

    /// 0 without hits.
    pub fn median(&self) -> f64 {
        self.ulps.get(self.ulps.len() / 2).copied().unwrap_or(0.0).into()
    }

    /// 0 without hits.
    pub fn max(&self) -> f64 {
        self.ulps.last().copied().unwrap_or(0.0).into()
    }

    pub(super) fn of(mut ulps: Vec<f32>) -> Distance {
        ulps.sort_unstable_by(f32::total_cmp);
        Distance { ulps }
    }

    pub(super) fn and(mut self, other: &Distance) -> Distance {
        self.ulps.extend(&other.ulps);
        Distance::of(self.ulps)
    }
}

impl Serialize for Distance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Distance", 3)?;
        fields.serialize_field("hits", &self.hits())?;
        fields.serialize_field("median_ulps", &self.median())?;
        fields.serialize_field("max_ulps", &self.max())?;
        fields.end()
    }
}

/// What one arithmetic came to.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    pub fair: Errors,
    pub hard: Errors,
    pub distance: Distance,
    pub hard_distance: Distance,
}

/// One tally for each arithmetic, filled a batch of rays at a time.
pub struct Tallies<'a> {
    view: &'a View<'a>,
    oracle: &'a Oracle<'a>,
    /// Instance records by the instances' numbers.
    records: Vec<Option<&'a InstanceRecord>>,
    /// With the distance errors of fair and of hard rays.
    tallies: Vec<(Tally, [Vec<f32>; 2])>,
}

/// What an answer is.
enum Class {
    /// With the error of its distance, where that is known.
    Right(Option<f32>),
    Missed,
    Farther,
    False,
}

impl<'a> Tallies<'a> {
    pub fn new(view: &'a View<'a>, oracle: &'a Oracle<'a>) -> Tallies<'a> {
        let mut records = vec![None; view.instances.len()];
        for record in view.instances {
            if let Some(slot) = records.get_mut(record.id as usize) {
                *slot = Some(record);
            }
        }
        Tallies { view, oracle, records, tallies: Arithmetic::all().map(|_| Default::default()).collect() }
    }

    /// Trace the rays by every arithmetic; `answers` are the oracle's.
    pub fn add(&mut self, fair: bool, rays: &[Ray], answers: &[Answer], exec: &Executor) -> Result<(), Malformed> {
        for (i, arithmetic) in Arithmetic::all().enumerate() {
            let classes = exec.map_range(rays.len().min(answers.len()), |i| {
                let hit = closest_hit_by(arithmetic, self.view, &rays[i])?;
                Ok(self.classify(&rays[i], &answers[i], hit.as_ref()))
            });
            let classes = classes.into_iter().collect::<Result<Vec<Class>, Malformed>>()?;
            let (tally, [fair_ulps, hard_ulps]) = &mut self.tallies[i];
            let (errors, ulps) = if fair { (&mut tally.fair, fair_ulps) } else { (&mut tally.hard, hard_ulps) };
            errors.rays += rays.len() as u64;
            for class in classes {
                match class {
                    Class::Right(error) => ulps.extend(error),
                    Class::Missed => errors.missed += 1,
                    Class::Farther => errors.farther += 1,
                    Class::False => errors.false_hits += 1,
                }
            }
        }
        Ok(())
    }

    /// In the order of [`Arithmetic::all`].
    pub fn finish(self) -> impl Iterator<Item = Tally> {
        self.tallies.into_iter().map(|(tally, [fair, hard])| Tally {
            distance: Distance::of(fair),
            hard_distance: Distance::of(hard),
            ..tally
        })
    }

    /// Unlike [`compare::judge`](crate::trace::compare::judge), this takes any distance from a hit on an acceptable triangle: it is measured, not judged.
    fn classify(&self, ray: &Ray, answer: &Answer, hit: Option<&Hit>) -> Class {
        let Some(hit) = hit else {
            return if answer.certain().is_some() { Class::Missed } else { Class::Right(None) };
        };
        let named = answer.candidates.iter().find(|c| names(self.view, self.oracle, hit, c.source));
        match named {
            Some(c) => Class::Right((c.standing == Standing::Hit).then(|| ulps(c, hit.t))),
            None => {
                let record = hit.instance.map(|id| self.records.get(id as usize).copied().flatten());
                let real = match record {
                    Some(None) => false,
                    Some(Some(record)) => is_real(self.view, ray, hit, Some(record)),
                    None => is_real(self.view, ray, hit, None),
                };
                if real && answer.certain().is_some() { Class::Farther } else { Class::False }
            }
        }
    }
}

/// How far `t` lies outside of the candidate's interval.
fn ulps(candidate: &Candidate, t: f32) -> f32 {
    let t = f64::from(t);
    let error = (candidate.nearest - t).max(t - candidate.farthest).max(0.0);
    let truth = t.clamp(candidate.nearest, candidate.farthest).abs() as f32;
    (error / (f64::from(truth.next_up()) - f64::from(truth))) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::brute::{Order, Source};

    #[test]
    fn distance_errors_count_units_of_the_true_distance() {
        let at = |nearest, farthest| Candidate {
            source: Source { instance: 0, triangle: 0 },
            standing: Standing::Hit,
            order: Order::First,
            t: nearest,
            nearest,
            farthest,
        };
        assert_eq!(ulps(&at(1.0, 1.0), 1.0), 0.0);
        assert_eq!(ulps(&at(1.0, 1.0), 1.0 + 3.0 * f32::EPSILON), 3.0);
        assert_eq!(ulps(&at(4.0, 4.0), 4.0 - 2.0 * f32::EPSILON), 0.5);
        assert_eq!(ulps(&at(1.0, 2.0), 1.5), 0.0);
        assert_eq!(ulps(&at(1.0, 2.0), 2.0 + 2.0 * f32::EPSILON), 1.0);
    }

    #[test]
    fn medians_and_maxima_are_of_all_files() {
        let both = Distance::of(vec![3.0, 1.0]).and(&Distance::of(vec![2.0]));
        assert_eq!((both.hits(), both.median(), both.max()), (3, 2.0, 3.0));
        assert_eq!((Distance::default().median(), Distance::default().max()), (0.0, 0.0));
    }
}
