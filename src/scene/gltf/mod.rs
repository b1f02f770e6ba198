//! glTF 2.0: `.gltf` with embedded or external buffers, and `.glb`.
//!
//! The JSON's structures come from the `gltf` crate; it is not asked to import or to validate, because its checks refuse
//! quantized positions and its readers trust what they skip. Every index, offset and count is checked here where it is used,
//! and only what the chosen scene shows is read: a broken material, texture or animation does not matter.
//!
//! ```text
//! container ─▶ document ─▶ nodes: instances ─▶ primitive: meshes ◀─ accessor ◀─ buffers: GLB chunk, data URI, file
//! ```
//!
//! Skinned and morphed meshes are read as they stand in the file: bind pose, no morph target applied, placed by their node.

mod accessor;
mod buffers;
mod container;
mod document;
mod nodes;
mod primitive;

use super::source::Source;
use super::{Mesh, Scene, SceneError};
use buffers::Buffers;
use document::Document;

pub(super) fn parse(bytes: Vec<u8>, source: &mut Source) -> Result<Scene, SceneError> {
    let (json, binary) = container::split(&bytes, source.path)?;
    let document = Document::parse(json, source)?;
    let mut buffers = Buffers::new(&document, binary);
    let mut scene = Scene { instances: nodes::instances(&document, &mut buffers, source)?, ..Scene::default() };

    // Read each mesh that an instance shows, in file order, and let the instances name it by its new number.
    let mut new_number = vec![None; document.meshes.len()];
    scene.instances.iter().for_each(|i| new_number[i.mesh as usize] = Some(0));
    for (index, number) in new_number.iter_mut().enumerate().filter(|(_, n)| n.is_some()) {
        *number = Some(scene.meshes.len() as u32);
        let mesh: Mesh = primitive::mesh(&document, index, &mut buffers, source, &mut scene.report)?;
        scene.meshes.push(mesh);
    }
    for instance in &mut scene.instances {
        instance.mesh = new_number[instance.mesh as usize].unwrap_or(0);
    }
    Ok(scene)
}

#[cfg(test)]
mod tests;
