//! What must hold of geometry before anything is built over it.
//!
//! The readers hold all of it. Geometry that a program brings in arrays passes through [`Mesh::new`] and [`Scene::new`], and whatever it
//! changed afterwards is found by [`Scene::validate`], which every build calls first.

use super::{Instance, Mesh, Part, Scene};
use crate::exec::Executor;
use crate::geom::{Affine, Point};
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
    /// An instance names a mesh that is not there.
    MeshOutOfRange {
        /// The instance.
        instance: usize,
        /// The mesh that it names.
        mesh: u32,
        /// How many meshes the scene has.
        meshes: usize,
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
            GeometryError::Remainders { mesh, positions, remainders } => {
                write!(
                    f,
                    "mesh {mesh} has {positions} positions and {remainders} remainders; it must have as many, or none"
                )
            }
            GeometryError::SourceNumber { mesh, triangle, number } => write!(
                f,
                "triangle {triangle} of mesh {mesh} has source number {number}, which is outside of its part or not behind the one before"
            ),
            GeometryError::PartNumbers { mesh, part, other, number } => write!(
                f,
                "parts {part} and {other} of mesh {mesh} both have triangle {number} of the source; parts of one source mesh have no number in common"
            ),
            GeometryError::TooMany { mesh, count } => {
                write!(f, "mesh {mesh} has {count} triangles or positions, and 32-bit numbers count {}", u32::MAX)
            }
            GeometryError::MeshOutOfRange { instance, mesh, meshes } => {
                write!(f, "instance {instance} names mesh {mesh}, but the scene has {meshes} meshes")
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

impl Mesh {
    /// A mesh of one part from arrays: `triangles` are indices into `positions`.
    ///
    /// ```
    /// use bvhc::scene::{GeometryError, Mesh};
    ///
    /// let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = Mesh::new("roof", positions.clone(), vec![[0, 1, 2]])?;
    /// assert_eq!(mesh.parts[0].name, "roof");
    ///
    /// let error = Mesh::new("roof", positions, vec![[0, 1, 3]]).unwrap_err();
    /// assert!(matches!(error, GeometryError::IndexOutOfRange { triangle: 0, index: 3, positions: 3, .. }));
    /// # Ok::<(), GeometryError>(())
    /// ```
    ///
    /// # Errors
    /// Where an index is out of range or a corner is not finite.
    pub fn new(
        name: impl Into<String>,
        positions: Vec<Point>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Mesh, GeometryError> {
        let name = name.into();
        let count = triangles.len() as u32; // more than 32 bits are refused below
        let part = Part { name: name.clone(), triangle_count: count, prim_count: count, ..Part::default() };
        let mesh = Mesh { name, positions, triangles, parts: vec![part], ..Mesh::default() };
        mesh.validate(0, &Executor::sequential())?;
        Ok(mesh)
    }

    /// Hold a mesh against what every build relies on; `number` is what errors call it.
    ///
    /// # Errors
    /// The first thing that is wrong, in the order of triangles.
    pub fn validate(&self, number: usize, exec: &Executor) -> Result<(), GeometryError> {
        let most = self.triangles.len().max(self.positions.len());
        if u32::try_from(most).is_err() {
            return Err(GeometryError::TooMany { mesh: number, count: most });
        }
        let (positions, remainders) = (self.positions.len(), self.remainders.len());
        if remainders != 0 && remainders != positions {
            return Err(GeometryError::Remainders { mesh: number, positions, remainders });
        }
        if let Some(index) = self.remainders.iter().position(|r| !r.iter().all(|c| c.is_finite())) {
            return Err(GeometryError::Remainder { mesh: number, index, remainder: self.remainders[index] });
        }
        let (triangles, vertices) = (self.triangles.len(), self.vertices.len());
        if vertices != 0 && vertices != triangles {
            return Err(GeometryError::Vertices { mesh: number, triangles, vertices });
        }
        self.validate_corners(number, exec)?;
        self.validate_parts(number)
    }

    fn validate_corners(&self, mesh: usize, exec: &Executor) -> Result<(), GeometryError> {
        /// Triangles of one task.
        const CHUNK: usize = 1 << 14;
        let positions = self.positions.len();
        let chunks = exec.map_chunks(&self.triangles, CHUNK, |chunk, some| {
            some.iter().enumerate().try_for_each(|(i, corners)| {
                let triangle = chunk * CHUNK + i;
                corners.iter().try_for_each(|&index| match self.positions.get(index as usize) {
                    None => Err(GeometryError::IndexOutOfRange { mesh, triangle, index, positions }),
                    Some(position) if !position.iter().all(|c| c.is_finite()) => {
                        Err(GeometryError::NotFinite { mesh, triangle, index, position: *position })
                    }
                    Some(_) => Ok(()),
                })
            })
        });
        chunks.into_iter().collect()
    }

    /// A mesh made by hand may have no parts and no numbers: a build then gives it one part.
    fn validate_parts(&self, mesh: usize) -> Result<(), GeometryError> {
        let (triangles, numbers) = (self.triangles.len(), self.source_prims.len());
        if numbers != 0 && numbers != triangles {
            return Err(GeometryError::SourcePrims { mesh, triangles, numbers });
        }
        // The largest number has none behind it, which the numbers of a part end with.
        if self.parts.is_empty()
            && let Some(triangle) = self.source_prims.iter().position(|number| *number == u32::MAX)
        {
            return Err(GeometryError::SourceNumber { mesh, triangle, number: u32::MAX });
        }
        let mut next = 0usize;
        for (part, p) in self.parts.iter().enumerate() {
            if p.first_triangle as usize != next {
                return Err(GeometryError::Parts { mesh, part, expected: next, found: p.first_triangle as usize });
            }
            next += p.triangle_count as usize;
        }
        if !self.parts.is_empty() && next != triangles {
            return Err(GeometryError::Parts { mesh, part: self.parts.len(), expected: triangles, found: next });
        }
        for p in &self.parts {
            let numbers = u64::from(p.first_prim)..u64::from(p.first_prim) + u64::from(p.prim_count);
            let mut before = None;
            for triangle in p.first_triangle as usize..(p.first_triangle + p.triangle_count) as usize {
                let number = self.source_prim(triangle);
                if !numbers.contains(&u64::from(number)) || before.is_some_and(|before| before >= number) {
                    return Err(GeometryError::SourceNumber { mesh, triangle, number });
                }
                before = Some(number);
            }
        }
        self.validate_numbers(mesh)
    }

    /// No two triangles of the source have one number. Copies of a part, each for another node, are told apart by that.
    fn validate_numbers(&self, mesh: usize) -> Result<(), GeometryError> {
        let start = |part: usize| (self.parts[part].source_mesh, self.parts[part].first_prim);
        let end = |part: usize| {
            (
                self.parts[part].source_mesh,
                u64::from(self.parts[part].first_prim) + u64::from(self.parts[part].prim_count),
            )
        };
        let named = |part: &usize| self.parts[*part].baked_node.is_none() && self.parts[*part].prim_count > 0;
        let mut order: Vec<usize> = (0..self.parts.len()).filter(named).collect();
        if !order.is_sorted_by_key(|part| start(*part)) {
            order.sort_by_key(|part| start(*part));
        }
        for pair in order.windows(2) {
            let [other, part] = [pair[0], pair[1]];
            let (source, number) = start(part);
            if (source, u64::from(number)) < end(other) {
                return Err(GeometryError::PartNumbers { mesh, part, other, number });
            }
        }
        Ok(())
    }
}

impl Scene {
    /// A scene from meshes and the places where they stand.
    ///
    /// # Errors
    /// As [`Scene::validate`].
    pub fn new(meshes: Vec<Mesh>, instances: Vec<Instance>) -> Result<Scene, GeometryError> {
        let scene = Scene { meshes, instances, ..Scene::default() };
        scene.validate(&Executor::sequential())?;
        Ok(scene)
    }

    /// One mesh where it is.
    pub fn of_mesh(mesh: Mesh) -> Scene {
        let instance = Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: mesh.name.clone() };
        Scene { meshes: vec![mesh], instances: vec![instance], ..Scene::default() }
    }

    /// Hold a scene against what every build relies on: meshes as [`Mesh::validate`] has it, instances that name a mesh and whose
    /// transforms are finite and invertible.
    ///
    /// # Errors
    /// The first thing that is wrong: meshes before instances, each in their order.
    pub fn validate(&self, exec: &Executor) -> Result<(), GeometryError> {
        validate_placed(&self.meshes, &self.instances, exec)
    }
}

/// [`Scene::validate`] of its parts.
pub(crate) fn validate_placed(meshes: &[Mesh], instances: &[Instance], exec: &Executor) -> Result<(), GeometryError> {
    meshes.iter().enumerate().try_for_each(|(i, mesh)| mesh.validate(i, exec))?;
    for (instance, i) in instances.iter().enumerate() {
        if i.mesh as usize >= meshes.len() {
            return Err(GeometryError::MeshOutOfRange { instance, mesh: i.mesh, meshes: meshes.len() });
        }
        validate_transform(instance, &i.transform)?;
    }
    Ok(())
}

/// A ray can be taken into the mesh that this transform places: it has an inverse, and as a file stores it one that `f64` can tell. What does
/// not fit in `f32` is refused where it is placed.
pub(crate) fn validate_transform(instance: usize, transform: &Affine) -> Result<(), GeometryError> {
    let fits = transform.to_f32().iter().all(|entry| entry.is_finite());
    if transform.inverse().is_some() && (!fits || transform.is_storable()) {
        return Ok(());
    }
    // Comparison with NaN is false, so that NaN stays once it is there.
    let larger = |a: f64, b: &f64| if b.abs() <= a { a } else { b.abs() };
    let largest = transform.rows.iter().flatten().fold(0.0, larger);
    Err(GeometryError::Transform { instance, determinant: transform.determinant(), largest })
}
