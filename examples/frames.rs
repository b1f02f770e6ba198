//! Opens a sequence and traces one ray in each frame; prints what each frame takes to open, and what it hits. Of several files it prints a row each: what
//! they take in the file and in time.
//!
//! ```sh
//! bvhc build 'heli.%04d.obj' -o heli.bvhc
//! bvhc convert heli.bvhc -o heli.small.bvhc --codec compact
//! cargo run --release --example frames -- heli.bvhc heli.small.bvhc
//! ```

use bvhc::cache::{OpenOptions, SectionKind, Validation};
use bvhc::trace::closest_hit;
use bvhc::{Ray, Sequence, geom::Aabb};
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    match &paths[..] {
        [] => Err("usage: frames SEQUENCE.bvhc…".into()),
        [path] => play(path, true).map(|_| ()),
        _ => {
            println!(
                "| file | frames | triangles | bytes | bytes a triangle and frame | of positions | a frame opens in | at most |"
            );
            println!("|---|--:|--:|--:|--:|--:|--:|--:|");
            paths.iter().try_for_each(|path| {
                let played = play(path, false)?;
                println!("| {} {}", path.rsplit('/').next().unwrap_or(path), played);
                Ok(())
            })
        }
    }
}

/// Every frame of a file once, in their order. What there is to say of the whole, as the rest of a table's row.
fn play(path: &str, tell: bool) -> Result<String, Box<dyn std::error::Error>> {
    let start = Instant::now();
    // Front, rows and names. What a frame shows is hashed when it is opened; `Quick` leaves that out.
    let sequence = Sequence::open_with(path, &OpenOptions { validation: Validation::Quick, ..OpenOptions::default() })?;
    let opened = start.elapsed().as_secs_f64() * 1e3;
    if tell {
        println!("{path}: {} frames, opened in {opened:.3} ms", sequence.frame_count());
    }

    // From outside the box of all frames to its middle.
    let Aabb { min, max } = sequence.header().scene_bounds();
    let middle = [0, 1, 2].map(|a| (min[a] + max[a]) / 2.0);
    let ray = Ray::new([middle[0], middle[1], 2.0 * max[2] - min[2] + 1.0], [0.0, 0.0, -1.0]);
    let (mut times, mut shown) = (Vec::new(), 0);
    for index in 0..sequence.frame_count() {
        let start = Instant::now();
        let frame = sequence.frame(index)?;
        let took = start.elapsed().as_secs_f64() * 1e3;
        times.push(took);
        let hit = closest_hit(&frame.view(), &ray)?;
        let seen = hit.map_or("nothing".to_string(), |hit| {
            let part = sequence.name_of(&frame, &hit);
            format!("triangle {} of '{}' at {}", hit.prim, part.escape_debug(), hit.t)
        });
        let triangles = frame.view().triangles.len();
        shown += triangles;
        if tell {
            println!("frame {:>5}  {took:>7.3} ms  {triangles} triangles  {seen}", frame.record().number);
        }
    }
    times.sort_by(f64::total_cmp);
    let (middle, most, frames) = (times[times.len() / 2], times[times.len() - 1], times.len());
    if tell {
        println!("a frame opens in {middle:.3} ms (median), {most:.3} ms at most");
    }
    let positions = sequence.sections().iter().filter(|section| section.kind == SectionKind::VPOS);
    let positions: u64 = positions.map(|section| section.stored_len).sum();
    let (bytes, shown) = (sequence.header().file_len, shown as f64);
    let each = |bytes: u64| bytes as f64 / shown;
    Ok(format!(
        "| {frames} | {:.0} | {bytes} | {:.2} | {:.2} | {middle:.3} ms | {most:.3} ms |",
        shown / frames as f64,
        each(bytes),
        each(positions)
    ))
}
