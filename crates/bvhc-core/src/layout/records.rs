use std::cmp::Ordering;

use crate::geom::orient::orient3d;

/// `TRIS`: one slot of the leaf order, 48 bytes, three aligned 16-byte loads. Duplicated wherever a spatial split put it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleRecord {
    /// First corner, in the space of the BLAS.
    pub v0: [f32; 3],
    /// Number of the triangle in its source mesh (before anything was dropped). `prim - GEOM.first_prim` is its number in the part.
    pub prim: u32,
    /// Second corner, which [`Hit::u`](crate::Hit::u) is the weight of.
    pub v1: [f32; 3],
    /// Row of `GEOM`.
    pub geom: u32,
    /// Third corner, which [`Hit::v`](crate::Hit::v) is the weight of.
    pub v2: [f32; 3],
    /// Bit 0: this triangle stands in more than one leaf of its BLAS. Other bits zero.
    pub flags: u32,
}

impl TriangleRecord {
    /// The bit of [`TriangleRecord::flags`].
    pub const DUPLICATED: u32 = 1;

    /// All three: counter-clockwise as seen from the front (`format-spec/SPEC.md`, section 10).
    #[inline]
    pub fn corners(&self) -> [[f32; 3]; 3] {
        [self.v0, self.v1, self.v2]
    }
}

/// "No source node" in [`GeomRecord::baked_node`].
pub const NO_NODE: u32 = u32::MAX;

/// `GEOM`: which source part a run of primitive numbers came from, 64 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeomRecord {
    /// Index of the source mesh (glTF mesh index; 0 for OBJ).
    pub source_mesh: u32,
    /// glTF primitive index in that mesh, or OBJ run index in the file.
    pub source_part: u32,
    /// Source node whose transform was baked into the positions, or [`NO_NODE`].
    pub baked_node: u32,
    /// The BLAS that holds this part.
    pub blas: u32,
    /// First primitive number of the part in its source mesh.
    pub first_prim: u32,
    /// Primitives of the part in the source, dropped ones included.
    pub prim_count: u32,
    /// Primitives of the part that are in the file, each counted once.
    pub kept_count: u32,
    /// Zero.
    pub reserved: u32,
    /// BLAKE3 of the part's name in UTF-8; all zero for an unnamed part.
    pub name_hash: [u8; 32],
}

/// `BLAS`: one tree, 64 bytes. Node and reference indices inside a tree count from its own start.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlasRecord {
    /// Near corner of the root's box; all zero for an empty tree.
    pub min: [f32; 3],
    /// Records in `NODE`, the unused record 1 included: 0 for an empty tree, otherwise even.
    pub node_count: u32,
    /// Far corner of the root's box.
    pub max: [f32; 3],
    /// Records in `TRIS`.
    pub ref_count: u32,
    /// First record in `NODE`; always even.
    pub node_offset: u64,
    /// First record in `TRIS`.
    pub ref_offset: u64,
    /// Distinct triangles; `ref_count` is larger only with `DUP_REFS`.
    pub prim_count: u32,
    /// Depth of the tree's deepest leaf; the root has depth 0.
    pub max_depth: u32,
    /// SAH cost with C_T = 1.2 and C_I = 1.0, over the root's area; 0 for an empty or flat-point root.
    pub sah: f32,
    /// [`tree_flags`] of this tree: `REFITTABLE` or `DUP_REFS`.
    pub flags: u32,
}

/// `INST`: one mesh at one place, 128 bytes, in TLAS leaf order.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InstanceRecord {
    /// Object to world, three rows of four.
    pub object_to_world: [f32; 12],
    /// World to object: the inverse, computed in `f64` from the rounded `object_to_world` and rounded once.
    pub world_to_object: [f32; 12],
    /// The BLAS that stands there.
    pub blas: u32,
    /// Index of the instance in the scene's order.
    pub id: u32,
    /// Visibility mask for the renderer; all ones.
    pub mask: u32,
    /// Bit 0: the transform mirrors (negative determinant). Other bits zero.
    pub flags: u32,
    /// Source node index.
    pub node: u32,
    /// All zero.
    pub reserved: [u32; 3],
}

impl InstanceRecord {
    /// The bit of [`InstanceRecord::flags`].
    pub const MIRRORED: u32 = 1;
}

/// The sign of the determinant of a matrix of three rows of four, exactly: `Less` where the matrix mirrors, `Equal` where it has no inverse.
pub fn orientation(matrix: &[f32; 12]) -> Ordering {
    let [a, b, c] = [0, 4, 8].map(|i| [matrix[i], matrix[i + 1], matrix[i + 2]]);
    orient3d(a, b, c, [0.0; 3])
}

const _: () = assert!(size_of::<TriangleRecord>() == 48);
const _: () = assert!(size_of::<GeomRecord>() == 64);
const _: () = assert!(size_of::<BlasRecord>() == 64);
const _: () = assert!(size_of::<InstanceRecord>() == 128);

/// Bits of a word of `SIDE`.
pub mod side_flags {
    /// The transform that was baked into the part's positions mirrors: `(v1 − v0) × (v2 − v0)` points to the back.
    pub const MIRRORED: u32 = 1;
}

crate::pod::plain! {
    TriangleRecord = [[f32; 3], u32, [f32; 3], u32, [f32; 3], u32];
    GeomRecord = [[u32; 8], [u8; 32]];
    BlasRecord = [[f32; 3], u32, [f32; 3], u32, [u64; 2], [u32; 2], f32, u32];
    InstanceRecord = [[[f32; 12]; 2], [u32; 8]];
}

/// Bits of the header's `tree_flags`.
pub mod tree_flags {
    /// No leaf box was clipped: boxes are a function of the vertices, so the file can be refitted.
    pub const REFITTABLE: u32 = 1;
    /// Spatial splits: a triangle may stand in several leaves.
    pub const DUP_REFS: u32 = 2;
    /// Nodes and leaves stand in canonical depth-first order.
    pub const CANONICAL_DFS: u32 = 4;
    /// The file has many frames: [`required_features::SEQUENCE`](crate::layout::required_features::SEQUENCE).
    pub const SEQUENCE: u32 = 8;
    /// `TNOD` and `INST` are present.
    pub const TWO_LEVEL: u32 = 16;
}
