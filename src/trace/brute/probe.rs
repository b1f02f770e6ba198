//! The first step: `f64` with a margin.
//!
//! **The slack.** A file holds what the scene says up to rounding: `f32` matrices, or `f32` vertices baked by them. With `u = 2⁻²⁴`, an instance's
//! true map `M x + m`, its inverse `W x + w`, and `X` the largest coordinate of the mesh per axis, rounding `M`, `m` and then the inverse
//! moves a point in object space by at most, per axis,
//!
//! ```text
//! u · [ 2·|W|·(|M|·X + |m|) + |w| ]        times 1.01 for the second order; zero for the identity
//! ```
//!
//! and so does rounding a baked vertex, which is one of the terms. To this comes the arithmetic of both sides, at most `2⁻⁴⁸` of the largest
//! coordinate `R` in play, the distance to the triangle included: with `ε = 2⁻⁵³`, traversal's test computes a corner's
//! two sheared coordinates `x·d_z − z·d_x` with errors that move the corner by at most `3ε(|x| + |z|) ≤ 6εR` each, and its edge function's own roundings are
//! worth moving one end by another `2ε·2R`; together, over two axes, less than `15εR < 2⁻⁴⁹·R`. This side's formula does not lose more.
//!
//! **The distance** of a plane is `n·(p − o) / n·d`. With `m` the sums of the absolute products whose differences are `n`, both dot products
//! are off by at most `10ε·Σ m·|…| < 2⁻⁴⁹·Σ m·|…|`. Traversal keeps it within the corners' depths along the direction's largest component.

use crate::geom::vector::{cross, dot, sub};
use crate::geom::{Affine, Ray};

/// 2⁻⁴⁸ and 2⁻⁴⁹.
const ARITHMETIC: f64 = 1.0 / (1u64 << 48) as f64;
const PLANE: f64 = 1.0 / (1u64 << 49) as f64;

/// World to object.
pub(super) struct Map {
    to_object: Affine,
    /// The slack's share that does not depend on the ray.
    slack: f64,
}

impl Map {
    /// The inverse of an instance's own matrix.
    pub fn rounded(to_world: &Affine, mesh: &[[f64; 3]; 2]) -> Map {
        let to_object = to_world.inverse().unwrap_or(Affine::IDENTITY);
        Map { slack: matrix_slack(to_world, &to_object, mesh), to_object }
    }

    /// The very matrix that traversal uses.
    pub fn stored(to_object: Affine) -> Map {
        Map { to_object, slack: 0.0 }
    }

    pub fn is_identity(&self) -> bool {
        self.to_object == Affine::IDENTITY
    }
}

/// A box in the world that contains a mesh's.
pub(super) fn moved(to_world: &Affine, mesh: &[[f64; 3]; 2]) -> [[f64; 3]; 2] {
    let reach = [0, 1, 2].map(|a| mesh[0][a].abs().max(mesh[1][a].abs()));
    let far = to_world.rows.map(|r| r[0].abs() * reach[0] + r[1].abs() * reach[1] + r[2].abs() * reach[2] + r[3].abs());
    [far.map(|v| -v), far]
}

/// The formula at the head of this file, as the length of the vector.
fn matrix_slack(to_world: &Affine, to_object: &Affine, mesh: &[[f64; 3]; 2]) -> f64 {
    if *to_world == Affine::IDENTITY || mesh[0][0] > mesh[1][0] {
        return 0.0;
    }
    let reach = [0, 1, 2].map(|a| mesh[0][a].abs().max(mesh[1][a].abs()));
    let apply = |m: &Affine, v: [f64; 3]| m.rows.map(|r| r[0].abs() * v[0] + r[1].abs() * v[1] + r[2].abs() * v[2]);
    let linear = apply(to_world, reach);
    let world = [0, 1, 2].map(|a| linear[a] + to_world.rows[a][3].abs());
    let back = apply(to_object, world);
    length([0, 1, 2].map(|a| 1.01 * 2f64.powi(-24) * (2.0 * back[a] + to_object.rows[a][3].abs())))
}

/// A ray in an instance's space.
pub(super) struct Probe {
    origin: [f64; 3],
    direction: [f64; 3],
    inverse: [f64; 3],
    speed: f64,
    slack: f64,
    t_min: f64,
    t_max: f64,
}

/// The distances of a triangle that is not surely missed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub t: f64,
    pub nearest: f64,
    pub farthest: f64,
    /// The ray passes all edges, and `t_min` and `t_max`, by more than the margin.
    pub certain: bool,
}

impl Span {
    pub fn overlaps(&self, other: &Span) -> bool {
        self.nearest <= other.farthest && other.nearest <= self.farthest
    }
}

impl Probe {
    pub fn new(ray: &Ray, map: &Map, mesh: &[[f64; 3]; 2]) -> Probe {
        let origin = map.to_object.transform_point(ray.origin.map(f64::from));
        let direction = map.to_object.transform_vector(ray.direction.map(f64::from));

        // What the map's own arithmetic sums up, before anything cancels, counts as a coordinate in play.
        let largest = |v: [f64; 3]| v[0].abs().max(v[1].abs()).max(v[2].abs());
        let summed = map.to_object.rows.map(|r| {
            let o = ray.origin.map(|c| f64::from(c).abs());
            r[0].abs() * o[0] + r[1].abs() * o[1] + r[2].abs() * o[2] + r[3].abs()
        });
        let coordinates = largest(summed) + largest(mesh[0]) + largest(mesh[1]);
        Probe {
            origin,
            direction,
            inverse: direction.map(|d| 1.0 / d),
            speed: length(direction),
            slack: map.slack + ARITHMETIC * coordinates,
            t_min: f64::from(ray.t_min),
            t_max: f64::from(ray.t_max),
        }
    }

    /// Whether the ray may pass the box, widened by the slack, before `limit`. The factor covers the arithmetic of this test.
    pub fn meets(&self, [min, max]: &[[f64; 3]; 2], limit: f64) -> bool {
        let (mut near, mut far) = (self.t_min, limit);
        for a in 0..3 {
            let (lo, hi) = (min[a] - self.slack - self.origin[a], max[a] + self.slack - self.origin[a]);
            if self.direction[a] == 0.0 {
                if lo > 0.0 || hi < 0.0 {
                    return false;
                }
            } else if self.inverse[a].is_finite() {
                let (x, y) = (lo * self.inverse[a], hi * self.inverse[a]);
                near = near.max(x.min(y) - 1e-14 * x.abs().max(y.abs()));
                far = far.min(x.max(y) + 1e-14 * x.abs().max(y.abs()));
            }
        }
        near <= far
    }

    /// `None` if the ray certainly misses.
    ///
    /// The origin is moved along the ray to the triangle, so that products are of the triangle's size. The sides are the moments
    /// `d · (p × q)`, twice the areas that the edges span with the ray when seen along it. Moving two corners by up to the slack each changes
    /// an area by at most `slack·(|p| + |q|) + slack²`.
    pub fn test(&self, corners: [[f32; 3]; 3]) -> Option<Span> {
        let v = corners.map(|p| p.map(f64::from));
        let d = self.direction.map(|c| c / self.speed);
        let center = [0, 1, 2].map(|a| (v[0][a] + v[1][a] + v[2][a]) / 3.0);
        let along = dot(sub(center, self.origin), d);
        let start = [0, 1, 2].map(|a| self.origin[a] + along * d[a]);
        let p = v.map(|c| sub(c, start));
        let slack = self.slack + ARITHMETIC * along.abs();
        let reach = p.map(length);
        let (mut left, mut right, mut unsure) = (false, false, false);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let moment = dot(d, cross(p[i], p[j]));
            let margin = slack * (reach[i] + reach[j]) + slack * slack;
            let (to_left, to_right) = (moment > margin, moment < -margin);
            left |= to_left;
            right |= to_right;
            unsure |= !to_left && !to_right;
        }
        if left && right {
            return None;
        }
        let span = self.distances(&v, &p, along, slack);
        if span.farthest < self.t_min || span.nearest > self.t_max {
            return None;
        }
        let certain = !unsure && span.nearest >= self.t_min && span.farthest <= self.t_max;
        Some(Span { certain, ..span })
    }

    /// What may come out as the distance: the plane's within what rounding makes of it, within the depths of the corners.
    ///
    /// `p` are the corners relative to the point `along` the ray.
    fn distances(&self, v: &[[f64; 3]; 3], p: &[[f64; 3]; 3], along: f64, slack: f64) -> Span {
        let (mut nearest, mut farthest) = (f64::INFINITY, f64::NEG_INFINITY);
        let largest = self.direction.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        for a in (0..3).filter(|a| self.direction[*a].abs() >= 0.999_999 * largest) {
            for corner in v {
                let depth = (corner[a] - self.origin[a]) / self.direction[a];
                nearest = nearest.min(depth - slack / largest);
                farthest = farthest.max(depth + slack / largest);
            }
        }
        let middle = Span { t: 0.5 * (nearest + farthest), nearest, farthest, certain: false };

        // The plane.
        let (e, f) = (sub(v[1], v[0]), sub(v[2], v[0]));
        let normal = cross(e, f);
        let size = [(1, 2), (2, 0), (0, 1)].map(|(i, j)| (e[i] * f[j]).abs() + (e[j] * f[i]).abs());
        let facing = dot(normal, self.direction);
        let t = along / self.speed + dot(normal, p[0]) / facing;
        let facing_error = PLANE * dot(size, self.direction.map(f64::abs));
        let relative = sub(v[0], self.origin).map(f64::abs);
        let ahead_error = slack * length(normal) + PLANE * (dot(size, p[0].map(f64::abs)) + dot(size, relative));
        let rest = facing.abs() - facing_error;
        let spread =
            1.01 * ((ahead_error + 2.0 * t.abs() * facing_error) / rest + slack / self.speed + PLANE * t.abs());
        if !(rest > facing_error && spread.is_finite()) {
            return middle;
        }
        let (nearest, farthest) = (nearest.max(t - spread), farthest.min(t + spread));
        if nearest <= farthest { Span { t, nearest, farthest, certain: false } } else { middle }
    }
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}
