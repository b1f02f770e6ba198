//! The pipeline: rays in batches, the reference's answers, every device's answers, the oracle's word on a sample and on every difference.

use super::blame::blame;
use super::device::{Device, DeviceError, Query};
use super::origin::Origin;
use super::outcome::{Class, Counts, DeviceOutcome, Expected, Got, Mismatch, OracleOutcome, Outcome};
use super::plan::{Asked, Batch, Plan};
use super::record::HitRecord;
use super::subject::Subject;
use crate::build::Progress;
use crate::geom::Ray;
use crate::trace::brute::Answer;
use crate::trace::compare::{Verdict, judge, judge_any, passes_over, stands};
use rayon::prelude::*;
use std::time::Instant;

/// Why verification came to no verdict.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    #[error(transparent)]
    Device(#[from] DeviceError),
    #[error("Interrupted.")]
    Cancelled,
}

/// Trace the plan's rays on `reference`, whose answers are the CPU's, and on `others`, and judge what they say.
///
/// `progress` advances by the plan's rays. A tree that traversal gives up on is a mismatch, not an error.
pub fn run(
    subject: &Subject<'_>,
    reference: &mut dyn Device,
    others: &mut [Box<dyn Device + '_>],
    plan: &Plan,
    progress: &dyn Progress,
) -> Result<Outcome, VerifyError> {
    let of = |device: &dyn Device| DeviceOutcome {
        name: device.name().to_string(),
        description: device.description(),
        deviation: device.deviation(),
        sets: plan.sets.iter().map(|set| (*set, Counts::default())).collect(),
        first_mismatch: None,
    };
    let devices = std::iter::once(of(reference)).chain(others.iter().map(|d| of(d.as_ref()))).collect();
    let oracle = OracleOutcome { triangles: subject.scene().instanced_triangles(), ..OracleOutcome::default() };
    let cost = plan.cost(&subject.oracle, &subject.sampler);
    let mut run = Run { subject, plan, cost, outcome: Outcome { devices, oracle }, judged: vec![0; others.len()] };
    for batch in plan.batches() {
        if progress.is_cancelled() {
            return Err(VerifyError::Cancelled);
        }
        if !run.batch(&batch, reference, others)? {
            break;
        }
        progress.advance(batch.count);
    }
    Ok(run.outcome)
}

struct Run<'a> {
    subject: &'a Subject<'a>,
    plan: &'a Plan,
    /// What a ray costs the oracle.
    cost: u64,
    outcome: Outcome,
    /// Differences of each other device that the oracle has judged.
    judged: Vec<u64>,
}

/// The answers of one device to a batch.
#[derive(Default)]
struct Answers {
    closest: Option<Vec<HitRecord>>,
    any: Option<Vec<HitRecord>>,
    /// Rays, ascending, that the device answers otherwise without the tree.
    unlike_brute: Vec<usize>,
}

impl Run<'_> {
    /// False where the reference cannot go on.
    fn batch(
        &mut self,
        batch: &Batch,
        reference: &mut dyn Device,
        others: &mut [Box<dyn Device + '_>],
    ) -> Result<bool, VerifyError> {
        let rays = self.plan.rays_in(batch, &self.subject.sampler);
        let own = self.ask(0, batch, reference, &rays, true)?;
        let Some(truth) = own.closest.as_ref() else { return Ok(false) };
        let closest = self.plan.asked == Asked::Both;
        let mut answers = Vec::new();
        for (i, device) in others.iter_mut().enumerate() {
            let mut answer = self.ask(i + 1, batch, device.as_mut(), &rays, closest)?;
            if let Some(records) = &answer.closest {
                answer.unlike_brute = self.unlike_brute(i + 1, batch, device.as_mut(), &rays, records)?;
            }
            answers.push(answer);
        }

        // Choose what the oracle judges: its sample, and where a device differs, as far as it has time.
        let rays_of_set = self.plan.rays_of(batch.set);
        let sampled = self.plan.sampled(batch.set, self.cost);
        let sample = batch.sample(sampled, rays_of_set);
        let most = (sampled * self.plan.sets.len() as u64).max(LEAST_DIFFERENCES);
        let mut asked = sample.clone();
        for (i, answer) in answers.iter().enumerate() {
            let closest = answer.closest.iter().flat_map(|c| (0..c.len()).filter(|&k| c[k] != truth[k]));
            let any = answer.any.iter().flat_map(|a| (0..a.len()).filter(|&k| a[k].is_hit() != truth[k].is_hit()));
            let room = most.saturating_sub(self.judged[i]) as usize;
            let before = asked.len();
            asked.extend(closest.take(room));
            asked.extend(any.take(room));
            asked.extend(answer.unlike_brute.iter().take(room));
            self.judged[i] += (asked.len() - before) as u64;
        }
        let start = Instant::now();
        let fallen = self.retest(&rays, truth);
        asked.extend(fallen.iter().take(LEAST_DIFFERENCES as usize));
        asked.extend(self.passed_over(batch, &rays, truth).iter().take(LEAST_DIFFERENCES as usize));
        asked.sort_unstable();
        asked.dedup();
        let words: Vec<Answer> = asked.par_iter().map(|&k| self.subject.oracle.trace(&rays[k])).collect();
        self.outcome.oracle.seconds += start.elapsed().as_secs_f64();
        let question = Question { batch, rays: &rays, truth, sample: &sample, asked: &asked, words: &words };

        // Judge the reference by the oracle, then every other device by both. A hit that does not stand is none, whether or not there was time to
        // find what is.
        for &k in fallen.iter().filter(|k| asked.binary_search(k).is_err()) {
            let told = Told { k, query: Query::Closest, class: Class::False, right: &truth[k], record: &truth[k] };
            self.note(0, &question, &told);
        }
        for &k in &asked {
            let Some(answer) = question.word(k) else { continue };
            let (verdict, sampled) = (self.judge(answer, &truth[k]), sample.binary_search(&k).is_ok());
            if sampled {
                self.outcome.oracle.add(verdict);
            }
            if let Some(class) = class_of(verdict).filter(|c| sampled || c.is_mismatch()) {
                let told = Told { k, query: Query::Closest, class, right: &truth[k], record: &truth[k] };
                self.note(0, &question, &told);
            }
        }
        self.judge_any(0, &question, &own);
        for (i, answer) in answers.iter().enumerate() {
            self.judge_closest(i + 1, &question, answer);
            self.judge_any(i + 1, &question, answer);
        }
        Ok(true)
    }

    /// Trace a batch on a device and note how long it took; nothing more is asked of a device that could not walk the tree.
    fn ask(
        &mut self,
        number: usize,
        batch: &Batch,
        device: &mut dyn Device,
        rays: &[Ray],
        closest: bool,
    ) -> Result<Answers, VerifyError> {
        let mut answers = Answers::default();
        if self.outcome.devices[number].total().malformed > 0 {
            return Ok(answers);
        }
        for query in [Query::Closest, Query::Any] {
            if query == Query::Closest && !closest {
                continue;
            }
            let start = Instant::now();
            let records = match device.trace(rays, query) {
                Ok(records) => records,
                Err(DeviceError::Malformed { .. }) => {
                    self.note_malformed(number, batch, device, rays, query)?;
                    return Ok(Answers::default());
                }
                Err(other) => return Err(other.into()),
            };
            let spent = start.elapsed().as_secs_f64();
            let counts = &mut self.outcome.devices[number].sets[batch.set].1;
            let hits = records.iter().filter(|r| r.is_hit()).count() as u64;
            if query == Query::Closest || !closest {
                counts.rays += batch.count;
                counts.hits += hits;
            }
            match query {
                Query::Closest => (counts.seconds, answers.closest) = (counts.seconds + spent, Some(records)),
                Query::Any => (counts.any_seconds, answers.any) = (counts.any_seconds + spent, Some(records)),
            }
        }
        Ok(answers)
    }

    /// Test every hit of the reference against the one triangle of the scene that it names, and return the rays whose hits do not stand.
    fn retest(&mut self, rays: &[Ray], truth: &[HitRecord]) -> Vec<usize> {
        let subject = self.subject;
        let stands_at = |k: usize| -> Option<bool> {
            let hit = truth[k].hit()?;
            match subject.origins.of(&hit) {
                Origin::Known(source) => Some(stands(&subject.oracle, &rays[k], source, &hit)),
                Origin::Nothing => Some(false),
                Origin::Several => None,
            }
        };
        let tested: Vec<Option<bool>> = (0..rays.len()).into_par_iter().map(stands_at).collect();
        self.outcome.oracle.hits_tested += tested.iter().flatten().count() as u64;
        (0..rays.len()).filter(|&k| tested[k] == Some(false)).collect()
    }

    /// The rays that were aimed at a triangle and met nothing as near, although they may meet it.
    fn passed_over(&self, batch: &Batch, rays: &[Ray], truth: &[HitRecord]) -> Vec<usize> {
        let targets = self.plan.targets_in(batch, &self.subject.sampler);
        let missed = |k: usize| passes_over(&self.subject.oracle, &rays[k], targets[k], truth[k].hit().as_ref());
        (0..targets.len()).into_par_iter().filter(|&k| missed(k)).collect()
    }

    /// Let a device trace a sample without the tree, and return the rays whose answers are others.
    fn unlike_brute(
        &mut self,
        number: usize,
        batch: &Batch,
        device: &mut dyn Device,
        rays: &[Ray],
        records: &[HitRecord],
    ) -> Result<Vec<usize>, VerifyError> {
        let view = &self.subject.view;
        let tests: u64 = match view.tlas_nodes {
            [] => view.triangles.len() as u64,
            _ => {
                view.instances.iter().filter_map(|i| view.blas(i.blas as usize)).map(|b| b.triangles.len() as u64).sum()
            }
        };
        let rays_of_set = self.plan.rays_of(batch.set);
        let allowed = device.brute_work() / tests.max(1) / self.plan.sets.len() as u64;
        let sample = batch.sample(allowed.min(rays_of_set), rays_of_set);
        let picked: Vec<Ray> = sample.iter().map(|&k| rays[k]).collect();
        if picked.is_empty() {
            return Ok(Vec::new());
        }
        let start = Instant::now();
        let Some(brute) = device.brute_force(&picked)? else { return Ok(Vec::new()) };
        let counts = &mut self.outcome.devices[number].sets[batch.set].1;
        counts.brute_rays += picked.len() as u64;
        counts.brute_seconds += start.elapsed().as_secs_f64();

        // Which of a triangle's slots is named does not matter.
        let unlike =
            |a: &HitRecord, b: &HitRecord| a.is_hit() != b.is_hit() || *a != HitRecord { triangle: a.triangle, ..*b };
        let unlike: Vec<usize> =
            sample.iter().zip(&brute).filter(|(k, b)| unlike(&records[**k], b)).map(|(k, _)| *k).collect();
        counts.brute_unlike += unlike.len() as u64;
        Ok(unlike)
    }

    fn judge_closest(&mut self, number: usize, question: &Question<'_>, answers: &Answers) {
        let Some(records) = &answers.closest else { return };
        let exact = self.outcome.devices[number].deviation.is_none();
        let mut sample = question.sample.iter().copied().peekable();
        for (k, (record, right)) in records.iter().zip(question.truth).enumerate() {
            let sampled = sample.next_if_eq(&k).is_some();
            let lost = answers.unlike_brute.binary_search(&k).is_ok();
            let differs = record != right;
            let verdict = question.word(k).map(|answer| self.judge(answer, record));
            let told = verdict.and_then(class_of);
            if !sampled && !differs && !lost && !told.is_some_and(Class::is_mismatch) {
                continue;
            }
            let class = match told {
                Some(wrong) if wrong.is_mismatch() => wrong,
                _ if differs && exact => Class::Bits,
                _ if lost => Class::Tree,
                Some(right) => right,
                None if !differs => continue,
                None if verdict.is_some() => Class::Rounding,
                None => Class::Unjudged,
            };
            self.note(number, question, &Told { k, query: Query::Closest, class, right, record });
        }
    }

    /// A shadow ray ends somewhere exactly if there is a closest hit.
    fn judge_any(&mut self, number: usize, question: &Question<'_>, answers: &Answers) {
        let Some(any) = &answers.any else { return };
        let closest = answers.closest.as_deref().unwrap_or(question.truth);
        let exact = self.outcome.devices[number].deviation.is_none();
        for k in (0..any.len()).filter(|&k| any[k].is_hit() != closest[k].is_hit()) {
            let class = match question.word(k).map(|answer| judge_any(answer, any[k].is_hit())) {
                Some(wrong) if !wrong.is_right() => class_of(wrong).unwrap_or(Class::AnyHit),
                _ if exact => Class::AnyHit,
                Some(right) => class_of(right).unwrap_or(Class::Grazing),
                None => Class::Unjudged,
            };
            self.note(number, question, &Told { k, query: Query::Any, class, right: &closest[k], record: &any[k] });
        }
    }

    fn judge(&self, answer: &Answer, record: &HitRecord) -> Verdict {
        judge(&self.subject.view, &self.subject.oracle, answer, record.hit().as_ref())
    }

    /// Count an answer's class; keep the device's first mismatch, and find out what is to blame for it.
    fn note(&mut self, number: usize, question: &Question<'_>, told: &Told<'_>) {
        let (device, batch, class) = (&mut self.outcome.devices[number], question.batch, told.class);
        device.sets[batch.set].1.add(class);
        if !class.is_mismatch() || device.first_mismatch.is_some() {
            return;
        }
        let (ray, word, hit) = (&question.rays[told.k], question.word(told.k), told.record.hit());
        let expected = match word.map(|w| (w, w.first())) {
            Some((_, Some(c))) => {
                let scene = self.subject.scene();
                let mesh = &scene.meshes[scene.instances[c.source.instance as usize].mesh as usize];
                let prim = mesh.source_prim(c.source.triangle as usize);
                Expected::Hit { source: c.source, prim, nearest: c.nearest, farthest: c.farthest }
            }
            Some((w, None)) if w.candidates.is_empty() => Expected::Nothing,
            _ => Expected::Reference(told.right.hit()),
        };
        let (got, hit) = match (told.query, hit) {
            (Query::Any, hit) => (Got::Any(hit.is_some()), None),
            (Query::Closest, Some(hit)) => (Got::Hit(hit), Some(hit)),
            (Query::Closest, None) => (Got::Nothing, None),
        };
        device.first_mismatch = Some(Mismatch {
            device: device.name.clone(),
            set: self.plan.sets[batch.set],
            index: batch.first + told.k as u64,
            ray: *ray,
            query: told.query,
            class,
            expected,
            got,
            blame: blame(self.subject, ray, class, word, hit.as_ref()),
        });
    }

    /// Find the first ray that a device cannot trace, by halving.
    fn note_malformed(
        &mut self,
        number: usize,
        batch: &Batch,
        device: &mut dyn Device,
        rays: &[Ray],
        query: Query,
    ) -> Result<(), VerifyError> {
        let (mut low, mut high) = (0, rays.len());
        let mut reason = None;
        while low + 1 < high || reason.is_none() {
            let middle = if low + 1 < high { (low + high) / 2 } else { high };
            match device.trace(&rays[low..middle], query) {
                Err(DeviceError::Malformed { malformed, .. }) => (high, reason) = (middle, Some(malformed)),
                Ok(_) if middle < high => low = middle,
                Ok(_) => break,
                Err(other) => return Err(other.into()),
            }
        }
        let Some(malformed) = reason else { return Ok(()) };
        let device = &mut self.outcome.devices[number];
        device.sets[batch.set].1.add(Class::Malformed);
        device.first_mismatch.get_or_insert_with(|| Mismatch {
            device: device.name.clone(),
            set: self.plan.sets[batch.set],
            index: batch.first + low as u64,
            ray: rays[low],
            query,
            class: Class::Malformed,
            expected: Expected::Reference(None),
            got: Got::Malformed(malformed),
            blame: None,
        });
        Ok(())
    }
}

/// A batch and what is known about it.
struct Question<'a> {
    batch: &'a Batch,
    rays: &'a [Ray],
    /// The reference's closest hits.
    truth: &'a [HitRecord],
    /// The rays that the oracle was asked about, ascending: its sample, and all.
    sample: &'a [usize],
    asked: &'a [usize],
    /// Its answers, parallel to `asked`.
    words: &'a [Answer],
}

impl<'a> Question<'a> {
    fn word(&self, ray: usize) -> Option<&'a Answer> {
        self.asked.binary_search(&ray).ok().map(|i| &self.words[i])
    }
}

/// An answer to ray `k` that is to be counted.
struct Told<'a> {
    k: usize,
    query: Query,
    class: Class,
    right: &'a HitRecord,
    record: &'a HitRecord,
}

/// Differences of a device that are judged however large the scene.
const LEAST_DIFFERENCES: u64 = 256;

/// `None` for the hit that the oracle names itself.
fn class_of(verdict: Verdict) -> Option<Class> {
    match verdict {
        Verdict::Agree => None,
        Verdict::Tie => Some(Class::Tie),
        Verdict::Grazing => Some(Class::Grazing),
        Verdict::Unsure => Some(Class::Unsure),
        Verdict::Missed => Some(Class::Missed),
        Verdict::Farther => Some(Class::Farther),
        Verdict::False => Some(Class::False),
    }
}
