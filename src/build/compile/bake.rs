//! One level: every instance's triangles in one mesh, in world space.

use crate::build::error::{BuildError, Remedy};
use crate::build::top_down::driver::MAX_REFS;
use crate::exec::Executor;
use crate::geom::{Affine, Point};
use crate::scene::{Instance, Mesh, Part};

/// Merge the instances, in order, into one mesh.
///
/// Each vertex is moved in `f64` and rounded once. A mirroring transform turns a triangle's winding around and that is
/// left so: intersection does not cull, and the hit point and its barycentric coordinates stay those of the source's
/// corner order. Parts and source numbers stay those of the source; [`Part::baked_node`] tells copies of one part from
/// each other. A single instance at the identity is moved, not copied, and stays unmarked.
pub(super) fn bake(mut meshes: Vec<Mesh>, instances: &[Instance], exec: &Executor) -> Result<Mesh, BuildError> {
    if let [only] = instances
        && only.transform == Affine::IDENTITY
    {
        return Ok(std::mem::take(&mut meshes[only.mesh as usize]));
    }

    // Both counts must fit 32-bit indices.
    let of = |i: &Instance| &meshes[i.mesh as usize];
    let triangles: u64 = instances.iter().map(|i| of(i).triangles.len() as u64).sum();
    let positions: u64 = instances.iter().map(|i| of(i).positions.len() as u64).sum();
    for (what, needed, limit) in [
        ("one tree over all instances (triangles)", triangles, MAX_REFS),
        ("one mesh of all instances (positions)", positions, u64::from(u32::MAX)),
    ] {
        if needed > limit {
            return Err(BuildError::TooLarge { what, needed, limit, remedy: Remedy::TwoLevels });
        }
    }

    let mut out = Mesh {
        name: instances.first().map_or_else(String::new, |i| of(i).name.clone()),
        positions: Vec::with_capacity(positions as usize),
        remainders: Vec::new(),
        triangles: Vec::with_capacity(triangles as usize),
        source_prims: Vec::with_capacity(triangles as usize),
        parts: Vec::new(),
    };
    for (index, instance) in instances.iter().enumerate() {
        append(&mut out, &meshes[instance.mesh as usize], instance, exec)
            .ok_or(BuildError::OutOfRange { instance: index, mesh: instance.mesh })?;
    }
    Ok(out)
}

/// What one more instance of a mesh adds to the merged mesh.
pub(super) fn bytes_of_copy(mesh: &Mesh) -> u64 {
    let triangle = size_of::<[u32; 3]>() + size_of::<u32>();
    let bytes = mesh.positions.len() * size_of::<Point>() + mesh.triangles.len() * triangle;
    (bytes + mesh.parts.len() * size_of::<Part>()) as u64
}

const CHUNK: usize = 1 << 14;

/// `None` where a vertex leaves the range of `f32`.
fn append(out: &mut Mesh, mesh: &Mesh, instance: &Instance, exec: &Executor) -> Option<()> {
    let (first_position, first_triangle) = (out.positions.len(), out.triangles.len() as u32);

    // Only positions that a triangle uses must be finite, so unused ones are kept as they are to keep indices simple.
    out.positions.extend_from_slice(&mesh.positions);
    if instance.transform != Affine::IDENTITY {
        exec.map_chunks_mut(&mut out.positions[first_position..], CHUNK, |number, chunk| {
            for (v, p) in (number * CHUNK..).zip(chunk) {
                *p = mesh.baked_position(v, &instance.transform);
            }
        });
    }
    let offset = first_position as u32;
    out.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + offset)));
    let moved = &out.triangles[first_triangle as usize..];
    let finite = exec.map_chunks(moved, CHUNK, |_, chunk| {
        chunk.iter().flatten().all(|v| out.positions[*v as usize].iter().all(|c| c.is_finite()))
    });
    if finite.contains(&false) {
        return None;
    }

    out.source_prims.extend((0..mesh.triangles.len()).map(|i| mesh.source_prim(i)));
    out.parts.extend(mesh.parts.iter().map(|part| Part {
        baked_node: Some(instance.node),
        first_triangle: part.first_triangle + first_triangle,
        ..part.clone()
    }));
    Some(())
}
