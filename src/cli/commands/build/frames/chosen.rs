//! The frames of a sequence, as the arguments choose them.

use super::folder::runs;
use super::{Fps, FrameArgs};
use crate::scene::{AnimationChoice, Seconds};
use std::path::PathBuf;

/// Most frames of a sequence: each may need four sections, and a file has 65,536.
pub const MOST_FRAMES: usize = 16_000;

/// The frames of a sequence.
#[derive(Clone, Debug)]
pub enum Frames {
    /// Models, one a frame.
    Files(Vec<OneFrame>),
    /// A clip of a glTF model.
    Clip { choice: AnimationChoice, fps: Fps, range: Option<(Seconds, Seconds)> },
}

/// A frame that is a file.
#[derive(Clone, Debug)]
pub struct OneFrame {
    pub number: i32,
    pub model: PathBuf,
    /// It is not there, and the model is that of the frame before.
    pub held: bool,
}

impl FrameArgs {
    /// The frames that the arguments make of a glTF model; `None` where it is to stand still.
    pub fn of_clip(&self, clip: Option<&AnimationChoice>) -> Option<Frames> {
        let fps = self.fps.or(self.play.map(|_| Fps::Auto))?;
        Some(Frames::Clip { choice: clip.cloned().unwrap_or_default(), fps, range: self.play })
    }
}

impl Frames {
    /// What META and the build key have of it: one text for each choice of frames.
    pub fn recorded(&self) -> String {
        match self {
            Frames::Files(list) => {
                let numbers = |some: &mut dyn Iterator<Item = i32>| runs(&some.collect::<Vec<_>>());
                let all = numbers(&mut list.iter().map(|frame| frame.number));
                match numbers(&mut list.iter().filter(|frame| frame.held).map(|frame| frame.number)) {
                    held if held.is_empty() => format!("files {all}"),
                    held => format!("files {all}, held {held}"),
                }
            }
            Frames::Clip { choice, fps, range } => {
                let fps = match fps {
                    Fps::Auto => "auto".to_string(),
                    Fps::Rate(rate) => rate.to_string(),
                };
                let range = range.map_or_else(String::new, |(from, to)| format!(", {from}..{to} s"));
                let which = match choice {
                    AnimationChoice::Number(number) => format!("number {number}"),
                    AnimationChoice::Name(name) => format!("name {name}"),
                    _ => "the only one".to_string(),
                };
                format!("clip, fps {fps}{range}, {which}")
            }
        }
    }
}
