use super::accessor;
use super::document::{Document, Primitive, TRIANGLE_FAN, TRIANGLE_STRIP, TRIANGLES};
use super::extensions::{DRACO, compressed};
use super::pose::{Pose, Stage};
use super::reader::Reader;
use super::vertices::Attributes;
use crate::geom::{Affine, Point};
use crate::scene::pose::{Place, Rounded, split_all};
use crate::scene::precision::{count_beyond_range, is_far};
use crate::scene::rounded_before::rounded_before_posing;
use crate::scene::source::Source;
use crate::scene::{Mesh, Part, ReadReport, Rounding, SceneError};
use bytemuck::allocation::try_cast_vec;
use std::collections::BTreeMap;

/// A mesh in a pose.
pub(super) struct PosedMesh {
    pub mesh: Mesh,
    /// That of the mesh's instances, where the pose decides it and not the node: a skinned mesh stands in world space.
    pub transform: Option<Affine>,
    /// That the positions were rounded before they were written, where a pose moved them and the mesh does not tell it any more.
    pub rounded_before: Option<Rounding>,
}

/// Read one glTF mesh in one pose: its triangle primitives, one [`Part`] each. Primitives whose vertices are equal share them.
pub(super) fn mesh(
    reader: &mut Reader,
    index: usize,
    (pose, stage): (&Pose, &Stage),
    report: &mut ReadReport,
) -> Result<PosedMesh, SceneError> {
    let document = reader.document;
    let json = &document.meshes[index];
    let mut mesh = Mesh { name: json.name.clone().unwrap_or_default(), ..Mesh::default() };
    let mut points = Points::new(pose, stage);
    for (number, primitive) in json.primitives.iter().enumerate() {
        let place = format!("primitive {number} of mesh {index}");
        let mode = primitive.mode();
        if mode > TRIANGLE_FAN {
            return Err(SceneError::malformed(
                reader.source.path,
                format!("{place} has a mode that glTF does not know"),
            ));
        }
        check_compression(document, primitive, reader.source)?;
        let Some(positions) = primitive.surface_positions() else {
            report.skipped_primitives += 1;
            continue;
        };
        let attributes = Attributes::new(primitive, positions, points.weights, pose.skin.is_some());
        let (base, count) = match points.runs.get(&attributes) {
            Some(&run) => run,
            None => points.read(reader, index, attributes, &place, report)?,
        };

        // Connect them. Indices are needed only here.
        let (indices, restart) = match primitive.indices {
            Some(indices) => accessor::indices(reader, indices.0 as usize)?,
            None => {
                reader.source.charge(count * 4, "the indices")?;
                ((0..count as u32).collect(), u32::MAX)
            }
        };
        let corners = indices.len() as u64;
        let most = if mode == TRIANGLES { corners / 3 } else { corners.saturating_sub(2) };
        let before = mesh.triangles.len();
        check_count(before as u64 + most, "triangles", index, reader.source)?;
        reader.source.charge(most * size_of::<[u32; 3]>() as u64, "the triangles")?;
        connect(mode, indices, restart, &mut mesh.triangles);
        reader.source.release(corners * 4);
        let triangles = &mut mesh.triangles[before..];
        if let Some(bad) = triangles.iter().flatten().find(|v| u64::from(**v) >= count) {
            return Err(SceneError::malformed(
                reader.source.path,
                format!("{place} uses vertex {bad}, but has {count}"),
            ));
        }
        if reader.source.options.vertices {
            reader.source.charge(size_of_val(triangles) as u64, "the numbers of vertices")?;
            mesh.vertices.extend_from_slice(triangles);
        }
        if base > 0 {
            triangles.iter_mut().flatten().for_each(|v| *v += base as u32);
        }
        let (first, count) = (before as u32, triangles.len() as u32);
        if count > 0 {
            let material = primitive.material.map(|m| document.material_names.get(m.0 as usize));
            report.absent_materials += u64::from(material == Some(None));
            let material = material.flatten().cloned().unwrap_or_default();
            reader.source.charge((mesh.name.len() + material.len()) as u64, "the names of its parts")?;
            mesh.parts.push(Part {
                name: mesh.name.clone(),
                material,
                source_mesh: index as u32,
                source_part: number as u32,
                baked_node: None,
                mirrored: false,
                first_triangle: first,
                triangle_count: count,
                first_prim: first,
                prim_count: count,
            });
        }
    }
    let rounded_before = points.rounded_before(&mesh.triangles);
    let transform = points.finish(&mut mesh, reader.source, report)?;
    Ok(PosedMesh { mesh, transform, rounded_before })
}

/// The positions of a mesh's primitives, one run behind the other.
struct Points<'s> {
    weights: &'s [f64],
    is_plain: bool,
    place: Place<'s>,
    /// The first position and the number of them, for each set of accessors that was read.
    runs: BTreeMap<Attributes, (u64, u64)>,
    /// As they stand in the file.
    plain: (Vec<Point>, Vec<Point>),
    posed: Vec<[f64; 3]>,
    /// What `posed` was before, as long as it lies far off; empty for nearly every mesh.
    far: Vec<[f64; 3]>,
}

impl<'s> Points<'s> {
    fn new(pose: &Pose, stage: &'s Stage) -> Points<'s> {
        Points {
            weights: stage.weights(pose),
            is_plain: pose.is_plain(),
            place: stage.place(pose),
            runs: BTreeMap::new(),
            plain: (Vec::new(), Vec::new()),
            posed: Vec::new(),
            far: Vec::new(),
        }
    }

    /// Read one more run.
    fn read(
        &mut self,
        reader: &mut Reader,
        mesh: usize,
        attributes: Attributes,
        place: &str,
        report: &mut ReadReport,
    ) -> Result<(u64, u64), SceneError> {
        let (first, count) = if self.is_plain {
            let (positions, remainders) = accessor::positions(reader, attributes.positions)?;
            let (first, count) = (self.plain.0.len(), positions.len());
            append(&mut self.plain.0, positions);
            if !remainders.is_empty() || !self.plain.1.is_empty() {
                self.plain.1.resize(first, Point::default());
                self.plain.1.extend(remainders);
                self.plain.1.resize(first + count, Point::default());
            }
            (first, count)
        } else {
            let before = reader.source.passing();
            let joints = match self.place {
                Place::Mesh => 0,
                Place::World { joints, .. } => joints.len(),
            };
            let vertices = attributes.read(reader, joints, place)?;
            let read = reader.source.passing() - before;
            report.unweighted_vertices += vertices.influences.as_ref().map_or(0, |i| i.unweighted);
            let (first, count) = (self.posed.len(), vertices.positions.len());
            reader.source.charge((count * size_of::<[f64; 3]>()) as u64, "the posed positions")?;
            append(&mut self.posed, vertices.posed(self.weights, self.place));
            if is_far(&vertices.positions) {
                reader.source.charge((count * size_of::<[f64; 3]>()) as u64, "the positions before posing")?;
                self.far.resize(first, [0.0; 3]);
                self.far.extend_from_slice(&vertices.positions);
            }
            drop(vertices);
            reader.source.release(read);
            (first, count)
        };
        check_count((first + count) as u64, "positions", mesh, reader.source)?;
        let run = (first as u64, count as u64);
        self.runs.insert(attributes, run);
        Ok(run)
    }

    /// Whether the file's own positions were rounded before they were written, where they are not those of the mesh.
    fn rounded_before(&self, triangles: &[[u32; 3]]) -> Option<Rounding> {
        let before = |v: u32| self.far.get(v as usize).copied().unwrap_or_default();
        if self.far.is_empty() { None } else { rounded_before_posing(triangles, before) }
    }

    /// Hand the positions to their mesh; the transform is that of its instances, where the pose decides it.
    fn finish(
        self,
        mesh: &mut Mesh,
        source: &mut Source,
        report: &mut ReadReport,
    ) -> Result<Option<Affine>, SceneError> {
        source.release((self.far.len() * size_of::<[f64; 3]>()) as u64);
        drop(self.far);
        if self.is_plain {
            (mesh.positions, mesh.remainders) = self.plain;
            return Ok(None);
        }
        let posed = (self.posed.len() * size_of::<[f64; 3]>()) as u64;
        source.charge(posed, "the posed positions")?;
        source.release(posed);
        let fits = |p: &[f64; 3]| p.iter().all(|c| c.abs() <= f64::from(f32::MAX));
        let exact = if self.posed.iter().all(fits) { Vec::new() } else { self.posed.clone() };
        let transform = match self.place {
            Place::Mesh => {
                (mesh.positions, mesh.remainders) = split_all(&self.posed);
                None
            }
            Place::World { .. } => {
                let rounded = Rounded::new(self.posed);
                (mesh.positions, mesh.remainders) = (rounded.positions, rounded.remainders);
                Some(rounded.transform)
            }
        };
        if !exact.is_empty() {
            let stored = |v: u32| mesh.positions[v as usize];
            count_beyond_range(&mesh.triangles, |v| exact[v as usize], stored, report);
        }
        Ok(transform)
    }
}

/// Move `more` behind `all`, without a copy where it is the first.
fn append<T>(all: &mut Vec<T>, more: Vec<T>) {
    if all.is_empty() { *all = more } else { all.extend(more) }
}

/// Triangles and positions are numbered in 32 bits.
fn check_count(count: u64, of: &str, mesh: usize, source: &Source) -> Result<(), SceneError> {
    if count <= u64::from(u32::MAX) {
        return Ok(());
    }
    let what = format!("mesh {mesh} has {count} {of}");
    Err(SceneError::TooMany { path: source.path.to_owned(), line: None, what, limit: u32::MAX.into() })
}

/// Refuse a primitive whose data only a Draco decoder can give. Where the file keeps plain data beside the compressed, and
/// so does not require the extension, the plain data are read.
fn check_compression(document: &Document, primitive: &Primitive, source: &Source) -> Result<(), SceneError> {
    let has_data = |accessor: Option<usize>| accessor.is_none_or(|a| accessor::has_data(document, a));
    let is_plain = has_data(primitive.attribute("POSITION")) && has_data(primitive.indices.map(|i| i.0 as usize));
    let must_decode = document.requires(DRACO) && !source.options.ignores(DRACO);
    if primitive.has_extension(DRACO) && (must_decode || !is_plain) {
        return Err(compressed(DRACO, source));
    }
    Ok(())
}

/// Append the triangles that indices in a mode mean (glTF 2.0, 3.7.2.1), in this order:
///
/// - A list: triangle `i` has the indices `3i`, `3i + 1`, `3i + 2`.
/// - A strip: triangle `i` has `i`, `i + 1`, `i + 2` where `i` is even and `i`, `i + 2`, `i + 1` where it is odd.
/// - A fan: triangle `i` has `i + 1`, `i + 2`, `0`.
///
/// Incomplete triangles at the end are left out. In strips and fans the restart value, the highest that the type of the indices has,
/// begins a new one (`KHR_mesh_primitive_restart`): `i` counts from 0 in each, and triangles are numbered through all of them, as if each
/// were appended by itself. Without the extension glTF forbids the value there, but that is all it can mean.
fn connect(mode: u32, indices: Vec<u32>, restart: u32, out: &mut Vec<[u32; 3]>) {
    match mode {
        TRIANGLE_STRIP => {
            for run in indices.split(|i| *i == restart) {
                let turned = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
                out.extend(run.windows(3).enumerate().map(turned));
            }
        }
        TRIANGLE_FAN => {
            for run in indices.split(|i| *i == restart) {
                out.extend(run.windows(2).skip(1).map(|w| [w[0], w[1], run[0]]));
            }
        }
        // Without a copy where they are the first and the allocation is one of whole triangles.
        _ if out.is_empty() => {
            *out = try_cast_vec(indices).unwrap_or_else(|(_, indices)| indices.chunks_exact(3).map(triangle).collect());
        }
        _ => out.extend(indices.chunks_exact(3).map(triangle)),
    }
}

fn triangle(corners: &[u32]) -> [u32; 3] {
    [corners[0], corners[1], corners[2]]
}
