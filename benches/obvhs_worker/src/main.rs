//! Builds trees with obvhs for a benchmark in another process.
//!
//! Input: a count and that many triangles of nine floats; then a byte per request, the number of a preset. Each is answered
//! by the build's milliseconds (f64), the nodes as 32-byte records `min, first, max, count` with their number (u32) before, and the leaf
//! order of primitive indices with its number before. Everything is in the machine's byte order.

use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;
use std::io::{Read, Result, Write, stdin, stdout};
use std::time::{Duration, Instant};

fn main() -> Result<()> {
    let (mut input, mut output) = (stdin().lock(), stdout().lock());
    let mut count = [0; 4];
    input.read_exact(&mut count)?;
    let mut floats = vec![[0f32; 9]; u32::from_ne_bytes(count) as usize];
    input.read_exact(bytemuck::cast_slice_mut(&mut floats))?;
    let corner = |t: &[f32; 9], i: usize| [t[i], t[i + 1], t[i + 2]].into();
    let triangles: Vec<Triangle> =
        floats.iter().map(|t| Triangle { v0: corner(t, 0), v1: corner(t, 3), v2: corner(t, 6) }).collect();

    let mut request = [0];
    while input.read(&mut request)? == 1 {
        let params = match request[0] {
            0 => BvhBuildParams::fastest_build(),
            1 => BvhBuildParams::very_fast_build(),
            2 => BvhBuildParams::fast_build(),
            3 => BvhBuildParams::medium_build(),
            4 => BvhBuildParams::slow_build(),
            _ => BvhBuildParams::very_slow_build(),
        };
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
