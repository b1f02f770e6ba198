//! Wavefront OBJ: positions and faces by `tobj`, polygons cut here.
//!
//! ```text
//! bytes ─ statements: checked, counted, reduced to v and f ─▶ tobj ─▶ models ─ polygon: triangles ─▶ one Mesh
//! ```
//!
//! The whole file is one mesh; every run of faces with one group and material is one part. Normals, texture coordinates,
//! colours and MTL files carry no geometry and are not read. A fourth coordinate divides the other three.

mod polygon;
mod statements;
mod words;

use super::source::Source;
use super::{Instance, Mesh, Part, Scene, SceneError};
use crate::geom::{Affine, Point};
use polygon::Triangulator;
use statements::Statements;

pub(super) fn parse(bytes: Vec<u8>, source: &mut Source) -> Result<Scene, SceneError> {
    let mut statements = Statements::new(&bytes, source);
    let loaded =
        tobj::load_obj_buf(&mut statements, &tobj::LoadOptions::default(), |_| Ok((Vec::new(), Default::default())));
    let counts = statements.finish(loaded.as_ref().err())?;
    let models = loaded.map_err(|e| SceneError::malformed(source.path, e.to_string()))?.0;
    drop(bytes);

    // Join the models. tobj numbers each model's positions anew, so a position that two models share is stored twice.
    let mut mesh =
        Mesh { name: source.path.file_stem().unwrap_or_default().to_string_lossy().into(), ..Mesh::default() };
    let mut cut = Triangulator::default();
    for tobj::Model { mesh: model, name } in models {
        let positions = mesh.positions.len() as u64 + model.positions.len() as u64 / 3;
        if positions > u64::from(u32::MAX) {
            let what = format!("its parts have {positions} positions in all, shared ones counted for each");
            return Err(SceneError::TooMany { path: source.path.to_owned(), what, limit: u32::MAX.into() });
        }
        let base = mesh.positions.len() as u32;
        mesh.positions.extend(model.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]] as Point));
        let first_triangle = mesh.triangles.len() as u32;
        add_faces(&model, base, &mut mesh, &mut cut, source)?;
        let triangle_count = mesh.triangles.len() as u32 - first_triangle;
        if triangle_count > 0 {
            mesh.parts.push(Part {
                name: counts.part_name(&name),
                material: String::new(),
                source_mesh: 0,
                source_part: mesh.parts.len() as u32,
                baked_node: None,
                first_triangle,
                triangle_count,
                first_prim: first_triangle,
                prim_count: triangle_count,
            });
        }
    }

    let mut scene = Scene::default();
    scene.report.skipped_primitives = counts.skipped;
    scene.report.unreferenced_positions = counts.unreferenced;
    if !mesh.triangles.is_empty() {
        scene.meshes.push(mesh);
        scene.instances.push(Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() });
    }
    Ok(scene)
}

/// Append one model's faces, whose positions start at `base` of the mesh.
fn add_faces(
    model: &tobj::Mesh,
    base: u32,
    mesh: &mut Mesh,
    cut: &mut Triangulator,
    source: &Source,
) -> Result<(), SceneError> {
    if model.face_arities.is_empty() {
        mesh.triangles.extend(model.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|v| v + base)));
        return Ok(());
    }
    let mut rest = model.indices.as_slice();
    let mut corners = Vec::new();
    for &arity in &model.face_arities {
        let (face, tail) = rest.split_at(arity as usize);
        rest = tail;
        corners.clear();
        corners.extend(face.iter().map(|v| v + base));
        if arity as usize > polygon::MAX_CORNERS {
            return Err(SceneError::TooMany {
                path: source.path.to_owned(),
                what: format!("a face has {arity} corners"),
                limit: polygon::MAX_CORNERS as u64,
            });
        }
        if !cut.afford(arity.into()) {
            return Err(SceneError::TooMany {
                path: source.path.to_owned(),
                what: "its large faces are too many to cut into triangles: their squared numbers of corners add up to more"
                    .into(),
                limit: polygon::MAX_LARGE_WORK,
            });
        }
        cut.add(&corners, &mesh.positions, &mut mesh.triangles);
    }
    Ok(())
}

#[cfg(test)]
mod tests;
