//! The frames of a sequence, as the arguments choose them.

use super::{Fps, FrameArgs};
use crate::scene::frames::runs;
use crate::scene::{AnimationChoice, Seconds};
use crate::sequence::FrameLabel;
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

impl OneFrame {
    /// How the file names it.
    pub fn label(&self) -> FrameLabel {
        FrameLabel { number: self.number, time: None, held: self.held }
    }

    /// The numbers of some frames, and which of them are held: `1-4, held 3`.
    pub fn numbers(list: &[OneFrame]) -> String {
        let numbers = |some: &mut dyn Iterator<Item = i32>| runs(&some.collect::<Vec<_>>());
        let all = numbers(&mut list.iter().map(|frame| frame.number));
        match numbers(&mut list.iter().filter(|frame| frame.held).map(|frame| frame.number)) {
            held if held.is_empty() => all,
            held => format!("{all}, held {held}"),
        }
    }
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
            Frames::Files(list) => format!("files {}", OneFrame::numbers(list)),
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

/// The clip that META has of a sequence; `None` where it has files.
pub fn clip_of(recorded: &str) -> Option<AnimationChoice> {
    let rest = recorded.strip_prefix("clip, ")?;
    // A name stands last and may have commas in it.
    if let Some((_, name)) = rest.split_once(", name ") {
        return Some(AnimationChoice::Name(name.to_owned()));
    }
    match rest.rsplit_once(", number ") {
        Some((_, number)) => number.parse().ok().map(AnimationChoice::Number),
        None => Some(AnimationChoice::Only),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clip_that_is_recorded_is_read_back() {
        let stretch = Seconds::new(0.5).zip(Seconds::new(2.0));
        for choice in
            [AnimationChoice::Only, AnimationChoice::Number(3), AnimationChoice::Name("a, number 4, name b".into())]
        {
            for (fps, range) in [(Fps::Auto, None), (Fps::Rate(24.0), stretch)] {
                let frames = Frames::Clip { choice: choice.clone(), fps, range };
                assert_eq!(clip_of(&frames.recorded()), Some(choice.clone()), "{}", frames.recorded());
            }
        }
        assert_eq!(clip_of("files 1-20, held 3"), None);
    }
}
