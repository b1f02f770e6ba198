use super::accessor::{self, Shape};
use super::buffers::Buffers;
use super::document::Document;
use crate::geom::Affine;
use crate::scene::source::Source;
use crate::scene::{Instance, SceneError};
use ::gltf::json::Node;

/// Every mesh that the scene shows, at its place, in depth-first order. `mesh` is still the glTF's own index.
pub(super) fn instances(
    document: &Document,
    buffers: &mut Buffers,
    source: &mut Source,
) -> Result<Vec<Instance>, SceneError> {
    let mut instances = Vec::new();
    let mut reached = vec![false; document.nodes.len()];
    let mut stack: Vec<(u32, Affine)> =
        roots(document, source)?.into_iter().rev().map(|root| (root, Affine::IDENTITY)).collect();

    // Walk with a stack of our own, so that no depth of nesting can exhaust the thread's. Each node is reached at most
    // once, so this ends.
    while let Some((index, parent)) = stack.pop() {
        let Some(node) = document.nodes.get(index as usize) else {
            let count = document.nodes.len();
            let reason = format!("the scene or a node names node {index}, but there are {count}");
            return Err(SceneError::malformed(source.path, reason));
        };
        if std::mem::replace(&mut reached[index as usize], true) {
            let reason = format!("node {index} is reached twice; a node has one parent and is not its own descendant");
            return Err(SceneError::malformed(source.path, reason));
        }
        let world = parent.then_inner(&local_transform(node, index, source)?);
        if let Some(mesh) = node.mesh {
            let mesh = mesh.value();
            if mesh >= document.meshes.len() {
                let reason = format!("node {index} shows mesh {mesh}, but there are {}", document.meshes.len());
                return Err(SceneError::malformed(source.path, reason));
            }
            let places = instancing(document, node, index, buffers, source)?;
            let places_bytes = places.as_ref().map_or(0, |p| (p.len() * size_of::<Affine>()) as u64);
            let places = places.unwrap_or_else(|| vec![Affine::IDENTITY]);
            let name = node.name.clone().unwrap_or_default();
            source.charge((places.len() * (size_of::<Instance>() + name.len())) as u64, "the instances")?;
            instances.extend(places.iter().map(|place| Instance {
                mesh: mesh as u32,
                transform: world.then_inner(place),
                node: index,
                name: name.clone(),
            }));
            source.release(places_bytes);
        }
        let children = node.children.iter().flatten().rev();
        stack.extend(children.map(|child| (child.value() as u32, world)));
    }
    Ok(instances)
}

/// The nodes to start from: those of the scene asked for, else of the default scene, else of the first; without scenes, the
/// nodes that are nobody's child.
fn roots(document: &Document, source: &Source) -> Result<Vec<u32>, SceneError> {
    let count = document.scenes.len();
    let chosen = match (source.options.scene, document.scene) {
        (Some(asked), _) if asked as usize >= count => {
            let reason = format!("scene {asked} was asked for, but it has {count}");
            return Err(SceneError::malformed(source.path, reason));
        }
        (Some(asked), _) => asked,
        (None, Some(default)) if default as usize >= count => {
            let reason = format!("its default scene is {default}, but it has {count}");
            return Err(SceneError::malformed(source.path, reason));
        }
        (None, default) => default.unwrap_or(0),
    };
    if let Some(scene) = document.scenes.get(chosen as usize) {
        return Ok(scene.nodes.clone());
    }
    let mut is_child = vec![false; document.nodes.len()];
    for child in document.nodes.iter().flat_map(|n| n.children.iter().flatten()) {
        if let Some(flag) = is_child.get_mut(child.value()) {
            *flag = true;
        }
    }
    Ok((0..document.nodes.len() as u32).filter(|n| !is_child[*n as usize]).collect())
}

/// A node's own transform: its matrix, or else translation · rotation · scale.
fn local_transform(node: &Node, index: u32, source: &Source) -> Result<Affine, SceneError> {
    if let Some(m) = &node.matrix {
        let column = |c: usize| [0, 1, 2, 3].map(|r| f64::from(m[c * 4 + r]));
        let last_row = [0, 1, 2, 3].map(|c| f64::from(m[c * 4 + 3]));
        let is_affine = last_row.iter().zip([0.0, 0.0, 0.0, 1.0]).all(|(v, want)| (v - want).abs() < 1e-6);
        if !is_affine {
            let reason = format!("the matrix of node {index} has the last row {last_row:?}; it must be 0 0 0 1");
            return Err(SceneError::malformed(source.path, reason));
        }
        return Ok(Affine::from_columns([column(0), column(1), column(2), column(3)]));
    }
    let rotation = node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |r| r.0);
    Ok(compose(node.translation.unwrap_or([0.0; 3]), rotation, node.scale.unwrap_or([1.0; 3])))
}

/// Translation · rotation · scale. The quaternion is brought to unit length in `f64`, since its `f32` numbers never quite have
/// it; one without length rotates nothing.
fn compose(translation: [f32; 3], rotation: [f32; 4], scale: [f32; 3]) -> Affine {
    let [x, y, z, w] = rotation.map(f64::from);
    let norm = x * x + y * y + z * z + w * w;
    let s = if norm > 0.0 { 2.0 / norm } else { 0.0 };
    let turn = [
        [1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
        [s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)],
        [s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)],
    ];
    let [sx, sy, sz] = scale.map(f64::from);
    let row = |r: usize| [turn[r][0] * sx, turn[r][1] * sy, turn[r][2] * sz, f64::from(translation[r])];
    Affine { rows: [row(0), row(1), row(2)] }
}

/// The places that `EXT_mesh_gpu_instancing` gives a node's mesh, relative to the node; `None` without the extension.
fn instancing(
    document: &Document,
    node: &Node,
    index: u32,
    buffers: &mut Buffers,
    source: &mut Source,
) -> Result<Option<Vec<Affine>>, SceneError> {
    const NAME: &str = "EXT_mesh_gpu_instancing";
    let Some(extension) = node.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(None) };
    let malformed = |what: String| SceneError::malformed(source.path, format!("{NAME} of node {index} {what}"));
    let attributes = extension.get("attributes").and_then(|a| a.as_object());
    let attributes = attributes.ok_or_else(|| malformed("has no attributes".into()))?;
    let accessor = |name: &str| match attributes.get(name) {
        None => Ok(None),
        Some(value) => match value.as_u64() {
            Some(accessor) => Ok(Some(accessor as usize)),
            None => Err(malformed(format!("has '{value}' for {name}, which is no accessor number"))),
        },
    };
    let [translation, rotation, scale] = [accessor("TRANSLATION")?, accessor("ROTATION")?, accessor("SCALE")?];

    // All attributes must agree on the number of places before any of them is read.
    let mut counts = Vec::new();
    for accessor in [translation, rotation, scale].into_iter().flatten() {
        counts.push(accessor::count(document, accessor, source)?);
    }
    let Some(&count) = counts.first() else {
        return Err(malformed("has none of TRANSLATION, ROTATION and SCALE".into()));
    };
    if let Some(other) = counts.iter().find(|c| **c != count) {
        return Err(malformed(format!("has attributes of {count} and of {other} elements; they must be as many")));
    }
    let translations = vec3(document, translation, buffers, source)?;
    let scales = vec3(document, scale, buffers, source)?;
    let rotations = match rotation {
        Some(accessor) => Some(accessor::floats::<4>(document, accessor, Shape::ROTATION, buffers, source)?),
        None => None,
    };
    source.charge(count.saturating_mul(size_of::<Affine>() as u64), "the instances")?;
    let places = (0..count as usize).map(|i| {
        let rotation = rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |r| r[i]);
        let (translation, scale) =
            (translations.as_ref().map_or([0.0; 3], |t| t[i]), scales.as_ref().map_or([1.0; 3], |s| s[i]));
        compose(translation, rotation, scale)
    });
    let places = places.collect();
    let read = [translations.is_some(), scales.is_some()].iter().filter(|b| **b).count() * 12;
    source.release(count.saturating_mul((read + if rotations.is_some() { 16 } else { 0 }) as u64));
    Ok(Some(places))
}

fn vec3(
    document: &Document,
    accessor: Option<usize>,
    buffers: &mut Buffers,
    source: &mut Source,
) -> Result<Option<Vec<[f32; 3]>>, SceneError> {
    accessor.map(|a| accessor::floats(document, a, Shape::TRANSLATION, buffers, source)).transpose()
}
