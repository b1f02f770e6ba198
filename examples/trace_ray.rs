//! Open a cache and trace rays: `cargo run --release --example trace_ray -- FILE.bvhc [FRAME] < RAYS`
//!
//! FRAME is the number of the frame of a file of many frames.
//!
//! Each input line is a ray, `ox,oy,oz,dx,dy,dz`; each output line is the closest hit as JSON, or `null`. The reference reader in
//! `format-spec/reference` answers in the same form, and `format-spec/test.sh` compares the two.

use bvhc::cache::{Cache, OpenOptions, Sequence, Validation, View};
use bvhc::geom::Ray;
use bvhc::trace::closest_hit;
use std::error::Error;
use std::io::{BufRead, Write};

fn main() -> Result<(), Box<dyn Error>> {
    let usage = "usage: trace_ray FILE.bvhc [FRAME] < RAYS, each line ox,oy,oz,dx,dy,dz";
    let path = std::env::args_os().nth(1).ok_or(usage)?;
    let options = OpenOptions { validation: Validation::Tree, ..OpenOptions::default() };
    let Some(number) = std::env::args().nth(2) else {
        return trace(&Cache::open_with(&path, &options)?.view());
    };
    let sequence = Sequence::open_with(&path, &options)?;
    let index = sequence.numbered(number.parse()?).ok_or("there is no such frame")?;
    trace(&sequence.frame(index)?.view())
}

fn trace(view: &View<'_>) -> Result<(), Box<dyn Error>> {
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    for line in std::io::stdin().lock().lines() {
        let hit = closest_hit(view, &parse(&line?)?)?;
        let answer = hit.map(|h| {
            serde_json::json!({ "t": h.t, "u": h.u, "v": h.v, "instance": h.instance, "geom": h.geom, "prim": h.prim })
        });
        writeln!(out, "{}", serde_json::to_string(&answer)?)?;
    }
    Ok(())
}

fn parse(line: &str) -> Result<Ray, Box<dyn Error>> {
    let numbers = line.split(',').map(|n| n.trim().parse::<f32>()).collect::<Result<Vec<_>, _>>()?;
    let [ox, oy, oz, dx, dy, dz] = numbers[..] else {
        return Err(format!("a ray is six numbers, ox,oy,oz,dx,dy,dz, but the line is `{line}`").into());
    };
    Ok(Ray::new([ox, oy, oz], [dx, dy, dz]))
}
