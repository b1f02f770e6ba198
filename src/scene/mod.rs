//! Reading: OBJ and glTF files become a [`Scene`] of indexed triangle meshes and instances, and nothing else.
//!
//! Everything that a reader must refuse or repair is settled here: after [`Scene`] leaves this room, every index is in
//! range, every position that a triangle uses is finite, and every transform is finite and invertible. What was dropped is counted
//! in [`ReadReport`]. Builders know no files; this room knows no trees.

mod animation;
mod bounds;
mod clip;
mod collinear;
mod error;
mod excerpt;
pub mod frames;
mod geometry_error;
mod gltf;
mod grid;
mod obj;
mod options;
mod place;
mod pose;
mod precision;
mod read;
mod recorded;
mod renumber;
mod resemblance;
mod rounded_before;
mod sanitize;
mod source;
mod validate;
mod vertex_places;

pub use animation::{Animation, AnimationChoice, KeyTimes, Moment, Posed, Seconds};
pub(crate) use bounds::Bounds;
pub use clip::{Clip, play};
pub(crate) use collinear::is_collinear;
pub use error::{ErrorKind, SceneError};
pub use geometry_error::GeometryError;
#[cfg(any(feature = "cli", test))]
pub(crate) use gltf::{EXTENSIONS as GLTF_EXTENSIONS, Treatment};
pub use options::{Degenerate, Format, ReadOptions, VertexBits};
pub use precision::Loss;
pub(crate) use precision::local_origin;
pub(crate) use precision::shortest_edges;
pub use read::{animations, read, read_bytes, read_with};
pub(crate) use recorded::asks_for_vertices;
pub(crate) use renumber::{renumber, retain_numbered};
pub use resemblance::Resemblance;
pub(crate) use sanitize::drop_triangles;
pub use source::Progress;
pub(crate) use validate::{validate_placed, validate_transform};

use crate::geom::{Aabb, Affine, Point};

/// A scene: meshes stored once, and the places where they stand.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// In file order. Each is stored once, however many instances name it.
    pub meshes: Vec<Mesh>,
    /// In file order (depth-first node order for glTF). A mesh that no instance names is not part of the scene.
    pub instances: Vec<Instance>,
    /// What reading dropped or repaired.
    pub report: ReadReport,
    /// What rounding the positions cost.
    pub rounding: Rounding,
    /// What becomes of triangles that lose their area where an instance puts them: the policy that the scene was read by.
    pub degenerate: Degenerate,
    /// The moment of an animation that it stands at; `None` where it stands at rest.
    pub posed: Option<Posed>,
    /// Every file whose bytes the scene was made from, in the order of first use; the model file itself comes first.
    pub inputs: Vec<InputFile>,
}

/// An indexed triangle mesh: what becomes one BLAS.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// As the source names it, for messages; may be empty.
    pub name: String,
    /// In the mesh's own unit and space; those that a triangle uses are finite.
    pub positions: Vec<Point>,
    /// What rounding each position to `f32` left off, itself rounded: position + remainder is the position to 48 bits. Empty where every
    /// position is exact, as in most files; not where morph targets, joints or normalized integers make it.
    pub remainders: Vec<Point>,
    /// Indices into `positions`, three a triangle, all in range.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle its number in the source mesh, counted before anything was dropped and over all parts in order.
    /// Empty when nothing was dropped: triangle `i` then is source triangle `i`.
    ///
    /// The number minus [`Part::first_prim`] of its part is the triangle's number in the source's primitive. In a glTF primitive triangle `i`
    /// of a list has the indices `3i`, `3i + 1` and `3i + 2`; of a strip `i`, `i + 1` and `i + 2`, the last two swapped where `i`
    /// is odd; of a fan `i + 1`, `i + 2` and `0` (glTF 2.0, 3.7.2.1). Where restart values divide a strip or fan, each piece is numbered
    /// behind the one before it.
    pub source_prims: Vec<u32>,
    /// For each triangle the numbers of its three vertices in the source; empty where they were not asked for
    /// ([`ReadOptions::vertices`]). Of a glTF mesh they are vertices of the primitive, of an OBJ the corners of all faces, counted from 0.
    pub vertices: Vec<[u32; 3]>,
    /// Which runs of `triangles` came from which OBJ group or glTF primitive, in order, covering all of them.
    pub parts: Vec<Part>,
    /// BLAKE3 of the corners of all faces before they were cut into triangles, where that was asked for ([`ReadOptions::faces`]) and some face of an OBJ
    /// model has more than three. Meshes with equal hashes have the same polygons, although they may be cut otherwise.
    pub faces: Option<[u8; 32]>,
}

/// One OBJ object/group/material run or one glTF primitive: a row of the file's `GEOM` table. Names are those of the source, letter by
/// letter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Of an OBJ its object and group (`Lamp`, `/off` or `Lamp/off`), as section 10.4 of the specification writes them; of a glTF primitive the name of the
    /// mesh, which all of its primitives share. Empty if the source names none.
    ///
    /// Nodes have names too, but one mesh may stand on many: see [`Instance::name`].
    pub name: String,
    /// Name of the material: of an OBJ what `usemtl` says, with `%` and two hexadecimal digits for `%` and for bytes that are not UTF-8.
    /// Empty if there is none or the source does not name it.
    pub material: String,
    /// Index of the source mesh (glTF mesh index; 0 for OBJ).
    pub source_mesh: u32,
    /// Index of the glTF primitive in its mesh, or of the OBJ run in its file.
    pub source_part: u32,
    /// The node whose transform was baked into the positions: when several instances were flattened into one mesh, or when the transform
    /// has no inverse, as that of a decal made by a scale of 0.
    pub baked_node: Option<u32>,
    /// The transform that was baked into the positions mirrors, so that the corners wind the other way round.
    pub mirrored: bool,
    /// First of this part's triangles in [`Mesh::triangles`].
    pub first_triangle: u32,
    /// How many of [`Mesh::triangles`] are the part's.
    pub triangle_count: u32,
    /// Number of the part's first triangle in the source mesh, as in [`Mesh::source_prims`].
    pub first_prim: u32,
    /// Triangles of the part in the source, dropped ones included.
    pub prim_count: u32,
}

/// One mesh at one place.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Object to world; finite and invertible.
    pub transform: Affine,
    /// Source node index, 0 for OBJ; [`Instance::NO_NODE`] where the transform is no node's, or several nodes' geometry stands there. Nodes with `EXT_mesh_gpu_instancing` appear once per instance.
    pub node: u32,
    /// Of the node that places it; empty where the node or the source names none.
    pub name: String,
}

/// A file that the scene depends on: the raw material of the build key and the depfile.
#[derive(Clone, Debug, PartialEq)]
pub struct InputFile {
    /// As reached from the working directory (the path given, or that path's folder joined with the reference in the model).
    pub path: std::path::PathBuf,
    /// As written in the model relative to its folder; the file name for the model itself. Never absolute.
    pub name: String,
    /// Bytes, as read.
    pub len: u64,
    /// BLAKE3 of the bytes, as read.
    pub blake3: [u8; 32],
}

/// What rounding cost the mesh that lost most, in reading.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Rounding {
    /// From the numbers in the file to [`Mesh::positions`], where a file has more digits than `f32`.
    pub loss: Loss,
    /// The file's own numbers are of 32 bits, and these lie so far apart where the model is: its shape was lost before it was written.
    pub rounded_before: Option<f64>,
    /// From there onto the grid that [`ReadOptions::vertex_bits`] asks for; `None` where it asks for none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<Loss>,
}

/// What reading had to drop or repair, and what of a model a still scene cannot show. All zero for a clean file.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct ReadReport {
    /// Triangles with two equal corners or zero area (collinear corners), found by an exact test in `f64`.
    pub degenerate_triangles: u64,
    /// Triangles that use a NaN or infinite position; always dropped unless the policy is `error`.
    pub non_finite_triangles: u64,
    /// Triangles of an OBJ with a coordinate that is a number and beyond the range of `f32`; they are treated as those of
    /// `non_finite_triangles`, and not among them.
    pub out_of_range_triangles: u64,
    /// Positions that no triangle uses.
    pub unreferenced_positions: u64,
    /// Lines, points and other things that a triangle hierarchy cannot hold: OBJ statements (`l`, `p`, curves, faces of fewer
    /// than three corners), glTF primitives (points, lines, and such without positions).
    pub skipped_primitives: u64,
    /// Those of `skipped_primitives` that are OBJ faces of fewer than three corners: of text that was cut off, or of a faulty exporter.
    pub short_faces: u64,
    /// Positions of an OBJ with a weight other than 1, which only rational curves and surfaces have: they stand where their first three numbers say.
    pub ignored_weights: u64,
    /// Instances whose transform has a scale of 0 along every axis: nothing is left of them.
    pub singular_instances: u64,
    /// Instances that stand or reach beyond the range of `f32`, where no file can place them.
    pub out_of_range_instances: u64,
    /// The largest coordinate or matrix entry among these and the triangles out of range; 0 if there are none.
    pub largest_magnitude: f64,
    /// Statements of an OBJ with a keyword that is not known: a keyword in capitals, the mark of an unfinished merge, a file to be read in
    /// their place (`call`).
    pub unknown_statements: u64,
    /// The first of these.
    pub first_unknown_statement: Option<Statement>,
    /// glTF animations of a model of which none is played, so that everything stands at rest. Where one is played, the others
    /// are not counted.
    pub unplayed_animations: u64,
    /// Channels of the animation that is played with a path that glTF does not know.
    pub unknown_channels: u64,
    /// glTF nodes with a skin that has no joints, or with primitives that have no joints or weights: those stand where the node puts them.
    pub unposed_skins: u64,
    /// Nodes with a skin and `EXT_mesh_gpu_instancing`, which says nothing on skins: their meshes stand once, where the joints put them.
    pub uninstanced_skins: u64,
    /// Nodes whose skin's joints all mirror: corners of their triangles wind the other way round, and glTF does not say which side is then the front.
    pub mirrored_skins: u64,
    /// Vertices of skinned meshes whose weights are all zero: they follow their first joint.
    pub unweighted_vertices: u64,
    /// Morph weights other than 0 that find no target.
    pub unapplied_morph_weights: u64,
    /// glTF primitives with a material that is not there: their parts have none.
    pub absent_materials: u64,
    /// glTF nodes with a matrix and with translation, rotation or scale beside it, of which a file may have either: the matrix places them.
    pub twice_placed_nodes: u64,
    /// glTF nodes with a mesh that `KHR_node_visibility` hides.
    pub hidden_nodes: u64,
    /// glTF extensions that may place triangles and are not heeded: those that the caller ignores though the file requires them, and those
    /// that are not honoured and that the file does not require.
    pub ignored_extensions: Vec<String>,
}

/// A statement of an OBJ.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Statement {
    /// Number of its line, counted from 1.
    pub line: u64,
    /// Its first word, shortened where it is long.
    pub word: String,
}

impl ReadReport {
    /// Take over what another frame of the same sequence lost more of: afterwards each count is the largest of all frames.
    pub fn raise(&mut self, frame: &ReadReport) {
        // Short faces are among the skipped primitives, so that both are raised apart and added up.
        let lines = |report: &ReadReport| report.skipped_primitives - report.short_faces.min(report.skipped_primitives);
        let lines = lines(self).max(lines(frame));
        let counts = [
            (&mut self.degenerate_triangles, frame.degenerate_triangles),
            (&mut self.non_finite_triangles, frame.non_finite_triangles),
            (&mut self.out_of_range_triangles, frame.out_of_range_triangles),
            (&mut self.unreferenced_positions, frame.unreferenced_positions),
            (&mut self.short_faces, frame.short_faces),
            (&mut self.ignored_weights, frame.ignored_weights),
            (&mut self.singular_instances, frame.singular_instances),
            (&mut self.out_of_range_instances, frame.out_of_range_instances),
            (&mut self.unknown_statements, frame.unknown_statements),
            (&mut self.unplayed_animations, frame.unplayed_animations),
            (&mut self.unknown_channels, frame.unknown_channels),
            (&mut self.unposed_skins, frame.unposed_skins),
            (&mut self.uninstanced_skins, frame.uninstanced_skins),
            (&mut self.mirrored_skins, frame.mirrored_skins),
            (&mut self.unweighted_vertices, frame.unweighted_vertices),
            (&mut self.unapplied_morph_weights, frame.unapplied_morph_weights),
            (&mut self.absent_materials, frame.absent_materials),
            (&mut self.twice_placed_nodes, frame.twice_placed_nodes),
            (&mut self.hidden_nodes, frame.hidden_nodes),
        ];
        for (most, count) in counts {
            *most = count.max(*most);
        }
        self.skipped_primitives = lines + self.short_faces;
        if self.first_unknown_statement.is_none() {
            self.first_unknown_statement.clone_from(&frame.first_unknown_statement);
        }
        self.largest_magnitude = self.largest_magnitude.max(frame.largest_magnitude);
        for extension in &frame.ignored_extensions {
            if let Err(place) = self.ignored_extensions.binary_search(extension) {
                self.ignored_extensions.insert(place, extension.clone());
            }
        }
    }
}

impl Instance {
    /// For [`Instance::node`].
    pub const NO_NODE: u32 = u32::MAX;
}

impl Mesh {
    /// The source number of triangle `i`.
    ///
    /// # Panics
    /// Where there is no such triangle or position.
    pub fn source_prim(&self, i: usize) -> u32 {
        if self.source_prims.is_empty() { i as u32 } else { self.source_prims[i] }
    }

    /// The triangle of part `part` that has the source number `prim`. Within a part source numbers ascend.
    pub fn triangle_of(&self, part: usize, prim: u32) -> Option<usize> {
        let part = self.parts.get(part)?;
        let first = part.first_triangle as usize;
        let all = first..first.checked_add(part.triangle_count as usize)?;
        if self.source_prims.is_empty() {
            let i = prim as usize;
            return (all.contains(&i) && i < self.triangles.len()).then_some(i);
        }
        self.source_prims.get(all)?.binary_search(&prim).ok().map(|i| first + i)
    }

    /// Position `v` as exactly as it is known.
    ///
    /// # Panics
    /// Where there is no such triangle or position.
    pub fn exact_position(&self, v: usize) -> [f64; 3] {
        let (position, remainder) = (self.positions[v], self.remainders.get(v).copied().unwrap_or_default());
        [0, 1, 2].map(|k| f64::from(position[k]) + f64::from(remainder[k]))
    }

    /// The positions of triangle `i`, in the mesh's own space.
    ///
    /// # Panics
    /// Where there is no such triangle or position.
    pub fn corners(&self, i: usize) -> [Point; 3] {
        self.triangles[i].map(|v| self.positions[v as usize])
    }

    /// The corners of triangle `i` moved by a transform, computed in `f64` and rounded once: what a file of one level holds.
    pub(crate) fn baked_corners(&self, i: usize, to_world: &Affine) -> [Point; 3] {
        self.triangles[i].map(|v| self.baked_position(v as usize, to_world))
    }

    /// Position `v` moved by a transform, computed in `f64` and rounded once.
    pub(crate) fn baked_position(&self, v: usize, to_world: &Affine) -> Point {
        to_world.transform_point(self.exact_position(v)).map(|c| c as f32)
    }

    /// The box of those corners, exact.
    ///
    /// # Panics
    /// Where there is no such triangle or position.
    pub fn triangle_box(&self, i: usize) -> Aabb {
        Aabb::from_points(&self.corners(i))
    }
}

impl Scene {
    /// Triangles after instancing: what a ray can hit. An instance of a mesh that is not there has none.
    pub fn instanced_triangles(&self) -> u64 {
        let meshes = self.instances.iter().filter_map(|i| self.meshes.get(i.mesh as usize));
        meshes.map(|mesh| mesh.triangles.len() as u64).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_is_found_by_its_number_in_its_part_alone() {
        let part = |first_triangle, triangle_count| Part { first_triangle, triangle_count, ..Part::default() };
        let mut mesh = Mesh { triangles: vec![[0, 1, 2]; 5], parts: vec![part(0, 2), part(2, 3)], ..Mesh::default() };
        let all = |mesh: &Mesh, prim| [0, 1, 2].map(|part| mesh.triangle_of(part, prim));
        assert_eq!(all(&mesh, 1), [Some(1), None, None]);
        assert_eq!(all(&mesh, 4), [None, Some(4), None]);
        assert_eq!(all(&mesh, 5), [None; 3]);

        // Numbers go on where triangles were dropped.
        mesh.source_prims = vec![0, 3, 4, 6, 9];
        assert_eq!((all(&mesh, 3), all(&mesh, 9)), ([Some(1), None, None], [None, Some(4), None]));
        assert_eq!(all(&mesh, 5), [None; 3]);

        // A part that says more than there is finds nothing.
        mesh.parts[1] = part(4, u32::MAX);
        assert_eq!(all(&mesh, 9), [None; 3]);
        mesh.source_prims.clear();
        assert_eq!(all(&mesh, 5), [None; 3]);
    }
}
