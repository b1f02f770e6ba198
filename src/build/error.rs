/// Why a build ended without a result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BuildError {
    #[error("The build was cancelled.")]
    Cancelled,
    /// The tree's 32-bit indices do not reach further.
    #[error("Cannot build {what}: it needs {needed} references and a tree holds at most {limit}.\nhelp: {help}")]
    TooLarge { what: String, needed: u64, limit: u64, help: &'static str },
    #[error("Cannot build with {option} = {value}: {rule}.\nhelp: {help}")]
    Option { option: &'static str, value: String, rule: &'static str, help: String },
    #[error(
        "Cannot build: instance {instance} names mesh {mesh}, but the scene has {meshes} meshes.\nhelp: Build the Scene from a file with the scene readers, or number the meshes from 0."
    )]
    MeshIndex { instance: usize, mesh: u32, meshes: usize },
    #[error(
        "Cannot bake instance {instance} of mesh {mesh}: triangle {triangle} has a corner beyond the range of a 32-bit float in world space.\nhelp: Keep the levels apart with --levels two, or scale the scene down."
    )]
    NonFinite { instance: usize, mesh: u32, triangle: usize },
    #[error("Cannot start {jobs} threads: {reason}.\nhelp: Ask for fewer with --jobs.")]
    Threads { jobs: usize, reason: String },
}
