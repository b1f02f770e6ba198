//! Numbers of parts and nodes that tell triangles and copies from each other, for scenes made by hand.

use crate::scene::{Instance, Mesh, Part, Scene};

/// Meshes made by hand may all have the source number 0, and their parts too. Where two triangles would so have one number, parts are named by
/// where they stand in the scene; where one mesh stands in several places and no node tells them apart, they are named by their instances.
/// No model that is read is such a scene.
pub(super) fn number(scene: &mut Scene) {
    let without_node = shown_without_node(&scene.instances, scene.meshes.len());
    if !are_clear(&scene.meshes, &without_node) {
        let mut next = scene.meshes.len() as u32;
        for (number, mesh) in scene.meshes.iter_mut().enumerate() {
            by_place(&mut mesh.parts, number as u32, &mut next);
        }
    }
    for (number, instance) in scene.instances.iter_mut().enumerate() {
        if instance.node == Instance::NO_NODE && without_node[instance.mesh as usize] > 1 {
            instance.node = number as u32;
        }
    }
}

/// Name the parts of a mesh by the order of their numbers, as files have them. Parts of several meshes of the source stay those of several.
fn by_place(parts: &mut [Part], number: u32, next: &mut u32) {
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by_key(|&i| (parts[i].source_mesh, parts[i].first_prim));
    let (mut mesh, mut before) = (number, None);
    for (place, &i) in order.iter().enumerate() {
        let said = parts[i].source_mesh;
        if before.is_some_and(|before| before != said) {
            mesh = std::mem::replace(next, *next + 1);
        }
        before = Some(said);
        (parts[i].source_mesh, parts[i].source_part) = (mesh, place as u32);
    }
}

/// How often each mesh is shown by an instance that names no node.
fn shown_without_node(instances: &[Instance], meshes: usize) -> Vec<u32> {
    let mut shown = vec![0; meshes];
    for instance in instances.iter().filter(|instance| instance.node == Instance::NO_NODE) {
        shown[instance.mesh as usize] += 1;
    }
    shown
}

/// Whether no two triangles of the source have one number.
///
/// Meshes may have the same parts where they are one mesh of the source in several poses: nodes tell those apart.
fn are_clear(meshes: &[Mesh], without_node: &[u32]) -> bool {
    let said = |p: &Part| (p.source_mesh, p.source_part, u64::from(p.first_prim), u64::from(p.prim_count));
    let with_triangles = meshes.iter().enumerate().filter(|(_, mesh)| !mesh.triangles.is_empty());
    let mut parts: Vec<_> = with_triangles
        .flat_map(|(number, mesh)| mesh.parts.iter().map(move |p| (said(p), p.name.as_str(), number)))
        .collect();
    // Of equal parts those without a node stand side by side.
    parts.sort_unstable_by_key(|&(part, name, mesh)| (part, name, without_node[mesh] == 0, mesh));
    parts.windows(2).all(|pair| {
        let [(a, name, first), (b, other, second)] = [pair[0], pair[1]];
        if (a, name) == (b, other) {
            return first != second && (without_node[first] == 0 || without_node[second] == 0);
        }
        a.0 != b.0 || a.1 != b.1 && a.2 + a.3 <= b.2
    })
}
