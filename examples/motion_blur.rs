//! Motion blur from a file: `cargo run --release --example motion_blur -- SEQUENCE.bvhc PICTURE.png [FIRST [SECOND]]`
//!
//! FIRST and SECOND are places in the list of frames, counted from 0. It opens the time between these two frames, traces sixteen rays a pixel, each at a time of its own, and shades by the direction of what they hit.
//!
//! ```sh
//! bvhc build fox.glb -o fox.bvhc --clip Run --fps 24 --trees 1 --refit always
//! cargo run --release --example motion_blur -- fox.bvhc fox.png 3 4
//! ```

use bvhc::cache::Between;
use bvhc::exec::Executor;
use bvhc::random::Random;
use bvhc::{Hit, Ray, Sequence};
use std::error::Error;

const WIDTH: usize = 480;
const HEIGHT: usize = 360;
const SAMPLES: usize = 16;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [file, picture, frames @ ..] = &args[..] else {
        return Err("usage: motion_blur SEQUENCE.bvhc PICTURE.png [FIRST [SECOND]]".into());
    };
    let sequence = Sequence::open(file)?;
    let first = frames.first().map_or(Ok(0), |n| n.parse())?;
    let shutter = sequence.between(first, frames.get(1).map_or(Ok(first.saturating_add(1)), |n| n.parse())?)?;

    // Look at the middle of the scene from outside, slightly from above.
    let bounds = sequence.header().scene_bounds();
    let middle = bounds.center2().map(|c| c / 2.0);
    let size = bounds.extent().iter().map(|e| e * e).sum::<f32>().sqrt();
    let forward = unit([-0.6, -0.35, -0.72]);
    let right = unit(cross(forward, [0.0, 1.0, 0.0]));
    let up = cross(right, forward);
    let eye = [0, 1, 2].map(|a| middle[a] - 1.1 * size * forward[a]);

    // In each of sixteen equal parts of the time one ray, through a point of the pixel.
    let mut random = Random::new(1);
    let mut rays = Vec::with_capacity(WIDTH * HEIGHT * SAMPLES);
    for (pixel, sample) in (0..WIDTH * HEIGHT).flat_map(|pixel| (0..SAMPLES).map(move |sample| (pixel, sample))) {
        let mut jitter = || random.unit() as f32;
        let x = ((pixel % WIDTH) as f32 + jitter() - WIDTH as f32 / 2.0) / HEIGHT as f32;
        let y = (HEIGHT as f32 / 2.0 - jitter() - (pixel / WIDTH) as f32) / HEIGHT as f32;
        let ray = Ray::new(eye, [0, 1, 2].map(|a| forward[a] + x * right[a] + y * up[a]));
        rays.push((ray, (sample as f32 + jitter()) / SAMPLES as f32));
    }
    let mut hits = vec![None; rays.len()];
    shutter.closest_hits(&rays, &mut hits, &Executor::current())?;

    let shades = hits.iter().zip(&rays).map(|(hit, (_, time))| hit.map_or(SKY, |hit| shade(&shutter, &hit, *time)));
    let shades: Vec<[f32; 3]> = shades.collect();
    let mean = |some: &[[f32; 3]]| [0, 1, 2].map(|c| (some.iter().map(|s| s[c]).sum::<f32>() / SAMPLES as f32) as u8);
    let pixels: Vec<u8> = shades.chunks_exact(SAMPLES).flat_map(mean).collect();
    let mut encoder = png::Encoder::new(std::fs::File::create(picture)?, WIDTH as u32, HEIGHT as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header()?.write_image_data(&pixels)?;
    Ok(())
}

const SKY: [f32; 3] = [24.0, 28.0, 36.0];

/// Grey by how the triangle is turned at that time, the same on both sides.
fn shade(shutter: &Between<'_>, hit: &Hit, time: f32) -> [f32; 3] {
    let normal = shutter.normal(hit, time).unwrap_or_default().map(|c| c as f32);
    let light = dot(unit(normal), unit([0.36, 0.8, 0.48])).abs();
    [70.0 + 180.0 * light, 66.0 + 176.0 * light, 60.0 + 165.0 * light]
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
