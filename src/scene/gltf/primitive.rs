use super::accessor::{self, Shape};
use super::buffers::Buffers;
use super::document::{DRACO, Document, compressed};
use crate::scene::source::Source;
use crate::scene::{Mesh, Part, ReadReport, SceneError};
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use std::collections::BTreeMap;

/// Read one glTF mesh: its triangle primitives, one [`Part`] each. Primitives that share an accessor share its positions.
pub(super) fn mesh(
    document: &Document,
    index: usize,
    buffers: &mut Buffers,
    source: &mut Source,
    report: &mut ReadReport,
) -> Result<Mesh, SceneError> {
    let json = &document.meshes[index];
    let mut mesh = Mesh { name: json.name.clone().unwrap_or_default(), ..Mesh::default() };
    let mut first_position = BTreeMap::new();
    for (number, primitive) in json.primitives.iter().enumerate() {
        let place = |what: String| format!("primitive {number} of mesh {index} {what}");
        let mode = match primitive.mode {
            Checked::Valid(mode) => mode,
            Checked::Invalid => {
                return Err(SceneError::malformed(source.path, place("has a mode that glTF does not know".into())));
            }
        };
        let is_surface = matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan);
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions)).map(|a| a.value());
        check_compression(document, primitive, positions, source)?;
        let Some(positions) = positions.filter(|_| is_surface) else {
            report.skipped_primitives += 1;
            continue;
        };

        // Take the positions once for each accessor.
        let (base, count) = match first_position.get(&positions) {
            Some(&run) => run,
            None => {
                let read = accessor::floats(document, positions, Shape::POSITIONS, buffers, source)?;
                let run = (mesh.positions.len() as u64, read.len() as u64);
                check_count(run.0 + run.1, "positions", index, source)?;
                match run.0 {
                    0 => mesh.positions = read,
                    _ => mesh.positions.extend(read),
                }
                *first_position.entry(positions).or_insert(run)
            }
        };

        // Connect them. Indices are needed only here.
        let (indices, restart) = match primitive.indices {
            Some(indices) => accessor::indices(document, indices.value(), buffers, source)?,
            None => {
                source.charge(count * 4, "the indices")?;
                ((0..count as u32).collect(), u32::MAX)
            }
        };
        let corners = indices.len() as u64;
        let most = if mode == Mode::Triangles { corners / 3 } else { corners.saturating_sub(2) };
        let before = mesh.triangles.len();
        check_count(before as u64 + most, "triangles", index, source)?;
        source.charge(most * size_of::<[u32; 3]>() as u64, "the triangles")?;
        connect(mode, &indices, restart, &mut mesh.triangles);
        drop(indices);
        source.release(corners * 4);
        let triangles = &mut mesh.triangles[before..];
        if let Some(bad) = triangles.iter().flatten().find(|v| u64::from(**v) >= count) {
            return Err(SceneError::malformed(source.path, place(format!("uses vertex {bad}, but has {count}"))));
        }
        triangles.iter_mut().flatten().for_each(|v| *v += base as u32);
        let (first, count) = (before as u32, triangles.len() as u32);
        if count > 0 {
            mesh.parts.push(Part {
                name: String::new(),
                material: String::new(),
                source_mesh: index as u32,
                source_part: number as u32,
                baked_node: None,
                first_triangle: first,
                triangle_count: count,
                first_prim: first,
                prim_count: count,
            });
        }
    }
    Ok(mesh)
}

/// Triangles and positions are numbered in 32 bits.
fn check_count(count: u64, of: &str, mesh: usize, source: &Source) -> Result<(), SceneError> {
    if count <= u64::from(u32::MAX) {
        return Ok(());
    }
    let what = format!("mesh {mesh} has {count} {of}");
    Err(SceneError::TooMany { path: source.path.to_owned(), what, limit: u32::MAX.into() })
}

/// Refuse a primitive whose data only a Draco decoder can give. Where the file keeps plain data beside the compressed, and
/// so does not require the extension, the plain data are read.
fn check_compression(
    document: &Document,
    primitive: &Primitive,
    positions: Option<usize>,
    source: &Source,
) -> Result<(), SceneError> {
    let is_draco = primitive.extensions.as_ref().is_some_and(|e| e.others.contains_key(DRACO));
    let has_data = |accessor| accessor::has_data(document, accessor);
    let is_plain = positions.is_none_or(has_data) && primitive.indices.is_none_or(|i| has_data(i.value()));
    if is_draco && (document.requires(DRACO) || !is_plain) {
        return Err(compressed(DRACO, source));
    }
    Ok(())
}

/// Append the triangles that indices in a mode mean (glTF 2.0, 3.7.2.1). Incomplete triangles at the end are left out. In strips
/// and fans the restart value begins a new one; glTF forbids it there, but that is all it can mean.
fn connect(mode: Mode, indices: &[u32], restart: u32, out: &mut Vec<[u32; 3]>) {
    match mode {
        Mode::TriangleStrip => {
            for run in indices.split(|i| *i == restart) {
                let turned = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
                out.extend(run.windows(3).enumerate().map(turned));
            }
        }
        Mode::TriangleFan => {
            for run in indices.split(|i| *i == restart) {
                out.extend(run.windows(2).skip(1).map(|w| [w[0], w[1], run[0]]));
            }
        }
        _ => out.extend(indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]])),
    }
}
