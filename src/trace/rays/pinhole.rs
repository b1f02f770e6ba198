use crate::geom::Ray;
use crate::geom::vector::{cross, dot, sub};

/// A pinhole camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pinhole {
    eye: [f64; 3],
    forward: [f64; 3],
    right: [f64; 3],
    above: [f64; 3],
}

impl Pinhole {
    /// The screen spans `tan_half` to each side horizontally and `tan_half · aspect` vertically.
    pub fn new(eye: [f64; 3], look_at: [f64; 3], up: [f64; 3], tan_half: f64, aspect: f64) -> Pinhole {
        let unit = |v: [f64; 3]| v.map(|c| c / dot(v, v).sqrt());
        let forward = unit(sub(look_at, eye));
        let right = unit(cross(forward, up));
        let above = cross(right, forward);
        Pinhole { eye, forward, right: right.map(|c| c * tan_half), above: above.map(|c| c * tan_half * aspect) }
    }

    /// Through the point of the screen `x` to the right and `y` up, both in −1..1.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let direction = [0, 1, 2].map(|a| (self.forward[a] + x * self.right[a] + y * self.above[a]) as f32);
        Ray::new(self.eye.map(|c| c as f32), direction)
    }
}

/// A pinhole camera's rays, row by row: `width` × `height` rays through a screen that spans `tan_half` to each side of the view
/// direction horizontally.
pub fn camera(eye: [f64; 3], look_at: [f64; 3], up: [f64; 3], tan_half: f64, width: usize, height: usize) -> Vec<Ray> {
    let pinhole = Pinhole::new(eye, look_at, up, tan_half, height as f64 / width as f64);
    let pixel = |y: usize, x: usize| {
        pinhole.ray(2.0 * (x as f64 + 0.5) / width as f64 - 1.0, 1.0 - 2.0 * (y as f64 + 0.5) / height as f64)
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (y, x))).map(|(y, x)| pixel(y, x)).collect()
}
