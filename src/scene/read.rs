use super::source::{Progress, Source};
use super::{Format, ReadOptions, Scene, SceneError, gltf, obj, sanitize};
use crate::exec::Executor;
use std::path::Path;

/// Read a model file on the calling thread, its format taken from its extension or else from its content.
///
/// A model without triangles is not an error: the scene has no meshes and no instances, and the report says what was
/// skipped.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Scene, SceneError> {
    read_with(path, options, &Executor::sequential(), &mut |_, _| ())
}

/// [`read`] with the threads of `exec`, reporting bytes done and bytes to do from the calling thread.
pub fn read_with(path: &Path, options: &ReadOptions, exec: &Executor, progress: Progress) -> Result<Scene, SceneError> {
    let folder = path.parent().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p }.to_owned());
    let mut source = Source::new(path, folder, options, exec, progress);
    let bytes = source.read_model()?;
    parse(bytes, Format::from_extension(path), source)
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
    parse(bytes, format, source)
}

fn parse(bytes: Vec<u8>, format: Option<Format>, mut source: Source) -> Result<Scene, SceneError> {
    let unknown = || SceneError::UnknownFormat { path: source.path.to_owned() };
    let format = match format {
        Some(format) => format,
        None => Format::sniff(&bytes).ok_or_else(unknown)?,
    };
    let mut scene = match format {
        Format::Obj => obj::parse(bytes, &mut source)?,
        Format::Gltf => gltf::parse(bytes, &mut source)?,
    };
    sanitize::sanitize(&mut scene, &mut source)?;
    source.finish();
    scene.degenerate = source.options.degenerate;
    scene.inputs = source.inputs;
    Ok(scene)
}
