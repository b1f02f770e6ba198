//! A whole scene: decide between one level and two, build every tree, and hand over what a cache file stores.

mod bake;
mod orient;
mod place;
mod plan;
mod told_apart;
mod tree;

pub(crate) use self::orient::orient_option;
pub use self::orient::{Oriented, bytes_to_orient, orient_image, segments};
pub(crate) use self::tree::decide_sound;
pub use self::tree::{build_tree, decide_tree};

use self::bake::{Baked, bake, counts, drop_collapsed};
use self::plan::{Plan, loss_about, shift_meshes, visible};
use crate::build::{self, BuildError, BuildOptions, Progress, Remedy, tlas};
use crate::exec::Executor;
use crate::geom::{Aabb, Affine};
use crate::scene::{Instance, Loss, Mesh, Part, Scene, renumber, retain_numbered, validate_placed};
use crate::search;
use crate::tree::{Accel, Tree};

/// Most instances of a two-level file.
const MAX_INSTANCES: u64 = 1 << 24;

/// Triangles that [`compile`] will report through [`Progress::advance`].
pub fn primitives_to_build(scene: &Scene, options: &BuildOptions) -> u64 {
    primitives(scene, &Plan::of(scene, options.levels))
}

fn primitives(scene: &Scene, plan: &Plan) -> u64 {
    match plan {
        Plan::One | Plan::Groups(_) => visible(scene).map(|(_, mesh)| triangles(mesh)).sum(),
        Plan::Meshes { .. } => {
            let used = used_meshes(scene);
            scene.meshes.iter().zip(used).filter(|(_, used)| *used).map(|(mesh, _)| triangles(mesh)).sum()
        }
    }
}

/// Bytes that [`compile`] sets aside before it builds, which nothing in the model's own size bounds: the copies that
/// flattening makes, and the references with their duplicates. The nodes come on top, about as much again.
pub fn bytes_to_reserve(scene: &Scene, options: &BuildOptions) -> u64 {
    bytes_by_plan(scene, &Plan::of(scene, options.levels), options)
}

fn bytes_by_plan(scene: &Scene, plan: &Plan, options: &BuildOptions) -> u64 {
    if options.method.is_search() {
        let of_one = |recipe: BuildOptions| bytes_by_plan(scene, plan, &recipe);
        return search::candidates(options).into_iter().map(of_one).max().unwrap_or(0);
    }
    let triangles = usize::try_from(primitives(scene, plan)).unwrap_or(usize::MAX);
    let copied = match plan {
        Plan::One | Plan::Groups(_) if scene.instances.len() > 1 => {
            visible(scene).fold(0u64, |sum, (_, mesh)| sum.saturating_add(bake::bytes_of_copy(mesh)))
        }
        _ => 0,
    };
    build::bytes_to_reserve(triangles, options).saturating_add(copied)
}

/// Build the scene's trees.
///
/// The result depends on `scene` and `options` alone, not on the executor. Meshes that no instance names and instances
/// of meshes without triangles hold nothing that a ray can hit: they are left out, and the others keep their order.
///
/// An option that the method does not read changes nothing here; [`BuildOptions::refuse_unread`] tells of it.
pub fn compile(
    scene: Scene,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Accel, BuildError> {
    compile_sound(lay_out(scene, options, exec)?, options, exec, progress)
}

/// The rest of [`compile`] after [`lay_out`].
///
/// # Errors
/// Where what [`lay_out`] gave was changed into what breaks [`Mesh::validate`] or [`Scene::validate`]; else as [`compile`].
pub fn compile_laid_out(
    laid: LaidOut,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Accel, BuildError> {
    laid.validate(exec)?;
    compile_sound(laid, options, exec, progress)
}

/// [`compile_laid_out`] of what nobody changed since. Every way to a tree leads through here, so that options are asked in this place.
pub(crate) fn compile_sound(
    laid: LaidOut,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Accel, BuildError> {
    options.validate()?;
    let LaidOut { meshes, instances, placing } = laid;
    let mut accel = match instances {
        None => one_level(meshes, options, exec, progress)?,
        Some(instances) => two_levels(meshes, instances, options, exec, progress)?,
    };
    accel.notes.extend(placing.notes);
    Ok(accel)
}

/// The geometry that a scene's trees index.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct LaidOut {
    /// One for each BLAS, in their order.
    pub meshes: Vec<Mesh>,
    /// What the TLAS's references index; `None` for one level, which has at most one mesh, in world space.
    pub instances: Option<Vec<Instance>>,
    /// What the geometry lost on the way.
    pub placing: Placing,
}

impl LaidOut {
    /// Its fields can be changed after [`lay_out`], so they are asked again what they rely on.
    fn validate(&self, exec: &Executor) -> Result<(), BuildError> {
        match &self.instances {
            None if self.meshes.len() > 1 => Err(BuildError::OneLevel { meshes: self.meshes.len() }),
            None => self.meshes.iter().try_for_each(|mesh| Ok(mesh.validate(0, exec)?)),
            Some(instances) => Ok(validate_placed(&self.meshes, instances, exec)?),
        }
    }
}

/// What putting the meshes where their instances stand cost.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Placing {
    /// Triangles that had an area in their mesh and have none where they stand. They are left out or stay as [`Scene::degenerate`] says.
    pub collapsed: u64,
    /// How far rounding moves corners, of the instance that it costs most. Where it is a matrix that is rounded, in the mesh's own unit.
    pub loss: Loss,
    /// Why trees have origins of their own, for people.
    pub notes: Vec<String>,
}

/// [`compile`] without the trees: what a file of this scene holds, to build over or to compare a file with.
pub fn lay_out(mut scene: Scene, options: &BuildOptions, exec: &Executor) -> Result<LaidOut, BuildError> {
    scene.validate(exec)?;
    scene.meshes.iter_mut().filter(|mesh| !mesh.triangles.is_empty()).for_each(cover_with_parts);
    told_apart::number(&mut scene);
    let without_numbers = |mesh: &Mesh| mesh.vertices.is_empty() && !mesh.triangles.is_empty();
    if scene.meshes.iter().any(|mesh| !mesh.vertices.is_empty())
        && let Some(mesh) = scene.meshes.iter().position(without_numbers)
    {
        return Err(BuildError::NoVertices { mesh });
    }
    let plan = Plan::of(&scene, options.levels);
    let policy = scene.degenerate;
    let (mut meshes, instances) = keep_visible(scene);
    if instances.is_empty() {
        return Ok(LaidOut::default());
    }
    let mut placing = Placing { notes: plan.notes(), ..Placing::default() };
    let mut merge = |some: &[&Instance], origin: [f64; 3], told: bool, meshes: &mut [Mesh]| {
        // Asked before anything looks at every instance.
        counts(meshes, some)?;
        placing.note(worst_about(some, meshes, origin));
        match exec.run(|| bake(meshes, some, origin, told, exec))? {
            // It has lost nothing.
            Baked::Taken(mesh) => Ok(mesh),
            Baked::Moved(mut mesh) => {
                placing.collapsed += exec.run(|| drop_collapsed(&mut mesh, meshes, some, policy, exec))?;
                Ok::<Mesh, BuildError>(mesh)
            }
        }
    };
    let laid = match plan {
        Plan::One => {
            let all: Vec<&Instance> = instances.iter().collect();
            let mesh = merge(&all, [0.0; 3], false, &mut meshes)?;
            LaidOut { meshes: vec![mesh], instances: None, placing }
        }
        Plan::Groups(groups) => {
            let told = instances.len() > 1;
            let (mut merged, mut places) = (Vec::new(), Vec::new());
            for group in &groups {
                let some: Vec<&Instance> = group.instances.iter().map(|i| &instances[*i]).collect();
                merged.push(merge(&some, group.origin, told, &mut meshes)?);
                some.iter().for_each(|i| meshes[i.mesh as usize] = Mesh::default());
                let (node, name) = match some[..] {
                    [only] => (only.node, only.name.clone()),
                    _ => (Instance::NO_NODE, String::new()),
                };
                let (mesh, transform) = (places.len() as u32, Affine::translation(group.origin));
                places.push(Instance { mesh, transform, node, name });
            }
            LaidOut { meshes: merged, instances: Some(places), placing }
        }
        Plan::Meshes { apart } => {
            let mut instances = instances;
            let mut uses = vec![0u32; meshes.len()];
            instances.iter().for_each(|i| uses[i.mesh as usize] = uses[i.mesh as usize].saturating_add(1));
            for (instance, origin) in instances.iter_mut().zip(apart) {
                let Some(origin) = origin else { continue };
                let mesh = merge(&[instance], origin, true, &mut meshes)?;
                instance.transform = Affine::translation(origin);
                let others = &mut uses[instance.mesh as usize];
                *others = others.saturating_sub(1);
                match others {
                    0 => meshes[instance.mesh as usize] = mesh,
                    _ => {
                        instance.mesh = meshes.len() as u32;
                        meshes.push(mesh);
                    }
                }
            }
            let mut laid = LaidOut { meshes, instances: Some(instances), placing };
            let loss = shift_meshes(&mut laid);
            laid.placing.note(loss);
            laid
        }
    };
    Ok(without_empty(laid))
}

/// What baking costs the instance that loses most; told from all its triangles where that is much.
fn worst_about(instances: &[&Instance], meshes: &[Mesh], origin: [f64; 3]) -> Loss {
    let loss = |i: &Instance, most: usize| loss_about(i, &meshes[i.mesh as usize], origin, most);
    let sample = plan::sample(instances.len());
    let losses = instances.iter().map(|i| (i, loss(i, sample)));
    match losses.reduce(|a, b| if b.1.is_more_than(&a.1) { b } else { a }) {
        Some((i, worst)) if !worst.is_tolerable() => loss(i, usize::MAX),
        Some((_, worst)) => worst,
        None => Loss::default(),
    }
}

impl Placing {
    fn note(&mut self, loss: Loss) {
        if loss.is_more_than(&self.loss) || self.loss == Loss::default() {
            self.loss = loss;
        }
    }
}

/// Leave out meshes that lost all their triangles, with their instances.
fn without_empty(laid: LaidOut) -> LaidOut {
    let LaidOut { mut meshes, instances, placing } = laid;
    let numbers = renumber(meshes.iter().map(|m| !m.triangles.is_empty()));
    retain_numbered(&mut meshes, &numbers);
    let instances = instances.map(|all| instances_of(all, &numbers)).filter(|some| !some.is_empty());
    LaidOut { meshes, instances, placing }
}

/// The instances of the meshes that have a new number, by that.
fn instances_of(instances: Vec<Instance>, numbers: &[Option<u32>]) -> Vec<Instance> {
    instances.into_iter().filter_map(|i| numbers[i.mesh as usize].map(|mesh| Instance { mesh, ..i })).collect()
}

fn triangles(mesh: &Mesh) -> u64 {
    mesh.triangles.len() as u64
}

fn used_meshes(scene: &Scene) -> Vec<bool> {
    let mut used = vec![false; scene.meshes.len()];
    for i in &scene.instances {
        if let Some(u) = used.get_mut(i.mesh as usize) {
            *u = true;
        }
    }
    used
}

/// The meshes that some instance shows, the instances that show something, and both renumbered to each other.
fn keep_visible(scene: Scene) -> (Vec<Mesh>, Vec<Instance>) {
    let used = used_meshes(&scene);
    let Scene { mut meshes, instances, .. } = scene;
    let numbers = renumber(meshes.iter().zip(used).map(|(mesh, used)| used && !mesh.triangles.is_empty()));
    retain_numbered(&mut meshes, &numbers);
    (meshes, instances_of(instances, &numbers))
}

/// A mesh made by hand may name no parts; the file's tables want every triangle in one.
fn cover_with_parts(mesh: &mut Mesh) {
    if mesh.parts.is_empty() {
        let triangle_count = mesh.triangles.len() as u32;
        let prim_count = mesh.source_prims.iter().max().map_or(triangle_count, |last| last.saturating_add(1));
        mesh.parts.push(Part { name: mesh.name.clone(), triangle_count, prim_count, ..Part::default() });
    }
}

fn one_level(
    meshes: Vec<Mesh>,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Accel, BuildError> {
    let built = meshes.iter().map(|mesh| decide_sound(mesh, options, exec, progress)).collect::<Result<Vec<_>, _>>()?;
    let (blases, choices): (_, Vec<_>) = built.into_iter().unzip();
    let notes = search::notes(&choices.into_iter().flatten().collect::<Vec<_>>());
    Ok(Accel { meshes, blases, tlas: None, instances: Vec::new(), notes })
}

fn two_levels(
    meshes: Vec<Mesh>,
    instances: Vec<Instance>,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Accel, BuildError> {
    let needed = instances.len() as u64;
    if needed > MAX_INSTANCES {
        return Err(BuildError::TooLarge {
            what: "a tree over the instances",
            needed,
            limit: MAX_INSTANCES,
            remedy: Remedy::SplitScene,
        });
    }

    // Start with the largest meshes, so that no thread is left alone with one at the end.
    let mut order: Vec<usize> = (0..meshes.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(meshes[i].triangles.len()));
    let trees = exec.map(order, |_, i| {
        if progress.is_cancelled() {
            return Err(BuildError::Cancelled);
        }
        decide_sound(&meshes[i], options, exec, progress).map(|(tree, choice)| (i, tree, choice))
    });
    let mut blases = vec![Tree::default(); meshes.len()];
    let mut choices = vec![None; meshes.len()];
    for result in trees {
        let (i, tree, choice) = result?;
        (blases[i], choices[i]) = (tree, choice);
    }
    let notes = search::notes(&choices.into_iter().flatten().collect::<Vec<_>>());

    let boxes = world_boxes(&instances, &blases)?;
    let tlas = tlas::build(&boxes, exec);
    Ok(Accel { meshes, blases, tlas: Some(tlas), instances, notes })
}

/// Each instance's box in world space, by the transform as the file will hold it.
fn world_boxes(instances: &[Instance], blases: &[Tree]) -> Result<Vec<Aabb>, BuildError> {
    let world_box = |(index, instance): (usize, &Instance)| {
        let rounded = Affine::from_f32(&instance.transform.to_f32());
        let bounds = rounded.transform_box(&blases[instance.mesh as usize].bounds());
        if bounds.is_valid() {
            Ok(bounds)
        } else {
            Err(BuildError::OutOfRange { instance: index, mesh: instance.mesh })
        }
    };
    instances.iter().enumerate().map(world_box).collect()
}
