//! Geometry from arrays, without a model file: `cargo run --release --example own_geometry -- FILE.bvhc`
//!
//! A landscape of a few thousand triangles and a hundred copies of a tent on it become one two-level file, which is opened again and asked.

use bvhc::build::Preset;
use bvhc::geom::Affine;
use bvhc::{Build, Cache, Ray};
use std::error::Error;

const SIDE: u32 = 48;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args_os().nth(1).ok_or("usage: own_geometry FILE.bvhc")?;
    let mut build = Build::empty();

    // Positions, and three numbers of positions a triangle: the form that meshes have everywhere.
    let positions: Vec<[f32; 3]> =
        (0..SIDE * SIDE).map(|i| ((i % SIDE) as f32, (i / SIDE) as f32)).map(|(x, z)| [x, height(x, z), z]).collect();
    let cells = (0..(SIDE - 1) * (SIDE - 1)).map(|i| i % (SIDE - 1) + i / (SIDE - 1) * SIDE);
    let triangles: Vec<[u32; 3]> =
        cells.flat_map(|a| [[a, a + SIDE, a + 1], [a + 1, a + SIDE, a + SIDE + 1]]).collect();
    let land = build.add_mesh("land", &positions, &triangles)?;
    build.add_instance(land, Affine::IDENTITY)?;

    let tent = build.add_mesh(
        "tent",
        &[[-0.3, 0.0, -0.3], [0.3, 0.0, -0.3], [0.0, 0.0, 0.3], [0.0, 0.6, 0.0]],
        &[[0, 1, 3], [1, 2, 3], [2, 0, 3]],
    )?;
    for i in 0..100 {
        let (x, z) = ((2.5 + (i % 10) as f32 * 4.5), (2.5 + (i / 10) as f32 * 4.5));
        build.add_instance(tent, Affine::translation([x, height(x, z), z].map(f64::from)))?;
    }

    build.preset(Preset::Best).threads(0).run()?.write(&file)?;

    let cache = Cache::open(&file)?;
    let down = Ray::new([2.6, 100.0, 2.55], [0.0, -1.0, 0.0]);
    let hit = cache.closest_hit(&down)?.ok_or("the ray missed")?;
    let part = cache.name(hit.geom);
    println!("{} triangles, {} instances", cache.header().prim_count, cache.header().instance_count);
    println!("a ray from above meets triangle {} of the {part}, instance {:?}, at {}", hit.prim, hit.instance, hit.t);
    Ok(())
}

fn height(x: f32, z: f32) -> f32 {
    1.5 * (0.3 * x).sin() * (0.2 * z).cos()
}
