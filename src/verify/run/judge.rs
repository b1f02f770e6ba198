//! What is right of a batch's answers, and how each that is not is told.

use super::{Answers, Run, VerifyError};
use crate::geom::Ray;
use crate::trace::brute::Answer;
use crate::trace::compare::{Verdict, judge, judge_any};
use crate::verify::blame::blame;
use crate::verify::class::Class;
use crate::verify::device::{Device, DeviceError, Query};
use crate::verify::outcome::{Expected, Got, Mismatch};
use crate::verify::plan::Batch;
use crate::verify::record::HitRecord;

impl Run<'_> {
    pub(super) fn judge_closest(&mut self, number: usize, question: &Question<'_>, answers: &Answers) {
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
    pub(super) fn judge_any(&mut self, number: usize, question: &Question<'_>, answers: &Answers) {
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

    pub(super) fn judge(&self, answer: &Answer, record: &HitRecord) -> Verdict {
        judge(&self.subject.view, &self.subject.oracle, answer, record.hit().as_ref())
    }

    /// Count an answer's class; keep the device's first mismatch, and find out what is to blame for it.
    pub(super) fn note(&mut self, number: usize, question: &Question<'_>, told: &Told<'_>) {
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
    pub(super) fn note_malformed(
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
pub(super) struct Question<'a> {
    pub(super) batch: &'a Batch,
    pub(super) rays: &'a [Ray],
    /// The reference's closest hits.
    pub(super) truth: &'a [HitRecord],
    /// The rays that the oracle was asked about, ascending: its sample, and all.
    pub(super) sample: &'a [usize],
    pub(super) asked: &'a [usize],
    /// Its answers, parallel to `asked`.
    pub(super) words: &'a [Answer],
}

impl<'a> Question<'a> {
    pub(super) fn word(&self, ray: usize) -> Option<&'a Answer> {
        self.asked.binary_search(&ray).ok().map(|i| &self.words[i])
    }
}

/// An answer to ray `k` that is to be counted.
pub(super) struct Told<'a> {
    pub(super) k: usize,
    pub(super) query: Query,
    pub(super) class: Class,
    pub(super) right: &'a HitRecord,
    pub(super) record: &'a HitRecord,
}

/// `None` for the hit that the oracle names itself.
pub(super) fn class_of(verdict: Verdict) -> Option<Class> {
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
