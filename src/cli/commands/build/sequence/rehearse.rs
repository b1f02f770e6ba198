use super::super::frames::Frames;
use super::super::frames::OneFrame;
use super::super::make::Workshop;
use super::super::plan::Job;
use super::read_options;
use crate::cli::caches;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::cli::names;
use crate::cli::progress::Bar;
use crate::scene;

impl Workshop<'_> {
    /// Read all that a sequence is built from, and say what the build would say of it; nothing is built. Which frames it would have.
    pub fn rehearse_sequence(&self, job: &Job, frames_of: &Frames) -> Result<String, Failure> {
        let bar = Bar::new(&self.context.terminal, &names::path(&job.output));
        let (read, exec) = (read_options(&self.read), &self.context.exec);
        let mut progress = |_, _| ();
        match frames_of {
            Frames::Files(list) => {
                bar.phase("reading frames of", list.len() as u64);
                for (i, frame) in list.iter().enumerate() {
                    let held = if frame.held { ", held" } else { "" };
                    let model = names::path(&frame.model);
                    self.context.terminal.detail(&format!("frame {}: {model}{held}", frame.number));
                    if !frame.held {
                        let scene = scene::read_with(&frame.model, &read, exec, &mut progress);
                        let scene = scene.map_err(|e| caches::scene_failure(&e))?;
                        caches::fits(&frame.model, &scene, &self.build, self.context)?;
                    }
                    bar.set(i as u64 + 1, list.len() as u64);
                }
                let count = figures::counted(list.len() as u64, "frame", "frames");
                Ok(format!("{count}, {}", OneFrame::numbers(list)))
            }
            Frames::Clip { choice, fps, range } => {
                let model = names::path(&job.input);
                let played = scene::play(&job.input, choice, &read, exec, &mut progress, |clip| {
                    let times = self.times(clip.animation(), *fps, *range, &model)?;
                    let posed = times.first().map(|time| clip.at(*time).map_err(|e| caches::scene_failure(&e)));
                    posed.transpose()?;
                    let ends = times.first().zip(times.last());
                    let ends = ends.map_or_else(String::new, |(first, last)| format!(", {first} to {last} s"));
                    Ok(format!("{}{ends}", figures::counted(times.len() as u64, "frame", "frames")))
                });
                played.map_err(|e| caches::scene_failure(&e))?
            }
        }
    }
}
