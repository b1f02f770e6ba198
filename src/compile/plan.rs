//! Which trees a scene becomes, and in whose coordinates: one level or two, and about which origins, so that 32 bits hold every shape.
//!
//! Storing a corner rounds it. Near the origin that is nothing; a few hundred kilometres from it floats are centimetres apart, and a mesh of small
//! triangles that is put there by baking is no longer that mesh. [`Loss`] measures it. What would lose more than [`Loss::MOST`] is baked about a
//! place beside it instead, and an instance, which is a translation of whole floats then, puts the tree there: nothing is lost, since rays come into
//! the tree's coordinates in `f64`.

use super::LaidOut;
use super::place::{Grain, mesh_box, vertex, world_box};
use crate::build::Levels;
use crate::geom::Affine;
use crate::scene::{Bounds, Instance, Loss, Mesh, Scene, is_collinear, local_origin};

/// What the trees hold. Instances are numbered without those that show no triangle.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Plan {
    /// One tree over all instances, in the world.
    One,
    /// A tree for each group: its instances baked together about its origin.
    Groups(Vec<Group>),
    /// A tree for each mesh in its own coordinates, and the instances' matrices. `apart` has an origin for each instance whose matrix 32 bits do not hold
    /// well enough: it is baked about that origin. Where its mesh stands elsewhere too, that is a copy, and only made where no shift of the mesh could help.
    Meshes { apart: Vec<Option<[f64; 3]>> },
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Group {
    pub origin: [f64; 3],
    /// Ascending.
    pub instances: Vec<usize>,
}

/// Triangles that the whole measuring may look at, and fewest for each instance.
const WORK: usize = 1 << 20;
const LEAST: usize = 64;

/// Triangles of each of so many instances to look at.
pub(super) fn sample(instances: usize) -> usize {
    (WORK / instances.max(1)).clamp(LEAST, Loss::SAMPLE)
}

/// Origins that are tried for what does not fit the first ones, before everything gets its own.
const ROUNDS: usize = 32;

impl Plan {
    pub fn of(scene: &Scene, levels: Levels) -> Plan {
        let visible: Vec<(&Instance, &Mesh)> = visible(scene).collect();
        let mut uses = vec![0u32; scene.meshes.len()];
        visible.iter().for_each(|(i, _)| uses[i.mesh as usize] = uses[i.mesh as usize].saturating_add(1));
        let is_shared = uses.iter().any(|n| *n > 1);
        match levels {
            Levels::One => Plan::One,
            Levels::Auto if !is_shared => groups(&visible),
            Levels::Auto | Levels::Two => {
                let mut grains: Vec<Option<Grain>> = scene.meshes.iter().map(|_| None).collect();
                let own: usize = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
                let mut copies = own.max(WORK);
                let apart = visible.iter().map(|(instance, mesh)| {
                    let grain = grains[instance.mesh as usize].get_or_insert_with(|| Grain::new(mesh));
                    let by_matrix = grain.loss_by_matrix(&instance.transform);
                    (!by_matrix.is_tolerable()).then_some(())?;
                    let is_shared = uses[instance.mesh as usize] > 1;
                    if is_shared {
                        let turned = grain.loss_by_matrix(&without_translation(&instance.transform));
                        let no_shift_helps = !turned.is_tolerable() || instance.transform.is_nearly_flat();
                        (no_shift_helps && mesh.triangles.len() <= copies).then_some(())?;
                    }
                    let origin = local_origin(world_box(&grain.bounds, &instance.transform));
                    let is_better = by_matrix.is_more_than(&loss_about(instance, mesh, origin, Loss::SAMPLE));
                    copies -= if is_shared && is_better { mesh.triangles.len() } else { 0 };
                    is_better.then_some(origin)
                });
                Plan::Meshes { apart: apart.collect() }
            }
        }
    }

    /// In words, why trees have origins of their own; empty where none has.
    pub fn notes(&self) -> Vec<String> {
        let shown = |o: &[f64; 3]| format!("({}, {}, {})", o[0], o[1], o[2]);
        let (origins, all): (Vec<String>, usize) = match self {
            Plan::One => return Vec::new(),
            Plan::Groups(groups) => {
                let moved = groups.iter().map(|g| &g.origin).filter(|o| **o != [0.0; 3]);
                (moved.map(shown).collect(), groups.len())
            }
            Plan::Meshes { apart } => {
                let moved = apart.iter().flatten().filter(|o| **o != [0.0; 3]);
                (moved.map(shown).collect(), apart.len())
            }
        };
        let some = match &origins[..] {
            [] => return Vec::new(),
            [a, b, c, _, _, ..] => format!("{a}, {b}, {c} and {} more", origins.len() - 3),
            few => few.join(", "),
        };
        let trees =
            if origins.len() == all { "trees are".to_string() } else { format!("{} of the trees are", origins.len()) };
        vec![format!("levels: {trees} about origins of their own, since 32 bits lose the shape elsewhere: {some}")]
    }
}

fn without_translation(transform: &Affine) -> Affine {
    Affine { rows: transform.rows.map(|[x, y, z, _]| [x, y, z, 0.0]) }
}

/// The instances that show a triangle, with their meshes.
pub(super) fn visible(scene: &Scene) -> impl Iterator<Item = (&Instance, &Mesh)> {
    let shown = |i: &Instance| scene.meshes.get(i.mesh as usize).filter(|m| !m.triangles.is_empty());
    scene.instances.iter().filter_map(move |i| shown(i).map(|mesh| (i, mesh)))
}

/// One tree in the world if everything keeps its shape there, else as few trees as it takes, each about an origin that suits its instances.
fn groups(visible: &[(&Instance, &Mesh)]) -> Plan {
    let sample = sample(visible.len());
    let keeps = |i: &usize, origin: [f64; 3]| {
        let (instance, mesh) = visible[*i];
        loss_about(instance, mesh, origin, sample).is_tolerable()
    };
    let mut groups: Vec<Group> = Vec::new();
    let mut rest: Vec<usize> = (0..visible.len()).collect();
    for _ in 0..ROUNDS {
        let taken_about = |origin| rest.iter().copied().partition::<Vec<usize>, _>(|i| keeps(i, origin));
        let in_world = taken_about([0.0; 3]);
        if in_world.1.is_empty() && groups.is_empty() {
            return Plan::One;
        }
        let size = |some: &[usize]| some.iter().map(|i| visible[*i].1.triangles.len()).sum::<usize>();
        let (mut origin, mut taken, mut left) = ([0.0; 3], in_world.0, in_world.1);
        for other in [common_origin(&rest, visible), common_origin(&rest[..1], visible)] {
            let beside = taken_about(other);
            if size(&beside.0) > size(&taken) {
                (origin, (taken, left)) = (other, beside);
            }
        }
        if taken.is_empty() {
            break;
        }
        match groups.iter_mut().find(|g| g.origin == origin) {
            Some(group) => group.instances.extend(taken),
            None => groups.push(Group { origin, instances: taken }),
        }
        rest = left;
        if rest.is_empty() {
            break;
        }
    }

    // What fits nowhere together stands alone where that helps, and else where it would have stood.
    let mut helpless = Vec::new();
    for i in rest {
        let (instance, mesh) = visible[i];
        let own = common_origin(&[i], visible);
        let loss = |origin| loss_about(instance, mesh, origin, sample);
        match loss([0.0; 3]).is_more_than(&loss(own)) {
            true => groups.push(Group { origin: own, instances: vec![i] }),
            false => helpless.push(i),
        }
    }
    if !helpless.is_empty() {
        match groups.iter_mut().find(|g| g.origin == [0.0; 3]) {
            Some(world) => world.instances.extend(helpless),
            None => groups.push(Group { origin: [0.0; 3], instances: helpless }),
        }
    }
    groups.iter_mut().for_each(|g| g.instances.sort_unstable());
    groups.sort_by_key(|g| g.instances[0]);
    match &groups[..] {
        [] => Plan::One,
        [only] if only.origin == [0.0; 3] => Plan::One,
        _ => Plan::Groups(groups),
    }
}

/// An origin for all of these: that of a translation if it alone places them, else one near the middle of their box.
fn common_origin(some: &[usize], visible: &[(&Instance, &Mesh)]) -> [f64; 3] {
    if let [only] = some
        && let Some(origin) = whole_translation(&visible[*only].0.transform)
    {
        return origin;
    }
    let world_box = |i: &usize| world_box(&mesh_box(visible[*i].1), &visible[*i].0.transform);
    local_origin(some.iter().map(world_box).fold(Bounds::EMPTY, Bounds::union))
}

/// The translation that a matrix is, if it is nothing else and 32 bits hold it.
fn whole_translation(transform: &Affine) -> Option<[f64; 3]> {
    let origin = [0, 1, 2].map(|a| transform.rows[a][3]);
    let is_whole = *transform == Affine::translation(origin) && origin.iter().all(|c| f64::from(*c as f32) == *c);
    is_whole.then_some(origin)
}

/// What baking an instance about an origin costs.
pub(super) fn loss_about(instance: &Instance, mesh: &Mesh, origin: [f64; 3], most: usize) -> Loss {
    let to_tree = instance.transform.about(origin);
    if to_tree == Affine::IDENTITY {
        return Loss::default();
    }
    let exact = |v: u32| to_tree.transform_point(vertex(mesh, v).map(f64::from));
    Loss::of(&mesh.triangles, most, exact, |v| to_tree.bake(vertex(mesh, v)).map(f64::from))
}

/// Move the coordinates of meshes that stand in several places so that their matrices are closer to what 32 bits hold, where one shift does
/// that for all of a mesh's instances; return what is lost then by the mesh that loses most.
pub(super) fn shift_meshes(laid: &mut LaidOut) -> Loss {
    let mut worst = Loss::default();
    let Some(instances) = &mut laid.instances else { return worst };
    let mut of_mesh: Vec<Vec<usize>> = vec![Vec::new(); laid.meshes.len()];
    instances.iter().enumerate().for_each(|(i, instance)| of_mesh[instance.mesh as usize].push(i));
    for (mesh, of_mesh) in laid.meshes.iter_mut().zip(of_mesh) {
        let more = |a: Loss, b: Loss| if b.is_more_than(&a) { b } else { a };
        let loss = |grain: &Grain, transforms: &[Affine]| {
            transforms.iter().map(|t| grain.loss_by_matrix(t)).reduce(more).unwrap_or_default()
        };
        let transforms: Vec<Affine> = of_mesh.iter().map(|i| instances[*i].transform).collect();
        let mut grain = Grain::new(mesh);
        let mut least = loss(&grain, &transforms);
        if !least.is_tolerable()
            && let Some(shift) = transforms.iter().find_map(shift_to_floats)
        {
            let by = Affine::translation(shift.map(|c| -c));
            let positions = (0..mesh.positions.len()).map(|v| mesh.baked_position(v, &by)).collect();
            let moved = Mesh { positions, remainders: Vec::new(), ..mesh.clone() };
            let placed: Vec<Affine> = transforms.iter().map(|t| t.then_inner(&Affine::translation(shift))).collect();
            // The triangles are as small as they were; what rounding makes of them is lost as well.
            grain.bounds = mesh_box(&moved);
            let stored = |v: u32| vertex(&moved, v).map(f64::from);
            let exact = |v: u32| by.transform_point(vertex(mesh, v).map(f64::from));
            let then = more(loss(&grain, &placed), Loss::of(&mesh.triangles, usize::MAX, exact, stored));
            let keeps = |t: usize| !is_collinear(moved.corners(t)) || is_collinear(mesh.corners(t));
            if least.is_more_than(&then) && (0..mesh.triangles.len()).all(keeps) {
                (*mesh, least) = (moved, then);
                of_mesh.iter().zip(placed).for_each(|(i, t)| instances[*i].transform = t);
            }
        }
        if least.is_more_than(&worst) {
            worst = least;
        }
    }
    worst
}

/// The shift of a mesh's coordinates that turns a matrix's translation into floats; `None` where it is such already.
fn shift_to_floats(transform: &Affine) -> Option<[f64; 3]> {
    let off = [0, 1, 2].map(|a| f64::from(transform.rows[a][3] as f32) - transform.rows[a][3]);
    (off != [0.0; 3]).then(|| transform.inverse().map(|inverse| inverse.transform_vector(off)))?
}
