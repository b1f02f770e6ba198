//! Parts become one mesh.
//!
//! Each part has its positions anew, in the order in which its faces first use them, so that a position which two parts share is stored twice:
//! as `tobj` numbers them.

use super::corners::Corners;
use super::given::{Finger, Given};
use super::parts::PartName;
use super::polygon::Triangulator;
use super::range::Range;
use super::ranges::Everyday;
use crate::scene::{Mesh, Part, SceneError};
use std::path::Path;

/// The mesh so far, with positions as exact as they are read.
pub(super) struct Joined {
    pub mesh: Mesh,
    pub positions: Vec<[f64; 3]>,
    cut: Triangulator,
    corners: Option<Corners>,
    faces: Option<Faces>,
    /// Of the face at hand.
    face: Vec<u32>,
}

/// What [`Mesh::faces`] is made of.
#[derive(Default)]
struct Faces {
    hasher: blake3::Hasher,
    any_polygon: bool,
    /// Of the part at hand: how many corners each face has, and the corners, counted from the part's first position.
    arities: Vec<u32>,
    corners: Vec<u32>,
}

impl Joined {
    /// `corners` numbers corners, where that is asked for; `faces` asks for [`Mesh::faces`].
    pub fn new(name: String, corners: Option<Corners>, faces: bool) -> Joined {
        Joined {
            mesh: Mesh { name, ..Mesh::default() },
            positions: Vec::new(),
            cut: Triangulator::new(),
            corners,
            faces: faces.then(Faces::default),
            face: Vec::new(),
        }
    }

    /// Append what `tobj` made of a part.
    pub fn add_model(&mut self, model: &tobj::Mesh, name: PartName, path: &Path) -> Result<(), SceneError> {
        let count = self.positions.len() as u64 + model.positions.len() as u64 / 3;
        if count > u64::from(u32::MAX) {
            let what = format!("its parts have {count} positions in all, shared ones counted for each");
            return Err(SceneError::TooMany { path: path.to_owned(), line: None, what, limit: u32::MAX.into() });
        }
        let base = self.positions.len() as u32;
        self.positions.extend(model.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        let first_triangle = self.mesh.triangles.len();
        let (mut rest, mut arities) = (model.indices.as_slice(), model.face_arities.iter());
        while !rest.is_empty() {
            let (face, tail) = rest.split_at(arities.next().map_or(3, |arity| *arity as usize));
            rest = tail;
            self.face.clear();
            self.face.extend(face.iter().map(|v| v + base));
            self.add_face(base);
        }
        self.end_part(name, base, first_triangle);
        Ok(())
    }

    /// Append all parts of a text that was read in ranges. How many of its positions no face uses.
    pub fn add_everyday(&mut self, text: Everyday) -> u64 {
        let Everyday { mut ranges, parts, positions, triangles, .. } = text;
        let (given, mut finger) = (Given::of(&mut ranges), Finger::default());
        self.positions.reserve(positions);
        self.mesh.triangles.reserve_exact(triangles);
        // For each position its latest number in the mesh, counted from 1; one that is not above the part's first is an earlier part's.
        let mut numbers = vec![0u32; positions];
        let (mut face, mut base, mut first_triangle) = (0, 0, 0);
        let mut name: Option<PartName> = None;
        let mut parts = parts.into_iter().peekable();
        for Range { corners, arities, faces, .. } in ranges {
            let mut rest = corners.as_slice();
            for i in 0..faces {
                if let Some((_, next)) = parts.next_if(|(first, _)| *first == face) {
                    if let Some(name) = name.replace(next) {
                        self.end_part(name, base, first_triangle);
                    }
                    (base, first_triangle) = (self.positions.len() as u32, self.mesh.triangles.len());
                }
                let (own, tail) = rest.split_at(arities.get(i).map_or(3, |arity| *arity as usize));
                rest = tail;
                self.face.clear();
                for &corner in own {
                    let number = &mut numbers[corner as usize];
                    if *number <= base {
                        self.positions.push(given.position(corner as usize, &mut finger));
                        *number = self.positions.len() as u32;
                    }
                    self.face.push(*number - 1);
                }
                self.add_face(base);
                face += 1;
            }
        }
        if let Some(name) = name {
            self.end_part(name, base, first_triangle);
        }
        numbers.iter().filter(|number| **number == 0).count() as u64
    }

    /// Cut the face at hand, of a part whose positions begin at `base`.
    fn add_face(&mut self, base: u32) {
        let Joined { mesh, positions, cut, corners, faces, face } = self;
        if let Some(faces) = faces {
            faces.any_polygon |= face.len() != 3;
            faces.arities.push(face.len() as u32);
            faces.corners.extend(face.iter().map(|corner| corner - base));
        }
        let before = mesh.triangles.len();
        match face[..] {
            [a, b, c] if corners.is_none() => return mesh.triangles.push([a, b, c]),
            _ => cut.add(face, positions, &mut mesh.triangles),
        }
        let triangles = &mut mesh.triangles[before..];
        if let Some(corners) = corners {
            let first = corners.take(face.len() as u32);
            mesh.vertices.extend(triangles.iter().map(|t| t.map(|corner| first + corner)));
        }
        triangles.iter_mut().flatten().for_each(|v| *v = face[*v as usize]);
    }

    fn end_part(&mut self, name: PartName, base: u32, first_triangle: usize) {
        if let Some(faces) = &mut self.faces {
            faces.end_part(base);
        }
        let (first_triangle, triangle_count) =
            (first_triangle as u32, (self.mesh.triangles.len() - first_triangle) as u32);
        if triangle_count == 0 {
            return;
        }
        let PartName { name, material } = name;
        self.mesh.parts.push(Part {
            name,
            material,
            source_mesh: 0,
            source_part: self.mesh.parts.len() as u32,
            baked_node: None,
            mirrored: false,
            first_triangle,
            triangle_count,
            first_prim: first_triangle,
            prim_count: triangle_count,
        });
    }

    /// The mesh without its positions, and these.
    pub fn finish(mut self) -> (Mesh, Vec<[f64; 3]>) {
        let faces = self.faces.filter(|faces| faces.any_polygon);
        self.mesh.faces = faces.map(|faces| *faces.hasher.finalize().as_bytes());
        (self.mesh, self.positions)
    }
}

impl Faces {
    /// The numbers of corners count only where not all are 3.
    fn end_part(&mut self, base: u32) {
        if self.arities.iter().all(|arity| *arity == 3) {
            self.arities.clear();
        }
        self.hasher.update(&base.to_le_bytes());
        for words in [&mut self.arities, &mut self.corners] {
            self.hasher.update(&(words.len() as u64).to_le_bytes()).update(bytemuck::cast_slice(words));
            words.clear();
        }
    }
}
