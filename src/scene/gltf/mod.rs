//! glTF 2.0: `.gltf` with embedded or external buffers, and `.glb`.
//!
//! The structures are our own (`document`): those of the crates that read glTF round node transforms to `f32`, refuse whole numbers
//! that are written as `1.0`, or refuse quantized positions. Every index, offset and count is checked here where it is used, and only
//! what the chosen scene shows is read: a broken material, texture or animation does not matter.
//!
//! ```text
//! container ─▶ document ─▶ nodes: what is shown ─▶ pose: at rest ─▶ primitive: meshes ◀─ vertices ◀─ accessor ◀─ buffers ◀─ reference
//! ```
//!
//! Everything stands at rest: nodes by their own transforms, skinned meshes by their joints, morph targets by the weights of node or mesh. No
//! animation is played.

mod accessor;
mod buffers;
mod container;
mod data_uri;
mod document;
mod extensions;
mod instancing;
mod morph;
mod nodes;
mod pose;
mod primitive;
mod reader;
mod reference;
mod skin;
mod vertices;
mod whole;

#[cfg(any(feature = "cli", test))]
pub use extensions::{EXTENSIONS, Treatment};

use super::precision::worst_rounding;
use super::source::Source;
use super::{Instance, Scene, SceneError};
use crate::geom::Affine;
use buffers::Buffers;
use document::Document;
use nodes::Shown;
use pose::{Pose, Stage};
use reader::Reader;
use std::collections::BTreeMap;

pub(super) fn parse(bytes: Vec<u8>, source: &mut Source) -> Result<Scene, SceneError> {
    let (json, binary) = container::split(&bytes, source.path)?;
    let document = Document::parse(json, source)?;
    let buffers = Buffers::new(&document, binary);
    let mut reader = Reader { document: &document, buffers, source };
    let mut scene = Scene::default();
    scene.report.unplayed_animations = document.animation_count;
    scene.report.ignored_extensions.clone_from(&document.ignored_extensions);
    let mut layout = nodes::layout(&document, reader.source)?;
    scene.report.hidden_nodes = layout.hidden;
    let mut stage = Stage::at_rest(&mut reader, &mut layout)?;

    // Give each pose of each mesh a number, in the order in which they are shown, and place its instances.
    let mut numbers: BTreeMap<(u32, Pose), u32> = BTreeMap::new();
    let mut poses: Vec<(u32, Pose)> = Vec::new();
    for shown in &layout.shown {
        let posed = (shown.mesh, stage.pose(&document, shown, &mut scene.report));
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
    for number in order {
        let (index, pose) = &poses[number as usize];
        let (mesh, transform) = primitive::mesh(&mut reader, *index as usize, (pose, &stage), &mut scene.report)?;
        read[number as usize] = (scene.meshes.len() as u32, transform);
        scene.meshes.push(mesh);
    }
    for instance in &mut scene.instances {
        let (mesh, transform) = read[instance.mesh as usize];
        instance.mesh = mesh;
        instance.transform = transform.unwrap_or(instance.transform);
    }
    scene.rounding = worst_rounding(&scene.meshes);
    Ok(scene)
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
