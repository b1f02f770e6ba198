//! Positions on a grid, for those who want small files more than exact shapes.

use super::bounds::Bounds;
use super::precision::Loss;
use super::{Mesh, ReadOptions, VertexBits};

/// Put the positions of every mesh on a grid of at most `bits` bits an axis, as [`ReadOptions::vertex_bits`] asks. What the mesh that loses most loses;
/// `None` where it was not asked for.
///
/// The distance of the grid's planes is a power of two, the smallest one by which the longest side of the mesh's box is less than `2^bits` long, and the
/// origin is on the grid. So a vertex that stands still while others move stays where it is, and two frames have one grid unless one is twice as large.
pub(super) fn snap(meshes: &mut [Mesh], options: &ReadOptions) -> Option<Loss> {
    let bits = options.vertex_bits?;
    let losses = meshes.iter_mut().map(|mesh| snap_one(mesh, bits));
    losses.reduce(|a, b| if b.is_more_than(&a) { b } else { a }).or(Some(Loss::default()))
}

fn snap_one(mesh: &mut Mesh, bits: VertexBits) -> Loss {
    let used = mesh.triangles.iter().flatten().map(|v| mesh.exact_position(*v as usize));
    let longest = Bounds::of(used.filter(|p| p.iter().all(|c| c.is_finite()))).longest();
    let most = f64::from(bits.largest());
    if !(longest.is_finite() && longest > 0.0) {
        return Loss::default();
    }
    // The power of two below, by its bits: logarithms round differently from machine to machine.
    let below = f64::from_bits((longest / most).to_bits() & f64::INFINITY.to_bits());
    let step = if below * most >= longest { below } else { 2.0 * below };
    let exact: Vec<[f64; 3]> = (0..mesh.positions.len()).map(|v| mesh.exact_position(v)).collect();
    for (position, exact) in mesh.positions.iter_mut().zip(&exact) {
        // What is no number stays so, and is left out later.
        let snapped = exact.map(|c| ((c / step).round() * step) as f32 + 0.0);
        *position = [0, 1, 2].map(|k| if exact[k].is_finite() { snapped[k] } else { position[k] });
    }
    // The grid is where the vertices are from here on.
    mesh.remainders = Vec::new();
    let stored = |v: u32| mesh.positions[v as usize].map(f64::from);
    Loss::of(&mesh.triangles, Loss::SAMPLE, |v| exact[v as usize], stored)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on(bits: u8, positions: &[[f32; 3]]) -> (Vec<[f32; 3]>, Loss) {
        let options = ReadOptions { vertex_bits: VertexBits::new(bits), ..ReadOptions::default() };
        let triangles = (2..positions.len() as u32).map(|i| [0, 1, i]).collect();
        let mut meshes = [Mesh { positions: positions.to_vec(), triangles, ..Mesh::default() }];
        let loss = snap(&mut meshes, &options).unwrap();
        (meshes[0].positions.clone(), loss)
    }

    #[test]
    fn corners_move_by_half_a_step_at_most_and_onto_the_grid() {
        let positions: Vec<[f32; 3]> = (0..50).map(|i| [0.37 * i as f32, 0.11 * (i * i % 31) as f32, -7.1]).collect();
        for bits in [8, 12, 16, 24] {
            let (snapped, loss) = on(bits, &positions);
            // 18.13 wide: steps of 2^(5 - bits).
            let step = 2f64.powi(5 - i32::from(bits));
            for (a, b) in positions.iter().flatten().zip(snapped.iter().flatten()) {
                let (a, b) = (f64::from(*a), f64::from(*b));
                assert!((a - b).abs() <= step / 2.0, "{bits}: {a} {b}");
                assert_eq!((b / step).fract(), 0.0, "{bits}: {b}");
            }
            assert!(loss.farthest <= step && (loss.share < Loss::MOST) == (bits > 8), "{bits}: {loss:?}");
        }
        // A grid on itself is the same grid.
        let once = on(12, &positions).0;
        let (twice, loss) = on(12, &once);
        assert_eq!((twice, loss.farthest), (once, 0.0));
    }

    #[test]
    fn what_has_no_size_or_is_no_number_stays() {
        let point = [[0.1, 0.2, 0.3]; 4];
        assert_eq!(on(8, &point).0, point);
        let (snapped, _) = on(8, &[[0.0; 3], [1.0, 0.3, 0.0], [f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.501]]);
        assert!(snapped[2][0].is_nan() && snapped[3][1] == f32::INFINITY);
        assert_eq!(snapped[1], [1.0, 0.296875, 0.0]);
    }
}
