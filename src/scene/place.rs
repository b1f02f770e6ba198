//! Instances that a file cannot place as they are: transforms without inverse, and places beyond `f32`.

use super::bounds::Bounds;
use super::collinear::is_collinear;
use super::pose::Rounded;
use super::source::Source;
use super::{Degenerate, Mesh, Part, Scene, SceneError};
use crate::exec::Executor;
use crate::geom::vector::{cross, dot, sub};
use crate::geom::{Aabb, Affine};

/// What becomes of an instance.
enum Fate {
    /// Its transform can be stored and inverted.
    Stays,
    /// A scale of 0 along one or two axes, or so nearly that `f64` cannot tell the inverse: there is something to see, but no way for a ray back
    /// into the mesh.
    Flat,
    /// A scale of 0 along every axis.
    Vanishes,
    /// A number of the transform does not fit in `f32`.
    OutOfRange,
}

/// Bake the transforms that have no inverse into meshes of their own, and drop the instances of which nothing is left or which
/// `f32` cannot place.
pub(super) fn settle(scene: &mut Scene, source: &mut Source) -> Result<(), SceneError> {
    let mut kept = Vec::with_capacity(scene.instances.len());
    for mut instance in std::mem::take(&mut scene.instances) {
        match fate(&instance.transform) {
            Fate::Stays => {}
            Fate::Flat => {
                let (mesh, transform) =
                    flattened(&scene.meshes[instance.mesh as usize], &instance.transform, instance.node, source)?;
                instance.mesh = scene.meshes.len() as u32;
                instance.transform = transform;
                scene.meshes.push(mesh);
            }
            Fate::Vanishes => {
                scene.report.singular_instances += 1;
                continue;
            }
            Fate::OutOfRange => {
                let entries = instance.transform.rows.iter().flatten();
                count_out_of_range(scene, entries.fold(0.0, |most, v| magnitude(*v).max(most)));
                continue;
            }
        }
        kept.push(instance);
    }
    scene.instances = kept;
    Ok(())
}

/// A transform must have an inverse both as composed and as the file will store it, and one that `f64` can tell.
fn fate(transform: &Affine) -> Fate {
    let stored = transform.to_f32();
    if stored.iter().any(|v| !v.is_finite()) {
        return Fate::OutOfRange;
    }
    match transform.rows.iter().all(|row| row[..3] == [0.0; 3]) {
        _ if transform.is_storable() => Fate::Stays,
        true => Fate::Vanishes,
        false => Fate::Flat,
    }
}

/// A copy of a mesh with a node's transform baked into it, and the transform that is left for its instance. The copy is charged.
fn flattened(mesh: &Mesh, transform: &Affine, node: u32, source: &mut Source) -> Result<(Mesh, Affine), SceneError> {
    let (positions, triangles) = (mesh.positions.len() as u64, mesh.triangles.len() as u64);
    let names: usize = mesh.parts.iter().map(|p| size_of::<Part>() + p.name.len() + p.material.len()).sum();
    let numbers = 4 * triangles + 12 * mesh.vertices.len() as u64;
    source.charge(
        48 * positions + 12 * triangles + numbers + names as u64,
        "a mesh that is scaled to nothing along an axis",
    )?;
    let transform_mirrors = transform.mirrors();
    let world: Vec<[f64; 3]> =
        (0..mesh.positions.len()).map(|v| transform.transform_point(mesh.exact_position(v))).collect();
    let mut triangles = mesh.triangles.clone();
    if source.options.degenerate != Degenerate::Keep {
        let lost = |t: &[u32; 3]| is_lost(mesh, t, transform, &world);
        // A triangle of one corner has no area however its corner is rounded.
        triangles.iter_mut().filter(|t| lost(t)).for_each(|t| *t = [t[0]; 3]);
    }
    let Rounded { positions, remainders, transform } = Rounded::new(world);
    let parts = mesh
        .parts
        .iter()
        .map(|part| Part { baked_node: Some(node), mirrored: transform_mirrors, ..part.clone() })
        .collect();
    Ok((Mesh { positions, remainders, triangles, parts, ..mesh_without_points(mesh) }, transform))
}

/// Whether a triangle has an area in its mesh, and none where a transform without inverse puts it. What the rounding of `f64` leaves of one there, as behind
/// a rotation, is none: in `f32` it would be a needle of noise.
fn is_lost(mesh: &Mesh, triangle: &[u32; 3], transform: &Affine, world: &[[f64; 3]]) -> bool {
    /// Far more than the roundings of a chain of some nodes, far less than those of `f32`.
    const NOISE: f64 = 1.0 / (1u64 << 44) as f64;
    let local = triangle.map(|v| mesh.positions[v as usize]);
    let [a, b, c] = triangle.map(|v| world[v as usize]);
    let (u, v) = (sub(b, a), sub(c, a));
    let normal = cross(u, v);
    let length = |v: [f64; 3]| dot(v, v).sqrt();
    let reach = local.iter().flatten().fold(0.0, |most: f64, c| most.max(f64::from(*c).abs()));
    let largest = |of: &dyn Fn(&[f64; 4]) -> f64| transform.rows.iter().map(of).fold(0.0, f64::max);
    let moved = largest(&|row| row[..3].iter().fold(0.0, |sum, m| sum + m.abs()) * reach + row[3].abs());
    length(normal) <= NOISE * moved * (length(u) + length(v))
        && local.iter().flatten().all(|c| c.is_finite())
        && !is_collinear(local)
}

fn mesh_without_points(mesh: &Mesh) -> Mesh {
    Mesh {
        name: mesh.name.clone(),
        source_prims: mesh.source_prims.clone(),
        vertices: mesh.vertices.clone(),
        ..Mesh::default()
    }
}

/// Drop instances whose image in the world does not fit in `f32`: they have no box there, so nothing can be traced in them.
pub(super) fn drop_boundless(scene: &mut Scene, exec: &Executor) {
    /// Triangles of one task.
    const CHUNK: usize = 1 << 14;
    let mesh_box = |mesh: &Mesh| {
        let of_some = |_, some: &[[u32; 3]]| {
            some.iter().flatten().fold(Aabb::EMPTY, |all, v| all.grow(mesh.positions[*v as usize]))
        };
        exec.map_chunks(&mesh.triangles, CHUNK, of_some).into_iter().fold(Aabb::EMPTY, Aabb::union)
    };
    let boxes: Vec<Aabb> = scene.meshes.iter().map(mesh_box).collect();
    let mut kept = Vec::with_capacity(scene.instances.len());
    for instance in std::mem::take(&mut scene.instances) {
        let local = &boxes[instance.mesh as usize];
        if local.is_empty() || instance.transform.transform_box(local).is_valid() {
            kept.push(instance);
        } else {
            count_out_of_range(scene, largest_coordinate(&instance.transform, local));
        }
    }
    scene.instances = kept;
}

/// The largest coordinate of a box's corners in world space.
fn largest_coordinate(transform: &Affine, local: &Aabb) -> f64 {
    let corners = Bounds::from(*local).corners();
    corners.into_iter().flat_map(|p| transform.transform_point(p)).fold(0.0, |most, c| magnitude(c).max(most))
}

/// What even `f64` cannot hold any more, and the difference of two such numbers, is infinite.
fn magnitude(coordinate: f64) -> f64 {
    if coordinate.is_nan() { f64::INFINITY } else { coordinate.abs() }
}

fn count_out_of_range(scene: &mut Scene, magnitude: f64) {
    scene.report.out_of_range_instances += 1;
    scene.report.largest_magnitude = scene.report.largest_magnitude.max(magnitude);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_beyond_all_numbers_is_told_as_infinite() {
        // Two infinities that cancel: their sum is no number.
        let far = Affine { rows: [[1e300, -1e300, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
        let local = Aabb { min: [0.0; 3], max: [1e38, 1e38, 0.0] };
        assert_eq!(largest_coordinate(&far, &local), f64::INFINITY);
        assert_eq!((magnitude(-3.0), magnitude(f64::NAN)), (3.0, f64::INFINITY));
        let near = Affine::translation([2.0, 0.0, -9.0]);
        assert_eq!(largest_coordinate(&near, &Aabb { min: [0.0; 3], max: [1.0, 1.0, 1.0] }), 9.0);
    }
}
