use crate::exec::ThreadsError;
use crate::scene::GeometryError;

/// Why a build ended without a result: data, which a program puts into its own words. The texts name no flag of the command line.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// [`Progress::is_cancelled`](super::Progress::is_cancelled) said so.
    #[error("the build was cancelled")]
    Cancelled,
    /// The geometry breaks what every build relies on. No scene that the readers made does.
    #[error("cannot build: the geometry is not sound")]
    Geometry(#[from] GeometryError),
    /// The numbers of vertices were asked for, or other meshes have them, and a mesh has none.
    #[error(
        "cannot build with vertices: mesh {mesh} has no numbers of its vertices; a model has them if it is read with ReadOptions::vertices"
    )]
    NoVertices {
        /// The first mesh with triangles and without numbers.
        mesh: usize,
    },
    /// There were triangles, and none is left to build over.
    #[error(
        "cannot build: no triangle is left; reading left out {read}, and {placed} lost their area where instances put them"
    )]
    NothingLeft {
        /// Triangles that reading left out.
        read: u64,
        /// Triangles that lost their area where instances put them.
        placed: u64,
    },
    /// A mesh was added, and no instance shows it: no ray would meet it.
    #[error("cannot build: mesh {mesh} ('{name}') was added, and no instance places it")]
    Unplaced {
        /// Its number.
        mesh: u32,
        /// Its name.
        name: String,
    },
    /// 32-bit indices do not reach further.
    #[error("cannot build {what}: it would hold {needed}, and the limit is {limit}")]
    TooLarge {
        /// What is counted, and in which tree.
        what: &'static str,
        /// How many there would be.
        needed: u64,
        /// How many there may be.
        limit: u64,
        /// What avoids it.
        remedy: Remedy,
    },
    /// An option's value is outside of its range, or set twice.
    #[error("cannot build with {option} {value}: {rule}")]
    Option {
        /// Name of the option, as [`OPTIONS`](super::OPTIONS) has it.
        option: &'static str,
        /// The refused value.
        value: String,
        /// What the option takes.
        rule: String,
        /// A value that is taken; `None` where the value is sound but stands there twice.
        default: Option<String>,
    },
    /// A preset and options were both given, and each says everything about the trees.
    #[error(
        "cannot build by the preset {preset} and by options: each says everything, so one of them would be ignored"
    )]
    TwoRecipes {
        /// Name of the preset.
        preset: &'static str,
    },
    /// The value would be ignored.
    #[error("cannot build with {option} {value}: method {method} does not read it; {option} is read by {readers}")]
    NotRead {
        /// Name of the option.
        option: &'static str,
        /// The value that it was given.
        value: String,
        /// The method that ignores it.
        method: &'static str,
        /// The methods that read it.
        readers: String,
    },
    /// A name that is none of a list.
    #[error("cannot build: there is no {kind} named {name}, only {choices}")]
    UnknownName {
        /// What is named: a method, a preset.
        kind: &'static str,
        /// The unknown name.
        name: String,
        /// The known names.
        choices: String,
        /// The known name that was most likely meant.
        nearest: Option<String>,
    },
    /// An instance lies where 32-bit floats do not reach.
    #[error(
        "cannot place instance {instance} of mesh {mesh}: in world space it reaches beyond {limit:e}, the range of a 32-bit float",
        limit = f32::MAX
    )]
    OutOfRange {
        /// The instance.
        instance: usize,
        /// Its mesh.
        mesh: u32,
    },
    /// Triangles lose their area where an instance puts them, and the scene's policy is to refuse such.
    #[error(
        "cannot place mesh '{mesh}' for node {node}: {count} of its triangles lose their area there, rounded to 32 bits; the first is triangle {prim}"
    )]
    Collapsed {
        /// How many.
        count: usize,
        /// Number of the first in its source mesh.
        prim: u32,
        /// Name of the mesh.
        mesh: String,
        /// The instance's node.
        node: u32,
    },
    /// The operating system refused to start threads.
    #[error(transparent)]
    Threads(#[from] ThreadsError),
    /// One level is one tree over one mesh.
    #[error("cannot build one level: it is the tree of one mesh, and {meshes} are given without instances")]
    OneLevel {
        /// How many are given.
        meshes: usize,
    },
    /// What was built cannot be laid out as the file's records.
    #[error("cannot lay out the trees: {0}")]
    Layout(String),
}

/// What avoids a limit: a program says how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Remedy {
    /// Build by [`Method::Bonsai`](super::Method::Bonsai), which has no such limit.
    Bonsai,
    /// Keep meshes and instances apart: [`Levels::Two`](super::Levels::Two).
    TwoLevels,
    /// [`Levels::Two`](super::Levels::Two), or a smaller `split_budget`.
    TwoLevelsOrFewerDuplicates,
    /// Several files.
    SplitScene,
}
