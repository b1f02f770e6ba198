use super::animation::Motion;
use super::document::{Document, Mesh};
use super::morph::{Targets, WeightLists};
use super::nodes::{self, Shown};
use super::reader::Reader;
use super::skin::Skin;
use super::vertices::influences;
use crate::geom::Affine;
use crate::scene::pose::{Hierarchy, Place};
use crate::scene::{ReadReport, SceneError};
use std::collections::BTreeMap;

/// What gives a mesh its shape beside its own data: equal poses of one mesh are one mesh in the scene.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Pose {
    pub skin: Option<u32>,
    /// The node that places the primitives that no joint holds, where a skinned mesh has such.
    node: Option<u32>,
    /// The morph weights that move something, by the number of their list.
    weights: u32,
}

impl Pose {
    /// Whether the mesh is as it stands in the file.
    pub fn is_plain(&self) -> bool {
        *self == Pose::default()
    }
}

/// What can pose a mesh: looked up once, however many nodes show it.
struct Posable {
    /// How many of its primitives are surfaces, and how many of these have joints and weights.
    surfaces: usize,
    influenced: usize,
    targets: Targets,
    /// The mesh's own morph weights, and how many of them find no target.
    weights: (u32, u64),
}

impl Posable {
    fn of(mesh: &Mesh, lists: &mut WeightLists) -> Posable {
        let surfaces = || mesh.primitives.iter().filter(|p| p.surface_positions().is_some());
        let targets = Targets::of(mesh);
        let (moving, without) = targets.weigh(mesh.weights.as_deref().unwrap_or_default());
        Posable {
            surfaces: surfaces().count(),
            influenced: surfaces().filter(|p| !influences(p).is_empty()).count(),
            targets,
            weights: (lists.number(moving), without),
        }
    }
}

/// Everything that poses the meshes of a scene at one time.
pub(super) struct Stage<'m> {
    motion: &'m Motion,
    /// Each node's transform to world space.
    pub to_world: Vec<Affine>,
    /// Each joint's, from the mesh's space, by skin.
    joints: BTreeMap<u32, Vec<Affine>>,
    /// By mesh.
    posable: BTreeMap<u32, Posable>,
    weights: WeightLists,
}

impl<'m> Stage<'m> {
    /// The scene with every node where an animation moves it, or where it stands in the file. The hierarchy has all joints of the skins.
    pub fn new(
        reader: &mut Reader,
        hierarchy: &Hierarchy,
        skins: &BTreeMap<u32, Skin>,
        motion: &'m Motion,
    ) -> Result<Stage<'m>, SceneError> {
        let Reader { document, source, .. } = reader;
        let to_world = hierarchy.to_world(nodes::own_transforms(document, hierarchy, motion, source)?);
        let joints = skins.values().map(|skin| skin.joints.len()).sum::<usize>();
        source.charge((joints * size_of::<Affine>()) as u64, "the joints")?;
        let joints = skins.iter().map(|(index, skin)| (*index, skin.transforms(&to_world))).collect();
        Ok(Stage { motion, to_world, joints, posable: BTreeMap::new(), weights: WeightLists::new() })
    }

    /// How a node's mesh is posed. What cannot be posed is counted.
    pub fn pose(&mut self, document: &Document, shown: &Shown, report: &mut ReadReport) -> Pose {
        let mesh = &document.meshes[shown.mesh as usize];
        let posable = self.posable.entry(shown.mesh).or_insert_with(|| Posable::of(mesh, &mut self.weights));
        let of_animation = self.motion.of(shown.node).and_then(|moved| moved.weights.as_deref());
        let of_node = document.nodes[shown.node as usize].weights.as_deref().filter(|w| !w.is_empty());
        let (weights, unapplied) = of_animation.or(of_node).map_or(posable.weights, |given| {
            let (moving, without) = posable.targets.weigh(given);
            (self.weights.number(moving), without)
        });
        report.unapplied_morph_weights += unapplied;
        let mut pose = Pose { weights, ..Pose::default() };
        let Some(skin) = shown.skin.filter(|_| posable.surfaces > 0) else { return pose };
        let has_joints = self.joints.get(&skin).is_some_and(|j| !j.is_empty());
        let held = if has_joints { posable.influenced } else { 0 };
        let is_partly_rigid = held < posable.surfaces;
        report.unposed_skins += u64::from(is_partly_rigid);
        if held > 0 {
            let joints = self.joints.get(&skin).map_or(&[][..], Vec::as_slice);
            report.mirrored_skins += u64::from(joints.iter().all(Affine::mirrors));
            pose.skin = Some(skin);
            pose.node = is_partly_rigid.then_some(shown.node);
        }
        pose
    }

    /// The morph weights of a pose.
    pub fn weights(&self, pose: &Pose) -> &[f64] {
        self.weights.get(pose.weights)
    }

    /// What places the vertices of a mesh in this pose.
    pub fn place(&self, pose: &Pose) -> Place<'_> {
        let Some(joints) = pose.skin.and_then(|skin| self.joints.get(&skin)) else { return Place::Mesh };
        let node = pose.node.map_or(&Affine::IDENTITY, |node| &self.to_world[node as usize]);
        Place::World { joints, node }
    }
}
