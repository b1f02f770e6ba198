use super::accessor::{self, Shape};
use super::document::Node;
use super::extensions::INSTANCING;
use super::nodes::compose;
use super::reader::Reader;
use super::whole::Index;
use crate::geom::Affine;
use crate::scene::SceneError;
use crate::scene::source::Source;
use serde::Deserialize;

/// Whether `EXT_mesh_gpu_instancing` places a node's mesh.
pub(super) fn is_instanced(node: &Node, source: &Source) -> bool {
    !source.options.ignores(INSTANCING) && node.extensions.as_ref().is_some_and(|e| e.instancing.is_some())
}

/// The places that `EXT_mesh_gpu_instancing` gives a node's mesh, relative to the node, in the order of the accessors' elements; `None`
/// without the extension. Their memory is charged and stays charged.
pub(super) fn places(reader: &mut Reader, node: &Node, index: u32) -> Result<Option<Vec<Affine>>, SceneError> {
    let extension = node.extensions.as_ref().and_then(|e| e.instancing.as_ref());
    let Some(extension) = extension.filter(|_| is_instanced(node, reader.source)) else { return Ok(None) };
    let path = reader.source.path;
    let malformed = |what: String| SceneError::malformed(path, format!("{INSTANCING} of node {index} {what}"));
    let attributes = extension.get("attributes").and_then(|a| a.as_object());
    let attributes = attributes.ok_or_else(|| malformed("has no attributes".into()))?;
    let accessor = |name: &str| match attributes.get(name) {
        None => Ok(None),
        Some(value) => match Index::deserialize(value) {
            Ok(accessor) => Ok(Some(accessor.0 as usize)),
            Err(_) => Err(malformed(format!("names for {name} what is no accessor number"))),
        },
    };
    let [translation, rotation, scale] = [accessor("TRANSLATION")?, accessor("ROTATION")?, accessor("SCALE")?];

    // All attributes must agree on the number of places before any of them is read.
    let mut counts = Vec::new();
    for accessor in [translation, rotation, scale].into_iter().flatten() {
        counts.push(accessor::count(reader, accessor)?);
    }
    let Some(&count) = counts.first() else {
        return Err(malformed("has none of TRANSLATION, ROTATION and SCALE".into()));
    };
    if let Some(other) = counts.iter().find(|c| **c != count) {
        return Err(malformed(format!("has attributes of {count} and of {other} elements; they must be as many")));
    }
    let translations = numbers::<3>(reader, translation, Shape::TRANSLATION)?;
    let scales = numbers::<3>(reader, scale, Shape::TRANSLATION)?;
    let rotations = numbers::<4>(reader, rotation, Shape::ROTATION)?;
    reader.source.charge(count.saturating_mul(size_of::<Affine>() as u64), "the instances")?;
    let places = (0..count as usize).map(|i| {
        let translation = translations.as_ref().map_or([0.0; 3], |t| t[i]);
        let rotation = rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |r| r[i]);
        compose(translation, rotation, scales.as_ref().map_or([1.0; 3], |s| s[i]))
    });
    let places = places.collect();
    let read = [translations.as_ref().map_or(0, |_| 3), scales.map_or(0, |_| 3), rotations.map_or(0, |_| 4)];
    reader.source.release(count.saturating_mul(read.iter().sum::<u64>() * size_of::<f64>() as u64));
    Ok(Some(places))
}

fn numbers<const N: usize>(
    reader: &mut Reader,
    accessor: Option<usize>,
    shape: Shape,
) -> Result<Option<Vec<[f64; N]>>, SceneError> {
    accessor.map(|a| accessor::numbers(reader, a, shape)).transpose()
}
