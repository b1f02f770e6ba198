use crate::geom::{Affine, Point};
use crate::scene::bounds::Bounds;
use crate::scene::precision::local_origin;

/// Posed positions as a mesh keeps them: rounded to `f32` once, with what rounding left off, around an origin near them.
#[derive(Debug)]
pub struct Rounded {
    pub positions: Vec<Point>,
    /// As [`Mesh::remainders`](crate::scene::Mesh::remainders).
    pub remainders: Vec<Point>,
    /// Where the positions' own origin stands: the transform of the mesh's instance. The identity unless they stand far off.
    pub transform: Affine,
}

/// Positions get an origin of their own where they reach farther from the world's than so many times their own size: 2⁻²⁰ of it is
/// what `f32` would lose there.
const FAR: f64 = 16.0;

impl Rounded {
    /// Round positions in world space.
    pub fn new(mut world: Vec<[f64; 3]>) -> Rounded {
        let origin = origin(&world);
        if origin != [0.0; 3] {
            world.iter_mut().for_each(|p| (0..3).for_each(|k| p[k] -= origin[k]));
        }
        let (positions, remainders) = split_all(&world);
        Rounded { positions, remainders, transform: Affine::translation(origin) }
    }
}

/// Where the finite positions stand far off, an origin beside them, which a file can state exactly; else zero. Along an axis that is beyond
/// `f32` it is their middle: then no file can place the mesh, and its instance says so.
fn origin(world: &[[f64; 3]]) -> [f64; 3] {
    let bounds = Bounds::of(world.iter().copied().filter(|p| p.iter().all(|c| c.is_finite())));
    let Bounds { min, max } = bounds;
    let reach = min.iter().chain(&max).map(|c| c.abs()).fold(0.0, f64::max);
    if !(reach.is_finite() && reach > FAR * bounds.longest()) {
        return [0.0; 3];
    }
    let near = local_origin(bounds);
    [0, 1, 2].map(|k| {
        let middle = 0.5 * min[k] + 0.5 * max[k];
        if (middle as f32).is_finite() { near[k] } else { middle }
    })
}

/// A position rounded to `f32`, and what that left off, itself rounded.
pub fn split(p: [f64; 3]) -> (Point, Point) {
    let rounded = p.map(|c| c as f32);
    let remainder = [0, 1, 2].map(|k| (p[k] - f64::from(rounded[k])) as f32);
    // An infinite coordinate has no remainder that means anything.
    (rounded, remainder.map(|c| if c.is_finite() { c } else { 0.0 }))
}

/// Many positions rounded, and what that left off: nothing at all where every one is exact.
pub fn split_all(positions: &[[f64; 3]]) -> (Vec<Point>, Vec<Point>) {
    let (rounded, remainders): (Vec<Point>, Vec<Point>) = positions.iter().map(|p| split(*p)).unzip();
    let is_exact = remainders.iter().flatten().all(|c| *c == 0.0);
    (rounded, if is_exact { Vec::new() } else { remainders })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rounding_leaves_off_is_kept_to_48_bits() {
        let (positions, remainders) = split_all(&[[0.1, 1.0, -1e-30], [1e39, 0.0, f64::NAN]]);
        for k in 0..3 {
            let sum = f64::from(positions[0][k]) + f64::from(remainders[0][k]);
            assert!((sum - [0.1, 1.0, -1e-30][k]).abs() <= 1e-15 * sum.abs(), "{k}");
        }
        assert_eq!(remainders[1], [0.0; 3]);
        assert!(split_all(&[[0.5, 1.0, 2.0]]).1.is_empty());
    }

    #[test]
    fn positions_far_off_get_an_origin_of_their_own() {
        let far = [[4_649_776.75, 0.0, 0.1], [4_649_778.8, 2.0, 0.3]];
        let rounded = Rounded::new(far.to_vec());
        for (i, p) in far.iter().enumerate() {
            let back = rounded.transform.transform_point(rounded.positions[i].map(f64::from));
            assert!((0..3).all(|k| (back[k] - p[k]).abs() < 1e-7), "{back:?}");
        }
        assert_eq!(Rounded::new(vec![[3.0, 0.0, 0.0], [4.0, 1.0, 0.0]]).transform, Affine::IDENTITY);
        assert_eq!(Rounded::new(Vec::new()).transform, Affine::IDENTITY);
    }
}
