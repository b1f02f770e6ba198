//! Several instances in one tree: their triangles in one mesh, in the world or about an origin.

use crate::build::{BuildError, MAX_REFS, Remedy};
use crate::exec::Executor;
use crate::geom::{Affine, Point};
use crate::scene::{Degenerate, Instance, Mesh, Part, drop_triangles, is_collinear};

/// What baking makes.
pub(super) enum Baked {
    /// The mesh as it was: an empty one stands in its place.
    Taken(Mesh),
    /// A copy, moved.
    Moved(Mesh),
}

/// Triangles and positions of all instances together.
///
/// # Errors
/// Where 32-bit indices do not reach all of them in one mesh.
pub(super) fn counts(meshes: &[Mesh], instances: &[&Instance]) -> Result<[u64; 2], BuildError> {
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
    Ok([triangles, positions])
}

/// Merge instances, in order, into one mesh whose coordinates are measured from `origin`.
///
/// Each vertex is moved in `f64` and rounded once. A mirroring transform turns a triangle's winding around and that is
/// left so: intersection does not cull, and the hit point and its barycentric coordinates stay those of the source's
/// corner order. [`Part::mirrored`] says so. Parts and source numbers stay those of the source; [`Part::baked_node`] tells copies of one part from
/// each other. A single instance that need not be moved is taken, not copied, and stays unmarked unless it must be `told` from others.
pub(super) fn bake(
    meshes: &mut [Mesh],
    instances: &[&Instance],
    origin: [f64; 3],
    told: bool,
    exec: &Executor,
) -> Result<Baked, BuildError> {
    if let [only] = instances
        && only.transform.about(origin) == Affine::IDENTITY
    {
        let mut mesh = std::mem::take(&mut meshes[only.mesh as usize]);
        if told {
            mesh.parts
                .iter_mut()
                .for_each(|part| part.baked_node = Some(only.node).filter(|n| *n != Instance::NO_NODE));
        }
        return Ok(Baked::Taken(mesh));
    }

    let of = |i: &Instance| &meshes[i.mesh as usize];
    let [triangles, positions] = counts(meshes, instances)?;
    let mut out = Mesh {
        name: instances.first().map_or_else(String::new, |i| of(i).name.clone()),
        positions: Vec::with_capacity(positions as usize),
        remainders: Vec::new(),
        triangles: Vec::with_capacity(triangles as usize),
        source_prims: Vec::with_capacity(triangles as usize),
        vertices: Vec::new(),
        parts: Vec::new(),
        faces: None,
    };
    for (index, instance) in instances.iter().enumerate() {
        append(&mut out, &meshes[instance.mesh as usize], instance, origin, exec)
            .ok_or(BuildError::OutOfRange { instance: index, mesh: instance.mesh })?;
    }
    Ok(Baked::Moved(out))
}

/// Apply the policy to triangles that have lost their area where the instances put them, and count those.
///
/// `mesh` is what baking made of `meshes` by `instances`. Triangles that had none before were judged when they were read.
pub(super) fn drop_collapsed(
    mesh: &mut Mesh,
    meshes: &[Mesh],
    instances: &[&Instance],
    policy: Degenerate,
    exec: &Executor,
) -> Result<u64, BuildError> {
    let (mut collapsed, mut first) = (Vec::new(), 0);
    for instance in instances {
        let source = &meshes[instance.mesh as usize];
        let numbers: Vec<u32> = (0..source.triangles.len() as u32).collect();
        let found = exec.map_chunks(&numbers, CHUNK, |_, chunk| {
            let is_new = |i: &&u32| {
                is_collinear(mesh.corners(first + **i as usize)) && !is_collinear(source.corners(**i as usize))
            };
            chunk.iter().filter(is_new).map(|i| first as u32 + i).collect::<Vec<u32>>()
        });
        if let (Degenerate::Error, Some(i)) = (policy, found.iter().flatten().next()) {
            let (count, prim) = (found.iter().flatten().count(), mesh.source_prim(*i as usize));
            return Err(BuildError::Collapsed { count, prim, mesh: source.name.clone(), node: instance.node });
        }
        collapsed.extend(found.into_iter().flatten());
        first += source.triangles.len();
    }
    if policy == Degenerate::Drop && !collapsed.is_empty() {
        drop_triangles(mesh, &collapsed);
    }
    Ok(collapsed.len() as u64)
}

/// What one more instance of a mesh adds to the merged mesh.
pub(super) fn bytes_of_copy(mesh: &Mesh) -> u64 {
    let triangle = size_of::<[u32; 3]>() + size_of::<u32>();
    let vertices = size_of_val(&mesh.vertices[..]);
    let bytes = mesh.positions.len() * size_of::<Point>() + mesh.triangles.len() * triangle + vertices;
    (bytes + mesh.parts.len() * size_of::<Part>()) as u64
}

const CHUNK: usize = 1 << 14;

/// `None` where a vertex leaves the range of `f32`.
fn append(out: &mut Mesh, mesh: &Mesh, instance: &Instance, origin: [f64; 3], exec: &Executor) -> Option<()> {
    let to_tree = instance.transform.about(origin);
    let (first_position, first_triangle) = (out.positions.len(), out.triangles.len() as u32);

    // Only positions that a triangle uses must be finite, so unused ones are kept as they are to keep indices simple.
    out.positions.extend_from_slice(&mesh.positions);
    if to_tree != Affine::IDENTITY {
        exec.map_chunks_mut(&mut out.positions[first_position..], CHUNK, |number, chunk| {
            for (v, p) in (number * CHUNK..).zip(chunk) {
                *p = mesh.baked_position(v, &to_tree);
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

    // Either all meshes of a scene have the numbers of their vertices or none: `lay_out` refuses others.
    out.vertices.extend_from_slice(&mesh.vertices);
    let mirrors = to_tree.mirrors();
    out.source_prims.extend((0..mesh.triangles.len()).map(|i| mesh.source_prim(i)));
    out.parts.extend(mesh.parts.iter().map(|part| Part {
        baked_node: Some(instance.node).filter(|n| *n != Instance::NO_NODE),
        mirrored: part.mirrored != mirrors,
        first_triangle: part.first_triangle + first_triangle,
        ..part.clone()
    }));
    Some(())
}
