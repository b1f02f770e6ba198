use std::collections::BTreeMap;

use super::shape::parts_hash;
use crate::scene::Mesh;

/// How polygons were cut into triangles when they were first seen.
///
/// A reader cuts each model for itself, along the diagonal that suits a face as it stands. So a quad that bends from one frame to the next can become two
/// other triangles, though its corners are the same. In a sequence faces stay cut as they were in the first frame that shows them: hits then name the
/// same triangle in every frame, and its tree can be refitted.
#[derive(Default)]
pub struct Cuts {
    /// By the polygons and the parts of a mesh.
    known: BTreeMap<([u8; 32], [u8; 32]), Cut>,
}

struct Cut {
    positions: usize,
    triangles: Vec<[u32; 3]>,
    vertices: Vec<[u32; 3]>,
}

impl Cuts {
    /// Cut the faces of a mesh as those of an earlier one with the same faces.
    pub fn apply(&mut self, mesh: &mut Mesh) {
        // Where a triangle was dropped, polygons and triangles no longer go together.
        let Some(faces) = mesh.faces.filter(|_| mesh.source_prims.is_empty()) else { return };
        match self.known.get(&(faces, parts_hash(mesh))) {
            Some(cut) if (cut.positions, cut.triangles.len()) == (mesh.positions.len(), mesh.triangles.len()) => {
                mesh.triangles.clone_from(&cut.triangles);
                mesh.vertices.clone_from(&cut.vertices);
            }
            Some(_) => {}
            None => {
                let (triangles, vertices) = (mesh.triangles.clone(), mesh.vertices.clone());
                let cut = Cut { positions: mesh.positions.len(), triangles, vertices };
                self.known.insert((faces, parts_hash(mesh)), cut);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_stay_cut_as_they_were() {
        let quad = |triangles: [[u32; 3]; 2]| Mesh {
            positions: vec![[0.0; 3]; 4],
            triangles: triangles.to_vec(),
            faces: Some([7; 32]),
            ..Mesh::default()
        };
        let (one, other) = ([[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]);
        let mut cuts = Cuts::default();
        cuts.apply(&mut quad(one));
        let mut later = quad(other);
        cuts.apply(&mut later);
        assert_eq!(later.triangles, one);

        // Other faces, a triangle that was dropped, and faces that nothing is known of stay as they are.
        let as_they_are = [
            Mesh { faces: Some([8; 32]), ..quad(other) },
            Mesh { source_prims: vec![0, 2], ..quad(other) },
            Mesh { faces: None, ..quad(other) },
            Mesh { positions: vec![[0.0; 3]; 5], ..quad(other) },
        ];
        for mut mesh in as_they_are {
            cuts.apply(&mut mesh);
            assert_eq!(mesh.triangles, other);
        }
    }
}
