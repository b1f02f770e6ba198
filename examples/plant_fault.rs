//! Break a sound cache file on purpose, to see `bvhc verify` find it: `cargo run --example plant_fault -- FAULT IN.bvhc OUT.bvhc`
//!
//! The hashes of the new file agree with its content, so `bvhc info` and every reader take it for sound.

#[path = "../tests/common/faults.rs"]
mod faults;

use bvhc::cache::{Cache, Image, Meta, WriteOptions, write_file};
use bvhc::exec::Executor;
use faults::{Fault, plant};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let names: Vec<&str> = Fault::ALL.iter().map(|(name, _)| *name).collect();
    let usage = format!("usage: plant_fault {} IN.bvhc OUT.bvhc", names.join("|"));
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [name, from, to] = &args[..] else { return Err(usage.into()) };
    let (_, fault) = Fault::ALL.into_iter().find(|(n, _)| n == name).ok_or(usage)?;

    let cache = Cache::open(from)?;
    let mut image = Image {
        nodes: cache.nodes().to_vec(),
        triangles: cache.triangles().to_vec(),
        geoms: cache.geoms().to_vec(),
        blases: cache.blases().to_vec(),
        tlas_nodes: cache.tlas_nodes().to_vec(),
        instances: cache.instances().to_vec(),
        names: (0..cache.geoms().len()).map(|i| cache.names().get(i).unwrap_or_default().to_string()).collect(),
        flags: cache.header().tree_flags,
        ..Image::default()
    };
    let planted = plant(&mut image, fault).ok_or("this file has nothing that can be broken so")?;
    let meta = cache.meta().cloned().unwrap_or_else(Meta::default);
    let unchecked = WriteOptions { check: false, ..WriteOptions::default() };
    write_file(Path::new(to), &image, &meta, &unchecked, &Executor::current())?;
    println!("{to}: broke {} {:?}", planted.section, planted.records);
    Ok(())
}
