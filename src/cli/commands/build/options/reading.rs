//! Flags that choose what of a model is read.

use crate::cli::advice;
use crate::cli::failure::Failure;
use crate::cli::reading::{ModelReading, not_of_obj};
use crate::scene::{AnimationChoice, Format, ReadOptions, VertexBits};
use clap::Args;
use std::path::Path;

/// How models are read.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadArgs {
    #[command(flatten)]
    pub model: ModelReading,
    /// Leave a glTF model at rest, as its nodes and meshes stand without a clip, and do not warn that it has clips; OBJ models have none
    #[arg(long, conflicts_with_all = ["clip", "time", "fps", "play"])]
    pub at_rest: bool,
    /// Keep which vertices of the model each triangle has, to interpolate normals and texture coordinates at hits: 12 bytes a triangle
    #[arg(long)]
    pub vertices: bool,
    /// Put positions on a grid of so many bits an axis (8 to 24) within each mesh's box: with --codec compact, 16 halve a sequence
    #[arg(long, value_name = "N")]
    pub vertex_bits: Option<VertexBits>,
    /// What comes from standard input; told by its content if not given
    #[arg(long, value_name = "FORMAT", value_enum)]
    pub input_format: Option<InputFormat>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum InputFormat {
    Obj,
    Gltf,
    Glb,
}

impl From<InputFormat> for Format {
    fn from(format: InputFormat) -> Format {
        match format {
            InputFormat::Obj => Format::Obj,
            InputFormat::Gltf | InputFormat::Glb => Format::Gltf,
        }
    }
}

impl ReadArgs {
    pub fn resolve(&self) -> ReadOptions {
        let (vertices, vertex_bits) = (self.vertices, self.vertex_bits);
        ReadOptions { vertices, vertex_bits, ..self.model.resolve() }
    }

    /// As the reader tells it. `content` is the model itself where it came from standard input.
    fn format(&self, model: &Path, content: Option<&[u8]>) -> Option<Format> {
        match content {
            Some(bytes) => self.input_format.map(Format::from).or_else(|| Format::sniff(bytes)),
            None => Format::from_extension(model).or_else(|| Format::sniff(&std::fs::read(model).ok()?)),
        }
    }

    /// Refuse to choose a scene or an animation of a model that has none to choose from, or to play one by the flag `played_by`. `content` is the model itself
    /// where it came from standard input.
    pub fn suit(&self, model: &Path, content: Option<&[u8]>, played_by: Option<&'static str>) -> Result<(), Failure> {
        let played = played_by.map(|flag| (flag, "animations"));
        let Some((flag, things)) = self.model.choice().or(played) else { return Ok(()) };
        let given = match (flag, self.model.scene, self.model.time) {
            ("--scene", Some(number), _) => format!("--scene {number}"),
            ("--time", _, Some(time)) => format!("--time {time}"),
            _ => flag.to_owned(),
        };
        if self.format(model, content) != Some(Format::Obj) {
            return Ok(());
        }
        let cut = match &self.model.clip {
            Some(AnimationChoice::Name(name)) if flag == "--clip" => advice::cut(name),
            _ => None,
        };
        let refused = not_of_obj(model, &given, flag, things);
        Err(match cut {
            Some(help) => refused.help(help),
            None => refused,
        })
    }
}
