//! OpenCL devices give the bits of the library's own traversal. Every test says so and passes where there is no device.
#![cfg(feature = "opencl")]

mod common;

use bvhc::build::{BuildOptions, Executor, Levels, Method, NoProgress, Preset, compile};
use bvhc::cache::Image;
use bvhc::geom::Ray;
use bvhc::scene::{ReadOptions, Scene, read};
use bvhc::trace::rays::{RaySet, Sampler};
use bvhc::verify::opencl::{Context, OpenCl, Options, list_devices, preferred};
use bvhc::verify::{Cpu, Device, DeviceError, HitRecord, Query};
use std::path::{Path, PathBuf};

/// The device that a user would get, or `None` with a line that says so.
fn context(options: Options) -> Option<Context> {
    match list_devices() {
        Ok(devices) => {
            let info = preferred(&devices).expect("a usable device");
            Some(Context::open(info.index, options).expect("it opens"))
        }
        Err(error @ (DeviceError::NoLibrary { .. } | DeviceError::NoDevice { .. })) => {
            println!("skipped: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

fn build(scene: &Scene, method: Method, levels: Levels) -> Image {
    let options = BuildOptions { method, levels, ..BuildOptions::preset(Preset::Best) };
    Image::new(&compile(scene.clone(), &options, &Executor::new(0).expect("threads"), &NoProgress).expect("a tree"))
}

/// Rays of every set.
fn all_rays(scene: &Scene, count: usize) -> Vec<Ray> {
    let sampler = Sampler::new(scene);
    RaySet::ALL.iter().flat_map(|&set| sampler.rays(set, count.div_ceil(RaySet::ALL.len()), 7)).collect()
}

/// All bits of all answers, to both questions.
fn assert_same(name: &str, context: &Context, image: &Image, rays: &[Ray]) {
    let (mut cpu, mut opencl) =
        (Cpu::new(image.view()), OpenCl::new(context, image.view()).unwrap_or_else(|e| panic!("{name}: {e}")));
    for query in [Query::Closest, Query::Any] {
        let want = cpu.trace(rays, query).expect("a tree");
        let got = opencl.trace(rays, query).unwrap_or_else(|e| panic!("{name}: {e}"));
        let hits = want.iter().filter(|r| r.is_hit()).count();
        for (i, (want, got)) in want.iter().zip(&got).enumerate() {
            assert_eq!(got, want, "{name}, {query:?}, ray {i}: {:?}", rays[i]);
        }
        println!("{name}, {query:?}: {} rays, {hits} hits, all bits equal", rays.len());
    }
}

fn sample(name: &str) -> Scene {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples").join(name);
    read(&path, &ReadOptions::default()).expect("a scene")
}

#[test]
fn samples_give_the_cpus_bits() {
    let Some(context) = context(Options::default()) else { return };
    assert_eq!(HitRecord::MISS.status, 0);
    for (file, levels) in [
        ("pillar.obj", Levels::One),
        ("colonnade.obj", Levels::One),
        ("forest.gltf", Levels::Two),
        ("forest.gltf", Levels::One),
    ] {
        let scene = sample(file);
        let rays = all_rays(&scene, 20_000);
        for method in [Method::Binned, Method::Sbvh] {
            let image = build(&scene, method, levels);
            assert_same(&format!("{file}, {method:?}, {levels:?}"), &context, &image, &rays);
        }
    }
}
