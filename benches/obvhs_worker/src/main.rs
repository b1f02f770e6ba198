//! Builds trees with obvhs for a benchmark in another process.
//!
//! Input: a count and that many triangles of nine floats; then a byte per request, the number of a preset. Each is answered
//! by the build's milliseconds (f64), the nodes as 32-byte records `min, first, max, count` with their number (u32) before, and the leaf
//! order of primitive indices with its number before. Everything is in the machine's byte order. With `league` it also traces rays through the binary tree and
//! through the 8-wide one (CWBVH), with the crate's own triangle test: see `benches/league/serve.rs`.

#[path = "../../league/serve.rs"]
mod serve;

use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use std::io::{Read, Result, Write, stdin, stdout};
use std::time::{Duration, Instant};

fn main() -> Result<()> {
    let (mut input, mut output) = (stdin().lock(), stdout().lock());
    let floats = serve::triangles(&mut input)?;
    let corner = |t: &[f32; 9], i: usize| [t[i], t[i + 1], t[i + 2]].into();
    let triangles: Vec<Triangle> =
        floats.iter().map(|t| Triangle { v0: corner(t, 0), v1: corner(t, 3), v2: corner(t, 6) }).collect();

    if std::env::args().nth(1).as_deref() == Some("league") {
        return serve::serve(&mut input, &mut output, |setting, wide, rays| {
            Some(league(&triangles, setting, wide, rays))
        });
    }
    let mut request = [0];
    while input.read(&mut request)? == 1 {
        let params = params(request[0]);
        let start = Instant::now();
        let bvh = build_bvh2_from_tris(&triangles, params, &mut Duration::default());
        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
        let mut nodes: Vec<u32> = Vec::with_capacity(8 * bvh.nodes.len());
        for node in &bvh.nodes {
            nodes.extend(node.aabb.min.to_array().map(f32::to_bits));
            nodes.push(node.first_index);
            nodes.extend(node.aabb.max.to_array().map(f32::to_bits));
            nodes.push(node.prim_count);
        }
        output.write_all(&milliseconds.to_ne_bytes())?;
        output.write_all(&(bvh.nodes.len() as u32).to_ne_bytes())?;
        output.write_all(bytemuck::cast_slice(&nodes))?;
        output.write_all(&(bvh.primitive_indices.len() as u32).to_ne_bytes())?;
        output.write_all(bytemuck::cast_slice(&bvh.primitive_indices))?;
        output.flush()?;
    }
    Ok(())
}

fn params(setting: u8) -> BvhBuildParams {
    match setting {
        0 => BvhBuildParams::fastest_build(),
        1 => BvhBuildParams::very_fast_build(),
        2 => BvhBuildParams::fast_build(),
        3 => BvhBuildParams::medium_build(),
        4 => BvhBuildParams::slow_build(),
        _ => BvhBuildParams::very_slow_build(),
    }
}

fn league(triangles: &[Triangle], setting: u8, wide: u8, rays: &[serve::Ray]) -> serve::Told {
    let ask =
        |ray: &serve::Ray| Ray::new([ray[0], ray[1], ray[2]].into(), [ray[4], ray[5], ray[6]].into(), ray[3], ray[7]);
    let mut time = Duration::default();
    let start = Instant::now();
    // Triangles in the order of the leaves, as the crate's examples have them.
    let in_order = |order: &[u32]| order.iter().map(|i| RtTriangle::from(&triangles[*i as usize])).collect::<Vec<_>>();
    let answer = |hit: RayHit, order: &[u32]| (hit.t < f32::MAX).then(|| (hit.t, order[hit.primitive_id as usize]));
    if wide == 0 {
        let tree = build_bvh2_from_tris(triangles, params(setting), &mut time);
        let leaves = in_order(&tree.primitive_indices);
        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
        let (seconds, hits) = serve::traced(rays, |ray| {
            let mut hit = RayHit::none();
            tree.ray_traverse(ask(ray), &mut hit, |ray, i| leaves[i].intersect(ray));
            answer(hit, &tree.primitive_indices)
        });
        let bytes = size_of_val(&tree.nodes[..]) + size_of_val(&tree.primitive_indices[..]) + size_of_val(&leaves[..]);
        serve::Told { milliseconds, nodes: tree.nodes.len() as f64, bytes: bytes as f64, seconds, hits }
    } else {
        let tree = build_cwbvh_from_tris(triangles, params(setting), &mut time);
        let leaves = in_order(&tree.primitive_indices);
        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
        let (seconds, hits) = serve::traced(rays, |ray| {
            let mut hit = RayHit::none();
            tree.ray_traverse(ask(ray), &mut hit, |ray, i| leaves[i].intersect(ray));
            answer(hit, &tree.primitive_indices)
        });
        let bytes = size_of_val(&tree.nodes[..]) + size_of_val(&tree.primitive_indices[..]) + size_of_val(&leaves[..]);
        serve::Told { milliseconds, nodes: tree.nodes.len() as f64, bytes: bytes as f64, seconds, hits }
    }
}
