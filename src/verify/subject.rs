use super::origin::Origins;
use crate::cache::View;
use crate::exec::Executor;
use crate::scene::Scene;
use crate::trace::brute::Oracle;
use crate::trace::rays::Sampler;

/// A file under verification and the scene that it should hold.
pub struct Subject<'a> {
    /// The file's records.
    pub view: View<'a>,
    /// Brute force over the scene, with the file's matrices.
    pub oracle: Oracle<'a>,
    /// Rays through the scene.
    pub sampler: Sampler<'a>,
    pub(super) origins: Origins,
    /// What verification runs on.
    pub(super) exec: &'a Executor,
}

impl<'a> Subject<'a> {
    /// `scene` has no instance without triangles, as a file has none: instance numbers are those of the file.
    ///
    /// # Panics
    /// Where the scene is not sound: [`Scene::validate`] finds that.
    pub fn new(view: View<'a>, scene: &'a Scene, exec: &'a Executor) -> Subject<'a> {
        Subject {
            view,
            oracle: Oracle::of_file(scene, &view, exec),
            sampler: Sampler::new(scene),
            origins: Origins::new(&view, scene, exec),
            exec,
        }
    }

    /// What the file should hold.
    pub fn scene(&self) -> &'a Scene {
        self.oracle.scene()
    }
}
