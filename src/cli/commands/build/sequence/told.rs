//! What the frames of a sequence had to say.

use crate::build::Levels;
use crate::cli::commands::build::remarks::Remarks;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::compile::Placing;
use crate::scene::{InputFile, ReadOptions, ReadReport, Rounding, Scene};
use crate::sequence::{FrameLabel, FrameOutcome, Incoming, Preparer};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::Duration;

/// What the frames had to say, all together.
#[derive(Default)]
pub struct Told {
    pub report: ReadReport,
    pub rounding: Rounding,
    pub placing: Placing,
    /// In the order of the frames.
    pub inputs: Vec<InputFile>,
    /// Files that were read before the first frame.
    pub surveyed: Vec<InputFile>,
    pub frames: Vec<FrameOutcome>,
    /// What reading took, added up over all threads.
    pub read_time: Duration,
    /// What making trees and adding frames took, while others were read.
    pub add_time: Duration,
    /// Which frames were read or posed, counted from 0.
    pub read: BTreeSet<usize>,
    /// The numbers of the frames that did not arrive whole.
    pub troubled: Vec<i32>,
    /// A file that changed between two readings.
    pub changed: Option<PathBuf>,
    /// Whether clips of the frames' models were left out on purpose.
    pub at_rest: bool,
}

/// What a frame's file or pose had to say.
pub struct Arrived {
    report: ReadReport,
    rounding: Rounding,
    inputs: Vec<InputFile>,
    is_empty: bool,
    is_read: bool,
    took: Duration,
}

impl Arrived {
    /// Of a frame that was not read, since its model is what it was.
    pub fn unread(input: InputFile) -> Arrived {
        let (report, rounding) = (ReadReport::default(), Rounding::default());
        Arrived { report, rounding, inputs: vec![input], is_empty: false, is_read: false, took: Duration::ZERO }
    }

    /// What reading dropped or repaired, with what went when meshes were put where they stand.
    pub fn lost(&self, collapsed: u64) -> ReadReport {
        let mut lost = self.report.clone();
        lost.degenerate_triangles += collapsed;
        lost
    }
}

/// A scene that was read becomes a frame on its way.
pub fn arrive(
    preparer: &Preparer,
    scene: Scene,
    label: FrameLabel,
    took: Duration,
) -> Result<Incoming<Arrived>, Failure> {
    let (report, rounding, inputs) = (scene.report.clone(), scene.rounding, scene.inputs.clone());
    let told = Arrived { report, rounding, inputs, is_empty: scene.meshes.is_empty(), is_read: true, took };
    Ok(Incoming { frame: preparer.prepare(scene)?, label, told })
}

impl Told {
    /// How much of a time in which frames were read and added, the one beside the other, went into reading.
    pub fn reading(&self, of: Duration) -> Duration {
        let [read, add] = [self.read_time, self.add_time].map(|time| time.as_secs_f64());
        if read + add > 0.0 { of.mul_f64(read / (read + add)) } else { Duration::ZERO }
    }

    /// Files that were read. One that is read twice and is another then has changed between.
    pub fn inputs(&mut self, inputs: &[InputFile]) {
        for input in inputs {
            let known = |some: &[InputFile]| some.iter().find(|known| known.path == input.path).cloned();
            let (listed, before) = (known(&self.inputs), known(&self.surveyed));
            if listed.as_ref().or(before.as_ref()).is_some_and(|known| known != input) {
                self.changed.get_or_insert_with(|| input.path.clone());
            }
            if listed.is_none() {
                self.inputs.push(before.unwrap_or_else(|| input.clone()));
            }
        }
    }

    pub fn frame(&mut self, index: usize, scene: &Arrived, frame: FrameOutcome, read: &ReadOptions) {
        if scene.is_read {
            self.read.insert(index);
        }
        let (report, rounding, placing) = (&scene.report, &scene.rounding, &Placing::default());
        let remarks = Remarks { report, read, rounding, placing, at_rest: self.at_rest };
        if scene.is_empty || !remarks.warnings(Levels::Two).is_empty() {
            self.troubled.push(frame.number);
        }
        self.read_time += scene.took;
        self.report.raise(&scene.report);
        let grid = [self.rounding.grid, scene.rounding.grid].into_iter().flatten();
        let grid = grid.reduce(|a, b| if b.is_more_than(&a) { b } else { a });
        if !self.rounding.loss.is_more_than(&scene.rounding.loss) {
            self.rounding = scene.rounding;
        }
        self.rounding.grid = grid;
        self.inputs(&scene.inputs);
        self.placing.collapsed = self.placing.collapsed.max(frame.placing.collapsed);
        if !self.placing.loss.is_more_than(&frame.placing.loss) {
            self.placing.loss = frame.placing.loss;
        }
        for note in &frame.placing.notes {
            if !self.placing.notes.contains(note) {
                self.placing.notes.push(note.clone());
            }
        }
        self.frames.push(frame);
    }
}

/// Why there are more trees than were asked for, where faces are cut otherwise in some frames.
pub fn own_cuts(frames: &[FrameOutcome]) -> Option<String> {
    let mut numbers = frames.iter().filter(|frame| frame.own_cuts > 0).map(|frame| frame.number);
    let first = numbers.next()?;
    let place = match numbers.count() as u64 {
        0 => format!("in frame {first}"),
        others => format!("in {} from {first} on", figures::counted(1 + others, "frame", "frames")),
    };
    Some(format!(
        "{place} faces have bent so far that they are cut into other triangles than in the first frame; each cut has trees of its own, so \
         that there may be more than --trees says"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_several_threads_read_at_once_is_not_counted_twice() {
        let seconds = Duration::from_secs;
        let told = Told { read_time: seconds(6), add_time: seconds(2), ..Told::default() };
        assert_eq!(told.reading(seconds(4)), seconds(3));
        assert_eq!(Told::default().reading(seconds(4)), seconds(0));
    }

    #[test]
    fn a_file_that_is_another_when_it_is_read_again_has_changed() {
        let input = |blake3: u8| InputFile { path: "a.obj".into(), name: "a.obj".into(), len: 1, blake3: [blake3; 32] };
        let mut told = Told::default();
        told.inputs(&[input(1)]);
        told.inputs(&[input(1)]);
        assert_eq!((told.inputs.len(), told.changed.clone()), (1, None));
        told.inputs(&[input(2)]);
        assert_eq!(told.changed, Some("a.obj".into()));
        assert_eq!(told.inputs, [input(1)], "what was read first is compared with the file in the end");

        let mut told = Told { surveyed: vec![input(1)], ..Told::default() };
        told.inputs(&[input(2)]);
        assert_eq!((told.changed, told.inputs), (Some("a.obj".into()), vec![input(1)]));
    }
}
