//! A vertex of a part stands in one place: what rule E0323 asks of a file, asked of a mesh before anything is built.

use super::geometry_error::GeometryError;
use super::{Mesh, Part};

/// The first use of a vertex: the triangle and the index of its position.
type Use = (u32, u32);

impl Mesh {
    /// Hold the positions that a part's triangles give one vertex ([`Mesh::vertices`]) against each other. Lists are as long as they must be and
    /// indices in range.
    pub(super) fn validate_vertices(&self, mesh: usize) -> Result<(), GeometryError> {
        if self.vertices.is_empty() {
            return Ok(());
        }
        let whole = [Part { triangle_count: self.triangles.len() as u32, ..Part::default() }];
        let parts = if self.parts.is_empty() { &whole[..] } else { &self.parts };
        parts.iter().enumerate().try_for_each(|(part, p)| {
            let triangles = p.first_triangle..p.first_triangle + p.triangle_count;
            match self.vertex_in_two_places(triangles) {
                None => Ok(()),
                Some((vertex, [first, other])) => Err(GeometryError::VertexPlaces {
                    mesh,
                    part,
                    vertex,
                    triangles: [first.0, other.0].map(|triangle| triangle as usize),
                    positions: [first.1, other.1],
                }),
            }
        })
    }

    fn vertex_in_two_places(&self, triangles: std::ops::Range<u32>) -> Option<(u32, [Use; 2])> {
        let uses = || {
            triangles.clone().flat_map(|triangle| {
                let (vertices, indices) = (self.vertices[triangle as usize], self.triangles[triangle as usize]);
                (0..3).map(move |k| (vertices[k], (triangle, indices[k])))
            })
        };
        // Numbers of a part mostly lie close together, so that a table is small; numbers that do not are sorted.
        let (low, high) = uses().fold((u32::MAX, 0), |(low, high), (vertex, _)| (low.min(vertex), high.max(vertex)));
        let span = u64::from(high) + 1 - u64::from(low).min(u64::from(high));
        if span > 8 * triangles.len() as u64 + 64 {
            let mut sorted: Vec<(u32, Use)> = uses().collect();
            sorted.sort_unstable();
            let pair =
                sorted.windows(2).find(|pair| pair[0].0 == pair[1].0 && !self.is_one_place(pair[0].1, pair[1].1))?;
            return Some((pair[0].0, [pair[0].1, pair[1].1]));
        }
        let mut firsts: Vec<Option<Use>> = vec![None; span as usize];
        uses().find_map(|(vertex, this)| {
            let first = *firsts[(vertex - low) as usize].get_or_insert(this);
            (!self.is_one_place(first, this)).then_some((vertex, [first, this]))
        })
    }

    /// Zeros have no sign here. Remainders count, since a transform may bring them into what is stored.
    fn is_one_place(&self, (_, a): Use, (_, b): Use) -> bool {
        let (a, b) = (a as usize, b as usize);
        a == b
            || self.positions[a] == self.positions[b]
                && (self.remainders.is_empty() || self.remainders[a] == self.remainders[b])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSITIONS: [[f32; 3]; 5] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 0.0], [1.0, 1.0, 0.0]];

    fn told(triangles: &[[u32; 3]], vertices: &[[u32; 3]]) -> Result<(), GeometryError> {
        let mut mesh = Mesh::new("sheet", POSITIONS.to_vec(), triangles.to_vec())?;
        mesh.vertices = vertices.to_vec();
        mesh.validate(7, &crate::exec::Executor::sequential())
    }

    #[test]
    fn a_vertex_in_two_places_is_told_however_far_apart_numbers_lie() {
        for far in [8, u32::MAX] {
            assert_eq!(told(&[[0, 1, 2], [3, 4, 2]], &[[5, 6, far], [5, 7, far]]), Ok(()), "0 and -0 are one place");
            let error = told(&[[0, 1, 2], [1, 4, 2]], &[[5, 6, far], [5, 7, far]]);
            let expected =
                GeometryError::VertexPlaces { mesh: 7, part: 0, vertex: 5, triangles: [0, 1], positions: [0, 1] };
            assert_eq!(error, Err(expected));
        }
    }

    #[test]
    fn what_rounding_left_off_tells_places_apart() {
        let mut mesh = Mesh::new("sheet", POSITIONS.to_vec(), vec![[0, 1, 2], [3, 4, 2]]).expect("a mesh");
        mesh.vertices = vec![[5, 6, 8], [5, 7, 8]];
        mesh.remainders = vec![[0.0; 3]; 5];
        assert_eq!(mesh.validate_vertices(0), Ok(()));
        mesh.remainders[3] = [1e-9, 0.0, 0.0];
        assert!(matches!(mesh.validate_vertices(0), Err(GeometryError::VertexPlaces { vertex: 5, .. })));
    }

    #[test]
    fn parts_have_numbers_of_their_own() {
        let mut mesh = Mesh::new("sheet", POSITIONS.to_vec(), vec![[0, 1, 2], [1, 4, 2]]).expect("a mesh");
        mesh.vertices = vec![[5, 6, 8], [5, 7, 8]];
        let half = |first| Part {
            first_triangle: first,
            triangle_count: 1,
            first_prim: first,
            prim_count: 1,
            ..Part::default()
        };
        mesh.parts = vec![half(0), half(1)];
        assert_eq!(mesh.validate(0, &crate::exec::Executor::sequential()), Ok(()));
    }
}
