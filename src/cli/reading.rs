//! Flags that choose what a model holds: of `build`, which reads it, and of the commands that compare a file with it.

use super::exit::Exit;
use super::failure::Failure;
use super::names;
use crate::build::Named;
use crate::scene::{AnimationChoice, Degenerate, Moment, ReadOptions, Seconds};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use std::path::Path;

/// What of a model is read.
#[derive(Clone, Debug, Default, Args)]
pub struct ModelReading {
    /// What to do with triangles without area [default: drop; in a sequence keep]
    #[arg(long, value_parser = choice::<Degenerate>(), value_name = "POLICY")]
    pub degenerate: Option<Degenerate>,
    /// Let a glTF file name buffers outside its own folder; OBJ files name none
    #[arg(long)]
    pub allow_outside: bool,
    /// The glTF scene to read; default: the one that the file names
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
}

impl ModelReading {
    pub fn resolve(&self) -> ReadOptions {
        ReadOptions {
            degenerate: self.degenerate.unwrap_or_default(),
            allow_outside: self.allow_outside,
            scene: self.scene,
            moment: self.moment(),
            ignore_extensions: self.ignore_extensions.clone(),
            ..ReadOptions::default()
        }
    }

    /// The flags that are given, as they are typed.
    pub fn typed(&self) -> Vec<String> {
        let pair = |flag: &str, value: String| [flag.to_owned(), value];
        let clip = self.clip.as_ref().map(|clip| match clip {
            AnimationChoice::Name(name) => name.clone(),
            AnimationChoice::Number(number) => number.to_string(),
            AnimationChoice::Only => String::new(),
        });
        let pairs = [
            self.degenerate.map(|policy| pair("--degenerate", policy.name().to_owned())),
            self.scene.map(|number| pair("--scene", number.to_string())),
            clip.map(|clip| pair("--clip", clip)),
            self.time.map(|time| pair("--time", time.to_string())),
        ];
        let outside = self.allow_outside.then(|| "--allow-outside".to_owned());
        let ignored = self.ignore_extensions.iter().flat_map(|name| pair("--ignore-extension", name.clone()));
        pairs.into_iter().flatten().flatten().chain(outside).chain(ignored).collect()
    }

    fn moment(&self) -> Option<Moment> {
        let is_posed = self.clip.is_some() || self.time.is_some();
        is_posed.then(|| Moment { animation: self.clip.clone().unwrap_or_default(), time: self.time })
    }

    /// What is chosen of a glTF model: the first flag that is given, and what OBJ models have none of.
    pub fn choice(&self) -> Option<(&'static str, &'static str)> {
        let given = [
            (self.scene.is_some(), "--scene", "scenes"),
            (self.clip.is_some(), "--clip", "animations"),
            (self.time.is_some(), "--time", "animations"),
        ];
        given.into_iter().find_map(|(is_given, flag, things)| is_given.then_some((flag, things)))
    }

    /// The first flag that is given, as it is typed.
    pub fn first_given(&self) -> Option<&'static str> {
        let given = [
            (self.degenerate.is_some(), "--degenerate"),
            (self.allow_outside, "--allow-outside"),
            (self.scene.is_some(), "--scene"),
            (self.clip.is_some(), "--clip"),
            (self.time.is_some(), "--time"),
            (!self.ignore_extensions.is_empty(), "--ignore-extension"),
        ];
        given.iter().find_map(|(is_given, flag)| is_given.then_some(*flag))
    }
}

/// The failure for a flag, typed as `given`, that is about things which only glTF models have.
pub fn not_of_obj(model: &Path, given: &str, flag: &str, things: &str) -> Failure {
    Failure::new(Exit::Usage, format!("cannot read {} with {given}", names::path(model)))
        .fact(format!("it is an OBJ model, which has no {things}; only glTF models have"))
        .help(format!("leave out {flag}"))
}

/// A closed set of the library as values of a flag: its names are the choices.
pub fn choice<T: Named + Send + Sync>() -> impl TypedValueParser<Value = T> {
    let names = T::names().into_iter().map(|(_, name)| PossibleValue::new(name));
    PossibleValuesParser::new(names).try_map(|text| T::parse(&text))
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

/// A name for `--ignore-extension`.
fn extension_name(text: &str) -> Result<String, String> {
    let may_stand = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    if text.is_empty() || !text.chars().all(may_stand) {
        return Err("a glTF extension has a name such as KHR_node_visibility".to_string());
    }
    Ok(text.to_owned())
}

impl Named for Degenerate {
    const KIND: &'static str = "policy";

    fn names() -> Vec<(Self, &'static str)> {
        [Degenerate::Keep, Degenerate::Drop, Degenerate::Error].map(|policy| (policy, policy.name())).to_vec()
    }
}
