//! Animations, which some call clips: what they make of a scene's nodes at a time.
//!
//! ```text
//! json ─▶ channels: what moves ─▶ sampler: keys and values ─▶ motion
//! ```
//!
//! Only channels that move something of the scene are read. Before its first key a channel holds its first value, and after its last
//! its last; what no channel moves stays at rest (glTF 2.0, 3.11).

mod channels;
mod choice;
mod interpolation;
mod json;
mod keys;
mod motion;
mod pointer;
mod rotation;
mod sampler;
mod scope;

pub(super) use choice::{choose, list};
pub(super) use motion::{Motion, Moved};
pub(super) use scope::Scope;

use super::reader::Reader;
use crate::scene::{Animation, SceneError, Seconds};
use channels::{Channels, Heeded};
use sampler::Sampler;

/// An animation that was read, to be sampled at any time.
#[derive(Debug)]
pub(super) struct Playable {
    pub animation: Animation,
    /// Channels with a path that glTF does not know.
    pub unknown_channels: u64,
    /// Whether `KHR_animation_pointer` moves something and is ignored, as the caller wants.
    pub ignores_pointer: bool,
    moves: Vec<(Heeded, Sampler)>,
}

impl Playable {
    /// Read animation `number`. Its memory is charged and stays charged.
    pub fn read(reader: &mut Reader, number: u32, scope: &Scope) -> Result<Playable, SceneError> {
        let Channels { heeded, unknown, ignores_pointer } =
            Channels::choose(reader.document, number, scope, reader.source)?;
        let mut moves = Vec::with_capacity(heeded.len());
        for channel in heeded {
            let sampler = Sampler::read(reader, &channel)?;
            moves.push((channel, sampler));
        }
        let keys = keys::of_all(moves.iter().map(|(_, sampler)| sampler.keys()));
        let animation = Animation { number, name: reader.document.animation_name(number), keys };
        Ok(Playable { animation, unknown_channels: unknown, ignores_pointer, moves })
    }

    /// The time of the first key that moves something; 0 where nothing does.
    pub fn first_key(&self) -> Seconds {
        self.animation.keys.and_then(|keys| Seconds::new(keys.first.into())).unwrap_or_default()
    }

    /// What the animation makes of the nodes at a time in seconds.
    pub fn at(&self, time: f64) -> Motion {
        let mut motion = Motion::default();
        for (channel, sampler) in &self.moves {
            motion.set(channel.node, channel.path, sampler.at(time));
        }
        motion
    }
}
