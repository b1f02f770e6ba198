//! No ray shot from inside of a closed mesh at its edges and vertices gets out.

mod common;

use bvhc::build::{BuildOptions, Executor, Method, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::compile::compile;
use bvhc::scene::{Mesh, ReadOptions, read};
use bvhc::verify::Cpu;
use bvhc::verify::watertight::{close, escapes, eyes_inside, open_edges};
use common::meshes::{cube, scene_of, sphere};

/// The mesh, closed, built by both methods, and shot at on the CPU.
fn assert_tight(name: &str, mesh: &Mesh, rays: u64) {
    assert!(open_edges(mesh).is_empty(), "{name} is not closed");
    let exec = Executor::new(0).expect("threads");
    let eyes = eyes_inside(mesh, 16, 1, &exec);
    assert!(!eyes.is_empty(), "{name} has no inside");
    for (method, label, share) in [(Method::Binned, "binned", rays / 4), (Method::Sbvh, "sbvh", rays - rays / 4)] {
        let options = BuildOptions { method, ..BuildOptions::preset(Preset::Best) };
        let image =
            Image::new(&compile(scene_of(mesh.clone()), &options, &exec, &NoProgress).expect("a tree"), &exec).unwrap();
        let found = escapes(&mut Cpu::new(image.view(), &exec), mesh, &eyes, share, 1, &exec).expect("a walk");
        println!("{name}, {label}: {} rays at edges and vertices, {} escaped", found.rays, found.escaped);
        assert_eq!((found.rays, found.escaped), (share, 0), "{name}, {label}: {:?}", found.first);
    }
}

fn made() -> Vec<(&'static str, Mesh)> {
    let far = [1.0e5, -3.0e5, 7.0e4];
    vec![
        ("cube", cube(16, |p| p.map(|v| v as f32))),
        ("cube off the grid", cube(15, |p| p.map(|v| (0.7 * v + 0.1) as f32))),
        ("sphere", sphere(24, 1.0, [0.0; 3])),
        ("far sphere", sphere(10, 4.0, far)),
    ]
}

#[test]
fn no_ray_escapes() {
    for (name, mesh) in made() {
        assert_tight(name, &mesh, 100_000);
    }
}

#[test]
#[ignore = "long: ten million rays in each closed mesh, real ones among them"]
fn long_no_ray_of_ten_millions_escapes() {
    for (name, mesh) in made().into_iter().filter(|(name, _)| matches!(*name, "cube" | "sphere")) {
        assert_tight(name, &mesh, 10_000_000);
    }
    let Some(models) = common::models_dir() else { return };

    // The bunny stands on holes, which are capped first; the dragon is closed.
    let load = |file: &str| read(&models.join(file), &ReadOptions::default()).expect("a scene").meshes.swap_remove(0);
    let mut bunny = load("stanford_bunny/stanford_bunny.obj");
    println!("bunny: {} open edges, capped", open_edges(&bunny).len());
    close(&mut bunny);
    assert_tight("bunny", &bunny, 10_000_000);
    assert_tight("dragon", &load("stanford_dragon/dragon_11k.obj"), 10_000_000);
}
