//! [`Lens`]: a pinhole camera over a film of pixels. It knows the ray of each pixel, and the pixel of each point.

use crate::geom::Ray;
use crate::geom::vector::{cross, dot, sub};
use crate::trace::probe::Camera;

/// A camera and a film of `width` × `height` pixels.
///
/// The camera's `tan_half` is that of half the angle of view across the longer side of the film, so a scene that fits a square film fits
/// every film whose shorter side shows enough.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    eye: [f64; 3],
    forward: [f64; 3],
    right: [f64; 3],
    above: [f64; 3],
    /// Pixels for a tangent of 1.
    scale: f64,
    /// Pixels across.
    pub width: usize,
    /// Pixels down.
    pub height: usize,
}

impl Lens {
    /// Where the camera looks along what it calls up, another axis is taken for up.
    pub fn new(camera: &Camera, width: usize, height: usize) -> Lens {
        let forward = unit(sub(camera.look_at, camera.eye)).unwrap_or([0.0, 0.0, -1.0]);
        let ups = [camera.up, [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let right = ups.into_iter().find_map(|up| unit(cross(forward, unit(up)?)).filter(|r| dot(*r, *r) > 0.5));
        let right = right.unwrap_or([1.0, 0.0, 0.0]);
        let above = cross(right, forward);
        let longer = width.max(height) as f64;
        Lens { eye: camera.eye, forward, right, above, scale: 0.5 * longer / camera.tan_half, width, height }
    }

    /// The ray through a place of the film, in pixels from its upper left corner. Its direction is one unit long along the view, so a hit's `t`
    /// is its depth.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let across = (x - 0.5 * self.width as f64) / self.scale;
        let up = (0.5 * self.height as f64 - y) / self.scale;
        let direction = [0, 1, 2].map(|a| (self.forward[a] + across * self.right[a] + up * self.above[a]) as f32);
        Ray::new(self.eye.map(|c| c as f32), direction)
    }

    /// A point in the camera's own axes: to the right, up, and along the view.
    pub fn seen_from_eye(&self, point: [f64; 3]) -> [f64; 3] {
        let way = sub(point, self.eye);
        [dot(way, self.right), dot(way, self.above), dot(way, self.forward)]
    }

    /// Where a point in the camera's own axes falls on the film, in pixels from its upper left corner; only for points before the eye.
    pub fn on_film(&self, [right, above, depth]: [f64; 3]) -> [f64; 2] {
        let k = self.scale / depth;
        [0.5 * self.width as f64 + right * k, 0.5 * self.height as f64 - above * k]
    }

    /// Whether a point falls on the film.
    pub fn frames(&self, point: [f64; 3]) -> bool {
        let seen = self.seen_from_eye(point);
        let [x, y] = self.on_film(seen);
        seen[2] > 0.0 && x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64
    }

    /// The tangents of half the angles of view across and down.
    pub fn tangents(&self) -> [f64; 2] {
        [self.width, self.height].map(|side| 0.5 * side as f64 / self.scale)
    }

    /// Where all rays start.
    pub fn eye(&self) -> [f64; 3] {
        self.eye
    }

    /// The way that the camera looks, of length 1.
    pub fn forward(&self) -> [f64; 3] {
        self.forward
    }
}

/// The vector with length 1, unless it has none. Scaled first, so that no square overflows or vanishes.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let largest = v.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let v = v.map(|c| c / largest);
    let length = dot(v, v).sqrt();
    Some(v.map(|c| c / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera { eye: [1.0, 2.0, 3.0], look_at: [4.0, 2.5, -1.0], up: [0.0, 1.0, 0.0], tan_half: 0.5 }
    }

    #[test]
    fn a_point_on_a_pixels_ray_falls_on_that_pixel() {
        let lens = Lens::new(&camera(), 300, 200);
        for (x, y) in [(0.5, 0.5), (150.0, 100.0), (299.5, 10.5), (20.0, 199.0)] {
            let ray = lens.ray(x, y);
            let point = [0, 1, 2].map(|a| f64::from(ray.origin[a]) + 7.0 * f64::from(ray.direction[a]));
            let seen = lens.seen_from_eye(point);
            let [u, v] = lens.on_film(seen);
            assert!((u - x).abs() < 1e-3 && (v - y).abs() < 1e-3, "{x} {y} became {u} {v}");
            assert!((seen[2] - 7.0).abs() < 1e-5, "t is the depth: {}", seen[2]);
        }
    }

    #[test]
    fn the_angle_of_view_spans_the_longer_side() {
        for (width, height) in [(400, 100), (100, 400)] {
            let lens = Lens::new(&camera(), width, height);
            let edge = if width > height { lens.ray(0.0, 50.0) } else { lens.ray(50.0, 0.0) };
            let d = edge.direction.map(f64::from);
            let along = dot(d, lens.forward);
            assert!(((dot(d, d) - along * along).sqrt() / along - 0.5).abs() < 1e-6);
        }
    }

    #[test]
    fn looking_along_up_is_no_trouble() {
        let down = Camera { look_at: [1.0, -5.0, 3.0], ..camera() };
        let ray = Lens::new(&down, 10, 10).ray(0.0, 0.0);
        assert!(ray.direction.iter().all(|c| c.is_finite()) && ray.direction[1] < -0.9, "{ray:?}");
    }
}
