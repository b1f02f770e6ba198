//! A whole scene: decide between one level and two, build every tree, and hand over what a cache file stores.

mod bake;
pub mod tlas;

use self::bake::bake;
use crate::build::agglomerative;
use crate::build::decide_tree;
use crate::build::error::{BuildError, Remedy};
use crate::build::presplit;
use crate::build::prim_ref::PrimRef;
use crate::build::progress::Progress;
use crate::build::recipe::options::{BuildOptions, Levels, Method};
use crate::build::search;
use crate::build::spatial::budgeted_slots;
use crate::build::sweep;
use crate::exec::Executor;
use crate::geom::{Aabb, Affine};
use crate::scene::{Instance, Mesh, Part, Scene};
use crate::tree::{Accel, Tree};

/// Most instances of a two-level file.
pub const MAX_INSTANCES: u64 = 1 << 24;

/// How many levels a scene is built with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plan {
    One,
    Two,
}

/// Triangles that [`compile`] will report through [`Progress::advance`].
pub fn primitives_to_build(scene: &Scene, options: &BuildOptions) -> u64 {
    match plan(scene, options) {
        Plan::One => scene.instances.iter().filter_map(|i| scene.meshes.get(i.mesh as usize)).map(triangles).sum(),
        Plan::Two => {
            let used = used_meshes(scene);
            scene.meshes.iter().zip(used).filter(|(_, used)| *used).map(|(mesh, _)| triangles(mesh)).sum()
        }
    }
}

/// Bytes that [`compile`] sets aside before it builds, which nothing in the model's own size bounds: the copies that
/// flattening makes, and the references with their duplicates. The nodes come on top, about as much again.
pub fn bytes_to_reserve(scene: &Scene, options: &BuildOptions) -> u64 {
    if options.method.is_search() {
        let of_one = |recipe: BuildOptions| bytes_to_reserve(scene, &recipe);
        return search::candidates(options).into_iter().map(of_one).max().unwrap_or(0);
    }
    let triangles = usize::try_from(primitives_to_build(scene, options)).unwrap_or(usize::MAX);
    let references = match options.method {
        Method::Sbvh => budgeted_slots(triangles, options.split_budget),
        _ => presplit::budgeted(triangles, options.presplit),
    };
    let beside = match options.method {
        Method::Sweep => sweep::BYTES_PER_REF,
        Method::Agglomerative => agglomerative::BYTES_PER_REF,
        Method::Binned | Method::Bonsai | Method::Sbvh | Method::Auto | Method::Best => 0,
    };
    let of_references = (references as u64).saturating_mul(size_of::<PrimRef>() as u64 + beside);
    let copied = match plan(scene, options) {
        Plan::One if scene.instances.len() > 1 => {
            let shown = scene.instances.iter().filter_map(|i| scene.meshes.get(i.mesh as usize));
            shown.fold(0u64, |sum, mesh| sum.saturating_add(bake::bytes_of_copy(mesh)))
        }
        _ => 0,
    };
    of_references.saturating_add(copied)
}

/// Build the scene's trees.
///
/// The result depends on `scene` and `options` alone, not on the executor. Meshes that no instance names and instances
/// of meshes without triangles hold nothing that a ray can hit: they are left out, and the others keep their order.
pub fn compile(
    scene: Scene,
    options: &BuildOptions,
    exec: &Executor,
    progress: &dyn Progress,
) -> Result<Accel, BuildError> {
    options.validate()?;
    let LaidOut { meshes, instances } = lay_out(scene, options, exec)?;
    match instances {
        None => one_level(meshes, options, exec, progress),
        Some(instances) => two_levels(meshes, instances, options, exec, progress),
    }
}

/// The geometry that a scene's trees index.
#[derive(Clone, Debug, Default)]
pub struct LaidOut {
    /// One for each BLAS, in their order.
    pub meshes: Vec<Mesh>,
    /// What the TLAS's references index; `None` for one level, which has at most one mesh, in world space.
    pub instances: Option<Vec<Instance>>,
}

/// [`compile`] without the trees: what a file of this scene holds, to build over or to compare a file with.
pub fn lay_out(scene: Scene, options: &BuildOptions, exec: &Executor) -> Result<LaidOut, BuildError> {
    let plan = plan(&scene, options);
    scene.validate(exec)?;
    let (meshes, instances) = keep_visible(scene);
    match plan {
        _ if instances.is_empty() => Ok(LaidOut::default()),
        Plan::One => {
            let mesh = exec.run(|| bake(meshes, &instances, exec))?;
            Ok(LaidOut { meshes: vec![mesh], instances: None })
        }
        Plan::Two => Ok(LaidOut { meshes, instances: Some(instances) }),
    }
}

fn plan(scene: &Scene, options: &BuildOptions) -> Plan {
    match options.levels {
        Levels::One => Plan::One,
        Levels::Two => Plan::Two,
        Levels::Auto => {
            let mut uses = vec![0u32; scene.meshes.len()];
            for i in &scene.instances {
                if let Some(n) = uses.get_mut(i.mesh as usize) {
                    *n = n.saturating_add(1);
                }
            }
            let shared = uses.iter().zip(&scene.meshes).any(|(&n, mesh)| n > 1 && !mesh.triangles.is_empty());
            if shared { Plan::Two } else { Plan::One }
        }
    }
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
    let count = scene.meshes.len();
    let used = used_meshes(&scene);
    let mut renumbered = vec![None; count];
    let mut meshes = Vec::new();
    for (old, mut mesh) in scene.meshes.into_iter().enumerate() {
        if used[old] && !mesh.triangles.is_empty() {
            renumbered[old] = Some(meshes.len() as u32);
            cover_with_parts(&mut mesh);
            meshes.push(mesh);
        }
    }
    let instances = scene
        .instances
        .into_iter()
        .filter_map(|i| renumbered[i.mesh as usize].map(|mesh| Instance { mesh, ..i }))
        .collect();
    (meshes, instances)
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
    let built = meshes.iter().map(|mesh| decide_tree(mesh, options, exec, progress)).collect::<Result<Vec<_>, _>>()?;
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
        decide_tree(&meshes[i], options, exec, progress).map(|(tree, choice)| (i, tree, choice))
    });
    let mut blases = vec![Tree::default(); meshes.len()];
    let mut choices = vec![None; meshes.len()];
    for result in trees {
        let (i, tree, choice) = result?;
        (blases[i], choices[i]) = (tree, choice);
    }
    let notes = search::notes(&choices.into_iter().flatten().collect::<Vec<_>>());

    let boxes = world_boxes(&instances, &blases)?;
    let tlas = exec.run(|| tlas::build(&boxes));
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
