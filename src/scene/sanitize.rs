//! The last step of reading: what no tree can hold goes, and is counted.

use super::collinear::is_collinear;
use super::grid;
use super::place;
use super::renumber::{renumber, retain_numbered};
use super::source::Source;
use super::{Degenerate, Mesh, Part, Scene, SceneError};
use crate::exec::Executor;
use crate::geom::Affine;
use std::collections::BTreeMap;

/// Apply the degenerate policy, drop triangles with non-finite positions, instances that cannot be placed and meshes
/// that nothing shows, and count all of it. Afterwards every mesh has a triangle and an instance.
pub(super) fn sanitize(scene: &mut Scene, source: &mut Source) -> Result<(), SceneError> {
    let shown = places_of_each_mesh(scene);
    scene.rounding.grid = grid::snap(&mut scene.meshes, source.options);
    place::settle(scene, source)?;
    drop_unused_meshes(scene);
    let mut first_bad = None;
    for mesh in &mut scene.meshes {
        let found = clean(mesh, source.options.degenerate, source.exec());
        if let (None, Some(first)) = (&first_bad, found.first) {
            first_bad = Some((first, describe(mesh, first)));
        }
        scene.report.degenerate_triangles += found.degenerate;
        scene.report.non_finite_triangles += found.non_finite;
        scene.report.unreferenced_positions += found.unreferenced;
    }
    // A position beyond the range is stored as infinite.
    scene.report.non_finite_triangles =
        scene.report.non_finite_triangles.saturating_sub(scene.report.out_of_range_triangles);
    if let (Some((first, mesh)), Degenerate::Error) = (first_bad, source.options.degenerate) {
        return Err(SceneError::Degenerate {
            path: source.path.to_owned(),
            degenerate: scene.report.degenerate_triangles,
            non_finite: scene.report.non_finite_triangles,
            out_of_range: scene.report.out_of_range_triangles,
            first: first.into(),
            mesh,
        });
    }
    place::drop_boundless(scene, source.exec());
    scene.report.singular_instances += flat_to_nothing(scene);
    drop_unused_meshes(scene);
    name_the_last_place(scene, &shown);
    Ok(())
}

/// How many instances each source mesh has.
fn places_of_each_mesh(scene: &Scene) -> BTreeMap<u32, u64> {
    let mut places = BTreeMap::new();
    for part in scene.instances.iter().filter_map(|i| scene.meshes[i.mesh as usize].parts.first()) {
        *places.entry(part.source_mesh).or_default() += 1;
    }
    places
}

/// A file of one level says by [`Part::baked_node`] which node a triangle comes from, but not of an only instance that nothing moves. Where
/// the others of its source mesh were dropped, say it all the same: nobody could tell which one was left.
fn name_the_last_place(scene: &mut Scene, shown: &BTreeMap<u32, u64>) {
    let [only] = &scene.instances[..] else { return };
    if only.transform != Affine::IDENTITY {
        return;
    }
    for part in &mut scene.meshes[only.mesh as usize].parts {
        if shown.get(&part.source_mesh).is_some_and(|places| *places > 1) {
            part.baked_node = Some(only.node);
        }
    }
}

/// Instances without inverse of which no triangle keeps an area. They are counted, or nobody could tell which elements of a node are left.
fn flat_to_nothing(scene: &Scene) -> u64 {
    let is_gone = |mesh: &Mesh| mesh.triangles.is_empty() && mesh.parts.iter().any(|p| p.baked_node.is_some());
    scene.instances.iter().filter(|i| is_gone(&scene.meshes[i.mesh as usize])).count() as u64
}

/// Remove instances of empty meshes and meshes without instances, and renumber what stays in its order.
fn drop_unused_meshes(scene: &mut Scene) {
    let meshes = &scene.meshes;
    scene.instances.retain(|i| !meshes[i.mesh as usize].triangles.is_empty());
    let mut used = vec![false; scene.meshes.len()];
    scene.instances.iter().for_each(|i| used[i.mesh as usize] = true);
    if used.iter().all(|&u| u) {
        return;
    }
    let numbers = renumber(used);
    retain_numbered(&mut scene.meshes, &numbers);
    scene.instances.iter_mut().for_each(|i| i.mesh = numbers[i.mesh as usize].unwrap_or_default());
}

#[derive(Default)]
struct Found {
    degenerate: u64,
    non_finite: u64,
    unreferenced: u64,
    /// The first triangle that the policy `error` refuses.
    first: Option<u32>,
}

/// Triangles that one task looks at.
const CHUNK: usize = 1 << 14;

/// Drop a mesh's bad triangles and compact its positions if some are used by none.
fn clean(mesh: &mut Mesh, policy: Degenerate, exec: &Executor) -> Found {
    let mut found = Found::default();
    let mut dropped = Vec::new();
    let bad = exec.map_chunks(&mesh.triangles, CHUNK, |chunk, some| {
        let fault = |(i, triangle): (usize, &[u32; 3])| {
            let corners = triangle.map(|v| mesh.positions[v as usize]);
            let is_finite = corners.iter().flatten().all(|c| c.is_finite());
            (!is_finite || is_collinear(corners)).then_some(((chunk * CHUNK + i) as u32, is_finite))
        };
        some.iter().enumerate().filter_map(fault).collect::<Vec<_>>()
    });
    for (i, is_finite) in bad.into_iter().flatten() {
        *(if is_finite { &mut found.degenerate } else { &mut found.non_finite }) += 1;
        if !is_finite || policy != Degenerate::Keep {
            dropped.push(i);
        }
    }
    let mut referenced = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|&v| referenced[v as usize] = true);
    found.first = dropped.first().copied();
    found.unreferenced = referenced.iter().filter(|r| !**r).count() as u64;
    if !dropped.is_empty() {
        drop_triangles(mesh, &dropped);
        referenced.fill(false);
        mesh.triangles.iter().flatten().for_each(|&v| referenced[v as usize] = true);
    }
    if referenced.contains(&false) {
        compact_positions(mesh, &referenced);
    }
    found
}

/// Remove the triangles numbered in `dropped`, which ascends, and move the parts' bounds with them.
pub(crate) fn drop_triangles(mesh: &mut Mesh, dropped: &[u32]) {
    if mesh.source_prims.is_empty() {
        mesh.source_prims = (0..mesh.triangles.len() as u32).collect();
    }
    remove(&mut mesh.source_prims, dropped);
    remove(&mut mesh.triangles, dropped);
    if !mesh.vertices.is_empty() {
        remove(&mut mesh.vertices, dropped);
    }
    for part in &mut mesh.parts {
        let before = |i: u32| dropped.partition_point(|&d| d < i) as u32;
        let (start, end) = (part.first_triangle, part.first_triangle + part.triangle_count);
        part.first_triangle = start - before(start);
        part.triangle_count = end - before(end) - part.first_triangle;
    }
}

/// Remove the items numbered in `dropped`, which ascends.
fn remove<T: Copy>(items: &mut Vec<T>, dropped: &[u32]) {
    let mut end = dropped.first().map_or(items.len(), |first| *first as usize);
    for (i, place) in dropped.iter().enumerate() {
        let kept = *place as usize + 1..dropped.get(i + 1).map_or(items.len(), |next| *next as usize);
        items.copy_within(kept.clone(), end);
        end += kept.len();
    }
    items.truncate(end);
}

fn compact_positions(mesh: &mut Mesh, referenced: &[bool]) {
    let numbers = renumber(referenced.iter().copied());
    for points in [&mut mesh.positions, &mut mesh.remainders] {
        retain_numbered(points, &numbers);
        points.shrink_to_fit();
    }
    mesh.triangles.iter_mut().flatten().for_each(|v| *v = numbers[*v as usize].unwrap_or_default());
}

/// The mesh and part of source triangle `prim`, in words.
fn describe(mesh: &Mesh, prim: u32) -> String {
    let index = mesh.parts.partition_point(|p| p.first_prim + p.prim_count <= prim);
    match mesh.parts.get(index) {
        Some(Part { name, .. }) if !name.is_empty() => format!("mesh '{}', part '{name}'", mesh.name),
        Some(Part { source_mesh, source_part, .. }) => format!("mesh {source_mesh}, part {source_part}"),
        None => format!("mesh '{}'", mesh.name),
    }
}
