use std::collections::HashMap;

use crate::geom::Point;
use crate::scene::Mesh;

/// The vertices of a topology: those of a mesh that its triangles use, in the order in which its leaves first use them, and each place once.
///
/// Vertices are one as long as they stand in one place in every pose, which each pose is asked again: glTF and OBJ repeat positions for the sake of
/// normals and texture coordinates.
#[derive(Clone, Debug)]
pub struct Weld {
    /// For each vertex of the mesh its vertex here, [`Weld::UNUSED`] where no triangle uses it.
    pub of: Vec<u32>,
    /// For each vertex here the first of the mesh that it is.
    pub sources: Vec<u32>,
}

impl Weld {
    /// For [`Weld::of`].
    pub const UNUSED: u32 = u32::MAX;

    /// The vertices of a mesh as it stands, in the order of `refs`. They are apart as they are now, and also where `class` is another.
    pub fn by(mesh: &Mesh, refs: &[u32], class: impl Fn(u32) -> u32) -> Weld {
        let mut weld = Weld { of: vec![Weld::UNUSED; mesh.positions.len()], sources: Vec::new() };
        // Only asked, never walked through: the order of a hash map decides nothing.
        let mut places: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
        for v in refs.iter().flat_map(|&r| mesh.triangles[r as usize]) {
            if weld.of[v as usize] == Weld::UNUSED {
                let next = weld.sources.len() as u32;
                let place = *places.entry((class(v), bits(mesh.positions[v as usize]))).or_insert(next);
                if place == next {
                    weld.sources.push(v);
                }
                weld.of[v as usize] = place;
            }
        }
        weld
    }

    /// The positions of the vertices in a pose; `None` where vertices that are one stand apart.
    pub fn positions(&self, mesh: &Mesh) -> Option<Vec<Point>> {
        let at = |v: u32| mesh.positions[v as usize];
        let together = |(v, of): (usize, &u32)| {
            *of == Weld::UNUSED || bits(mesh.positions[v]) == bits(at(self.sources[*of as usize]))
        };
        self.of.iter().enumerate().all(together).then(|| self.sources.iter().map(|v| clean(at(*v))).collect())
    }

    /// Vertices that were one and stand apart in this pose become two.
    pub fn split(&self, mesh: &Mesh, refs: &[u32]) -> Weld {
        Weld::by(mesh, refs, |v| self.of[v as usize])
    }
}

/// `-0.0` becomes `0.0`.
pub fn clean(p: Point) -> Point {
    p.map(|c| c + 0.0)
}

/// What tells places apart.
pub fn bits(p: Point) -> [u32; 3] {
    clean(p).map(f32::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(positions: &[Point]) -> Mesh {
        Mesh { positions: positions.to_vec(), triangles: vec![[0, 1, 2], [3, 4, 5]], ..Mesh::default() }
    }

    #[test]
    fn places_are_stored_once_until_they_part() {
        let (a, b, c, d) = ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]);
        let together = mesh(&[a, b, c, b, d, [-0.0, 1.0, 0.0], [9.0; 3]]);
        let weld = Weld::by(&together, &[1, 0], |_| 0);
        assert_eq!(weld.sources, [3, 4, 5, 0]);
        assert_eq!(weld.of, [3, 0, 2, 0, 1, 2, Weld::UNUSED]);
        assert_eq!(weld.positions(&together), Some(vec![b, d, c, a]));

        // The second triangle leaves the first along one edge's end.
        let apart = mesh(&[a, b, c, [2.0, 0.0, 0.0], d, c, [8.0; 3]]);
        assert_eq!(weld.positions(&apart), None);
        let split = weld.split(&apart, &[1, 0]);
        assert_eq!(split.sources.len(), 5);
        assert!(split.positions(&apart).is_some() && split.positions(&together).is_some());
    }
}
