//! What a worker answers to `benches/league.rs`, shared by the workers' packages.
//!
//! Input: a count and that many triangles of nine floats; a count and that many rays of eight floats: origin, least distance, direction, greatest distance.
//! Then two bytes a request: the number of a setting, and 0 for the binary tree or 1 for the 8-wide one. Each is answered by four numbers (f64): the
//! milliseconds that the build took, nodes, bytes that rays need, and the seconds that all rays took; then by a distance (f32) and a triangle (u32) a ray. A form
//! that the peer has not is answered by a time that is no number, and nothing else; nodes and bytes that it does not tell are none either. Everything is in
//! the machine's byte order.

use std::io::{Read, Result, Write};
use std::time::Instant;

/// Origin, least distance, direction, greatest distance. The least is 0 and the greatest infinite.
pub type Ray = [f32; 8];

/// How often all rays are traced; the least time counts.
const ROUNDS: usize = 3;
/// The triangle of a ray that hits nothing.
const NOTHING: u32 = u32::MAX;

/// What a tree came to.
pub struct Told {
    pub milliseconds: f64,
    pub nodes: f64,
    pub bytes: f64,
    pub seconds: f64,
    pub hits: Vec<Option<(f32, u32)>>,
}

/// A count and that many triangles.
pub fn triangles(input: &mut impl Read) -> Result<Vec<[f32; 9]>> {
    let mut count = [0; 4];
    input.read_exact(&mut count)?;
    let mut floats = vec![[0f32; 9]; u32::from_ne_bytes(count) as usize];
    input.read_exact(bytemuck::cast_slice_mut(&mut floats))?;
    Ok(floats)
}

/// The seconds that all rays take, and what they hit.
pub fn traced(rays: &[Ray], trace: impl Fn(&Ray) -> Option<(f32, u32)>) -> (f64, Vec<Option<(f32, u32)>>) {
    let mut least = f64::INFINITY;
    let mut hits = Vec::new();
    for _ in 0..ROUNDS {
        let start = Instant::now();
        hits = rays.iter().map(&trace).collect();
        least = least.min(start.elapsed().as_secs_f64());
    }
    (least, hits)
}

/// Read the rays, and answer requests until there are no more.
pub fn serve(
    input: &mut impl Read,
    output: &mut impl Write,
    mut answer: impl FnMut(u8, u8, &[Ray]) -> Option<Told>,
) -> Result<()> {
    let mut count = [0; 4];
    input.read_exact(&mut count)?;
    let mut rays = vec![[0f32; 8]; u32::from_ne_bytes(count) as usize];
    input.read_exact(bytemuck::cast_slice_mut(&mut rays))?;
    let mut request = [0; 2];
    while input.read_exact(&mut request).is_ok() {
        let Some(told) = answer(request[0], request[1], &rays) else {
            output.write_all(&f64::NAN.to_ne_bytes())?;
            output.flush()?;
            continue;
        };
        let Told { milliseconds, nodes, bytes, seconds, hits } = told;
        output.write_all(bytemuck::cast_slice(&[milliseconds, nodes, bytes, seconds]))?;
        let numbers = |hit: &Option<(f32, u32)>| match *hit {
            Some((t, triangle)) => [t.to_bits(), triangle],
            None => [f32::INFINITY.to_bits(), NOTHING],
        };
        let hits: Vec<[u32; 2]> = hits.iter().map(numbers).collect();
        output.write_all(bytemuck::cast_slice(&hits))?;
        output.flush()?;
    }
    Ok(())
}
