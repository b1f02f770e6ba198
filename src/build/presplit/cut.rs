//! Cutting triangles into the number of pieces that they were given.

use super::CHUNK;
use super::planes::Planes;
use crate::build::prim_ref::{PrimRef, PrimRefs};
use crate::exec::Executor;
use crate::geom::clip;
use crate::geom::{Aabb, Point};
use crate::scene::Mesh;

/// Replace every reference that may be cut by its pieces.
pub(super) fn cut_all(mesh: &Mesh, mut whole: PrimRefs, splits: &[u8], planes: &Planes, exec: &Executor) -> PrimRefs {
    let more = exec.map_chunks_mut(&mut whole.refs, CHUNK, |chunk_index, chunk| {
        let mut more = Vec::new();
        for (r, cuts) in chunk.iter_mut().zip(&splits[chunk_index * CHUNK..]) {
            if *cuts > 0 {
                let mut pieces = Pieces { corners: mesh.corners(r.prim as usize), planes, more: &mut more };
                *r = pieces.cut(*r, u32::from(*cuts));
            }
        }
        more
    });
    let mut refs = whole.refs;
    refs.reserve_exact(more.iter().map(Vec::len).sum());
    more.iter().for_each(|more| refs.extend_from_slice(more));
    PrimRefs::of_refs(refs, exec)
}

struct Pieces<'a> {
    corners: [Point; 3],
    planes: &'a Planes,
    more: &'a mut Vec<PrimRef>,
}

impl Pieces<'_> {
    /// Cut a piece so often at most; returns one of the pieces, the others go to the list. Recurses no deeper than there
    /// are cuts.
    fn cut(&mut self, piece: PrimRef, cuts: u32) -> PrimRef {
        let bounds = piece.bounds();
        let Some(plane) = self.planes.coarsest(&bounds).filter(|_| cuts > 0) else { return piece };
        let (below, above) = clip::split(&self.corners, plane.axis, plane.position, &bounds);
        let part = |b: &Aabb| PrimRef { min: b.min, max: b.max, ..piece };
        match (below.is_empty(), above.is_empty()) {
            // The larger part gets more of the cuts that are left.
            (false, false) => {
                let longest = |b: &Aabb| b.extent().into_iter().fold(0.0, f32::max);
                let (a, b) = (longest(&below), longest(&above));
                let left = ((cuts - 1) as f32 * (a / (a + b)) + 0.5) as u32;
                let left = left.min(cuts - 1);
                let other = self.cut(part(&above), cuts - 1 - left);
                self.more.push(other);
                self.cut(part(&below), left)
            }
            // The plane cuts only the box: what is left is smaller, and that is free.
            (true, false) => self.cut(part(&above), cuts - 1),
            (false, true) => self.cut(part(&below), cuts - 1),
            (true, true) => piece,
        }
    }
}
