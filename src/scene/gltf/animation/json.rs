use crate::scene::gltf::whole::Index;
use serde::Deserialize;

/// An animation as the file has it.
#[derive(Deserialize)]
pub(super) struct Animation {
    #[serde(default)]
    pub channels: Vec<Channel>,
    #[serde(default)]
    pub samplers: Vec<Sampler>,
}

/// What moves a property of a node, or of something else.
#[derive(Deserialize)]
pub(super) struct Channel {
    pub sampler: Index,
    pub target: Target,
}

#[derive(Deserialize)]
pub(super) struct Target {
    /// Absent where an extension says what moves.
    pub node: Option<Index>,
    pub path: String,
    pub extensions: Option<TargetExtensions>,
}

#[derive(Deserialize)]
pub(super) struct TargetExtensions {
    #[serde(rename = "KHR_animation_pointer")]
    pub pointer: Option<Pointer>,
}

#[derive(Deserialize)]
pub(super) struct Pointer {
    pub pointer: Option<String>,
}

/// Accessors of key times and of values, and how values between keys are found.
#[derive(Deserialize)]
pub(super) struct Sampler {
    pub input: Index,
    pub output: Index,
    pub interpolation: Option<String>,
}
