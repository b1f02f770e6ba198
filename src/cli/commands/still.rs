//! A frame of a sequence as the still file that it would be.

use super::build::clip_of;
use crate::cache::{Dependency, Frame, FrameRecord, Image, Meta, Sequence};
use crate::scene::{Format, Moment, ReadOptions, Seconds};
use std::path::Path;

/// What a still file of a frame holds, and what it says of how it was made; without META of the sequence only who made it.
pub fn of_frame(sequence: &Sequence, frame: &Frame<'_>) -> (Image, Meta) {
    let number = frame.record().number;
    let meta = sequence.meta().map(|meta| meta_of(meta, sequence, number)).unwrap_or_else(|| Meta {
        tool: "bvhc".to_string(),
        tool_version: env!("CARGO_PKG_VERSION").to_string(),
        ..Meta::default()
    });
    (Image::of_frame(sequence, frame), meta)
}

/// What a still build of the frame would record, so that the file can be compared with its model: of a clip the moment, of files the one of the frame.
fn meta_of(meta: &Meta, sequence: &Sequence, number: i32) -> Meta {
    let mut meta = meta.clone();
    let of_sequence = ["sequence", "refit", "trees", "rebuild_ratio"];
    let choice = meta.options.iter().find(|(name, _)| name == "sequence").map(|(_, value)| value.clone());
    meta.options.retain(|(name, _)| !of_sequence.contains(&name.as_str()));
    let frames = sequence.frames();
    let row = sequence.numbered(number).unwrap_or(0);
    match choice.as_deref().and_then(clip_of) {
        Some(animation) => {
            let time = frames.get(row).and_then(|frame| Seconds::new(frame.time.into()));
            let moment = Some(Moment { animation, time });
            let posed = ReadOptions { moment, ..ReadOptions::default() }.effective();
            let is_moment = |name: &str| name == "time" || name.starts_with("animation");
            meta.options.extend(posed.into_iter().filter(|(name, _)| is_moment(name)));
        }
        None => {
            // Frames that are held are those before: each of the others brought a file.
            let files = frames.iter().take(row + 1).filter(|frame| frame.flags & FrameRecord::HELD == 0).count();
            // A model stands before the files that it names, but for those that an earlier one names too.
            let is_model = |d: &Dependency| Format::from_extension(Path::new(&d.name)).is_some();
            let models: Vec<usize> =
                (0..meta.dependencies.len()).filter(|i| is_model(&meta.dependencies[*i])).collect();
            let all = meta.dependencies.len();
            let start = files.checked_sub(1).and_then(|i| models.get(i)).copied().unwrap_or(all);
            let end = models.get(files).copied().unwrap_or(all);
            meta.dependencies = meta.dependencies.drain(start..end.max(start)).collect();
            if let Some(own) = meta.dependencies.first_mut() {
                own.role = Dependency::MODEL;
            }
        }
    }
    meta.options.push(("frame".to_string(), number.to_string()));
    meta
}
