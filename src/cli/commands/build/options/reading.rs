//! Flags that choose what of a model is read.

use super::choice;
use crate::build::Named;
use crate::cli::advice;
use crate::cli::caches::extension_name;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::names;
use crate::scene::{AnimationChoice, Degenerate, Format, Moment, ReadOptions, Seconds, VertexBits};
use clap::Args;
use std::path::Path;

/// How models are read.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Reading")]
pub struct ReadArgs {
    /// What to do with triangles without area [default: drop; in a sequence keep]
    #[arg(long, value_parser = choice::<Degenerate>(), value_name = "POLICY")]
    pub degenerate: Option<Degenerate>,
    /// Let a glTF file name buffers outside its own folder
    #[arg(long)]
    pub allow_outside: bool,
    /// The glTF scene to build; default: the one that the file names
    #[arg(long, value_name = "N")]
    pub scene: Option<u32>,
    /// Pose a glTF model by this clip (animation), at --time or else at its first key
    #[arg(long, value_name = "NAME|NUMBER", value_parser = animation_choice)]
    pub clip: Option<AnimationChoice>,
    /// Pose a glTF model at this time of --clip, or else of its only animation
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub time: Option<Seconds>,
    /// Read glTF as if this extension were not in the file, even where the file requires it; may be given again
    #[arg(long = "ignore-extension", value_name = "NAME", value_parser = extension_name)]
    pub ignore_extensions: Vec<String>,
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
        let (degenerate, allow_outside, scene, vertices) =
            (self.degenerate.unwrap_or_default(), self.allow_outside, self.scene, self.vertices);
        let (ignore_extensions, moment) = (self.ignore_extensions.clone(), self.moment());
        ReadOptions {
            degenerate,
            allow_outside,
            scene,
            moment,
            ignore_extensions,
            vertices,
            vertex_bits: self.vertex_bits,
            ..ReadOptions::default()
        }
    }

    fn moment(&self) -> Option<Moment> {
        let is_posed = self.clip.is_some() || self.time.is_some();
        is_posed.then(|| Moment { animation: self.clip.clone().unwrap_or_default(), time: self.time })
    }

    /// Refuse to choose a scene or an animation of a model that has none to choose from. `content` is the model itself where it came from standard input.
    /// The format of a file is told as the reader tells it.
    pub fn suit(&self, model: &Path, content: Option<&[u8]>) -> Result<(), Failure> {
        let chosen = [
            ("--scene", "scenes", self.scene.map(|number| format!("--scene {number}"))),
            ("--clip", "animations", self.clip.as_ref().map(|_| "--clip".to_owned())),
            ("--time", "animations", self.time.map(|time| format!("--time {time}"))),
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
        let cut = match &self.clip {
            Some(AnimationChoice::Name(name)) if flag == "--clip" => advice::cut(name),
            _ => None,
        };
        Err(Failure::new(Exit::Usage, format!("cannot read {} with {given}", names::path(model)))
            .fact(format!("it is an OBJ model, which has no {things}; only glTF models have"))
            .help(cut.unwrap_or_else(|| format!("leave out {flag}"))))
    }
}

/// Digits are a number, all else is a name.
fn animation_choice(text: &str) -> Result<AnimationChoice, String> {
    match text {
        "" => Err("an animation has a name or a number".to_owned()),
        _ if text.bytes().all(|b| b.is_ascii_digit()) => {
            text.parse().map(AnimationChoice::Number).map_err(|_| format!("no file has so many animations as {text}"))
        }
        _ => Ok(AnimationChoice::Name(text.to_owned())),
    }
}

impl Named for Degenerate {
    const KIND: &'static str = "policy";

    fn names() -> Vec<(Self, &'static str)> {
        [Degenerate::Keep, Degenerate::Drop, Degenerate::Error].map(|policy| (policy, policy.name())).to_vec()
    }
}
