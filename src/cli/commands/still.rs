//! A frame of a sequence as the still file that it would be.

use super::build::clip_of;
use crate::cache::{Dependency, Frame, FrameRecord, Image, Meta, Sequence};
use crate::scene::{Moment, ReadOptions, Seconds};

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
            let own = meta.dependencies.get(files.wrapping_sub(1)).cloned();
            meta.dependencies = own.into_iter().map(|own| Dependency { role: Dependency::MODEL, ..own }).collect();
        }
    }
    meta.options.push(("frame".to_string(), number.to_string()));
    meta
}
