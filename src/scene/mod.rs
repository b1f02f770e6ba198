//! Reading: OBJ and glTF files become a [`Scene`] of indexed triangle meshes and instances, and nothing else.
//!
//! Everything that a reader must refuse or repair is settled here: after [`Scene`] leaves this room, every index is in
//! range, every position that a triangle uses is finite, and every transform is finite and invertible. What was dropped is counted
//! in [`ReadReport`]. Builders know no files; this room knows no trees.

mod collinear;
mod error;
mod gltf;
mod obj;
mod options;
mod precision;
mod read;
mod sanitize;
mod source;
mod validate;

pub(crate) use collinear::is_collinear;
pub use error::{ErrorKind, SceneError};
pub use options::{Degenerate, Format, ReadOptions};
pub(crate) use precision::shortest_edges;
pub use precision::{Loss, local_origin};
pub use read::{read, read_bytes, read_with};
pub(crate) use sanitize::drop_triangles;
pub use source::Progress;
pub use validate::GeometryError;

use crate::geom::{Aabb, Affine, Point};

/// A scene: meshes stored once, and the places where they stand.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub meshes: Vec<Mesh>,
    /// In file order (depth-first node order for glTF). A mesh that no instance names is not part of the scene.
    pub instances: Vec<Instance>,
    pub report: ReadReport,
    /// What rounding the positions cost.
    pub rounding: Rounding,
    /// What becomes of triangles that lose their area where an instance puts them: the policy that the scene was read by.
    pub degenerate: Degenerate,
    /// Every file whose bytes the scene was made from, in the order of first use; the model file itself comes first.
    pub inputs: Vec<InputFile>,
}

/// An indexed triangle mesh: what becomes one BLAS.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub name: String,
    pub positions: Vec<Point>,
    /// Indices into `positions`, three a triangle, all in range.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle its number in the source mesh, counted before anything was dropped and over all parts in order.
    /// Empty when nothing was dropped: triangle `i` then is source triangle `i`.
    pub source_prims: Vec<u32>,
    /// Which runs of `triangles` came from which OBJ group or glTF primitive, in order, covering all of them.
    pub parts: Vec<Part>,
}

/// One OBJ object/group/material run or one glTF primitive: a row of the file's `GEOM` table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Of an OBJ its object and group (`Lamp`, `/off` or `Lamp/off`), as `scene/obj/names.rs` writes them; empty if the source names none.
    pub name: String,
    /// Name of the material: of an OBJ what `usemtl` says, with `%` and two hexadecimal digits for `%` and for bytes that are not UTF-8.
    /// Empty if the source names none.
    pub material: String,
    /// Index of the source mesh (glTF mesh index; 0 for OBJ).
    pub source_mesh: u32,
    /// Index of the glTF primitive in its mesh, or of the OBJ run in its file.
    pub source_part: u32,
    /// The node whose transform was baked into the positions, when several instances were flattened into one mesh.
    pub baked_node: Option<u32>,
    /// First of this part's triangles in [`Mesh::triangles`].
    pub first_triangle: u32,
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
    pub name: String,
}

/// A file that the scene depends on: the raw material of the build key and the depfile.
#[derive(Clone, Debug, PartialEq)]
pub struct InputFile {
    /// As reached from the working directory (the path given, or that path's folder joined with the reference in the model).
    pub path: std::path::PathBuf,
    /// As written in the model relative to its folder; the file name for the model itself. Never absolute.
    pub name: String,
    pub len: u64,
    pub blake3: [u8; 32],
}

/// What rounding cost the mesh that lost most, in reading.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Rounding {
    /// From the numbers in the file to [`Mesh::positions`], where a file has more digits than `f32`.
    pub loss: Loss,
    /// The file's own numbers are of 32 bits, and these lie so far apart where the model is: its shape was lost before it was written.
    pub rounded_before: Option<f64>,
}

/// What reading had to drop or repair. All zero for a clean file.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct ReadReport {
    /// Triangles with two equal corners or zero area (collinear corners), found by an exact test in `f64`.
    pub degenerate_triangles: u64,
    /// Triangles that use a NaN or infinite position; always dropped unless the policy is `error`.
    pub non_finite_triangles: u64,
    /// Positions that no triangle uses.
    pub unreferenced_positions: u64,
    /// Lines, points and other things that a triangle hierarchy cannot hold: OBJ statements (`l`, `p`, curves, faces of fewer
    /// than three corners), glTF primitives (points, lines, and such without positions).
    pub skipped_primitives: u64,
    /// Instances whose transform is singular or not finite, and so has no inverse to take a ray into the mesh, or whose image
    /// in the world is beyond the range of `f32`.
    pub singular_instances: u64,
}

impl Instance {
    /// For [`Instance::node`].
    pub const NO_NODE: u32 = u32::MAX;
}

impl Mesh {
    /// The source number of triangle `i`.
    pub fn source_prim(&self, i: usize) -> u32 {
        if self.source_prims.is_empty() { i as u32 } else { self.source_prims[i] }
    }

    pub fn corners(&self, i: usize) -> [Point; 3] {
        self.triangles[i].map(|v| self.positions[v as usize])
    }

    pub fn triangle_box(&self, i: usize) -> Aabb {
        Aabb::from_points(&self.corners(i))
    }
}

impl Scene {
    /// Triangles after instancing: what a ray can hit.
    pub fn instanced_triangles(&self) -> u64 {
        self.instances.iter().map(|i| self.meshes[i.mesh as usize].triangles.len() as u64).sum()
    }
}
