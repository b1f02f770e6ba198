//! Agreement with the model that a file was built from.

use bvhc_core::cache::check::{Bits, Content, hex};

use super::{Place, Report};
use crate::cache::{GeomRecord, Meta, NO_NODE, SectionKind, View, clip_name, rules, side_flags};
use crate::exec::Executor;
use crate::geom::Point;
use crate::scene::{InputFile, Instance, Mesh, Part, ReadReport};

/// The geometry that a file should hold: the model read again and laid out as it is built (`compile::lay_out`).
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// One for each BLAS, in their order.
    pub meshes: &'a [Mesh],
    /// For a two-level file.
    pub instances: Option<&'a [Instance]>,
    /// Files that the model was read from.
    pub inputs: &'a [InputFile],
    /// What reading left out, where the model was read from files.
    pub report: Option<&'a ReadReport>,
}

/// Every triangle of the source is in the file with its very corners, and no other is.
pub fn check(content: &Content<'_>, source: &Source<'_>, max_issues: usize, out: &mut Report, exec: &Executor) {
    let view = &content.view;
    match content.meta {
        Some(meta) => {
            check_inputs(meta, source.inputs, out);
            source.report.into_iter().for_each(|report| check_left_out(meta, report, out));
        }
        None => out
            .skip("Whether the input files are those that the file was built from: META is missing or cannot be read."),
    }
    let (trees, meshes) = (view.blases.len(), source.meshes.len());
    if trees != meshes {
        let at = Place::section(SectionKind::BLAS);
        out.add(&rules::E0604, at, || {
            (format!("the source has {meshes} meshes"), format!("the file has {trees} trees"))
        });
        out.skip("The triangles against the source: meshes and trees cannot be paired.");
    } else if !view.geoms.is_sorted_by_key(|row| row.blas) {
        out.skip("The triangles against the source: the rows of GEOM are not in the order of their trees.");
    } else {
        let parts = exec.map_range(meshes, |tree| {
            let mut part = Report::new(max_issues);
            check_mesh(content, tree, &source.meshes[tree], &mut part);
            part
        });
        parts.into_iter().for_each(|part| out.append(part));
    }
    check_instances(view, source.instances, out);
    if content.vertices.is_some() && source.meshes.iter().any(|m| m.vertices.is_empty() && !m.triangles.is_empty()) {
        out.skip("The vertices of triangles against the source: it was read without them.");
    }
}

fn check_inputs(meta: &Meta, inputs: &[InputFile], out: &mut Report) {
    let at = Place::section(SectionKind::META);
    if meta.dependencies.len() != inputs.len() {
        let expected = format!("the source was read from {} files", inputs.len());
        let actual = format!("META lists {}", meta.dependencies.len());
        out.add(&rules::E0606, at, || (expected, actual));
    }
    for (i, (stated, found)) in meta.dependencies.iter().zip(inputs).enumerate() {
        if (stated.len, stated.blake3) != (found.len, found.blake3) {
            out.add(&rules::E0606, at, || {
                let expected = format!("input {i} has {} bytes and hash {}", found.len, hex(&found.blake3));
                (expected, format!("META states {} bytes and hash {}", stated.len, hex(&stated.blake3)))
            });
        }
    }
}

/// The two counts of META that a reader needs, to find the element of an instance (section 10.5 of the specification). Others inform people, and tools of
/// other versions count other things.
fn check_left_out(meta: &Meta, report: &ReadReport, out: &mut Report) {
    let counted =
        [("singular_instances", report.singular_instances), ("out_of_range_instances", report.out_of_range_instances)];
    for (name, expected) in counted {
        let stated = meta.read_counts.iter().find(|(stated, _)| stated == name).map_or(0, |(_, count)| *count);
        if stated != expected {
            out.add(&rules::E0606, Place::section(SectionKind::META), || {
                (format!("reading the source leaves out {expected} as {name}"), format!("META states {stated}"))
            });
        }
    }
}

fn check_mesh(content: &Content<'_>, tree: usize, mesh: &Mesh, out: &mut Report) {
    let view = &content.view;
    // Pair the rows of GEOM with the parts.
    let low = view.geoms.partition_point(|g| (g.blas as usize) < tree);
    let high = view.geoms.partition_point(|g| (g.blas as usize) <= tree);
    let rows = view.geoms.get(low..high).unwrap_or_default();
    if rows.len() != mesh.parts.len() {
        let at = Place::record(SectionKind::BLAS, tree as u64);
        out.add(&rules::E0604, at, || {
            (format!("the mesh has {} parts", mesh.parts.len()), format!("tree {tree} has {}", rows.len()))
        });
        out.skip(format!("The triangles of tree {tree} against the source: its parts cannot be paired."));
        return;
    }
    for (k, (row, part)) in rows.iter().zip(&mesh.parts).enumerate() {
        let name = clip_name(&part.name);
        let expected = GeomRecord {
            source_mesh: part.source_mesh,
            source_part: part.source_part,
            baked_node: part.baked_node.unwrap_or(NO_NODE),
            blas: tree as u32,
            first_prim: part.first_prim,
            prim_count: part.prim_count,
            kept_count: row.kept_count, // what is missing or too much is found triangle by triangle
            reserved: row.reserved,
            name_hash: if name.is_empty() { [0; 32] } else { *blake3::hash(name.as_bytes()).as_bytes() },
        };
        if *row != expected {
            let place = Place::record(SectionKind::GEOM, (low + k) as u64);
            out.add(&rules::E0604, place, || {
                let of_source = GeomRecord { kept_count: part.triangle_count, ..expected };
                (format!("the source has {}", fields(&of_source)), format!("GEOM has {}", fields(row)))
            });
        }
    }

    rows.iter().zip(low..).zip(&mesh.parts).for_each(|((_, geom), part)| check_origin(content, geom, part, out));

    // Find each of the tree's triangles in the mesh.
    let Some(records) = view.blas(tree) else {
        out.skip(format!("The triangles of tree {tree} against the source: its row of BLAS leads out of the records."));
        return;
    };
    let start = view.blases[tree].ref_offset;
    let Some(mut seen) = Bits::new(mesh.triangles.len() as u64) else {
        let place = Place::record(SectionKind::BLAS, tree as u64);
        out.starve(place, &format!("The triangles of tree {tree} against the source"));
        return;
    };
    for (slot, triangle) in records.triangles.iter().enumerate() {
        let index = start + slot as u64;
        let place = Place { tree: Some((tree as u32, slot as u64)), ..Place::record(SectionKind::TRIS, index) };
        let part = (triangle.geom as usize).checked_sub(low);
        match part.and_then(|part| mesh.triangle_of(part, triangle.prim)) {
            None => out.add(&rules::E0602, place, || {
                ("no such triangle".into(), format!("has prim {} of part {}", triangle.prim, triangle.geom))
            }),
            Some(i) => {
                seen.set(i as u64);
                let corners = mesh.corners(i).map(|p| p.map(|c| c + 0.0)); // as written: -0.0 becomes +0.0
                let stored = triangle.corners().map(|p| p.map(|c| c + 0.0));
                if bits(corners) != bits(stored) {
                    out.add(&rules::E0603, place, || (show(corners), show(triangle.corners())));
                }
                let stated = content.vertices.and_then(|all| all.get(usize::try_from(index).ok()?));
                if let (Some(expected), Some(stated)) =
                    (mesh.vertices.get(i), stated.filter(|s| Some(*s) != mesh.vertices.get(i)))
                {
                    let place = Place { section: Some(SectionKind::VERT), ..place };
                    out.add(&rules::E0607, place, || {
                        (format!("the source has the vertices {expected:?}"), format!("VERT has {stated:?}"))
                    });
                }
            }
        }
    }
    for i in (0..mesh.triangles.len()).filter(|i| !seen.get(*i as u64)) {
        let at = Place::record(SectionKind::BLAS, tree as u64);
        out.add(&rules::E0601, at, || {
            (format!("triangle {} of mesh {:?}", mesh.source_prim(i), mesh.name), format!("tree {tree} has not"))
        });
    }
}

/// Compare what other sections say of a part.
fn check_origin(content: &Content<'_>, geom: usize, part: &Part, out: &mut Report) {
    let place = Place::record(SectionKind::GEOM, geom as u64);
    let expected = clip_name(&part.material);
    if let Some(materials) = &content.materials
        && let material = materials.get(geom).unwrap_or_default()
        && expected != material
    {
        out.add(&rules::E0604, place, || {
            (format!("its material in the source is {expected:?}"), format!("the file has {material:?}"))
        });
    }
    let is_mirrored = |yes: bool| if yes { "mirrored" } else { "not mirrored" };
    let Some(sides) = content.sides else { return };
    let stated = sides.get(geom).is_some_and(|side| side & side_flags::MIRRORED != 0);
    let expected = part.mirrored && part.baked_node.is_some();
    if expected != stated {
        out.add(&rules::E0604, place, || {
            (format!("the source has it {}", is_mirrored(expected)), format!("the file has it {}", is_mirrored(stated)))
        });
    }
}

fn check_instances(view: &View<'_>, instances: Option<&[Instance]>, out: &mut Report) {
    let at = Place::section(SectionKind::INST);
    let Some(instances) = instances else { return };
    if instances.len() != view.instances.len() {
        let actual = format!("the file has {}", view.instances.len());
        out.add(&rules::E0605, at, || (format!("the source has {} instances", instances.len()), actual));
    }
    for (i, record) in view.instances.iter().enumerate() {
        let place = Place::record(SectionKind::INST, i as u64);
        let Some(instance) = instances.get(record.id as usize) else { continue };
        let matrix = instance.transform.to_f32();
        if matrix.map(f32::to_bits) != record.object_to_world.map(f32::to_bits) {
            out.add(&rules::E0605, place, || {
                (format!("its matrix must be {matrix:?}"), format!("it is {:?}", record.object_to_world))
            });
        }
        if (instance.mesh, instance.node) != (record.blas, record.node) {
            out.add(&rules::E0605, place, || {
                let expected = format!("it must place mesh {} for node {}", instance.mesh, instance.node);
                (expected, format!("it places tree {} for node {}", record.blas, record.node))
            });
        }
    }
}

fn bits(corners: [Point; 3]) -> [[u32; 3]; 3] {
    corners.map(|p| p.map(f32::to_bits))
}

fn show(corners: [Point; 3]) -> String {
    let [a, b, c] = corners;
    format!("{a:?} {b:?} {c:?}")
}

fn fields(g: &GeomRecord) -> String {
    let node = if g.baked_node == NO_NODE { "none".into() } else { g.baked_node.to_string() };
    format!(
        "mesh {} part {} node {node}, {} of {} primitives from {}, name hash {}",
        g.source_mesh,
        g.source_part,
        g.kept_count,
        g.prim_count,
        g.first_prim,
        hex(&g.name_hash[..4])
    )
}
