//! Cutting large triangles before the build, so that any method gets most of what spatial splits gain within a fixed
//! number of references (Ernst and Greiner, "Early Split Clipping for Bounding Volume Hierarchies", 2007).
//!
//! The number of pieces goes by priority, and cuts are made at planes that halve space (Karras and Aila, "Fast Parallel
//! Construction of High-Quality Bounding Volume Hierarchies", 2013, section 4.1): the coarser a plane, the likelier it
//! is that some split near the root falls close to it.
//!
//! `planes` knows the planes, `budget` shares out the pieces, `cut` cuts.

mod budget;
mod cut;
mod planes;

use self::budget::Limits;
use self::planes::Planes;
use super::prim_ref::PrimRefs;
use crate::exec::Executor;
use crate::scene::Mesh;

/// Most pieces of one triangle, by the share of references that may be added. Few: a wall that is whole stands in a leaf near the
/// root, where most rays that it stops find it soon; cut into many pieces it is found at the end of a long way.
fn max_pieces(share: f32) -> u32 {
    ((8.0 * share).ceil() as u32).clamp(4, 64)
}

/// Triangles that one task looks at. A constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1 << 12;

/// References that a mesh of so many triangles has at most: the triangles and `share` times as many more.
pub(super) fn budgeted(triangles: usize, share: f32) -> usize {
    triangles.saturating_add(extra(triangles, share))
}

fn extra(triangles: usize, share: f32) -> usize {
    (triangles as f64 * f64::from(share).max(0.0)) as usize
}

/// One reference for each triangle, or several for parts of it, `share` times the triangles more at most.
///
/// A triangle's first piece stands in its place, the others follow behind all triangles. The parts' boxes cover the triangle,
/// and none reaches out of the triangle's box.
pub(super) fn references(mesh: &Mesh, share: f32, exec: &Executor) -> PrimRefs {
    let count = mesh.triangles.len();
    let whole = PrimRefs::of_mesh(mesh, 0, exec);
    let extra = extra(count, share);
    if extra == 0 || count == 0 {
        return whole;
    }
    let Some(planes) = Planes::over(&whole.bounds) else { return whole };
    exec.run(|| {
        let splits =
            budget::share_out(mesh, &whole.refs, &planes, Limits { cuts: extra, pieces: max_pieces(share) }, exec);
        cut::cut_all(mesh, whole, &splits, &planes, exec)
    })
}
