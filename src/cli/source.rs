//! The model that a file is compared with (`--source`), and how it is read: as the file's META says, or else as flags say.

use super::Context;
use super::caches;
use super::exit::Exit;
use super::failure::Failure;
use super::names;
use super::reading::{ModelReading, choice, not_of_obj};
use crate::build::{BuildOptions, Levels, Named};
use crate::cache::Meta;
use crate::scene::{self, Degenerate, Format, ReadOptions, Scene};
use clap::Args;
use std::path::{Path, PathBuf};

/// How the model of `--source` is read. META says most of it; the flags are for files without META.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "How the model was read (only where META is missing, but for the permissions)")]
pub struct SourceReading {
    #[command(flatten)]
    model: ModelReading,
    /// How instances were laid out
    #[arg(long, value_parser = choice::<Levels>(), value_name = "LEVELS")]
    levels: Option<Levels>,
}

/// What a file says of how it was made.
#[derive(Clone, Copy, Debug)]
pub struct Stated<'a> {
    pub meta: Option<&'a Meta>,
    /// Whether it has a tree over instances.
    pub two_levels: bool,
    /// Whether it has numbers of vertices that are to be compared, whatever META says of them.
    pub has_vertices: bool,
}

impl SourceReading {
    /// Refuse flags about a model where none is named, and those that only glTF models read for an OBJ model.
    pub fn suits(&self, source: Option<&PathBuf>) -> Result<(), Failure> {
        let given = self.model.first_given().or(self.levels.map(|_| "--levels"));
        let is_obj = source.is_some_and(|model| Format::from_extension(model) == Some(Format::Obj));
        if let (Some(model), Some((flag, things))) = (source, self.model.choice().filter(|_| is_obj)) {
            return Err(not_of_obj(model, flag, flag, things));
        }
        match given.filter(|_| source.is_none()) {
            None => Ok(()),
            Some(flag) => Err(Failure::new(Exit::Usage, format!("cannot use {flag} without a model"))
                .fact("it says how the model of --source is read")
                .help("name the model: --source MODEL")),
        }
    }

    /// The ways in which a file's model may have been read and laid out, the likeliest first: one where the file has META, else those that the
    /// flags leave open. A file that agrees with any of them agrees with its model.
    pub fn ways(
        &self,
        file: &Path,
        stated: Stated<'_>,
        context: &Context,
    ) -> Result<Vec<(ReadOptions, BuildOptions)>, Failure> {
        let max_memory = context.global.max_memory;
        if let Some(meta) = stated.meta {
            let (read, build) = recorded(meta);
            self.contradicts_nothing(file, &read, build.levels)?;
            let mut ignore_extensions = read.ignore_extensions.clone();
            ignore_extensions.extend_from_slice(&self.model.ignore_extensions);
            let allow_outside = self.model.allow_outside;
            let vertices = read.vertices || stated.has_vertices;
            return Ok(vec![(ReadOptions { ignore_extensions, allow_outside, max_memory, vertices, ..read }, build)]);
        }
        if self.model.first_given().is_none() && self.levels.is_none() {
            context.terminal.note(&format!(
                "{} has no META, so its model is read by defaults; how it was built can be said by --degenerate, --scene, --clip, --time, \
                 --ignore-extension and --levels",
                names::path(file)
            ));
        }
        let policies = self.model.degenerate.map_or(vec![Degenerate::Drop, Degenerate::Keep], |policy| vec![policy]);
        let layouts = match self.levels {
            Some(levels) => vec![levels],
            None if stated.two_levels => vec![Levels::Auto, Levels::Two],
            None => vec![Levels::One],
        };
        let vertices = stated.has_vertices;
        let read = |degenerate| ReadOptions { degenerate, max_memory, vertices, ..self.model.resolve() };
        let way = |levels, policy| (read(policy), BuildOptions { levels, ..BuildOptions::default() });
        Ok(layouts.iter().flat_map(|levels| policies.iter().map(move |policy| way(*levels, *policy))).collect())
    }

    /// What META says counts; a flag that says otherwise is a mistake.
    fn contradicts_nothing(&self, file: &Path, read: &ReadOptions, levels: Levels) -> Result<(), Failure> {
        let asked = self.model.resolve();
        let degenerate = self.model.degenerate.filter(|policy| *policy != read.degenerate);
        let scene = asked.scene.filter(|_| asked.scene != read.scene);
        let moment = asked.moment.as_ref().filter(|_| asked.moment != read.moment);
        let layout = self.levels.filter(|asked| *asked != levels);
        let flag = degenerate
            .map(|_| "--degenerate")
            .or(scene.map(|_| "--scene"))
            .or(moment.map(|_| if self.model.clip.is_some() { "--clip" } else { "--time" }))
            .or(layout.map(|_| "--levels"));
        let Some(flag) = flag else { return Ok(()) };
        let mut recorded = read.effective();
        recorded.push(("levels".to_owned(), levels.name().to_owned()));
        let recorded: Vec<String> = recorded.into_iter().map(|(name, value)| format!("{name}={value}")).collect();
        Err(Failure::new(Exit::Usage, format!("cannot read the model of {} by another {flag}", names::path(file)))
            .fact(format!("META says how it was read: {}", recorded.join(" ")))
            .fact("flags say it only where META is missing")
            .help(format!("leave out {flag}")))
    }
}

/// The options in META that decide what of a model a file holds; defaults where it does not say.
fn recorded(meta: &Meta) -> (ReadOptions, BuildOptions) {
    let options = &meta.options[..];
    let levels = options.iter().find(|(name, _)| name == "levels").and_then(|(_, value)| Levels::parse(value).ok());
    let build = BuildOptions { levels: levels.unwrap_or(Levels::Auto), ..BuildOptions::default() };
    (ReadOptions::recorded(options), build)
}

/// Read a model to compare a file with it, and say what its grid cost.
pub fn read(model: &Path, read: &ReadOptions, build: &BuildOptions, context: &Context) -> Result<Scene, Failure> {
    let scene = read_untold(model, read, build, context)?;
    tell_grid(model, &scene, context);
    Ok(scene)
}

/// The same of a frame behind the first one, whose grid was told.
pub fn read_untold(
    model: &Path,
    read: &ReadOptions,
    build: &BuildOptions,
    context: &Context,
) -> Result<Scene, Failure> {
    let scene = scene::read_with(model, read, &context.exec, &mut |_, _| ()).map_err(|e| caches::scene_failure(&e))?;
    // Laying out makes no duplicates.
    caches::fits(model, &scene, &BuildOptions { split_budget: 1.0, ..build.clone() }, context)?;
    Ok(scene)
}

fn tell_grid(model: &Path, scene: &Scene, context: &Context) {
    let Some(loss) = scene.rounding.grid else { return };
    let share = 100.0 * loss.share;
    context.terminal.note(&format!(
        "{} is compared on the grid that the file was built on: it moves corners by up to {:.3e}, on average {share:.2}% of a triangle's \
         shortest edge",
        names::path(model),
        loss.farthest
    ));
}
