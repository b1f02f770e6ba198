//! Render where a tree makes rays work: `cargo run --release --example heatmap -- [MODEL.obj] [PICTURE.png]`
//!
//! Four panels over one view of the scene (default: the colonnade, into `samples/picture.png`): the scene itself, then
//! for three builds the inner nodes and triangles that each pixel's ray visits, from black (none) over red and yellow to white
//! (400 and more). The means are printed.

use bvhc::build::{Axes, BuildOptions, Executor, Method, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::compile::compile;
use bvhc::geom::Ray;
use bvhc::scene::{ReadOptions, read};
use bvhc::trace::{Counters, Malformed, closest_hit, try_closest_hit};
use bvhc::tree::quality::sah;
use std::error::Error;
use std::path::{Path, PathBuf};

const WIDTH: usize = 480;
const HEIGHT: usize = 300;
/// Work that is drawn white.
const WHITE: f32 = 400.0;

fn main() -> Result<(), Box<dyn Error>> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples");
    let mut args = std::env::args_os().skip(1).map(PathBuf::from);
    let model = args.next().unwrap_or_else(|| here.join("colonnade.obj"));
    let picture = args.next().unwrap_or_else(|| here.join("picture.png"));

    let scene = read(&model, &ReadOptions::default())?;
    let executor = Executor::new(0)?;
    let draft = BuildOptions::preset(Preset::Draft);
    let recipes = [
        ("binned, longest axis", BuildOptions { method: Method::Binned, axes: Axes::Longest, ..draft.clone() }),
        ("binned, three axes", BuildOptions { method: Method::Binned, axes: Axes::All, ..draft }),
        ("sbvh", BuildOptions { method: Method::Sbvh, ..BuildOptions::preset(Preset::Best) }),
    ];
    let mut panels = Vec::new();
    println!("| method | SAH | inner nodes a ray | triangle tests a ray |\n|---|--:|--:|--:|");
    for (name, options) in recipes {
        let accel = compile(scene.clone(), &options, &executor, &NoProgress)?;
        let image = Image::new(&accel, &Executor::current())?;
        let camera = Camera::over(&image);
        if panels.is_empty() {
            panels.push(photograph(&image, &camera)?);
        }
        let (mut heat, mut total) = (Vec::new(), Counters::default());
        for (x, y) in pixels() {
            let mut work = Counters::default();
            try_closest_hit(&image.view(), &camera.ray(x, y), &mut work)?;
            heat.push(colour((work.inner_nodes + work.triangles) as f32 / WHITE));
            total = total + work;
        }
        panels.push(heat);
        let a_ray = |count: u64| count as f64 / (WIDTH * HEIGHT) as f64;
        println!(
            "| {name} | {:.1} | {:.1} | {:.1} |",
            sah(&image.nodes),
            a_ray(total.inner_nodes),
            a_ray(total.triangles)
        );
    }
    write(&picture, &panels)?;
    println!("\nwrote {}", picture.display());
    Ok(())
}

/// A pinhole that looks along the scene's longest horizontal side from just inside its low end.
struct Camera {
    eye: [f32; 3],
    forward: [f32; 3],
    right: [f32; 3],
}

impl Camera {
    fn over(image: &Image) -> Camera {
        let b = &image.blases[0];
        let [x, y, z] = [0, 1, 2].map(|a| b.max[a] - b.min[a]);
        let at = |fx: f32, fy: f32, fz: f32| [b.min[0] + fx * x, b.min[1] + fy * y, b.min[2] + fz * z];
        if x >= z {
            Camera { eye: at(0.03, 0.2, 0.4), forward: [0.98, 0.12, 0.06], right: [-0.06, 0.0, 0.98] }
        } else {
            Camera { eye: at(0.4, 0.2, 0.97), forward: [0.06, 0.12, -0.98], right: [0.98, 0.0, 0.06] }
        }
    }

    /// The ray through a place on the film, in pixels from the upper left corner.
    fn ray(&self, x: f32, y: f32) -> Ray {
        let scale = 1.3 / HEIGHT as f32;
        let across = (x - WIDTH as f32 / 2.0) * scale;
        let up = (HEIGHT as f32 / 2.0 - y) * scale;
        let d = [0, 1, 2].map(|a| self.forward[a] + across * self.right[a]);
        Ray::new(self.eye, [d[0], d[1] + up, d[2]])
    }
}

/// The middles of all pixels, row by row.
fn pixels() -> impl Iterator<Item = (f32, f32)> {
    (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x as f32 + 0.5, y as f32 + 0.5)))
}

/// The scene itself, the mean of nine rays a pixel.
fn photograph(image: &Image, camera: &Camera) -> Result<Vec<[u8; 3]>, Malformed> {
    let mut film = Vec::new();
    for (x, y) in pixels() {
        let mut sum = [0u32; 3];
        for n in 0..9i32 {
            let ray = camera.ray(x + (n % 3 - 1) as f32 / 3.0, y + (n / 3 - 1) as f32 / 3.0);
            let hit = closest_hit(&image.view(), &ray)?;
            let rgb = hit.map_or([24, 28, 36], |hit| shade(&image.triangles[hit.triangle].corners()));
            sum = [0, 1, 2].map(|c| sum[c] + u32::from(rgb[c]));
        }
        film.push(sum.map(|c| (c / 9) as u8));
    }
    Ok(film)
}

/// Grey by how the triangle is turned, the same on both sides.
fn shade([a, b, c]: &[[f32; 3]; 3]) -> [u8; 3] {
    let e = |p: &[f32; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    let (u, v) = (e(b), e(c));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt().max(1e-30);
    let light = ((0.36 * n[0] + 0.8 * n[1] + 0.48 * n[2]) / length).abs();
    [(70.0 + 180.0 * light) as u8, (66.0 + 176.0 * light) as u8, (60.0 + 165.0 * light) as u8]
}

/// Black, red, yellow, white: brighter is always more.
fn colour(share: f32) -> [u8; 3] {
    let step = |from: f32| (((share - from) * 3.0).clamp(0.0, 1.0) * 255.0) as u8;
    [step(0.0), step(1.0 / 3.0), step(2.0 / 3.0)]
}

/// Two rows of two panels with a seam between them.
fn write(path: &Path, panels: &[Vec<[u8; 3]>]) -> Result<(), Box<dyn Error>> {
    const SEAM: usize = 6;
    let (width, height) = (2 * WIDTH + SEAM, 2 * HEIGHT + SEAM);
    let mut pixels = vec![255; width * height * 3];
    for (n, panel) in panels.iter().enumerate() {
        let (left, top) = ((n % 2) * (WIDTH + SEAM), (n / 2) * (HEIGHT + SEAM));
        for (i, rgb) in panel.iter().enumerate() {
            let at = ((top + i / WIDTH) * width + left + i % WIDTH) * 3;
            pixels[at..at + 3].copy_from_slice(rgb);
        }
    }
    let mut encoder =
        png::Encoder::new(std::io::BufWriter::new(std::fs::File::create(path)?), width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.write_header()?.write_image_data(&pixels)?;
    Ok(())
}
