//! Wavefront OBJ: positions and faces by `tobj`, polygons cut here.
//!
//! ```text
//! bytes ─ ranges: everyday statements, side by side, coordinates by tobj ──────────────┐   (a long file: in pieces)
//!   └─ any other text ─ statements: checked, counted, reduced to v and f ─▶ tobj ─▶ models ─ joined, polygon: triangles ─▶ one Mesh
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
mod given;
mod grouped;
mod joined;
mod keyword;
mod lines;
mod names;
mod parts;
mod pieces;
mod plain;
mod polygon;
mod position;
mod range;
mod ranges;
mod statements;
mod words;

use super::bounds::Bounds;
use super::options::without_padding;
use super::pose::split_all;
use super::precision::{self, Loss};
use super::rounded_before::rounded_before;
use super::source::Source;
use super::{Instance, Mesh, ReadReport, Rounding, Scene, SceneError};
use crate::geom::{Affine, Point};
use corners::{Corners, Gap};
use joined::Joined;
use lines::line_of;
pub(super) use pieces::Other;
use ranges::Everyday;
use statements::{Counts, Statements};

/// Read a text. `everyday` is false where it is known to hold more than everyday statements.
pub(super) fn parse(bytes: Vec<u8>, everyday: bool, source: &mut Source) -> Result<Scene, SceneError> {
    parse_in(bytes, everyday.then_some(ranges::RANGE), source)
}

/// [`parse`] in ranges of about so many bytes where the text allows; `None`: statement by statement.
fn parse_in(bytes: Vec<u8>, range: Option<usize>, source: &mut Source) -> Result<Scene, SceneError> {
    let text = without_padding(&bytes);
    // Most texts have none, and `contains` is many times faster than a search for its place.
    if text.contains(&0) {
        let line = line_of(text, text.iter().position(|b| *b == 0).unwrap_or_default());
        let reason = "it has a NUL byte, so it is binary data or damaged, and an OBJ model is text";
        return Err(SceneError::malformed_line(source.path, line, reason));
    }
    if let Some(everyday) = range.and_then(|range| ranges::read(text, range, source)) {
        drop(bytes);
        return scene_of(everyday, source);
    }
    let (counts, gaps, models) = one_by_one(text, source)?;
    drop(bytes);
    let report = ReadReport {
        skipped_primitives: counts.skipped,
        short_faces: counts.short_faces,
        ignored_weights: counts.weighted,
        unreferenced_positions: counts.unreferenced,
        unknown_statements: counts.unknown,
        first_unknown_statement: counts.first_unknown.clone(),
        ..ReadReport::default()
    };
    let mut joined = joined(gaps, source);
    for tobj::Model { mesh: model, name } in models {
        joined.add_model(&model, counts.part_name(&name), source.path)?;
    }
    placed(joined.finish(), report, source)
}

/// Read a file of everyday statements whose text is too long to be held for nothing. With any other nothing is done.
pub(super) fn parse_in_pieces(source: &mut Source) -> Result<Result<Scene, Other>, SceneError> {
    let pieces::Read { text, len, blake3 } = match pieces::read(ranges::RANGE, source) {
        Ok(read) => read,
        Err(other) => return Ok(Err(other)),
    };
    source.add_hashed(source.path.to_owned(), source.model_name(), len, blake3);
    source.advance(len);
    scene_of(text, source).map(Ok)
}

fn scene_of(text: Everyday, source: &mut Source) -> Result<Scene, SceneError> {
    let mut report =
        ReadReport { skipped_primitives: text.skipped, ignored_weights: text.weighted, ..ReadReport::default() };
    if source.options.vertices || source.options.faces {
        let mut joined = joined(Vec::new(), source);
        report.unreferenced_positions = joined.add_everyday(text);
        return placed(joined.finish(), report, source);
    }
    let (mesh, positions, unreferenced) = grouped::join(text, grouped::FACES, name_of(source), source.exec());
    report.unreferenced_positions = unreferenced;
    placed((mesh, positions), report, source)
}

fn name_of(source: &Source) -> String {
    source.path.file_stem().unwrap_or_default().to_string_lossy().into()
}

fn joined(gaps: Vec<Gap>, source: &Source) -> Joined {
    Joined::new(name_of(source), source.options.vertices.then(|| Corners::new(gaps)), source.options.faces)
}

/// The mesh where 32 bits hold its shape.
fn placed(read: (Mesh, Vec<[f64; 3]>), report: ReadReport, source: &mut Source) -> Result<Scene, SceneError> {
    let (mut mesh, mut positions) = read;
    let mut scene = Scene { report, ..Scene::default() };
    if !mesh.triangles.is_empty() {
        let (origin, rounding) = origin_for(&positions, &mesh.triangles);
        let place = |v: u32| stored(positions[v as usize], origin);
        if !positions.iter().all(|p| stored(*p, origin).iter().all(|c| c.is_finite())) {
            precision::count_beyond_range(&mesh.triangles, |v| positions[v as usize], place, &mut scene.report);
        }
        if origin == [0.0; 3] {
            mesh.positions = source.exec().generate(positions.len(), |v| stored(positions[v], origin));
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

/// Read statement by statement: what is wrong is told with its line.
fn one_by_one(text: &[u8], source: &mut Source) -> Result<(Counts, Vec<Gap>, Vec<tobj::Model>), SceneError> {
    let path = source.path;
    let mut statements = Statements::new(text, source);
    let loaded =
        tobj::load_obj_buf(&mut statements, &tobj::LoadOptions::default(), |_| Ok((Vec::new(), Default::default())));
    let (counts, gaps) = statements.finish(loaded.as_ref().err())?;
    let models = loaded.map_err(|e| SceneError::malformed(path, e.to_string()))?.0;
    Ok((counts, gaps, models))
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
    let rounded_before = rounded_before(triangles, exact, from_zero.edge, 0.0);
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

#[cfg(test)]
mod tests;
