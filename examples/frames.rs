//! Opens a sequence and traces one ray in each frame; prints what each frame takes to open, and what it hits.
//!
//! ```sh
//! bvhc build 'heli.%04d.obj' -o heli.bvhc
//! cargo run --release --example frames -- heli.bvhc
//! ```

use bvhc::cache::{OpenOptions, Validation};
use bvhc::trace::closest_hit;
use bvhc::{Ray, Sequence, geom::Aabb};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: frames SEQUENCE.bvhc")?;
    let start = Instant::now();
    // Front, rows and names. What a frame shows is hashed when it is opened; `Quick` leaves that out.
    let sequence =
        Sequence::open_with(&path, &OpenOptions { validation: Validation::Quick, ..OpenOptions::default() })?;
    println!("{path}: {} frames, opened in {:.3} ms", sequence.frame_count(), start.elapsed().as_secs_f64() * 1e3);

    // From outside the box of all frames to its middle.
    let Aabb { min, max } = sequence.header().scene_bounds();
    let middle = [0, 1, 2].map(|a| (min[a] + max[a]) / 2.0);
    let ray = Ray::new([middle[0], middle[1], 2.0 * max[2] - min[2] + 1.0], [0.0, 0.0, -1.0]);
    let mut times = Vec::new();
    for index in 0..sequence.frame_count() {
        let start = Instant::now();
        let frame = sequence.frame(index)?;
        let took = start.elapsed().as_secs_f64() * 1e3;
        times.push(took);
        let hit = closest_hit(&frame.view(), &ray)?;
        let seen = hit.map_or("nothing".to_string(), |hit| {
            let part = sequence.names().get(frame.parts()[hit.geom as usize] as usize).unwrap_or_default();
            format!("triangle {} of '{}' at {}", hit.prim, part.escape_debug(), hit.t)
        });
        println!(
            "frame {:>5}  {took:>7.3} ms  {} triangles  {seen}",
            frame.record().number,
            frame.view().triangles.len()
        );
    }
    times.sort_by(f64::total_cmp);
    println!("a frame opens in {:.3} ms (median), {:.3} ms at most", times[times.len() / 2], times[times.len() - 1]);
    Ok(())
}
