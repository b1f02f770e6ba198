//! The records of instances and triangles beside what the scene says of them.

use super::Blame;
use crate::cache::TriangleRecord;
use crate::geom::{Affine, Point};
use crate::trace::Hit;
use crate::trace::brute::Source;
use crate::trace::compare::names;
use crate::verify::subject::Subject;

/// What is wrong with the record of instance `id`, if anything is.
pub fn instance(subject: &Subject<'_>, id: u32) -> Option<Blame> {
    let at = subject.view.instances.iter().position(|i| i.id == id)?;
    let record = &subject.view.instances[at];
    let Some(place) = subject.scene().instances.get(id as usize) else {
        return Some(Blame::new("INST", at as u64, format!("the scene has no instance {id}")));
    };
    let to_world = place.transform.to_f32();
    if let Some(k) = first_difference(&record.object_to_world, &to_world) {
        let why = format!(
            "element {k} of object_to_world is {:?}, but the scene has {:?}",
            record.object_to_world[k], to_world[k]
        );
        return Some(Blame::new("INST", at as u64, why));
    }
    let inverse = Affine::from_f32(&record.object_to_world).inverse()?.to_f32();
    let k = first_difference(&record.world_to_object, &inverse)?;
    let why = format!(
        "element {k} of world_to_object is {:?}, but the inverse of object_to_world has {:?}",
        record.world_to_object[k], inverse[k]
    );
    Some(Blame::new("INST", at as u64, why))
}

/// The first elements that differ by more than rounding to `f32` might, were the arithmetic another.
fn first_difference(a: &[f32; 12], b: &[f32; 12]) -> Option<usize> {
    let row_size = |k: usize| b[k / 4 * 4..][..4].iter().fold(0.0f32, |m, v| m.max(v.abs()));
    (0..12).find(|&k| !((a[k] - b[k]).abs() <= row_size(k) * 4.0 * f32::EPSILON))
}

/// The corners of a source triangle as the file should have them.
pub fn corners(subject: &Subject<'_>, source: Source) -> [Point; 3] {
    let scene = subject.scene();
    let place = &scene.instances[source.instance as usize];
    let (mesh, triangle) = (&scene.meshes[place.mesh as usize], source.triangle as usize);
    let baked = subject.view.tlas_nodes.is_empty() && place.transform != Affine::IDENTITY;
    if baked { mesh.baked_corners(triangle, &place.transform) } else { mesh.corners(triangle) }
}

/// Whether a record bears the numbers of a source triangle.
pub fn is_of(subject: &Subject<'_>, source: Source, record: &TriangleRecord) -> bool {
    let (prim, geom) = (record.prim, record.geom);
    let hit = Hit { t: 0.0, u: 0.0, v: 0.0, prim, geom, instance: None, triangle: 0 };
    names(&subject.view, &subject.oracle, &hit, source)
}

/// Whether other instances of the same mesh come from the same node, so that in one tree numbers do not tell their triangles apart.
pub fn copies_share_a_node(subject: &Subject<'_>, source: Source) -> bool {
    let instances = &subject.scene().instances;
    let place = &instances[source.instance as usize];
    let alike = instances.iter().filter(|i| (i.mesh, i.node) == (place.mesh, place.node));
    subject.view.tlas_nodes.is_empty() && alike.count() > 1
}

/// The source triangle whose numbers a hit's record bears; of several, one that has its corners.
pub fn source_of(subject: &Subject<'_>, hit: &Hit, record: &TriangleRecord) -> Option<Source> {
    let scene = subject.scene();
    let mut found = None;
    for (index, place) in scene.instances.iter().enumerate() {
        if hit.instance.is_some_and(|id| id as usize != index) {
            continue;
        }
        let mesh = &scene.meshes[place.mesh as usize];
        let numbered = (0..mesh.triangles.len()).filter(|&t| mesh.source_prim(t) == record.prim);
        for triangle in numbered {
            let source = Source { instance: index as u32, triangle: triangle as u32 };
            if is_of(subject, source, record) {
                if corners(subject, source) == record.corners() {
                    return Some(source);
                }
                found.get_or_insert(source);
            }
        }
    }
    found
}

/// What is wrong with the corners of a triangle's record, if anything is.
pub fn moved(record: &TriangleRecord, expected: &[Point; 3], slot: usize, tree: u32) -> Option<Blame> {
    let corners = record.corners();
    let k = (0..3).find(|&k| corners[k] != expected[k])?;
    let why = format!("v{k} of triangle {} is {:?}, but the scene has {:?}", record.prim, corners[k], expected[k]);
    Some(Blame::new("TRIS", slot as u64, why).in_tree(tree))
}
