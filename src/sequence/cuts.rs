use std::collections::BTreeMap;

use super::shape::parts_hash;
use crate::geom::vector::{cross, dot, sub};
use crate::scene::Mesh;

/// How the faces of a mesh stand to those of the meshes before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Faces {
    /// None before has these faces, so that later ones are cut as they are.
    First,
    /// Cut as before; or there are none that could be.
    AsBefore,
    /// Cut as the reader has cut them, since the cut of before would leave them.
    OwnCut,
}

/// How polygons were cut into triangles when they were first seen.
///
/// A reader cuts each model for itself, along the diagonal that suits a face as it stands. So a quad that bends from one frame to the next can become two
/// other triangles, though its corners are the same. In a sequence faces stay cut as they were in the first frame that shows them: hits then name the
/// same triangle in every frame, and its tree can be refitted. Only where such a cut would leave the face does the frame keep its own.
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
    pub fn apply(&mut self, mesh: &mut Mesh) -> Faces {
        // Where a triangle was dropped, polygons and triangles no longer go together.
        let Some(faces) = mesh.faces.filter(|_| mesh.source_prims.is_empty()) else { return Faces::AsBefore };
        match self.known.get(&(faces, parts_hash(mesh))) {
            Some(cut)
                if (cut.positions, cut.triangles.len()) == (mesh.positions.len(), mesh.triangles.len())
                    && stays_inside(mesh, &cut.triangles) =>
            {
                mesh.triangles.clone_from(&cut.triangles);
                mesh.vertices.clone_from(&cut.vertices);
                Faces::AsBefore
            }
            Some(cut) if cut.triangles == mesh.triangles => Faces::AsBefore,
            Some(_) => Faces::OwnCut,
            None => {
                let (triangles, vertices) = (mesh.triangles.clone(), mesh.vertices.clone());
                let cut = Cut { positions: mesh.positions.len(), triangles, vertices };
                self.known.insert((faces, parts_hash(mesh)), cut);
                Faces::First
            }
        }
    }
}

/// Whether triangles that cut the faces of a mesh otherwise than its own stay inside those faces: none of them is turned against its face. Where a face has become
/// concave along the diagonal that it was cut by, one is.
///
/// Faces and triangles stand in the same order, so the triangles that differ form runs of whole faces. The area vectors of the triangles of a face add up to the same
/// however it is cut, and [`Mesh`]'s own triangles are inside.
fn stays_inside(mesh: &Mesh, triangles: &[[u32; 3]]) -> bool {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.exact_position(v as usize));
        cross(sub(b, a), sub(c, a))
    };
    let differs: Vec<bool> = mesh.triangles.iter().zip(triangles).map(|(own, other)| own != other).collect();
    let mut at = 0;
    while let Some(start) = differs[at..].iter().position(|d| *d).map(|i| at + i) {
        let end = differs[start..].iter().position(|d| !*d).map_or(differs.len(), |i| start + i);
        let run = start..end;
        // A triangle of a run is compared with those of its own that have a corner pair with it: all of them lie in one face or in its neighbours of the run.
        for (i, other) in run.clone().map(|i| (i, &triangles[i])) {
            let turned = area(other);
            let own = run.clone().filter(|k| k.abs_diff(i) <= FACE && shares_edge(&mesh.triangles[*k], other));
            let add = |sum: [f64; 3], k: usize| {
                let one = area(&mesh.triangles[k]);
                [0, 1, 2].map(|a| sum[a] + one[a])
            };
            let face = own.fold([0.0; 3], add);
            if dot(turned, face) < 0.0 {
                return false;
            }
        }
        at = end;
    }
    true
}

/// Triangles of one face lie no farther apart in the list, but for faces of very many corners.
const FACE: usize = 64;

fn shares_edge(a: &[u32; 3], b: &[u32; 3]) -> bool {
    a.iter().filter(|v| b.contains(v)).count() >= 2
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

        // A square stays cut so where it is bent, and not where its second corner has come to lie beyond the diagonal.
        let square = |second: [f32; 3], triangles| Mesh {
            positions: vec![[0.0; 3], second, [2.0, 0.0, 2.0], [0.0, 0.0, 2.0]],
            ..quad(triangles)
        };
        for (second, stays) in [([2.0, 0.5, 0.0], true), ([0.5, 0.0, 1.2], false)] {
            let mut mesh = square(second, other);
            let faces = cuts.apply(&mut mesh);
            assert_eq!(mesh.triangles == one, stays, "{second:?}");
            assert_eq!(faces, if stays { Faces::AsBefore } else { Faces::OwnCut });
        }

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
