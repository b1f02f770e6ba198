//! A sequence that was built before, and of which some frames changed: the others are taken from the file.

use super::super::frames::OneFrame;
use super::super::make::Workshop;
use super::super::plan::Job;
use super::told::Arrived;
use super::{CHOICE, recipe_of, some};
use crate::cache;
use crate::cli::caches;
use crate::cli::failure::Failure;
use crate::scene::ReadReport;
use crate::sequence::{FrameModel, Incoming, PreparedFrame, Prior, Refit, SequenceBuilder};
use std::collections::BTreeMap;

/// Changed frames that are held in memory until their turn comes.
const HELD: usize = 16;

/// What is known of the frames before the first one is added.
pub struct Plan {
    /// Frames that were read.
    held: BTreeMap<usize, Incoming<Arrived>>,
    /// Those that need not be.
    unread: BTreeMap<usize, Arrived>,
}

impl Plan {
    /// Every frame is read at its turn.
    pub fn read_all() -> Plan {
        Plan { held: BTreeMap::new(), unread: BTreeMap::new() }
    }

    /// A frame that is not to be read now.
    pub fn ready(&mut self, index: usize, frame: &OneFrame) -> Option<Incoming<Arrived>> {
        let label = frame.label();
        let unread = |told| Incoming { frame: PreparedFrame::unread(), label, told };
        self.held.remove(&index).or_else(|| self.unread.remove(&index).map(unread))
    }
}

impl Workshop<'_> {
    /// The file that is there, if frames can be taken from it. Where each frame's trees are built, none can: nothing says whether another frame is the same.
    pub fn prior(&self, job: &Job, list: &[OneFrame]) -> Option<Prior> {
        if self.args.force || self.args.frames.policy().refit == Refit::Never {
            return None;
        }
        let model = |frame: &OneFrame| FrameModel { number: frame.number, path: frame.model.clone() };
        let models: Vec<FrameModel> = list.iter().map(model).collect();
        let surveyed = |count: usize| -> Vec<usize> {
            if self.surveys(count).is_some() { some(count).collect() } else { Vec::new() }
        };
        let recipe = recipe_of(self, "");
        let open = caches::options(self.context);
        Prior::find(&job.output, &models, &recipe, CHOICE, surveyed, &open, &self.context.exec)
    }

    /// Let frames be taken from an earlier build, and read those that changed as far as they fit.
    pub fn take(
        &self,
        prior: Prior,
        builder: &mut SequenceBuilder,
        mut read: impl FnMut(usize) -> Result<Incoming<Arrived>, Failure>,
    ) -> Result<Plan, Failure> {
        // What frames lost that are not read has to be known, since the file tells of the most of all. Frames of one model lose the same.
        let mut plan = Plan::read_all();
        let is_known =
            |lost: &ReadReport| cache::provenance(self.recipe.clone(), &[], lost).read_counts == prior.read_counts();
        if !is_known(&ReadReport::default()) {
            let Some(first) = prior.kept().next() else { return Ok(plan) };
            let frame = read(first)?;
            let is_known = is_known(&frame.told.lost(frame.frame.collapsed()));
            plan.held.insert(first, frame);
            if !is_known {
                return Ok(plan);
            }
        }

        let changed: Vec<usize> = prior.changed().collect();
        let are_few = changed.len() <= HELD;
        for &index in changed.iter().filter(|_| are_few) {
            plan.held.insert(index, read(index)?);
        }
        let inputs = prior.inputs().to_vec();
        let ahead = are_few.then(|| changed.iter().filter_map(|index| Some(&plan.held.get(index)?.frame)));
        let taken = builder.take_from(prior, ahead);
        for (index, input) in inputs.into_iter().enumerate().filter(|(i, _)| taken[*i]) {
            if !plan.held.contains_key(&index) {
                plan.unread.insert(index, Arrived::unread(input));
            }
        }
        Ok(plan)
    }
}
