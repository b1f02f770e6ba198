//! Frames one after another: while some are built, the next ones are read.

use super::{FrameLabel, FrameOutcome, SequenceBuilder, SequenceError};
use crate::build::BuildOptions;
use crate::compile::{self, LaidOut};
use crate::exec::Executor;
use crate::scene::Scene;
use std::ops::Range;
use std::time::{Duration, Instant};

/// Frames that are read together. As many more are being built, and no other frame is in memory.
pub const TOGETHER: usize = 4;

/// A frame whose meshes were put where they stand: what can be done on any thread, before its turn comes. Or one that need not be read.
pub struct PreparedFrame(pub(super) Option<LaidOut>);

impl PreparedFrame {
    /// A frame that is [taken from an earlier build](SequenceBuilder::take_from).
    pub fn unread() -> PreparedFrame {
        PreparedFrame(None)
    }

    /// Triangles that lost their area when they were put where they stand; 0 of a frame that was not read.
    pub fn collapsed(&self) -> u64 {
        self.laid().map_or(0, |laid| laid.placing.collapsed)
    }

    pub(super) fn laid(&self) -> Option<&LaidOut> {
        self.0.as_ref()
    }
}

/// Prepares frames for a [`SequenceBuilder`].
#[derive(Clone)]
pub struct Preparer<'a> {
    pub(super) options: BuildOptions,
    pub(super) exec: &'a Executor,
}

impl Preparer<'_> {
    /// Put the meshes of a frame where they stand.
    ///
    /// # Errors
    /// Where the scene cannot be built.
    pub fn prepare(&self, scene: Scene) -> Result<PreparedFrame, SequenceError> {
        Ok(PreparedFrame(Some(compile::lay_out(scene, &self.options, self.exec)?)))
    }
}

impl SequenceBuilder<'_> {
    /// Add `count` frames in their order. `read` gives some of them, [`TOGETHER`] at most, in order, and may use all threads; while these are added, it is asked
    /// for the next ones. `read_after_all` gives one that was [not read](PreparedFrame::unread) and has to be. `added` is told of each frame that was added. How long
    /// adding took; frames were read at the same time.
    ///
    /// # Errors
    /// The first that `read` or `added` gives, in the order of the frames, or that adding does.
    pub fn add_all<T: Send, E: Send + From<SequenceError>>(
        &mut self,
        count: usize,
        mut read: impl FnMut(Range<usize>) -> Result<Vec<Incoming<T>>, E> + Send,
        mut read_after_all: impl FnMut(usize) -> Result<Incoming<T>, E> + Send,
        mut added: impl FnMut(usize, FrameOutcome, T) -> Result<(), E> + Send,
    ) -> Result<Duration, E> {
        let (exec, mut spent) = (self.exec, Duration::ZERO);
        let some = |start: usize| start.min(count)..(start + TOGETHER).min(count);
        let mut next = read(some(0))?;
        for start in (0..count).step_by(TOGETHER) {
            let now = std::mem::take(&mut next);
            let ahead = some(start + TOGETHER);
            let add = || {
                for (i, Incoming { frame, label, told }) in now.into_iter().enumerate() {
                    let mut add = |frame, label| {
                        let start = Instant::now();
                        let outcome = self.add_prepared(frame, label);
                        spent += start.elapsed();
                        outcome
                    };
                    let (mut told, mut outcome) = (told, add(frame, label)?);
                    if outcome.is_none() {
                        let again = read_after_all(start + i)?;
                        (told, outcome) = (again.told, add(again.frame, again.label)?);
                    }
                    // A frame that was read is always added.
                    if let Some(outcome) = outcome {
                        added(start + i, outcome, told)?;
                    }
                }
                Ok::<(), E>(())
            };
            let (done, read_ahead) = exec.join(add, || if ahead.is_empty() { Ok(Vec::new()) } else { read(ahead) });
            done?;
            next = read_ahead?;
        }
        Ok(spent)
    }
}

/// A frame on its way, and what else there is to say of it.
pub struct Incoming<T> {
    /// Its meshes.
    pub frame: PreparedFrame,
    /// Which frame it is.
    pub label: FrameLabel,
    /// Handed on when it was added.
    pub told: T,
}
