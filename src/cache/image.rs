use super::{
    BlasRecord, CacheError, GeomRecord, InstanceRecord, NO_NODE, TriangleRecord, View, clip_name, side_flags,
    tree_flags,
};
use bvhc_core::layout::orientation;

use crate::exec::Executor;
use crate::geom::{Aabb, Affine};
use crate::scene::{Instance, Mesh, Part};
use crate::trace::Turns;
use crate::trace::wide::CompactTrees;
use crate::tree::{Accel, Node, Tree, quality};

/// The content of a cache file in memory, ready to be written or traversed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// `NODE`: tree after tree, as [`BlasRecord::node_offset`] says.
    pub nodes: Vec<Node>,
    /// `TRIS`: tree after tree in leaf order, as [`BlasRecord::ref_offset`] says.
    pub triangles: Vec<TriangleRecord>,
    /// `GEOM`: the source parts.
    pub geoms: Vec<GeomRecord>,
    /// `BLAS`: one record for each tree.
    pub blases: Vec<BlasRecord>,
    /// `TNOD`; empty without the flag [`tree_flags::TWO_LEVEL`].
    pub tlas_nodes: Vec<Node>,
    /// `INST`, in the order of the TLAS's leaves; empty without that flag.
    pub instances: Vec<InstanceRecord>,
    /// Names of the parts, one for each row of `geoms`; empty where no names are known.
    pub names: Vec<String>,
    /// Names of the parts' materials, one for each row of `geoms`; empty where none are known.
    pub materials: Vec<String>,
    /// For each row of `geoms` bits of [`side_flags`]; empty where none has any.
    pub sides: Vec<u32>,
    /// For each of `triangles` its vertices in the source; empty where they were not asked for.
    pub vertices: Vec<[u32; 3]>,
    /// `CROW`, `CNOD` and `CREF`; `None` for a file of binary trees alone.
    pub compact: Option<CompactTrees>,
    /// `OROW` and `ONOD`; `None` for a file whose boxes all lie along the axes of the scene.
    pub turns: Option<Turns>,
    /// Bits of [`tree_flags`].
    pub flags: u32,
}

impl Image {
    /// Lay out trees and geometry as the file's records.
    ///
    /// # Errors
    /// Where only some meshes have the numbers of their vertices, or a tree refers to triangles, a part to triangles, or an instance to a mesh
    /// that is not there. Whether the trees are sound beyond that is asked when the image is written.
    pub fn new(accel: &Accel, exec: &Executor) -> Result<Image, CacheError> {
        let (meshes, trees) = (accel.meshes.len(), accel.blases.len());
        if meshes != trees {
            return Err(unwritable(format!("there are {meshes} meshes and {trees} trees, and each mesh has one")));
        }
        for (number, (mesh, tree)) in accel.meshes.iter().zip(&accel.blases).enumerate() {
            fits(mesh, tree, number, exec)?;
        }
        let mut image = Image { flags: tree_flags::CANONICAL_DFS, ..Image::default() };
        for (mesh, tree) in accel.meshes.iter().zip(&accel.blases) {
            image.push_blas(mesh, tree, exec);
            image.nodes.extend_from_slice(&tree.nodes);
        }
        image.settle(&accel.instances, accel.tlas.as_ref())?;
        Ok(image)
    }

    /// [`Image::new`] of what [`compile`](crate::compile::compile) made: its meshes were validated before trees were built over them. Each is given
    /// back as soon as its records are made.
    pub(crate) fn of_compiled(accel: Accel, exec: &Executor) -> Result<Image, CacheError> {
        let mut image = Image { flags: tree_flags::CANONICAL_DFS, ..Image::default() };
        for (mesh, tree) in accel.meshes.into_iter().zip(accel.blases) {
            image.push_blas(&mesh, &tree, exec);
            drop(mesh);
            image.take_nodes(tree);
        }
        image.settle(&accel.instances, accel.tlas.as_ref())?;
        Ok(image)
    }

    /// What is said of all trees together, and the level above them.
    fn settle(&mut self, instances: &[Instance], tlas: Option<&Tree>) -> Result<(), CacheError> {
        self.settle_origins()?;
        let any_duplicates = self.blases.iter().any(|b| b.flags & tree_flags::DUP_REFS != 0);
        self.flags |= if any_duplicates { tree_flags::DUP_REFS } else { tree_flags::REFITTABLE };
        if let Some(tlas) = tlas {
            self.flags |= tree_flags::TWO_LEVEL;
            self.tlas_nodes.clone_from(&tlas.nodes);
            self.instances =
                tlas.refs.iter().map(|&id| instance_of(instances, id)).collect::<Result<_, CacheError>>()?;
        }
        Ok(())
    }

    /// Append the nodes of a tree, of which nothing else is needed.
    fn take_nodes(&mut self, tree: Tree) {
        if self.nodes.is_empty() {
            self.nodes = tree.nodes;
        } else {
            self.nodes.extend_from_slice(&tree.nodes);
        }
    }

    /// One tree over a mesh in world space.
    ///
    /// # Errors
    /// As [`Image::new`].
    pub fn of_tree(mesh: &Mesh, tree: &Tree, exec: &Executor) -> Result<Image, CacheError> {
        let mut image = Image { flags: tree_flags::CANONICAL_DFS, ..Image::default() };
        fits(mesh, tree, 0, exec)?;
        image.push_blas(mesh, tree, exec);
        image.nodes.extend_from_slice(&tree.nodes);
        image.settle_origins()?;
        image.flags |= image.blases[0].flags;
        Ok(image)
    }

    /// [`Image::of_tree`] of a mesh and a tree that were compiled, with no section left out.
    pub(crate) fn of_mesh(mesh: &Mesh, tree: &Tree, exec: &Executor) -> Image {
        let mut image = Image::default();
        image.push_blas(mesh, tree, exec);
        image.nodes.extend_from_slice(&tree.nodes);
        image
    }

    /// Append the records of a tree but for its nodes.
    fn push_blas(&mut self, mesh: &Mesh, tree: &Tree, exec: &Executor) {
        let blas = self.blases.len() as u32;
        let first_geom = self.geoms.len() as u32;
        self.names.extend(mesh.parts.iter().map(|part| clip_name(&part.name).into_owned()));
        self.materials.extend(mesh.parts.iter().map(|part| clip_name(&part.material).into_owned()));
        // The mark is about a node's transform: what a program moved by none is in the space of its mesh.
        let is_mirrored = |part: &Part| part.mirrored && part.baked_node.is_some();
        self.sides.extend(mesh.parts.iter().map(|part| if is_mirrored(part) { side_flags::MIRRORED } else { 0 }));
        self.geoms.extend(mesh.parts.iter().map(|part| GeomRecord {
            source_mesh: part.source_mesh,
            source_part: part.source_part,
            baked_node: part.baked_node.unwrap_or(NO_NODE),
            blas,
            first_prim: part.first_prim,
            prim_count: part.prim_count,
            kept_count: part.triangle_count,
            reserved: 0,
            name_hash: if part.name.is_empty() {
                [0; 32]
            } else {
                *blake3::hash(clip_name(&part.name).as_bytes()).as_bytes()
            },
        }));

        // Count how often each triangle stands in the leaf order, to flag the duplicated ones.
        let count_uses = || {
            let mut uses = vec![0u8; mesh.triangles.len()];
            for &r in &tree.refs {
                uses[r as usize] = uses[r as usize].saturating_add(1);
            }
            let duplicated = uses.iter().any(|&u| u > 1);
            (uses, duplicated)
        };
        let ((uses, duplicated), (max_depth, sah)) =
            exec.join(count_uses, || (tree.max_depth(), quality::sah(&tree.nodes)));
        let bounds = if tree.nodes.is_empty() { Aabb { min: [0.0; 3], max: [0.0; 3] } } else { tree.bounds() };
        self.blases.push(BlasRecord {
            min: bounds.min,
            max: bounds.max,
            node_offset: self.nodes.len() as u64,
            node_count: tree.nodes.len() as u32,
            ref_offset: self.triangles.len() as u64,
            ref_count: tree.refs.len() as u32,
            prim_count: mesh.triangles.len() as u32,
            max_depth,
            sah,
            flags: if duplicated { tree_flags::DUP_REFS } else { tree_flags::REFITTABLE },
        });
        // Corners are read from all over the mesh: side by side, the waits overlap.
        exec.append(&mut self.triangles, tree.refs.len(), |i| {
            let r = tree.refs[i] as usize;
            let flags = if uses[r] > 1 { TriangleRecord::DUPLICATED } else { 0 };
            triangle_record(mesh, r, first_geom, flags)
        });
        if !mesh.vertices.is_empty() {
            exec.append(&mut self.vertices, tree.refs.len(), |i| mesh.vertices[tree.refs[i] as usize]);
        }
    }

    /// What no part has is left out.
    fn settle_origins(&mut self) -> Result<(), CacheError> {
        if self.materials.iter().all(String::is_empty) {
            self.materials = Vec::new();
        }
        if self.sides.iter().all(|side| *side == 0) {
            self.sides = Vec::new();
        }
        let (vertices, triangles) = (self.vertices.len(), self.triangles.len());
        if vertices != 0 && vertices != triangles {
            return Err(unwritable(format!(
                "{triangles} triangles are in its trees, and {vertices} of them have vertices"
            )));
        }
        Ok(())
    }

    /// Collapse the trees over triangles, so that the file has compact ones beside them.
    ///
    /// # Errors
    /// Where the records are no trees, which those that were built are.
    pub fn add_compact(&mut self) -> Result<(), CacheError> {
        self.compact = Some(CompactTrees::of(&self.view()).map_err(|malformed| unwritable(malformed.to_string()))?);
        Ok(())
    }

    /// What traversal reads, without a copy.
    pub fn view(&self) -> View<'_> {
        View {
            nodes: &self.nodes,
            triangles: &self.triangles,
            geoms: &self.geoms,
            blases: &self.blases,
            tlas_nodes: &self.tlas_nodes,
            instances: &self.instances,
        }
    }
}

/// A triangle of a mesh whose parts' rows start at `first_geom`.
pub(crate) fn triangle_record(mesh: &Mesh, r: usize, first_geom: u32, flags: u32) -> TriangleRecord {
    let [v0, v1, v2] = mesh.corners(r).map(|p| p.map(|c| c + 0.0)); // -0.0 becomes +0.0
    let part = mesh.parts.partition_point(|p| p.first_triangle + p.triangle_count <= r as u32) as u32;
    TriangleRecord { v0, prim: mesh.source_prim(r), v1, geom: first_geom + part, v2, flags }
}

/// Every number that is followed below leads somewhere.
fn fits(mesh: &Mesh, tree: &Tree, number: usize, exec: &Executor) -> Result<(), CacheError> {
    if let Err(error) = mesh.validate(number, exec) {
        return Err(unwritable(error.to_string()));
    }
    let count = mesh.triangles.len();
    if mesh.parts.is_empty() && count > 0 {
        return Err(unwritable(format!("mesh {number} has {count} triangles and no part that they belong to")));
    }
    match tree.refs.iter().find(|&&r| r as usize >= count) {
        Some(r) => Err(unwritable(format!("tree {number} refers to triangle {r}, and its mesh has {count}"))),
        None => Ok(()),
    }
}

fn unwritable(detail: String) -> CacheError {
    CacheError::Unwritable { name: "the image".into(), detail }
}

/// The instance that `id` names in the scene, with the tree that it places.
pub(crate) fn instance_record(instance: &Instance, blas: u32, id: u32) -> InstanceRecord {
    let object_to_world = instance.transform.to_f32();
    let rounded = Affine::from_f32(&object_to_world);
    // The scene room refuses singular transforms; one that becomes singular by rounding to f32 maps everything to itself
    // here and is found by the check of the two matrices.
    let world_to_object = rounded.inverse().unwrap_or(Affine::IDENTITY).to_f32();
    InstanceRecord {
        object_to_world,
        world_to_object,
        blas,
        id,
        mask: u32::MAX,
        flags: if orientation(&object_to_world).is_lt() { InstanceRecord::MIRRORED } else { 0 },
        node: instance.node,
        reserved: [0; 3],
    }
}

fn instance_of(instances: &[Instance], id: u32) -> Result<InstanceRecord, CacheError> {
    let count = instances.len();
    let instance = instances.get(id as usize).ok_or_else(|| {
        unwritable(format!("the tree over the instances refers to instance {id}, and there are {count}"))
    })?;
    Ok(instance_record(instance, instance.mesh, id))
}
