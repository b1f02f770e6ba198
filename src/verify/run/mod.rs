//! The pipeline: rays in batches, the reference's answers, every device's answers, the oracle's word on a sample and on every difference.

mod judge;

use crate::build::Progress;
use crate::cache::View;
use crate::geom::Ray;
use crate::trace::brute::Answer;
use crate::trace::compare::{passes_over, stands};
use crate::verify::class::{Class, Counts};
use crate::verify::device::{Device, DeviceError, Query};
use crate::verify::origin::Origin;
use crate::verify::outcome::{DeviceOutcome, OracleOutcome, Outcome};
use crate::verify::plan::{Asked, Batch, Plan};
use crate::verify::record::HitRecord;
use crate::verify::subject::Subject;
use judge::{Question, Told, class_of};
use std::time::Instant;

/// Why verification came to no verdict.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// A device gave no answer.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The progress said so.
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
    let oracle =
        OracleOutcome { instanced_triangles: subject.scene().instanced_triangles(), ..OracleOutcome::default() };
    let start = Instant::now();
    let cost = plan.cost(&subject.oracle, &subject.sampler, subject.exec);
    let oracle = OracleOutcome { seconds: start.elapsed().as_secs_f64(), ..oracle };
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
        let exec = self.subject.exec;
        let rays = self.plan.rays_in(batch, &self.subject.sampler, exec);
        let own = self.ask(0, batch, reference, &rays, true)?;
        let Some(truth) = own.closest.as_ref() else { return Ok(false) };
        let closest = self.plan.asked == Asked::Both;
        let mut answers = Vec::new();
        for (i, device) in others.iter_mut().enumerate() {
            let mut answer = self.ask(i + 1, batch, device.as_mut(), &rays, closest)?;
            if let Some(records) = answer.closest.as_mut().filter(|_| device.names_any_copy()) {
                name_copies(records, truth, &self.subject.view);
            }
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
        let words: Vec<Answer> = exec.map_range(asked.len(), |i| self.subject.oracle.trace(&rays[asked[i]]));
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
        let tested = subject.exec.map_range(rays.len(), stands_at);
        self.outcome.oracle.hits_tested += tested.iter().flatten().count() as u64;
        (0..rays.len()).filter(|&k| tested[k] == Some(false)).collect()
    }

    /// The rays that were aimed at a triangle and met nothing as near, although they may meet it.
    fn passed_over(&self, batch: &Batch, rays: &[Ray], truth: &[HitRecord]) -> Vec<usize> {
        let exec = self.subject.exec;
        let targets = self.plan.targets_in(batch, &self.subject.sampler, exec);
        let missed = |k: usize| passes_over(&self.subject.oracle, &rays[k], targets[k], truth[k].hit().as_ref());
        let missed = exec.map_range(targets.len(), missed);
        (0..missed.len()).filter(|&k| missed[k]).collect()
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
}

/// Where a device names another record of the triangle that the reference names, and nothing else differs, let it name the reference's.
fn name_copies(records: &mut [HitRecord], truth: &[HitRecord], view: &View<'_>) {
    let is_of = |record: &HitRecord| {
        let triangle = view.triangles.get(record.triangle as usize);
        triangle.is_some_and(|t| (t.geom, t.prim) == (record.geom, record.prim))
    };
    for (record, right) in records.iter_mut().zip(truth).filter(|(record, right)| record.is_hit() && right.is_hit()) {
        if is_of(record) && (HitRecord { triangle: right.triangle, ..*record }) == *right {
            record.triangle = right.triangle;
        }
    }
}

/// Differences of a device that are judged however large the scene.
const LEAST_DIFFERENCES: u64 = 256;
