//! [`GeometryError`]: why geometry cannot be built over.

use crate::geom::Point;
use std::fmt;

/// Why geometry cannot be built over. Numbers count from 0.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum GeometryError {
    /// A triangle names a position that is not there.
    IndexOutOfRange {
        /// The mesh.
        mesh: usize,
        /// The triangle.
        triangle: usize,
        /// The index that it has.
        index: u32,
        /// How many positions the mesh has.
        positions: usize,
    },
    /// A triangle has a corner that is NaN or infinite.
    NotFinite {
        /// The mesh.
        mesh: usize,
        /// The triangle.
        triangle: usize,
        /// Index of the position.
        index: u32,
        /// The position.
        position: Point,
    },
    /// The parts of a mesh do not cover its triangles one after the other.
    Parts {
        /// The mesh.
        mesh: usize,
        /// The first part that does not begin where the one before ends, or the number of parts.
        part: usize,
        /// The triangle that the part should begin with, or the number of triangles that all should cover.
        expected: usize,
        /// What it begins with, or what all cover.
        found: usize,
    },
    /// A position's remainder is NaN or infinite.
    Remainder {
        /// The mesh.
        mesh: usize,
        /// Index of the position.
        index: usize,
        /// The remainder.
        remainder: Point,
    },
    /// A list parallel to the triangles has another length.
    SourcePrims {
        /// The mesh.
        mesh: usize,
        /// How many triangles the mesh has.
        triangles: usize,
        /// How many numbers the list has.
        numbers: usize,
    },
    /// The vertices of a mesh's triangles are not as many as the triangles.
    Vertices {
        /// The mesh.
        mesh: usize,
        /// How many triangles the mesh has.
        triangles: usize,
        /// How many triples of vertices it has.
        vertices: usize,
    },
    /// Two triangles of a part give one vertex of the source two places.
    VertexPlaces {
        /// The mesh.
        mesh: usize,
        /// The part, 0 where the mesh has none.
        part: usize,
        /// The vertex, as [`Mesh::vertices`](super::Mesh::vertices) numbers it.
        vertex: u32,
        /// The two triangles.
        triangles: [usize; 2],
        /// Indices of the position that each of them gives it.
        positions: [u32; 2],
    },
    /// The remainders of a mesh's positions are not as many as the positions.
    Remainders {
        /// The mesh.
        mesh: usize,
        /// How many positions the mesh has.
        positions: usize,
        /// How many remainders it has.
        remainders: usize,
    },
    /// A triangle's number in the source lies outside of its part, or does not lie behind that of the triangle before it.
    SourceNumber {
        /// The mesh.
        mesh: usize,
        /// The triangle.
        triangle: usize,
        /// The number that it has.
        number: u32,
    },
    /// Two parts of one mesh of the source have numbers of triangles in common, and no node tells them apart.
    PartNumbers {
        /// The mesh.
        mesh: usize,
        /// The part.
        part: usize,
        /// The part that has the same numbers.
        other: usize,
        /// The first number that both have.
        number: u32,
    },
    /// A mesh has more triangles or positions than 32-bit numbers count.
    TooMany {
        /// The mesh.
        mesh: usize,
        /// Triangles or positions, whichever are more.
        count: usize,
    },
    /// The numbers of a part do not end within 32 bits.
    PartRange {
        /// The mesh.
        mesh: usize,
        /// The part.
        part: usize,
        /// Its `first_prim`.
        first: u32,
        /// Its `prim_count`.
        count: u32,
    },
    /// A part says that it was baked at another node than where an instance places its mesh.
    PartNode {
        /// The mesh.
        mesh: usize,
        /// The part.
        part: usize,
        /// Its `baked_node`.
        node: u32,
        /// The instance's node.
        placed: u32,
    },
    /// An instance names a mesh that is not there.
    MeshOutOfRange {
        /// The instance.
        instance: usize,
        /// The mesh that it names.
        mesh: u32,
        /// How many meshes the scene has.
        meshes: usize,
    },
    /// A scene has the largest number that a node may have, and an instance needs one behind it.
    NoNode {
        /// The largest number of a node in the scene.
        largest: u32,
    },
    /// An instance's transform is not finite, or has no inverse that takes a ray into the mesh: none at all, none that `f64` can tell, or none in the range of
    /// `f32`.
    Transform {
        /// The instance.
        instance: usize,
        /// The determinant of the transform's linear part.
        determinant: f64,
        /// The largest magnitude among the transform's entries.
        largest: f64,
    },
}

impl fmt::Display for GeometryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            GeometryError::IndexOutOfRange { mesh, triangle, index, positions } => write!(
                f,
                "triangle {triangle} of mesh {mesh} names position {index}, but the mesh has {positions} positions"
            ),
            GeometryError::NotFinite { mesh, triangle, index, position: [x, y, z] } => write!(
                f,
                "triangle {triangle} of mesh {mesh} uses position {index}, which is not finite: ({x}, {y}, {z})"
            ),
            GeometryError::Remainder { mesh, index, remainder: [x, y, z] } => {
                write!(f, "the remainder of position {index} of mesh {mesh} is not finite: ({x}, {y}, {z})")
            }
            GeometryError::Parts { mesh, part, expected, found } => write!(
                f,
                "the parts of mesh {mesh} must cover its triangles in order: at part {part}, {expected} is expected and {found} stated"
            ),
            GeometryError::SourcePrims { mesh, triangles, numbers } => {
                write!(
                    f,
                    "mesh {mesh} has {triangles} triangles and {numbers} source numbers; it must have as many, or none"
                )
            }
            GeometryError::Vertices { mesh, triangles, vertices } => write!(
                f,
                "mesh {mesh} has {triangles} triangles and the vertices of {vertices}; it must have those of all, or none"
            ),
            GeometryError::VertexPlaces { mesh, part, vertex, triangles: [a, b], positions: [m, n] } => write!(
                f,
                "triangles {a} and {b} of mesh {mesh} have vertex {vertex} of part {part} at positions {m} and {n}, which differ; a vertex of a part \
                 stands in one place"
            ),
            GeometryError::Remainders { mesh, positions, remainders } => {
                write!(
                    f,
                    "mesh {mesh} has {positions} positions and {remainders} remainders; it must have as many, or none"
                )
            }
            GeometryError::SourceNumber { mesh, triangle, number } => write!(
                f,
                "triangle {triangle} of mesh {mesh} has source number {number}, which is outside of its part, or not behind the one before, or given twice"
            ),
            GeometryError::PartNumbers { mesh, part, other, number } => write!(
                f,
                "parts {part} and {other} of mesh {mesh} both have triangle {number} of the source; parts of one source mesh have no number in common"
            ),
            GeometryError::TooMany { mesh, count } => {
                write!(f, "mesh {mesh} has {count} triangles or positions, and 32-bit numbers count {}", u32::MAX)
            }
            GeometryError::PartRange { mesh, part, first, count } => write!(
                f,
                "part {part} of mesh {mesh} has {count} numbers from {first} on; the last one must be below {}",
                u32::MAX
            ),
            GeometryError::PartNode { mesh, part, node, placed } => write!(
                f,
                "part {part} of mesh {mesh} was baked at node {node}, and an instance of the mesh stands at node {placed}; they must be one"
            ),
            GeometryError::MeshOutOfRange { instance, mesh, meshes } => {
                write!(f, "instance {instance} names mesh {mesh}, but the number of meshes is {meshes}")
            }
            GeometryError::NoNode { largest } => {
                write!(f, "an instance needs a node number behind {largest}, which is the largest that there is")
            }
            GeometryError::Transform { instance, determinant, largest } => write!(
                f,
                "the transform of instance {instance} has the determinant {determinant:.3e} and entries of up to {largest:.3e}; it must be finite and \
                 have an inverse that 32-bit floats can hold"
            ),
        }
    }
}

impl std::error::Error for GeometryError {}
