/// Why a build ended without a result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    #[error("The build was cancelled.")]
    Cancelled,
    /// 32-bit indices do not reach further.
    #[error("Cannot build {what}: it would hold {needed}, and the limit is {limit}.\nhelp: {help}")]
    TooLarge { what: &'static str, needed: u64, limit: u64, help: &'static str },
    #[error("Cannot build with {option} {value}: {rule}.\nhelp: {help}")]
    Option { option: &'static str, value: String, rule: String, help: String },
    /// The value would be ignored.
    #[error(
        "Cannot build with {option} {value}: method {method} does not read it.\n\
         {option} is read by {readers}.\nhelp: Choose a method that reads it, or leave {option} out."
    )]
    NotRead { option: &'static str, value: String, method: &'static str, readers: String },
    #[error("Cannot build: there is no {kind} named {name}, only {choices}.\nhelp: {help}")]
    UnknownName { kind: &'static str, name: String, choices: String, help: String },
    /// Only a scene that no reader made can have this.
    #[error(
        "Cannot build: instance {instance} names mesh {mesh}, but the scene has {meshes} meshes, numbered from 0.\n\
         help: Read the scene with the scene readers, or correct the index."
    )]
    MeshIndex { instance: usize, mesh: u32, meshes: usize },
    #[error(
        "Cannot place instance {instance} of mesh {mesh}: in world space it reaches beyond {limit:e}, the range of a 32-bit float.\n\
         help: Scale the scene down."
    , limit = f32::MAX)]
    OutOfRange { instance: usize, mesh: u32 },
}
