//! Models whose shape was lost before they were written: positions that were rounded to 32-bit floats, or to few digits, far from the origin.

use super::precision::{Loss, spread, unmoved};
use super::{Mesh, Rounding};

/// How far apart 32-bit floats are at a coordinate.
fn spacing(coordinate: f64) -> f64 {
    let at = (coordinate.abs() as f32).max(f32::MIN_POSITIVE);
    f64::from(at.next_up()) - f64::from(at)
}

/// How far apart positions can be where a model lies, if they are 32-bit floats although its triangles are not much larger than these are
/// apart: then it was rounded before it was written, and no reader gets its shape back. At least a share of `least` of its coordinates must be where
/// floats are so far apart. Decimals of few digits may be such floats by chance, and then lie further apart than these.
pub(super) fn rounded_before(
    triangles: &[[u32; 3]],
    exact: impl Fn(u32) -> [f64; 3],
    edge: f64,
    least: f64,
) -> Option<f64> {
    // Without an edge there is no shape to lose.
    if edge <= 0.0 {
        return None;
    }
    let (mut all, mut on_grid, mut widest, mut coarse) = (0u64, 0, 0.0f64, Vec::new());
    for coordinate in spread(triangles, Loss::SAMPLE).flat_map(|t| t.map(&exact)).flatten() {
        all += 1;
        let apart = spacing(coordinate);
        if apart.is_finite() && apart > 0.25 * edge {
            coarse.push(coordinate);
            // Decimals of a few digits miss the float that they were printed from.
            on_grid += usize::from((coordinate - f64::from(coordinate as f32)).abs() <= apart / 64.0);
            widest = widest.max(apart);
        }
    }
    let count = coarse.len();
    let is_rounded = count > 0 && count as f64 >= least * all as f64 && on_grid >= count - count / 64;
    is_rounded.then(|| widest.max(decimal_step(&coarse)))
}

/// The largest power of ten of which all these numbers are multiples, as far as 64 bits tell; 0 where there is none.
fn decimal_step(numbers: &[f64]) -> f64 {
    let steps = (-9..=18).rev().map(|exponent: i32| match exponent {
        0.. => 10u64.pow(exponent.unsigned_abs()) as f64,
        _ => 1.0 / 10u64.pow(exponent.unsigned_abs()) as f64,
    });
    let is_multiple = |number: f64, step: f64| {
        let times = number / step;
        (times - times.round()).abs() <= 1e-15 * times.abs()
    };
    steps.into_iter().find(|step| numbers.iter().all(|number| is_multiple(*number, *step))).unwrap_or(0.0)
}

/// Coordinates of a file with 32-bit positions are floats wherever they are, so that a few far ones prove nothing.
const LEAST: f64 = 0.25;

/// [`Rounding::rounded_before`] of positions as a file has them, which a pose then moves: after that they are no floats any more.
pub(super) fn rounded_before_posing(triangles: &[[u32; 3]], exact: impl Fn(u32) -> [f64; 3]) -> Option<Rounding> {
    let loss = unmoved(triangles, &exact);
    let apart = rounded_before(triangles, &exact, loss.edge, LEAST)?;
    Some(Rounding { loss, rounded_before: Some(apart), grid: None })
}

/// What rounding cost the one of some meshes that lost most, whose file has 32-bit positions; nothing where none lost any. `posed` is what is known
/// of those that a pose moved.
pub(super) fn worst_rounding(meshes: &[Mesh], posed: Vec<Rounding>) -> Rounding {
    let rounding = |mesh: &Mesh| {
        let exact = |v: u32| mesh.exact_position(v as usize);
        let is_posed = !mesh.remainders.is_empty();
        let loss = match is_posed {
            true => Loss::of(&mesh.triangles, Loss::SAMPLE, exact, |v| mesh.positions[v as usize].map(f64::from)),
            false => unmoved(&mesh.triangles, exact),
        };
        let rounded_before = if is_posed { None } else { rounded_before(&mesh.triangles, exact, loss.edge, LEAST) };
        Rounding { loss, rounded_before, grid: None }
    };
    let cost = |r: &Rounding| {
        let apart = r.rounded_before.map_or(0.0, |apart| apart / r.loss.edge);
        if r.loss.is_tolerable() { (0.0, apart) } else { (r.loss.share, apart) }
    };
    let lost = meshes.iter().map(rounding).filter(|r| r.loss.farthest > 0.0 || r.rounded_before.is_some());
    posed.into_iter().chain(lost).reduce(|a, b| if cost(&b) > cost(&a) { b } else { a }).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::precision::tests::patch;

    #[test]
    fn a_model_that_was_rounded_before_is_told() {
        let (positions, triangles) = patch(20, 0.1, [500_123.26, 102.51, -4_649_776.77]);
        let printed = |c: f64| (f64::from(c as f32) * 1e4).round() / 1e4;
        let rounded = |v: u32| positions[v as usize].map(printed);
        assert_eq!(rounded_before(&triangles, rounded, 0.1, 0.0), Some(0.5));
        // Two of three coordinates are far off.
        assert_eq!(rounded_before(&triangles, rounded, 0.1, 0.6), Some(0.5));
        assert_eq!(rounded_before(&triangles, rounded, 0.1, 0.7), None);
        // With all their digits they were not.
        let exact = |v: u32| positions[v as usize];
        assert_eq!(rounded_before(&triangles, exact, 0.1, 0.0), None);
        assert_eq!(rounded_before(&[[0, 0, 0]], |_| [0.5, 0.0, 0.0], 0.0, 0.0), None);
    }

    #[test]
    fn the_mesh_that_lost_most_is_told_of_and_none_where_nothing_is_lost() {
        let mesh = |at: [f64; 3]| {
            let (positions, triangles) = patch(20, 0.1, at);
            let positions = positions.iter().map(|p| p.map(|c| c as f32)).collect();
            Mesh { positions, triangles, ..Mesh::default() }
        };
        let (near, far, farther) = (mesh([0.0; 3]), mesh([0.0, 0.0, 500_123.0]), mesh([0.0, 0.0, 5_001_230.0]));
        assert_eq!(worst_rounding(std::slice::from_ref(&near), Vec::new()), Rounding::default());
        assert_eq!(worst_rounding(&[], Vec::new()), Rounding::default());
        assert_eq!(worst_rounding(&[near.clone(), far.clone()], Vec::new()).rounded_before, Some(0.03125));
        let worst = worst_rounding(&[near.clone(), farther, far], Vec::new());
        assert_eq!(worst.rounded_before, Some(0.5));

        // Remainders tell what rounding costs here.
        let posed = |off: f32| Mesh { remainders: vec![[off, 0.0, 0.0]; near.positions.len()], ..near.clone() };
        let worst = worst_rounding(&[posed(1e-9), posed(0.05), posed(0.01)], Vec::new());
        assert!((worst.loss.share - 0.5).abs() < 1e-3 && worst.rounded_before.is_none(), "{worst:?}");
    }

    #[test]
    fn decimals_tell_their_step() {
        for (numbers, step) in [
            (&[1234560.0, 7654320.0][..], 10.0),
            (&[16_777_217.0, 3e9], 1.0),
            (&[0.25, 1e6], 0.01),
            (&[1e7 + 0.125, 0.0], 0.001),
            (&[1e12, -3e12], 1e12),
        ] {
            assert_eq!(decimal_step(numbers), step, "{numbers:?}");
        }
        assert!(decimal_step(&[1.0 / 3.0]) < 1e-8);
    }

    /// A grid of ten units whose numbers have six digits, far off: they are 32-bit floats by chance, which lie closer.
    #[test]
    fn text_of_six_digits_is_no_finer_than_its_digits() {
        let at = |v: u32| [4_649_770.0 + 10.0 * f64::from(v % 3), 1_000_000.0, 10.0 * f64::from(v / 3)];
        let triangles = [[0, 1, 3], [1, 4, 3]];
        assert_eq!(rounded_before(&triangles, at, 1.0, 0.25), Some(10.0));
        let odd = |v: u32| at(v).map(|c| c + 0.5);
        assert_eq!(rounded_before(&triangles, odd, 1.0, 0.25), Some(0.5));
    }
}
