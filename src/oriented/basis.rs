//! Three directions that a box lies along.

use crate::geom::vector::{cross, dot, sub};

/// A side shorter than this share of another has no direction that `f64` could tell from it.
const FLAT: f64 = 1e-12;

/// A rotation as its three axes: each of length 1, at right angles to the others, right-handed. `x × y = z`.
///
/// To rounding, that is: products of two different axes are at most [`Basis::ERROR`], and of one with itself as far from 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis([[f64; 3]; 3]);

impl Basis {
    /// The scene's own axes.
    pub const AXES: Basis = Basis([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// How far `axes · axesᵀ` may be from the unit matrix, in each of its nine numbers: a few roundings of `f64`.
    pub const ERROR: f64 = 8.0 * super::volume::UNIT;

    /// x, y and z.
    #[inline]
    pub fn axes(&self) -> &[[f64; 3]; 3] {
        &self.0
    }

    /// Along one direction, with x and y axes in the plane of both. Where the second says nothing, any direction at a right angle does.
    ///
    /// Without a first direction, [`Basis::AXES`].
    pub fn along(first: [f64; 3], second: [f64; 3]) -> Basis {
        let Some(x) = unit(first) else { return Basis::AXES };
        let y = match unit(second).map(|second| away(second, x)) {
            Some(y) if dot(y, y) > FLAT * FLAT => y,
            _ => {
                // The scene's axis that is farthest from x.
                let least = (0..3).min_by(|a, b| x[*a].abs().total_cmp(&x[*b].abs())).unwrap_or(0);
                away(Basis::AXES.0[least], x)
            }
        };
        // What is left after one subtraction may still lean, where there was little left.
        let Some(y) = unit(y).map(|y| away(y, x)).and_then(unit) else { return Basis::AXES };
        Basis([x, y, cross(x, y)])
    }

    /// Of a triangle: x is its longest edge, z its normal (Aston, "Agglomerative Building and Traversal of an Object Aligned Bounding Volume
    /// Hierarchy", 2018). Of a triangle without area, x is all that it says.
    pub fn of_triangle(corners: &[[f64; 3]; 3]) -> Basis {
        let edges = [0, 1, 2].map(|i| sub(corners[(i + 1) % 3], corners[i]));
        let mut longest = 0;
        for i in 1..3 {
            if dot(edges[i], edges[i]) > dot(edges[longest], edges[longest]) {
                longest = i;
            }
        }
        Basis::along(edges[longest], edges[(longest + 1) % 3])
    }

    /// The point's coordinates along the axes.
    #[inline(always)]
    pub fn coordinates(&self, p: [f64; 3]) -> [f64; 3] {
        self.0.map(|axis| dot(axis, p))
    }

    /// The point that has these coordinates.
    #[inline]
    pub fn point(&self, coordinates: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|a| dot([self.0[0][a], self.0[1][a], self.0[2][a]], coordinates))
    }
}

/// Of length 1; nothing where there is no direction. Scaled first, so that no square over- or underflows.
pub(super) fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let most = v.iter().fold(0.0f64, |most, c| most.max(c.abs()));
    if !(most > 0.0 && most.is_finite()) {
        return None;
    }
    let v = v.map(|c| c / most);
    let length = dot(v, v).sqrt();
    Some(v.map(|c| c / length))
}

/// What of `v` is at a right angle to `x`, which has length 1.
fn away(v: [f64; 3], x: [f64; 3]) -> [f64; 3] {
    let along = dot(v, x);
    [0, 1, 2].map(|a| v[a] - along * x[a])
}
