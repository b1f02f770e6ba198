use super::interpolation::Interpolation;
use super::json::{Animation, Channel};
use super::motion::Path;
use super::pointer;
use super::scope::Scope;
use crate::scene::SceneError;
use crate::scene::gltf::document::Document;
use crate::scene::gltf::extensions::{ANIMATION_POINTER, moved_by_pointer};
use crate::scene::source::Source;
use std::collections::BTreeSet;

/// The channels of an animation that move something of the scene, and what became of the others.
#[derive(Debug, Default)]
pub struct Channels {
    pub heeded: Vec<Heeded>,
    /// Channels with a path that glTF does not know.
    pub unknown: u64,
    /// Whether a channel of `KHR_animation_pointer` moves something and is ignored, as the caller wants.
    pub ignores_pointer: bool,
}

/// A channel that moves something: a node's property, and the accessors of its keys and values.
#[derive(Debug)]
pub struct Heeded {
    pub node: u32,
    pub path: Path,
    pub input: usize,
    pub output: usize,
    pub interpolation: Interpolation,
    /// The channel, for messages.
    pub what: String,
}

impl Channels {
    /// Choose the channels of animation `number` that move something. The others are not looked into: what they name may be broken.
    ///
    /// A channel without a node is passed over, as the specification asks (glTF 2.0, 3.11).
    pub fn choose(document: &Document, number: u32, scope: &Scope, source: &Source) -> Result<Channels, SceneError> {
        let animation: Animation = document.animation(number, source)?;
        let mut channels = Channels::default();
        let mut targets = BTreeSet::new();
        for (index, json) in animation.channels.iter().enumerate() {
            if json.target.path == "pointer" {
                channels.meet_pointer(json, scope, source)?;
                continue;
            }
            let Some(path) = Path::parse(&json.target.path) else {
                channels.unknown += 1;
                continue;
            };
            let Some(node) = json.target.node.map(|n| n.0) else { continue };
            let what = format!("channel {index} of animation {number}");
            let malformed = |why: String| SceneError::malformed(source.path, format!("{what} {why}"));
            let Some(target) = document.nodes.get(node as usize) else {
                return Err(malformed(format!("moves node {node}, but there are {}", document.nodes.len())));
            };
            let moves = if path == Path::Weights { target.mesh.is_some() } else { true };
            if !(moves && scope.carries(node)) {
                continue;
            }
            if path != Path::Weights && target.matrix.is_some() {
                let why = format!("moves the {} of node {node}, which has a matrix in its place", path.name());
                return Err(malformed(why));
            }
            if !targets.insert((node, path)) {
                let why = format!("moves the {} of node {node}, which another channel moves already", path.name());
                return Err(malformed(why));
            }
            let Some(sampler) = animation.samplers.get(json.sampler.0 as usize) else {
                let count = animation.samplers.len();
                return Err(malformed(format!("uses sampler {}, but there are {count}", json.sampler.0)));
            };
            let interpolation = Interpolation::parse(sampler.interpolation.as_deref()).map_err(malformed)?;
            let (input, output) = (sampler.input.0 as usize, sampler.output.0 as usize);
            channels.heeded.push(Heeded { node, path, input, output, interpolation, what });
        }
        Ok(channels)
    }

    /// Refuse a pointer that moves something, unless the caller ignores it.
    fn meet_pointer(&mut self, json: &Channel, scope: &Scope, source: &Source) -> Result<(), SceneError> {
        let extension = json.target.extensions.as_ref().and_then(|e| e.pointer.as_ref());
        let pointer = extension.and_then(|p| p.pointer.as_deref()).unwrap_or_default();
        if !pointer::moves_geometry(pointer, scope) {
            return Ok(());
        }
        if !source.options.ignores(ANIMATION_POINTER) {
            return Err(moved_by_pointer(source));
        }
        self.ignores_pointer = true;
        Ok(())
    }
}
