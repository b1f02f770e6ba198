//! Wavefront OBJ: positions and faces by `tobj`, polygons cut here.
//!
//! ```text
//! bytes ─ statements: checked, counted, reduced to v and f ─▶ tobj ─▶ models ─ polygon: triangles ─▶ one Mesh
//! ```
//!
//! The whole file is one mesh; every run of faces of one object, one group and one material is one part, in the file's order. Normals,
//! texture coordinates, colours and MTL files carry no geometry and are not read. A fourth number of a position is the weight that rational
//! curves and surfaces give it, which faces do not have: it is not read either.
//!
//! **From a triangle back to its face.** A face of `n` corners becomes `n - 2` triangles, always, whatever its shape. They are numbered
//! through the whole file in the order of its faces, from 0, before any is dropped: that is the number that a hit brings back (`prim`).
//! So the triangles of face `k`, counting `f` statements of at least three corners from 0, are `S(k) … S(k + 1) - 1` with `S(k)` the sum of `n - 2`
//! over the faces before it; in a file of triangles alone it is `k` itself. [`Part::first_prim`] and [`Part::prim_count`] count the same
//! numbers. Which corners of its face each triangle has is told by its positions, since cutting makes no new ones, and exactly by
//! [`Mesh::vertices`] where they are asked for.
//!
//! **Coordinates** are read as `f64`. Where `f32` would lose the shape, as with map coordinates, they are measured from a place beside
//! the model, and the instance puts the mesh back there.

mod corners;
mod face;
mod keyword;
mod lines;
mod names;
mod parts;
mod plain;
mod polygon;
mod position;
mod statements;
mod words;

use super::bounds::Bounds;
use super::options::without_padding;
use super::pose::split_all;
use super::precision::{self, Loss};
use super::source::Source;
use super::{Instance, Mesh, Part, ReadReport, Rounding, Scene, SceneError};
use crate::geom::{Affine, Point};
use corners::Corners;
use lines::line_of;
use parts::PartName;
use polygon::Triangulator;
use statements::Statements;

pub(super) fn parse(bytes: Vec<u8>, source: &mut Source) -> Result<Scene, SceneError> {
    let text = without_padding(&bytes);
    // Most texts have none, and `contains` is many times faster than a search for its place.
    if text.contains(&0) {
        let line = line_of(text, text.iter().position(|b| *b == 0).unwrap_or_default());
        let reason = "it has a NUL byte, so it is binary data or damaged, and an OBJ model is text";
        return Err(SceneError::malformed_line(source.path, line, reason));
    }
    let mut statements = Statements::new(text, source);
    let loaded =
        tobj::load_obj_buf(&mut statements, &tobj::LoadOptions::default(), |_| Ok((Vec::new(), Default::default())));
    let (counts, gaps) = statements.finish(loaded.as_ref().err())?;
    let models = loaded.map_err(|e| SceneError::malformed(source.path, e.to_string()))?.0;
    drop(bytes);

    // Join the models. tobj numbers each model's positions anew, so a position that two models share is stored twice.
    let mut mesh =
        Mesh { name: source.path.file_stem().unwrap_or_default().to_string_lossy().into(), ..Mesh::default() };
    let mut positions: Vec<[f64; 3]> = Vec::new();
    let mut cut = Triangulator::new();
    let mut corners = source.options.vertices.then(|| Corners::new(gaps));
    let mut faces = source.options.faces.then(blake3::Hasher::new);
    let mut any_polygon = false;
    for tobj::Model { mesh: model, name } in models {
        let count = positions.len() as u64 + model.positions.len() as u64 / 3;
        if count > u64::from(u32::MAX) {
            let what = format!("its parts have {count} positions in all, shared ones counted for each");
            return Err(SceneError::TooMany { path: source.path.to_owned(), line: None, what, limit: u32::MAX.into() });
        }
        let base = positions.len() as u32;
        positions.extend(model.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        let first_triangle = mesh.triangles.len() as u32;
        add_faces(&model, base, &positions, &mut mesh, corners.as_mut(), &mut cut);
        if let Some(faces) = &mut faces {
            any_polygon |= !model.face_arities.is_empty();
            faces.update(&base.to_le_bytes());
            for words in [&model.face_arities, &model.indices] {
                faces.update(&(words.len() as u64).to_le_bytes()).update(bytemuck::cast_slice(words));
            }
        }
        let triangle_count = mesh.triangles.len() as u32 - first_triangle;
        if triangle_count > 0 {
            let PartName { name, material } = counts.part_name(&name);
            mesh.parts.push(Part {
                name,
                material,
                source_mesh: 0,
                source_part: mesh.parts.len() as u32,
                baked_node: None,
                mirrored: false,
                first_triangle,
                triangle_count,
                first_prim: first_triangle,
                prim_count: triangle_count,
            });
        }
    }

    mesh.faces = faces.filter(|_| any_polygon).map(|faces| *faces.finalize().as_bytes());
    let mut scene = Scene::default();
    scene.report.skipped_primitives = counts.skipped;
    scene.report.short_faces = counts.short_faces;
    scene.report.unreferenced_positions = counts.unreferenced;
    scene.report.unknown_statements = counts.unknown;
    scene.report.first_unknown_statement = counts.first_unknown.clone();
    if !mesh.triangles.is_empty() {
        let (origin, rounding) = origin_for(&positions, &mesh.triangles);
        count_beyond_range(&mesh.triangles, &positions, origin, &mut scene.report);
        if origin == [0.0; 3] {
            mesh.positions = positions.iter().map(|p| stored(*p, origin)).collect();
        } else {
            // One tree in the world rounds these once more: without the remainders it would round what is rounded.
            source.charge(24 * positions.len() as u64, "positions about an origin")?;
            positions.iter_mut().for_each(|p| (0..3).for_each(|a| p[a] -= origin[a]));
            (mesh.positions, mesh.remainders) = split_all(&positions);
        }
        scene.rounding = rounding;
        scene.meshes.push(mesh);
        let node = if origin == [0.0; 3] { 0 } else { Instance::NO_NODE };
        scene.instances.push(Instance { mesh: 0, transform: Affine::translation(origin), node, name: String::new() });
    }
    Ok(scene)
}

/// Where to measure the positions from, and what is lost all the same. It is the file's own origin, unless `f32` cannot hold the shape from
/// there and can from a place beside it.
fn origin_for(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> ([f64; 3], Rounding) {
    let exact = |v: u32| positions[v as usize];
    let about = |origin: [f64; 3]| {
        move |v: u32| {
            let p = stored(positions[v as usize], origin);
            [0, 1, 2].map(|a| f64::from(p[a]) + origin[a])
        }
    };
    let from_zero = Loss::of(triangles, Loss::SAMPLE, exact, about([0.0; 3]));
    let rounded_before = precision::rounded_before(triangles, exact, from_zero.edge, 0.0);
    if from_zero.is_tolerable() {
        return ([0.0; 3], Rounding { loss: from_zero, rounded_before, grid: None });
    }
    let is_usable = |v: &u32| exact(*v).iter().all(|c| (*c as f32).is_finite());
    let used = triangles.iter().filter(|t| t.iter().all(is_usable)).flatten();
    let bounds = Bounds::of(used.map(|v| exact(*v)));
    let [near, far] =
        [precision::local_origin(bounds), [0.0; 3]].map(|o| (o, Loss::of(triangles, usize::MAX, exact, about(o))));
    let (origin, loss) = if far.1.is_more_than(&near.1) { near } else { far };
    (origin, Rounding { loss, rounded_before, grid: None })
}

/// A position as an `f32` measured from `origin`.
fn stored(p: [f64; 3], origin: [f64; 3]) -> Point {
    [0, 1, 2].map(|a| (p[a] - origin[a]) as f32)
}

/// Append one model's faces, whose positions start at `base`, and with `numbers` the corners of each triangle.
fn add_faces(
    model: &tobj::Mesh,
    base: u32,
    positions: &[[f64; 3]],
    mesh: &mut Mesh,
    mut numbers: Option<&mut Corners>,
    cut: &mut Triangulator,
) {
    if model.face_arities.is_empty() {
        mesh.triangles.extend(model.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|v| v + base)));
        if let Some(numbers) = numbers {
            let first = model.indices.chunks_exact(3).map(|_| numbers.take(3));
            mesh.vertices.extend(first.map(|first| [first, first + 1, first + 2]));
        }
        return;
    }
    let mut rest = model.indices.as_slice();
    let mut corners = Vec::new();
    for &arity in &model.face_arities {
        let (face, tail) = rest.split_at(arity as usize);
        rest = tail;
        corners.clear();
        corners.extend(face.iter().map(|v| v + base));
        let before = mesh.triangles.len();
        cut.add(&corners, positions, &mut mesh.triangles);
        let cut_now = &mut mesh.triangles[before..];
        if let Some(numbers) = &mut numbers {
            let first = numbers.take(arity);
            mesh.vertices.extend(cut_now.iter().map(|t| t.map(|corner| first + corner)));
        }
        cut_now.iter_mut().flatten().for_each(|v| *v = corners[*v as usize]);
    }
}

/// Count the triangles whose corners are all numbers, but not all such as `f32` can hold about the origin; and the largest coordinate there.
fn count_beyond_range(triangles: &[[u32; 3]], positions: &[[f64; 3]], origin: [f64; 3], report: &mut ReadReport) {
    let is_beyond = |p: &[f64; 3]| !stored(*p, origin).iter().all(|c| c.is_finite());
    if !positions.iter().any(is_beyond) {
        return;
    }
    for triangle in triangles {
        let corners = triangle.map(|v| positions[v as usize]);
        if corners.iter().any(is_beyond) && !corners.iter().flatten().any(|c| c.is_nan()) {
            report.out_of_range_triangles += 1;
            let largest = corners.iter().flatten().fold(0.0, |largest: f64, c| largest.max(c.abs()));
            report.largest_magnitude = report.largest_magnitude.max(largest);
        }
    }
}

#[cfg(test)]
mod tests;
