//! A renderer in sixty lines: `cargo run --release --example render -- FILE.bvhc PICTURE.png`
//!
//! It opens a cache file, traces one ray a pixel and shades by the direction of the triangle that is hit.

use bvhc::{Cache, Hit, Ray};
use std::error::Error;

const WIDTH: usize = 960;
const HEIGHT: usize = 720;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<_> = std::env::args_os().skip(1).collect();
    let [file, picture] = &args[..] else { return Err("usage: render FILE.bvhc PICTURE.png".into()) };
    let cache = Cache::open(file)?;

    // Look at the middle of the scene from outside, slightly from above.
    let bounds = cache.header().scene_bounds();
    let middle = bounds.center2().map(|c| c / 2.0);
    let size = bounds.extent().iter().map(|e| e * e).sum::<f32>().sqrt();
    let forward = unit([-0.6, -0.35, -0.72]);
    let right = unit(cross(forward, [0.0, 1.0, 0.0]));
    let up = cross(right, forward);
    let eye = [0, 1, 2].map(|a| middle[a] - 1.1 * size * forward[a]);
    let rays: Vec<Ray> = (0..WIDTH * HEIGHT)
        .map(|i| {
            let x = ((i % WIDTH) as f32 + 0.5 - WIDTH as f32 / 2.0) / HEIGHT as f32;
            let y = (HEIGHT as f32 / 2.0 - 0.5 - (i / WIDTH) as f32) / HEIGHT as f32;
            Ray::new(eye, [0, 1, 2].map(|a| forward[a] + x * right[a] + y * up[a]))
        })
        .collect();

    // All hits at once, on all cores with the feature `rayon`.
    let mut hits = vec![None; rays.len()];
    cache.closest_hits(&rays, &mut hits)?;
    let pixels: Vec<u8> = hits.iter().flat_map(|hit| hit.map_or([24, 28, 36], |hit| shade(&cache, &hit))).collect();

    let mut encoder = png::Encoder::new(std::fs::File::create(picture)?, WIDTH as u32, HEIGHT as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(&pixels)?;
    Ok(())
}

/// Grey by how the triangle is turned, the same on both sides.
fn shade(cache: &Cache, hit: &Hit) -> [u8; 3] {
    let normal = cache.normal(hit).unwrap_or_default().map(|c| c as f32);
    let light = dot(unit(normal), unit([0.36, 0.8, 0.48])).abs();
    [70.0 + 180.0 * light, 66.0 + 176.0 * light, 60.0 + 165.0 * light].map(|c| c as u8)
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    v.map(|c| c / dot(v, v).sqrt().max(f32::MIN_POSITIVE))
}
