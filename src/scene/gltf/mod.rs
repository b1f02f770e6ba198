//! glTF 2.0: `.gltf` with embedded or external buffers, and `.glb`.
//!
//! The structures are our own (`document`): those of the crates that read glTF round node transforms to `f32`, refuse whole numbers
//! that are written as `1.0`, or refuse quantized positions. Every index, offset and count is checked here where it is used, and only
//! what the chosen scene shows is read: a broken material, texture or animation does not matter.
//!
//! ```text
//! container ─▶ document ─▶ nodes: what is shown ─▶ pose ─▶ primitive: meshes ◀─ vertices ◀─ accessor ◀─ buffers ◀─ reference
//!                          animation: what moves ──┘
//! ```
//!
//! A [`Model`] is read once, and stands at rest or as an animation moves it at one time: nodes by their own transforms, skinned meshes by their joints,
//! morph targets by the weights of animation, node or mesh.

mod accessor;
mod animation;
mod buffers;
mod container;
mod data_uri;
mod document;
mod extensions;
mod instancing;
mod morph;
mod nodes;
mod pose;
mod present;
mod primitive;
mod reader;
mod reference;
mod skin;
mod vertices;
mod whole;

#[cfg(any(feature = "cli", test))]
pub use extensions::{EXTENSIONS, Treatment};

use super::animation::{Animation, AnimationChoice, Posed, Seconds};
use super::rounded_before::worst_rounding;
use super::source::Source;
use super::{Instance, Scene, SceneError};
use crate::geom::Affine;
use animation::{Motion, Playable, Scope};
use buffers::Buffers;
use document::Document;
use nodes::{Layout, Shown};
use pose::{Pose, Stage};
use primitive::PosedMesh;
use reader::Reader;
use skin::Skin;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Read the scene that the options ask for: at rest, or at a moment of an animation.
pub(super) fn parse(bytes: Vec<u8>, source: &mut Source) -> Result<Scene, SceneError> {
    let (mut model, options) = (Model::read(&bytes, source)?, source.options);
    match &options.moment {
        None => model.at_rest(source),
        Some(moment) => {
            let animation = model.animation(&moment.animation, source)?;
            model.at(&animation, moment.time.unwrap_or(animation.first_key()), source)
        }
    }
}

/// The animations of a model.
pub(super) fn animations(bytes: Vec<u8>, source: &mut Source) -> Result<Vec<Animation>, SceneError> {
    Model::read(&bytes, source)?.animations(source)
}

/// A model and the animation that it is posed by.
pub(super) struct Played<'b> {
    model: Model<'b>,
    playable: Playable,
}

impl<'b> Played<'b> {
    pub fn read(bytes: &'b [u8], choice: &AnimationChoice, source: &mut Source) -> Result<Played<'b>, SceneError> {
        let mut model = Model::read(bytes, source)?;
        let playable = model.animation(choice, source)?;
        Ok(Played { model, playable })
    }

    pub fn animation(&self) -> &Animation {
        &self.playable.animation
    }

    pub fn at(&mut self, time: Seconds, source: &mut Source) -> Result<Scene, SceneError> {
        self.model.at(&self.playable, time, source)
    }
}

/// A file that was read as far as no pose matters. It can be posed at any number of times; buffers are fetched once.
struct Model<'b> {
    document: Document,
    buffers: Buffers<'b>,
    layout: Layout,
    /// Those of nodes that are shown.
    skins: BTreeMap<u32, Skin>,
}

impl<'b> Model<'b> {
    fn read(bytes: &'b [u8], source: &mut Source) -> Result<Model<'b>, SceneError> {
        let (json, binary) = container::split(bytes, source.path)?;
        let document = Document::parse(json, source)?;
        let mut buffers = Buffers::new(&document, binary);
        let mut layout = nodes::layout(&document, source)?;
        let mut skins = BTreeMap::new();
        for index in layout.shown.iter().filter_map(|s| s.skin) {
            if let Entry::Vacant(entry) = skins.entry(index) {
                entry.insert(Skin::read(&mut Reader { document: &document, buffers: &mut buffers, source }, index)?);
            }
        }
        let joints: Vec<u32> = skins.values().flat_map(|s| s.joints.iter().copied()).collect();
        nodes::reach(&document, &joints, &mut layout.hierarchy, source)?;
        Ok(Model { document, buffers, layout, skins })
    }

    fn reader<'r, 's>(&'r mut self, source: &'r mut Source<'s>) -> Reader<'r, 'b, 's> {
        Reader { document: &self.document, buffers: &mut self.buffers, source }
    }

    /// What animations can move: the nodes at or above meshes and joints. Hidden meshes count, since an animation may show them.
    fn scope(&self) -> Scope {
        let mesh = |node: u32| self.document.nodes.get(node as usize).and_then(|n| n.mesh).map(|mesh| mesh.0);
        let nodes = || self.layout.hierarchy.nodes();
        let joints = self.skins.values().flat_map(|s| s.joints.iter().copied());
        let carriers = self.layout.hierarchy.carriers(nodes().filter(|node| mesh(*node).is_some()).chain(joints));
        Scope::new(carriers, nodes().filter_map(mesh).collect())
    }

    /// Every animation of the file.
    fn animations(&mut self, source: &mut Source) -> Result<Vec<Animation>, SceneError> {
        let scope = self.scope();
        animation::list(&mut self.reader(source), &scope)
    }

    /// Read the animation that is meant, to pose the model at any number of its times.
    fn animation(&mut self, choice: &AnimationChoice, source: &mut Source) -> Result<Playable, SceneError> {
        let scope = self.scope();
        let mut reader = self.reader(source);
        let number = animation::choose(&mut reader, choice, &scope)?;
        Playable::read(&mut reader, number, &scope)
    }

    fn at_rest(&mut self, source: &mut Source) -> Result<Scene, SceneError> {
        let mut scene = self.posed(&Motion::default(), source)?;
        scene.report.unplayed_animations = self.document.animations.len() as u64;
        Ok(scene)
    }

    /// The model as an animation has it at a time.
    fn at(&mut self, animation: &Playable, time: Seconds, source: &mut Source) -> Result<Scene, SceneError> {
        let mut scene = self.posed(&animation.at(time.get()), source)?;
        scene.report.unknown_channels = animation.unknown_channels;
        if animation.ignores_pointer {
            scene.report.ignored_extensions.push(extensions::ANIMATION_POINTER.to_owned());
            scene.report.ignored_extensions.sort();
        }
        scene.posed = Some(Posed { animation: animation.animation.clone(), time });
        Ok(scene)
    }

    fn posed(&mut self, motion: &Motion, source: &mut Source) -> Result<Scene, SceneError> {
        let Model { document, buffers, layout, skins } = self;
        let mut scene = Scene::default();
        scene.report.ignored_extensions.clone_from(&document.ignored_extensions);
        scene.report.hidden_nodes = layout.hidden;
        scene.report.twice_placed_nodes = layout.placed_twice;
        let mut reader = Reader { document, buffers, source };
        let mut stage = Stage::new(&mut reader, &layout.hierarchy, skins, motion)?;

        // Give each pose of each mesh a number, in the order in which they are shown, and place its instances.
        let mut numbers: BTreeMap<(u32, Pose), u32> = BTreeMap::new();
        let mut poses: Vec<(u32, Pose)> = Vec::new();
        for shown in &layout.shown {
            let posed = (shown.mesh, stage.pose(document, shown, &mut scene.report));
            let number = *numbers.entry(posed.clone()).or_insert(poses.len() as u32);
            if number as usize == poses.len() {
                poses.push(posed);
            }
            let is_skinned = poses[number as usize].1.skin.is_some();
            place(&mut reader, shown, number, is_skinned, &stage, &mut scene)?;
        }

        // Read them in the order of the file's meshes, and let the instances name them by their new numbers.
        let mut order: Vec<u32> = (0..poses.len() as u32).collect();
        order.sort_by_key(|number| poses[*number as usize].0);
        let mut read: Vec<(u32, Option<Affine>)> = vec![(0, None); poses.len()];
        let mut rounded = Vec::new();
        for number in order {
            let (index, pose) = &poses[number as usize];
            let PosedMesh { mesh, transform, rounded_before } =
                primitive::mesh(&mut reader, *index as usize, (pose, &stage), &mut scene.report)?;
            read[number as usize] = (scene.meshes.len() as u32, transform);
            scene.meshes.push(mesh);
            rounded.extend(rounded_before);
        }
        for instance in &mut scene.instances {
            let (mesh, transform) = read[instance.mesh as usize];
            instance.mesh = mesh;
            instance.transform = transform.unwrap_or(instance.transform);
        }
        scene.rounding = worst_rounding(&scene.meshes, rounded);
        Ok(scene)
    }
}

/// Add the instances of a node's mesh: one, or one for each element of `EXT_mesh_gpu_instancing`. That extension says nothing on skins:
/// a skinned mesh stands once, where its joints put it, and is counted.
fn place(
    reader: &mut Reader,
    shown: &Shown,
    number: u32,
    is_skinned: bool,
    stage: &Stage,
    scene: &mut Scene,
) -> Result<(), SceneError> {
    let node = &reader.document.nodes[shown.node as usize];
    let before = reader.source.passing();
    let places = if is_skinned {
        scene.report.uninstanced_skins += u64::from(instancing::is_instanced(node, reader.source));
        None
    } else {
        instancing::places(reader, node, shown.node)?
    };
    let places_bytes = reader.source.passing() - before;
    let places = places.unwrap_or_else(|| vec![Affine::IDENTITY]);
    let name = node.name.clone().unwrap_or_default();
    reader.source.charge((places.len() * (size_of::<Instance>() + name.len())) as u64, "the instances")?;
    let to_world = stage.to_world[shown.node as usize];
    scene.instances.extend(places.iter().map(|place| Instance {
        mesh: number,
        transform: to_world.then_inner(place),
        node: shown.node,
        name: name.clone(),
    }));
    reader.source.release(places_bytes);
    Ok(())
}

#[cfg(test)]
mod tests;
