//! Where surface lies, and how it spreads.

use super::basis::Basis;
use crate::geom::vector::{cross, dot, sub};

/// Area, first and second moments of triangles: they add up, so a set's follow from those of its parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    area: f64,
    /// ∫ x, ∫ y, ∫ z.
    first: [f64; 3],
    /// ∫ xx, ∫ yy, ∫ zz, ∫ xy, ∫ xz, ∫ yz.
    second: [f64; 6],
}

/// Which axes the second moments are of.
const PAIRS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];

impl Moments {
    /// Of a triangle's surface (Gottschalk, Lin and Manocha, "OBBTree: A Hierarchical Structure for Rapid Interference Detection",
    /// 1996, section 4): long triangles weigh as much as the small ones that they could be cut into.
    ///
    /// The nearer the origin, the more digits are left.
    pub fn of_triangle(corners: &[[f64; 3]; 3]) -> Moments {
        let [a, b, c] = *corners;
        let normal = cross(sub(b, a), sub(c, a));
        let area = 0.5 * dot(normal, normal).sqrt();
        let sum = [0, 1, 2].map(|k| a[k] + b[k] + c[k]);
        let second = PAIRS.map(|[i, j]| area / 12.0 * (sum[i] * sum[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j]));
        Moments { area, first: sum.map(|s| area / 3.0 * s), second }
    }

    /// The surface's area, in the square of the scene's unit; of one side.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Of both.
    pub fn plus(&self, other: &Moments) -> Moments {
        Moments {
            area: self.area + other.area,
            first: [0, 1, 2].map(|k| self.first[k] + other.first[k]),
            second: std::array::from_fn(|k| self.second[k] + other.second[k]),
        }
    }

    /// Along the directions in which surface spreads most, next and least; nothing where there is none.
    pub fn basis(&self) -> Option<Basis> {
        if !(self.area > 0.0 && self.area.is_finite()) {
            return None;
        }
        let middle = self.first.map(|v| v / self.area);
        let mut spread = [[0.0; 3]; 3];
        for (k, [i, j]) in PAIRS.into_iter().enumerate() {
            spread[i][j] = self.second[k] / self.area - middle[i] * middle[j];
            spread[j][i] = spread[i][j];
        }
        let (values, vectors) = eigen(spread);
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
        Some(Basis::along(vectors[order[0]], vectors[order[1]]))
    }
}

/// Eigenvalues and eigenvectors of a symmetric matrix, by Jacobi's rotations in cyclic order: a fixed number of rounds, of which
/// each squares what is left beside the diagonal.
fn eigen(mut m: [[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    const ROUNDS: usize = 8;
    // Rows are the vectors.
    let mut v = *Basis::AXES.axes();
    for _ in 0..ROUNDS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if m[p][q] == 0.0 {
                continue;
            }
            let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let t = if t.is_finite() { t } else { 0.0 };
            let cos = 1.0 / (t * t + 1.0).sqrt();
            let sin = t * cos;
            for k in 0..3 {
                (m[k][p], m[k][q]) = (cos * m[k][p] - sin * m[k][q], sin * m[k][p] + cos * m[k][q]);
            }
            for k in 0..3 {
                (m[p][k], m[q][k]) = (cos * m[p][k] - sin * m[q][k], sin * m[p][k] + cos * m[q][k]);
                (v[p][k], v[q][k]) = (cos * v[p][k] - sin * v[q][k], sin * v[p][k] + cos * v[q][k]);
            }
        }
    }
    ([m[0][0], m[1][1], m[2][2]], v)
}
