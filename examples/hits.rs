//! Trace random rays and say of each hit what leads back to the model: `cargo run --release --example hits -- FILE.bvhc COUNT`
//!
//! Each line is a hit as JSON: the ray, where it meets which triangle, the numbers of the triangle's vertices in the source (of a file that
//! was built with `--vertices`), the names of part and material, and the normal that points to the front. `tests/independent/origins.py`
//! holds them against the model.

use bvhc::cache::{Cache, OpenOptions, Validation};
use bvhc::geom::{Affine, Ray};
use bvhc_core::random::Random;
use std::error::Error;
use std::io::Write;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, count] = &arguments[..] else { return Err("usage: hits FILE.bvhc COUNT".into()) };
    let count: usize = count.parse()?;
    let cache = Cache::open_with(path, &OpenOptions { validation: Validation::Tree, ..OpenOptions::default() })?;
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    let (mut random, mut found) = (Random::new(7), 0);
    // Few rays that are aimed at a triangle miss everything.
    for _ in 0..count.saturating_mul(4) {
        let Some(ray) = aimed(&cache, &mut random) else { break };
        let Some(hit) = cache.closest_hit(&ray)? else { continue };
        let line = serde_json::json!({
            "origin": ray.origin, "direction": ray.direction, "t": hit.t, "u": hit.u, "v": hit.v, "instance": hit.instance,
            "geom": hit.geom, "prim": hit.prim, "triangle": hit.triangle, "vertices": cache.vertices().get(hit.triangle),
            "part": cache.name(hit.geom), "material": cache.material(hit.geom), "normal": cache.normal(&hit),
        });
        writeln!(out, "{line}")?;
        found += 1;
        if found == count {
            break;
        }
    }
    Ok(())
}

/// A ray from somewhere around the scene to a point of a random triangle.
fn aimed(cache: &Cache, random: &mut Random) -> Option<Ray> {
    let instances = cache.instances();
    let mut pick = |len: usize| random.below(len.max(1) as u64) as usize;
    let (triangles, to_world) = match instances.get(pick(instances.len())) {
        Some(i) => (cache.view().blas(i.blas as usize)?.triangles, Affine::from_f32(&i.object_to_world)),
        None => (cache.triangles(), Affine::IDENTITY),
    };
    let corners = triangles.get(pick(triangles.len()))?.corners().map(|p| to_world.transform_point(p.map(f64::from)));
    let (a, b) = (random.unit(), random.unit());
    let (u, v) = if a + b < 1.0 { (a, b) } else { (1.0 - a, 1.0 - b) };
    let target = [0, 1, 2].map(|k| corners[0][k] * (1.0 - u - v) + corners[1][k] * u + corners[2][k] * v);
    let bounds = cache.header().scene_bounds();
    let origin = [0, 1, 2].map(|k| {
        let size = f64::from(bounds.max[k] - bounds.min[k]);
        (f64::from(bounds.min[k]) + (random.unit() * 1.5 - 0.25) * size) as f32
    });
    let direction = [0, 1, 2].map(|k| (target[k] - f64::from(origin[k])) as f32);
    Some(Ray::new(origin, direction))
}
