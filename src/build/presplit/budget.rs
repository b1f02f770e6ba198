//! Which triangle is cut how often.

use super::CHUNK;
use super::planes::Planes;
use crate::build::prim_ref::PrimRef;
use crate::exec::Executor;
use crate::geom::vector::cross;
use crate::scene::Mesh;

/// What may not be exceeded.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    /// Cuts in all.
    pub cuts: usize,
    /// Pieces of one triangle, 1..=256.
    pub pieces: u32,
}

/// How often each triangle may be cut: its share of the budget by priority, rounded down.
///
/// So where all triangles are about alike, as in scans, hardly any is cut; and what rounding leaves over is left over, since the next
/// in line would be triangles of no importance.
pub(super) fn share_out(mesh: &Mesh, refs: &[PrimRef], planes: &Planes, limits: Limits, exec: &Executor) -> Vec<u8> {
    let priorities =
        exec.map_chunks(refs, CHUNK, |_, chunk| chunk.iter().map(|r| priority(mesh, r, planes)).collect::<Vec<f32>>());
    let priorities = priorities.concat();
    let sum: f64 = priorities.iter().map(|p| f64::from(*p)).sum();
    if !(sum > 0.0) {
        return vec![0; refs.len()];
    }
    let factor = limits.cuts as f64 / sum;
    priorities.iter().map(|p| ((factor * f64::from(*p)) as u32).min(limits.pieces - 1) as u8).collect()
}

/// The importance of the coarsest plane through the triangle's box, times the fourth root of the area that the triangle leaves empty of its
/// box. Karras and Aila take the third root of importance times area; more weight on the plane and less on the
/// size measured better. Only square roots, which all machines round alike.
fn priority(mesh: &Mesh, r: &PrimRef, planes: &Planes) -> f32 {
    let Some(plane) = planes.coarsest(&r.bounds()) else { return 0.0 };
    let [p, q, s] = mesh.corners(r.prim as usize).map(|v| v.map(f64::from));
    let normal = cross([0, 1, 2].map(|k| q[k] - p[k]), [0, 1, 2].map(|k| s[k] - p[k]));
    let [x, y, z] = [0, 1, 2].map(|k| f64::from(r.max[k]) - f64::from(r.min[k]));
    // A triangle's shadows on the three planes are the least that boxes around its parts can come to, were they ever so small.
    let shadows: f64 = normal.iter().map(|v| v.abs()).sum();
    let empty = (2.0 * (x * y + y * z + z * x) - shadows).max(0.0);
    (f64::from(plane.importance) * empty.sqrt().sqrt()) as f32
}
