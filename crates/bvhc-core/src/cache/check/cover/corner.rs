use std::cmp::Ordering;

use crate::geom::Point;
use crate::geom::orient::{orient2d, orient3d};
use crate::geom::vector::{cross, sub};

/// A corner of a part of a triangle, told by what meets there. It has no coordinates that could be rounded.
#[derive(Clone, Copy, Debug)]
pub enum Corner {
    /// Of the triangle itself.
    Own(u8),
    /// Where an edge meets a plane `x[axis] = plane` that it crosses. Edge `i` runs from corner `i` to the next.
    OnEdge { edge: u8, axis: u8, plane: f32 },
    /// Where two planes meet in the triangle.
    Inside { axes: [u8; 2], planes: [f32; 2] },
}

/// The triangle that is cut up.
#[derive(Clone, Copy, Debug)]
pub struct Whole {
    pub corners: [Point; 3],
    /// Signs of the normal's coordinates.
    pub normal: [Ordering; 3],
}

impl Whole {
    /// A coordinate of the normal has the sign of the area of the triangle's shadow along that axis.
    pub fn new(corners: [Point; 3]) -> Whole {
        let shadow = |axis: usize| {
            let [a, b, c] = corners.map(|p| [p[(axis + 1) % 3], p[(axis + 2) % 3]]);
            orient2d(a, b, c)
        };
        Whole { corners, normal: [shadow(0), shadow(1), shadow(2)] }
    }

    /// On which side of the plane `x[axis] = plane` a corner lies, exactly.
    ///
    /// A corner on an edge and one between two planes are compared by the sign of a determinant: of the edge, or of the triangle's corners, and
    /// the point that the planes single out.
    pub fn compare(&self, corner: &Corner, axis: usize, plane: f32) -> Ordering {
        match *corner {
            Corner::Own(i) => exact(self.corners[usize::from(i)][axis], plane),
            Corner::OnEdge { axis: on, plane: at, .. } if usize::from(on) == axis => exact(at, plane),
            Corner::OnEdge { edge, axis: on, plane: at } => {
                let (a, b) = self.edge(edge, usize::from(on));
                let flat = |p: Point| [p[usize::from(on)], p[axis]];
                orient2d(flat(a), flat(b), [at, plane]).reverse()
            }
            Corner::Inside { axes, planes } => {
                if let Some(k) = axes.iter().position(|a| usize::from(*a) == axis) {
                    return exact(planes[k], plane);
                }
                let mut point = [plane; 3];
                (point[usize::from(axes[0])], point[usize::from(axes[1])]) = (planes[0], planes[1]);
                let [a, b, c] = self.corners;
                let side = orient3d(a, b, c, point);
                if self.normal[axis].is_lt() { side.reverse() } else { side }
            }
        }
    }

    /// An edge from its lower end along an axis upward.
    fn edge(&self, edge: u8, axis: usize) -> (Point, Point) {
        let (a, b) = (self.corners[usize::from(edge)], self.corners[(usize::from(edge) + 1) % 3]);
        if a[axis] <= b[axis] { (a, b) } else { (b, a) }
    }

    /// About where a corner lies, for people to read.
    pub fn about(&self, corner: &Corner) -> [f64; 3] {
        let wide = |p: Point| p.map(f64::from);
        match *corner {
            Corner::Own(i) => wide(self.corners[usize::from(i)]),
            Corner::OnEdge { edge, axis, plane } => {
                let (a, b) = self.edge(edge, usize::from(axis));
                let (a, b, axis) = (wide(a), wide(b), usize::from(axis));
                let share = (f64::from(plane) - a[axis]) / (b[axis] - a[axis]);
                let mut point = [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]));
                point[axis] = plane.into();
                point
            }
            Corner::Inside { axes: [k, l], planes: [m, n] } => {
                let (k, l) = (usize::from(k), usize::from(l));
                let [a, b, c] = self.corners.map(wide);
                let (normal, third) = (cross(sub(b, a), sub(c, a)), 3 - k - l);
                let rise = normal[k] * (f64::from(m) - a[k]) + normal[l] * (f64::from(n) - a[l]);
                let mut point = [a[third] - rise / normal[third]; 3];
                (point[k], point[l]) = (m.into(), n.into());
                point
            }
        }
    }
}

fn exact(a: f32, b: f32) -> Ordering {
    a.partial_cmp(&b).unwrap_or(Ordering::Equal) // both are finite
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLOPE: [Point; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 1.0], [0.0, 4.0, 2.0]];

    /// The same triangle from both sides and from each corner on, with its axes turned.
    fn all_ways() -> impl Iterator<Item = (Whole, usize)> {
        (0..3).flat_map(|turn| {
            let turned = SLOPE.map(|p| [0, 1, 2].map(|k| p[(k + 3 - turn) % 3]));
            let [a, b, c] = turned;
            [[a, b, c], [b, c, a], [c, b, a]].map(|t| (Whole::new(t), turn))
        })
    }

    #[test]
    fn a_corner_between_two_planes_is_compared_along_the_third_axis() {
        for (whole, turn) in all_ways() {
            // At x = 1, y = 1 the height is 0.25 + 0.5.
            let [x, y, z] = [0, 1, 2].map(|k| (k + turn) % 3);
            let corner = Corner::Inside { axes: [x as u8, y as u8], planes: [1.0, 1.0] };
            let at = |plane| whole.compare(&corner, z, plane);
            assert_eq!(
                [at(0.75f32.next_down()), at(0.75), at(0.75f32.next_up())],
                [Ordering::Greater, Ordering::Equal, Ordering::Less]
            );
            assert_eq!(
                [whole.compare(&corner, x, 1.0), whole.compare(&corner, y, 2.0)],
                [Ordering::Equal, Ordering::Less]
            );
            assert!((whole.about(&corner)[z] - 0.75).abs() < 1e-12);
        }
    }

    #[test]
    fn a_corner_on_an_edge_is_compared_along_the_other_axes() {
        for (whole, turn) in all_ways() {
            let [x, y, z] = [0, 1, 2].map(|k| (k + turn) % 3);
            // The edge between the second and the third corner of SLOPE, halfway along x.
            let edge = (0..3u8)
                .find(|i| (0..2).all(|k| whole.corners[(usize::from(*i) + k) % 3][z] > 0.5))
                .expect("two corners are high");
            let corner = Corner::OnEdge { edge, axis: x as u8, plane: 2.0 };
            let at = |axis, plane| whole.compare(&corner, axis, plane);
            assert_eq!([at(z, 1.5f32.next_down()), at(z, 1.5), at(y, 2.0), at(x, 2.0f32.next_up())], {
                use Ordering::{Equal, Greater, Less};
                [Greater, Equal, Equal, Less]
            });
        }
    }

    /// Where the square of `f64`'s rounding error decides.
    #[test]
    fn near_cases_far_from_the_origin_are_exact() {
        let whole = Whole::new([[1e7, 1.0, 1e-30], [3e7, 16_777_216.0, 2.0], [-5e6, 3.0, 1e20]]);
        let corner = Corner::OnEdge { edge: 0, axis: 0, plane: 1.0000001e7 };
        // x = 1e7 + 1 of 2e7 (the plane's neighbour), so y = 1 + 16777215 / 2e7 · 1, which lies between two floats.
        let y = 1.0 + 16_777_215.0 * f64::from(1.0000001e7f32 - 1e7) / 2e7;
        let below = y as f32;
        let (low, high) = if f64::from(below) <= y { (below, below.next_up()) } else { (below.next_down(), below) };
        assert_eq!(
            [whole.compare(&corner, 1, low), whole.compare(&corner, 1, high)],
            [Ordering::Greater, Ordering::Less]
        );
    }
}
