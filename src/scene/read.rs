use super::source::{Progress, Source};
use super::{Animation, AnimationChoice, Format, ReadOptions, Resemblance, Scene, SceneError, gltf, obj, sanitize};
use crate::exec::Executor;
use std::path::{Path, PathBuf};

/// Read a model file on the calling thread, its format taken from its extension or else from its content.
///
/// A model without triangles is not an error: the scene has no meshes and no instances, and the report says what was
/// skipped.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Scene, SceneError> {
    read_with(path, options, &Executor::sequential(), &mut |_, _| ())
}

/// The animations of a model file, in its order; an OBJ has none. Key times are those of what an animation moves in the scene that `options` choose.
///
/// # Errors
/// Where the model or one of its animations cannot be read.
pub fn animations(path: &Path, options: &ReadOptions) -> Result<Vec<Animation>, SceneError> {
    let (exec, mut progress) = (Executor::sequential(), |_, _| ());
    let mut source = Source::new(path, folder_of(path), options, &exec, &mut progress);
    let bytes = source.read_model()?;
    match format_of(&bytes, Format::from_extension(path), &source)? {
        Format::Obj => Ok(Vec::new()),
        Format::Gltf => gltf::animations(bytes, &mut source),
    }
}

/// [`read`] with the threads of `exec`, reporting bytes done and bytes to do from the calling thread.
pub fn read_with(path: &Path, options: &ReadOptions, exec: &Executor, progress: Progress) -> Result<Scene, SceneError> {
    let mut source = Source::new(path, folder_of(path), options, exec, progress);
    let mut everyday = true;
    if options.moment.is_none() {
        match obj::parse_in_pieces(&mut source)? {
            Ok(scene) => return settle(scene, source),
            Err(other) => everyday = other != obj::Other::Text,
        }
    }
    let bytes = source.read_model()?;
    parse(bytes, Format::from_extension(path), everyday, source)
}

/// Read a model from memory, on the calling thread. `name` stands for the file in messages and in [`Scene::inputs`]; `folder` is where the model's
/// relative references start, and without one they are refused.
pub fn read_bytes(
    bytes: Vec<u8>,
    name: &str,
    format: Option<Format>,
    folder: Option<&Path>,
    options: &ReadOptions,
) -> Result<Scene, SceneError> {
    let (exec, mut progress) = (Executor::sequential(), |_, _| ());
    let mut source = Source::new(Path::new(name), folder.map(Path::to_owned), options, &exec, &mut progress);
    source.charge(bytes.len() as u64, "the model")?;
    source.add_model(&bytes);
    parse(bytes, format, true, source)
}

/// The folder that a model's relative references start from.
pub(super) fn folder_of(path: &Path) -> Option<PathBuf> {
    path.parent().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p }.to_owned())
}

pub(super) fn format_of(bytes: &[u8], given: Option<Format>, source: &Source) -> Result<Format, SceneError> {
    let glb = Resemblance::of_glb(bytes).filter(|_| given == Some(Format::Obj));
    if let Some(resembles) = Resemblance::of_wide_text(bytes).or(Resemblance::of_cache(bytes)).or(glb) {
        return Err(SceneError::InPlaceOfData { path: source.path.to_owned(), what: "the file".into(), resembles });
    }
    let unknown = || SceneError::UnknownFormat { path: source.path.to_owned() };
    given.or_else(|| Format::sniff(bytes)).ok_or_else(unknown)
}

fn parse(bytes: Vec<u8>, format: Option<Format>, everyday: bool, mut source: Source) -> Result<Scene, SceneError> {
    let options = source.options;
    let scene = match (format_of(&bytes, format, &source)?, &options.moment) {
        (Format::Obj, Some(moment)) => return Err(no_animations(source.path, &moment.animation)),
        (Format::Obj, None) => obj::parse(bytes, everyday, &mut source)?,
        (Format::Gltf, _) => gltf::parse(bytes, &mut source)?,
    };
    settle(scene, source)
}

fn settle(mut scene: Scene, mut source: Source) -> Result<Scene, SceneError> {
    sanitize::sanitize(&mut scene, &mut source)?;
    source.finish();
    scene.degenerate = source.options.degenerate;
    scene.inputs = source.inputs;
    Ok(scene)
}

/// An OBJ model has no animation that could be meant.
pub(super) fn no_animations(path: &Path, asked: &AnimationChoice) -> SceneError {
    let (path, asked) = (path.to_owned(), asked.clone());
    SceneError::NoSuchAnimation { path, asked, found: 0, count: 0, animations: Vec::new() }
}
