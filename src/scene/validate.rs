//! What must hold of geometry before anything is built over it.
//!
//! The readers hold all of it. Geometry that a program brings in arrays passes through [`Mesh::new`] and [`Scene::new`], and whatever it
//! changed afterwards is found by [`Scene::validate`], which every build calls first.

use super::geometry_error::GeometryError;
use super::{Instance, Mesh, Part, Scene};
use crate::exec::Executor;
use crate::geom::{Affine, Point};

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
        self.validate_parts(number)?;
        self.validate_vertices(number)
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
        if self.parts.is_empty() {
            self.validate_own_numbers(mesh)?;
        }
        let mut next = 0usize;
        for (part, p) in self.parts.iter().enumerate() {
            if p.first_triangle as usize != next {
                return Err(GeometryError::Parts { mesh, part, expected: next, found: p.first_triangle as usize });
            }
            next += p.triangle_count as usize;
            if p.first_prim.checked_add(p.prim_count).is_none() {
                return Err(GeometryError::PartRange { mesh, part, first: p.first_prim, count: p.prim_count });
            }
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

    /// Of a mesh without parts no two triangles have one number.
    fn validate_own_numbers(&self, mesh: usize) -> Result<(), GeometryError> {
        if self.source_prims.is_sorted_by(|a, b| a < b) {
            return Ok(());
        }
        let mut order: Vec<(u32, usize)> = self.source_prims.iter().copied().zip(0..).collect();
        order.sort_unstable();
        match order.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            None => Ok(()),
            Some(pair) => Err(GeometryError::SourceNumber { mesh, triangle: pair[1].1, number: pair[1].0 }),
        }
    }

    /// The parts that were baked at a node, with that.
    fn baked(&self) -> impl Iterator<Item = (usize, u32)> {
        self.parts.iter().enumerate().filter_map(|(part, p)| Some((part, p.baked_node?)))
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
    let baked: Vec<Vec<(usize, u32)>> = meshes.iter().map(|mesh| mesh.baked().collect()).collect();
    for (instance, i) in instances.iter().enumerate() {
        if i.mesh as usize >= meshes.len() {
            return Err(GeometryError::MeshOutOfRange { instance, mesh: i.mesh, meshes: meshes.len() });
        }
        validate_transform(instance, &i.transform)?;
        // Nobody could tell which of the two a hit belongs to.
        let mesh = i.mesh as usize;
        let is_other = |node: u32| node == Instance::NO_NODE || i.node != Instance::NO_NODE && node != i.node;
        if let Some(&(part, node)) = baked[mesh].iter().find(|(_, node)| is_other(*node)) {
            return Err(GeometryError::PartNode { mesh, part, node, placed: i.node });
        }
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
