use super::animation::Motion;
use super::document::{Document, Mesh};
use super::nodes::{self, Shown};
use super::skin::Skin;
use super::vertices::influences;
use crate::geom::Affine;
use crate::scene::pose::{Hierarchy, Place};
use crate::scene::source::Source;
use crate::scene::{ReadReport, SceneError};
use std::collections::BTreeMap;

/// What gives a mesh its shape beside its own data: equal poses of one mesh are one mesh in the scene.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Pose {
    pub skin: Option<u32>,
    /// The node that places the primitives that no joint holds, where a skinned mesh has such.
    node: Option<u32>,
    /// The morph weights that move something, as bits.
    weights: Vec<u64>,
}

impl Pose {
    /// Whether the mesh is as it stands in the file.
    pub fn is_plain(&self) -> bool {
        *self == Pose::default()
    }

    pub fn weights(&self) -> Vec<f64> {
        self.weights.iter().map(|bits| f64::from_bits(*bits)).collect()
    }
}

/// Everything that poses the meshes of a scene at one time.
pub(super) struct Stage<'m> {
    motion: &'m Motion,
    /// Each node's transform to world space.
    pub to_world: Vec<Affine>,
    /// Each joint's, from the mesh's space, by skin.
    joints: BTreeMap<u32, Vec<Affine>>,
}

impl<'m> Stage<'m> {
    /// The scene with every node where an animation moves it, or where it stands in the file. The hierarchy has all joints of the skins.
    pub fn new(
        document: &Document,
        hierarchy: &Hierarchy,
        skins: &BTreeMap<u32, Skin>,
        motion: &'m Motion,
        source: &mut Source,
    ) -> Result<Stage<'m>, SceneError> {
        let to_world = hierarchy.to_world(nodes::own_transforms(document, hierarchy, motion, source)?);
        let joints = skins.values().map(|skin| skin.joints.len()).sum::<usize>();
        source.charge((joints * size_of::<Affine>()) as u64, "the joints")?;
        let joints = skins.iter().map(|(index, skin)| (*index, skin.transforms(&to_world))).collect();
        Ok(Stage { motion, to_world, joints })
    }

    /// How a node's mesh is posed. What cannot be posed is counted.
    pub fn pose(&self, document: &Document, shown: &Shown, report: &mut ReadReport) -> Pose {
        let mesh = &document.meshes[shown.mesh as usize];
        let mut pose = Pose { weights: weights(document, shown, self.motion, mesh, report), ..Pose::default() };
        let surfaces = || mesh.primitives.iter().filter(|p| p.surface_positions().is_some());
        let Some(skin) = shown.skin.filter(|_| surfaces().next().is_some()) else { return pose };
        let has_joints = self.joints.get(&skin).is_some_and(|j| !j.is_empty());
        let held = surfaces().filter(|p| has_joints && !influences(p).is_empty()).count();
        let is_partly_rigid = held < surfaces().count();
        report.unposed_skins += u64::from(is_partly_rigid);
        if held > 0 {
            pose.skin = Some(skin);
            pose.node = is_partly_rigid.then_some(shown.node);
        }
        pose
    }

    /// What places the vertices of a mesh in this pose.
    pub fn place(&self, pose: &Pose) -> Place<'_> {
        let Some(joints) = pose.skin.and_then(|skin| self.joints.get(&skin)) else { return Place::Mesh };
        let node = pose.node.map_or(&Affine::IDENTITY, |node| &self.to_world[node as usize]);
        Place::World { joints, node }
    }
}

/// The morph weights that move something of a node's mesh: those of the animation, else the node's, else the mesh's. Those that find no target
/// are counted.
fn weights(document: &Document, shown: &Shown, motion: &Motion, mesh: &Mesh, report: &mut ReadReport) -> Vec<u64> {
    let of_animation = motion.of(shown.node).and_then(|moved| moved.weights.as_ref());
    let of_node = document.nodes[shown.node as usize].weights.as_ref().filter(|w| !w.is_empty());
    let given = of_animation.or(of_node).or(mesh.weights.as_ref()).map_or(&[][..], Vec::as_slice);
    let surfaces = || mesh.primitives.iter().filter(|p| p.surface_positions().is_some());
    let mut weights: Vec<u64> = Vec::with_capacity(given.len());
    for (i, weight) in given.iter().enumerate() {
        let targets = || surfaces().map(|p| p.targets.as_ref().and_then(|t| t.get(i)));
        if *weight != 0.0 && targets().any(|t| t.is_none()) {
            report.unapplied_morph_weights += 1;
        }
        let moves = *weight != 0.0 && targets().flatten().any(|t| t.contains_key("POSITION"));
        weights.push(if moves { weight.to_bits() } else { 0 });
    }
    let end = weights.iter().rposition(|bits| *bits != 0).map_or(0, |last| last + 1);
    weights.truncate(end);
    weights
}
