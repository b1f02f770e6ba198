//! What an output that is up to date has to say of its model, which is not read again.

use super::Workshop;
use super::plan::Job;
use super::remarks::{Kind, Remark, empty_frames, nothing_in_it};
use crate::cli::caches;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::cli::names;
use crate::report::effort::BuildEffort;

impl Workshop<'_> {
    /// What META says was left out when the output was built.
    pub fn remembered(&self, job: &Job) -> Result<Vec<Remark>, Failure> {
        let head = caches::head(&job.output, self.context)?;
        let is_empty = job.frames.is_none() && head.header.prim_count == 0;
        let counts = head.meta.map_or_else(Vec::new, |meta| meta.read_counts);
        let is_no_news = |name: &str| match name {
            "unreferenced_positions" => true,
            "unplayed_animations" => self.args.read.at_rest,
            _ => false,
        };
        let most = if job.frames.is_some() { " in the frame with most of them" } else { "" };
        let told = |(name, count): &(String, u64)| {
            let kind = match name.as_str() {
                "degenerate_triangles" => Kind::WithoutArea,
                "unplayed_animations" => Kind::AtRest,
                _ => Kind::LeftOut,
            };
            let text = || format!("{}: {}{most}", name.replace('_', " "), figures::count(*count));
            (*count > 0 && !is_no_news(name)).then(|| kind.remark(text()))
        };
        let mut told: Vec<Remark> = counts.iter().filter_map(told).collect();
        told.extend(is_empty.then(nothing_in_it));
        if job.frames.is_some() {
            told.extend(empty_frames(&job.output, self.context)?);
        }
        Ok(told)
    }

    /// Say that `--record-effort` came too late for an output that is up to date: an effort does not make it another one.
    pub fn tell_unrecorded(&self, job: &Job) -> Result<(), Failure> {
        if !self.args.record_effort {
            return Ok(());
        }
        let notes = caches::head(&job.output, self.context)?.meta.map_or_else(Vec::new, |meta| meta.notes);
        if notes.iter().all(|note| BuildEffort::of_note(note).is_none()) {
            let name = names::path(&job.output);
            self.context.terminal.note(&format!(
                "{name}: it is up to date, and what its build took was not recorded then; --force builds it again"
            ));
        }
        Ok(())
    }

    /// What was told when an output was built holds as long as it is up to date: where warnings are errors, a still model is read once more, and of a
    /// sequence META has what was left out.
    pub fn forgive_again(&self, job: &Job, remembered: &[Remark]) -> Result<(), Failure> {
        if !self.args.warnings_as_errors {
            return Ok(());
        }
        if job.frames.is_none() {
            return self.rehearse(job).map(drop);
        }
        self.forgive(&names::path(&job.output), remembered)
    }
}
