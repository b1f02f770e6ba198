//! A clip: a model that is read once and posed at any number of times of one of its animations.

use super::source::{Progress, Source};
use super::{Animation, AnimationChoice, Format, ReadOptions, Scene, SceneError, Seconds, gltf, read, sanitize};
use crate::exec::Executor;
use std::path::Path;

/// A model and one of its animations.
pub struct Clip<'c, 'b, 's> {
    model: gltf::Played<'b>,
    source: &'c mut Source<'s>,
}

impl Clip<'_, '_, '_> {
    /// The animation that is played.
    pub fn animation(&self) -> &Animation {
        self.model.animation()
    }

    /// The model as the animation has it at a time: what [`read`](super::read()) gives for that moment. Only what stays read is charged to the memory
    /// limit; scenes that were given before are not.
    ///
    /// # Errors
    /// As [`read`](super::read()).
    pub fn at(&mut self, time: Seconds) -> Result<Scene, SceneError> {
        let before = self.source.passing();
        let mut scene = self.model.at(time, self.source)?;
        sanitize::sanitize(&mut scene, self.source)?;
        self.source.release(self.source.passing().saturating_sub(before));
        scene.degenerate = self.source.options.degenerate;
        scene.inputs.clone_from(&self.source.inputs);
        Ok(scene)
    }
}

/// Read a glTF model, and let `work` pose it by one of its animations. What `options` say of a moment does not count.
///
/// # Errors
/// Where the model or its animation cannot be read; an OBJ model has none.
pub fn play<R>(
    path: &Path,
    choice: &AnimationChoice,
    options: &ReadOptions,
    exec: &Executor,
    progress: Progress,
    work: impl FnOnce(&mut Clip<'_, '_, '_>) -> R,
) -> Result<R, SceneError> {
    let mut source = Source::new(path, read::folder_of(path), options, exec, progress);
    let bytes = source.read_model()?;
    if read::format_of(&bytes, Format::from_extension(path), &source)? == Format::Obj {
        return Err(read::no_animations(path, choice));
    }
    let model = gltf::Played::read(&bytes, choice, &mut source)?;
    let result = work(&mut Clip { model, source: &mut source });
    source.finish();
    Ok(result)
}
