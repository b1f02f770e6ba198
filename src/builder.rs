//! One way in for programs: geometry from arrays or from a model, to a file or to rays, without a choice that can be forgotten.
//!
//! The rooms behind it stay open for those who need more: [`scene`](crate::scene) reads, [`compile`](crate::compile) builds,
//! [`cache`](crate::cache) writes.

use crate::build::{BuildError, BuildOptions, Named, NoProgress, Preset, Progress};
use crate::built::Built;
use crate::cache::keys::Recipe;
use crate::cache::{self, Image, Meta};
use crate::compile::{compile_sound, lay_out, orient_image, orient_option};
use crate::exec::Executor;
use crate::geom::{Affine, Point};
use crate::scene::{self, GeometryError, Instance, Mesh, ReadOptions, Scene, SceneError, validate_transform};
use std::collections::BTreeSet;
use std::path::Path;

/// A build before it runs: what is built, how, and on how many threads.
///
/// ```
/// use bvhc::{Build, Ray, build::Preset};
///
/// let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let built = Build::new(&positions, &[[0, 1, 2]])?.preset(Preset::Best).threads(0).run()?;
/// let hit = built.closest_hit(&Ray::new([0.25, 0.25, -2.0], [0.0, 0.0, 1.0]))?.expect("the triangle is ahead");
/// assert_eq!((hit.t, hit.prim), (2.0, 0));
/// # let path = tempfile::tempdir()?.path().join("scene.bvhc");
/// # std::fs::create_dir_all(path.parent().unwrap())?;
/// built.write(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Several meshes, each in several places:
///
/// ```
/// use bvhc::{Build, geom::Affine};
///
/// let mut build = Build::empty();
/// let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let tree = build.add_mesh("tree", &positions, &[[0, 1, 2]])?;
/// build.add_instance(tree, Affine::translation([10.0, 0.0, 0.0]))?;
/// build.add_instance(tree, Affine::translation([20.0, 0.0, 0.0]))?;
/// let built = build.run()?;
/// assert_eq!(built.view().instances.len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
#[must_use = "nothing is built before `run`"]
pub struct Build {
    scene: Scene,
    /// How the scene's model was read; `None` where there is none.
    read: Option<ReadOptions>,
    preset: Option<Preset>,
    options: Option<BuildOptions>,
    vertices: bool,
    compact: bool,
    orient: bool,
    threads: usize,
    /// Whether the caller added something to a model: then the file is not what `bvhc build` makes of the model, and names no input.
    changed: bool,
    /// Meshes that no instance shows yet.
    unplaced: BTreeSet<u32>,
    /// How many meshes were read from a model; they are the first ones.
    of_model: usize,
    /// The number of the next place; found out once, since every place is asked for it.
    next_node: Option<u32>,
}

impl Build {
    /// One mesh in world space: `triangles` are indices into `positions`. No triangles are no error: rays miss what is built of them.
    ///
    /// # Errors
    /// Where an index is out of range or a corner is not finite.
    pub fn new(positions: &[Point], triangles: &[[u32; 3]]) -> Result<Build, GeometryError> {
        let mesh = Mesh::new(String::new(), positions.to_vec(), triangles.to_vec())?;
        Ok(Build { scene: Scene::of_mesh(mesh), ..Build::default() })
    }

    /// No mesh yet: [`Build::add_mesh`] and [`Build::add_instance`] bring them.
    pub fn empty() -> Build {
        Build::default()
    }

    /// A scene that is there already.
    ///
    /// # Errors
    /// As [`Scene::validate`].
    pub fn of_scene(scene: Scene) -> Result<Build, GeometryError> {
        scene.validate(&Executor::sequential())?;
        let vertices = has_vertices(&scene);
        let mut unplaced: BTreeSet<u32> = (0..scene.meshes.len() as u32).collect();
        scene.instances.iter().for_each(|i| _ = unplaced.remove(&i.mesh));
        unplaced.retain(|mesh| !scene.meshes[*mesh as usize].triangles.is_empty());
        let of_model = if scene.inputs.is_empty() { 0 } else { scene.meshes.len() };
        Ok(Build { scene, vertices, unplaced, of_model, ..Build::default() })
    }

    /// An OBJ or glTF model, read by the default policies.
    ///
    /// # Errors
    /// Where the model cannot be read.
    pub fn of_model(path: impl AsRef<Path>) -> Result<Build, SceneError> {
        Build::of_model_with(path, &ReadOptions::default())
    }

    /// An OBJ or glTF model, read as `options` say; with [`ReadOptions::vertices`] the file has their numbers, as by [`Build::vertices`].
    ///
    /// # Errors
    /// Where the model cannot be read.
    pub fn of_model_with(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Build, SceneError> {
        let scene = scene::read(path.as_ref(), options)?;
        let (of_model, vertices) = (scene.meshes.len(), options.vertices);
        Ok(Build { scene, read: Some(options.clone()), vertices, of_model, ..Build::default() })
    }

    /// Add a mesh, which [`Build::add_instance`] has to place. Returns its number.
    ///
    /// # Errors
    /// As [`Build::new`].
    pub fn add_mesh(
        &mut self,
        name: impl Into<String>,
        positions: &[Point],
        triangles: &[[u32; 3]],
    ) -> Result<u32, GeometryError> {
        self.add(Mesh::new(name, positions.to_vec(), triangles.to_vec())?)
    }

    /// Add a mesh that has more than a name: parts, materials, numbers of its source. [`Build::add_instance`] has to place it. Returns its number, which
    /// its parts get as [`Part::source_mesh`](crate::scene::Part::source_mesh).
    ///
    /// ```
    /// use bvhc::{Build, scene::Mesh};
    ///
    /// let mut roof = Mesh::new("roof", vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])?;
    /// roof.parts[0].material = "slate".into();
    /// let mut build = Build::empty();
    /// assert_eq!(build.add(roof)?, 0);
    /// # Ok::<(), bvhc::scene::GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Mesh::validate`].
    pub fn add(&mut self, mut mesh: Mesh) -> Result<u32, GeometryError> {
        let number = self.scene.meshes.len();
        mesh.parts.iter_mut().for_each(|part| part.source_mesh = number as u32);
        mesh.validate(number, &Executor::sequential())?;
        self.vertices |= !mesh.vertices.is_empty();
        self.scene.meshes.push(mesh);
        self.changed = true;
        self.unplaced.insert(number as u32);
        Ok(number as u32)
    }

    /// Place a mesh. Returns the number of the place, which [`Built::node`] and [`Opened::node`](crate::Opened::node) tell of a hit. Places are
    /// numbered from 0; in a model that was read, behind its nodes.
    ///
    /// # Errors
    /// Where there is no such mesh, the transform is not finite or has no inverse, or no number is left behind those of the model's nodes.
    pub fn add_instance(&mut self, mesh: u32, object_to_world: Affine) -> Result<u32, GeometryError> {
        let (instance, meshes) = (self.scene.instances.len(), self.scene.meshes.len());
        if mesh as usize >= meshes {
            return Err(GeometryError::MeshOutOfRange { instance, mesh, meshes });
        }
        validate_transform(instance, &object_to_world)?;
        let name = self.scene.meshes[mesh as usize].name.clone();
        let nodes = || self.scene.instances.iter().map(|i| i.node).filter(|node| *node != Instance::NO_NODE);
        let node = self.next_node.unwrap_or_else(|| nodes().max().map_or(0, |last| last + 1));
        if node == Instance::NO_NODE {
            return Err(GeometryError::NoNode { largest: node - 1 });
        }
        self.next_node = Some(node + 1);
        self.scene.instances.push(Instance { mesh, transform: object_to_world, node, name });
        self.changed = true;
        self.unplaced.remove(&mesh);
        Ok(node)
    }

    /// How good the trees shall be, and how long they may take; the default is [`Preset::Auto`].
    ///
    /// A preset and [`Build::options`] exclude each other, since either says everything: [`Build::run`] refuses both, in whatever order.
    pub fn preset(self, preset: Preset) -> Build {
        Build { preset: Some(preset), ..self }
    }

    /// Every choice by itself, in the place of a preset.
    ///
    /// ```
    /// use bvhc::{Build, build::{BuildOptions, Method, Preset}};
    ///
    /// let sweep = BuildOptions { method: Method::Sweep, reinsert: 8, ..BuildOptions::preset(Preset::Draft) };
    /// let triangle = Build::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
    /// triangle.clone().options(sweep.clone()).run()?;
    ///
    /// // Sweep trees have no bins: a number of them that no preset has was meant to do something.
    /// let error = triangle.options(BuildOptions { bins: 17, ..sweep }).run().unwrap_err();
    /// assert!(error.to_string().contains("method sweep does not read it"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// [`Build::run`] refuses a value that the method does not read, as [`BuildOptions::refuse_unread`] says.
    pub fn options(self, options: BuildOptions) -> Build {
        Build { options: Some(options), ..self }
    }

    /// Whether the file shall hold which vertices each triangle has: of arrays their indices into the positions, for normals and texture
    /// coordinates at a hit ([`Opened::vertices`](cache::Opened::vertices)). A model must have been read for it:
    /// [`Build::of_model_with`].
    pub fn vertices(self, vertices: bool) -> Build {
        Build { vertices, ..self }
    }

    /// Whether the file shall have compact trees beside the binary ones, for about ten more bytes a triangle: rays are traced in them then, faster and
    /// with the same answers ([`CompactTrees`](crate::trace::wide::CompactTrees)).
    pub fn compact(self, compact: bool) -> Build {
        Build { compact, ..self }
    }

    /// Whether subtrees whose boxes pay along other axes shall be [turned](crate::compile::orient_image) in the file: hits are the same, and rays find them
    /// faster. For files of one level that have no compact trees.
    pub fn orient(self, orient: bool) -> Build {
        Build { orient, ..self }
    }

    /// Threads to use; 0, the default, means one per core. The result is the same for any number.
    pub fn threads(self, threads: usize) -> Build {
        Build { threads, ..self }
    }

    /// Build.
    ///
    /// # Errors
    /// Where an option is out of its range or not read by the method, a preset and options were both given, the scene is too large, no threads
    /// can be started, a mesh was added and not placed, vertices are asked for of a model that was read without them, or no
    /// triangle is left of those that a model had or arrays were given.
    pub fn run(self) -> Result<Built, BuildError> {
        let exec = Executor::new(self.threads)?;
        self.run_on(exec, &NoProgress)
    }

    /// [`Build::run`] on given threads, watched and stopped by `progress`.
    ///
    /// # Errors
    /// As [`Build::run`], and where `progress` cancels the build.
    pub fn run_on(self, exec: Executor, progress: &dyn Progress) -> Result<Built, BuildError> {
        let options = self.recipe()?;
        let Build { mut scene, read, vertices, compact, orient, changed, unplaced, of_model, .. } = self;
        let had_triangles = scene.meshes.iter().any(|mesh| !mesh.triangles.is_empty());
        let is_model = read.is_some() || !scene.inputs.is_empty();
        let read = read.filter(|_| !changed);
        if let Some(mesh) = unplaced.first() {
            let name = scene.meshes[*mesh as usize].name.clone();
            return Err(BuildError::Unplaced { mesh: *mesh, name });
        }
        number_vertices(&mut scene, of_model, vertices)?;
        let method = options.method;
        let mut recipe =
            Recipe { method: method.to_string(), builder_revision: options.revision(), options: options.effective() };
        // A model's file is the same as the program's, so that `bvhc build` finds it up to date. Arrays were not read by any policy.
        match read {
            Some(read) => recipe.options.extend(ReadOptions { vertices, ..read }.effective()),
            None => recipe.options.extend(ReadOptions::effective_of_arrays(vertices)),
        }
        if orient {
            recipe.options.push(orient_option());
        }
        let (mut inputs, report) = (std::mem::take(&mut scene.inputs), scene.report.clone());
        if changed {
            inputs.clear();
        }
        let posed = scene.posed.iter().map(ToString::to_string).collect();
        let laid = lay_out(scene, &options, &exec)?;
        if (is_model || had_triangles) && laid.meshes.is_empty() {
            let read = report.degenerate_triangles + report.non_finite_triangles + report.out_of_range_triangles;
            return Err(BuildError::NothingLeft { read, placed: laid.placing.collapsed });
        }
        let placing = laid.placing.clone();
        let mut accel = compile_sound(laid, &options, &exec, progress)?;
        let mut notes = [posed, std::mem::take(&mut accel.notes)].concat();
        let mut image = Image::of_compiled(accel, &exec).map_err(|e| BuildError::Layout(e.to_string()))?;
        if compact {
            image.add_compact().map_err(|e| BuildError::Layout(e.to_string()))?;
        }
        if orient {
            let oriented = orient_image(&mut image, &exec).map_err(|e| BuildError::Layout(e.to_string()))?;
            notes.push(oriented.to_string());
        }
        let meta = Meta { notes, ..cache::provenance(recipe, &inputs, &report) };
        Ok(Built::new(image, meta, report, placing, exec))
    }

    /// The options of the build, which a preset or the caller has given.
    fn recipe(&self) -> Result<BuildOptions, BuildError> {
        match (self.preset, &self.options) {
            (Some(preset), Some(_)) => Err(BuildError::TwoRecipes { preset: preset.name() }),
            (preset, None) => Ok(preset.map_or_else(BuildOptions::default, BuildOptions::preset)),
            (None, Some(options)) => {
                options.refuse_unread()?;
                Ok(options.clone())
            }
        }
    }
}

fn has_vertices(scene: &Scene) -> bool {
    scene.meshes.iter().any(|mesh| !mesh.vertices.is_empty())
}

/// Give each triangle the numbers of its vertices where they are `wanted`, and take them away where they are not.
/// The first `of_model` meshes were
/// read from a model: only its reader knows theirs. Those of arrays are their indices.
fn number_vertices(scene: &mut Scene, of_model: usize, wanted: bool) -> Result<(), BuildError> {
    for (number, mesh) in scene.meshes.iter_mut().enumerate() {
        match wanted {
            false => mesh.vertices = Vec::new(),
            true if !mesh.vertices.is_empty() || mesh.triangles.is_empty() => {}
            true if number >= of_model => mesh.vertices.clone_from(&mesh.triangles),
            true => return Err(BuildError::NoVertices { mesh: number }),
        }
    }
    Ok(())
}
