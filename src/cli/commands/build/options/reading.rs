//! Flags that choose what of a model is read.

use crate::cli::advice;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::names;
use crate::cli::reading::ModelReading;
use crate::scene::{AnimationChoice, Format, ReadOptions, VertexBits};
use clap::Args;
use std::path::Path;

/// How models are read.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadArgs {
    #[command(flatten)]
    pub model: ModelReading,
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

    /// Refuse to choose a scene or an animation of a model that has none to choose from. `content` is the model itself where it came from standard input.
    /// The format of a file is told as the reader tells it.
    pub fn suit(&self, model: &Path, content: Option<&[u8]>) -> Result<(), Failure> {
        let chosen = [
            ("--scene", "scenes", self.model.scene.map(|number| format!("--scene {number}"))),
            ("--clip", "animations", self.model.clip.as_ref().map(|_| "--clip".to_owned())),
            ("--time", "animations", self.model.time.map(|time| format!("--time {time}"))),
        ];
        let chosen = chosen.into_iter().find_map(|(flag, things, given)| Some((flag, things, given?)));
        let Some((flag, things, given)) = chosen else { return Ok(()) };
        let format = match content {
            Some(bytes) => self.input_format.map(Format::from).or_else(|| Format::sniff(bytes)),
            None => Format::from_extension(model).or_else(|| Format::sniff(&std::fs::read(model).ok()?)),
        };
        if format != Some(Format::Obj) {
            return Ok(());
        }
        let cut = match &self.model.clip {
            Some(AnimationChoice::Name(name)) if flag == "--clip" => advice::cut(name),
            _ => None,
        };
        Err(Failure::new(Exit::Usage, format!("cannot read {} with {given}", names::path(model)))
            .fact(format!("it is an OBJ model, which has no {things}; only glTF models have"))
            .help(cut.unwrap_or_else(|| format!("leave out {flag}"))))
    }
}
