//! Who asks for one thread gets one: nothing in the library starts threads of its own or uses a pool that it was not given.
//!
//! A file of its own with one test, because the threads of other tests would be counted too.

#![cfg(target_os = "linux")]

mod common;

use bvhc::Build;
use bvhc::build::{BuildOptions, Levels, METHODS, Method, Preset, Progress};
use bvhc::cache::check::{Level, Limits, check_bytes};
use bvhc::cache::{
    Cache, Codec, ConvertOptions, Image, Meta, OpenOptions, WriteOptions, convert, hash_file, write_file,
};
use bvhc::compile::compile;
use bvhc::exec::Executor;
use bvhc::geom::Affine;
use bvhc::scene::{self, Instance, Mesh, ReadOptions, Scene};
use bvhc::verify::accuracy::{Measure, measure};
use bvhc::verify::watertight::{escapes, eyes_inside};
use bvhc::verify::{Cpu, Plan, Subject, run};
use common::meshes::{scene_of, sphere};
use std::fmt::Write;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Threads of this process.
fn threads() -> usize {
    std::fs::read_dir("/proc/self/task").expect("Linux lists a process's threads").count()
}

/// Looks how many threads there are whenever it is told of progress: a pool that is gone in the end is seen too.
#[derive(Default)]
struct Watch(AtomicUsize);

impl Watch {
    fn look(&self) {
        self.0.fetch_max(threads(), Ordering::Relaxed);
    }

    /// Fail if some step started a thread.
    fn none_since(&self, before: usize, step: &str) {
        self.look();
        assert_eq!(self.0.load(Ordering::Relaxed), before, "{step} started threads");
    }
}

impl Progress for Watch {
    fn phase(&self, _name: &'static str) {
        self.look();
    }

    fn advance(&self, _primitives: u64) {
        self.look();
    }
}

/// One small mesh at so many places that the top level is clustered in groups.
fn many_instances(mesh: Mesh) -> Scene {
    let at = |i: u32| Affine {
        rows: [
            [1.0, 0.0, 0.0, 3.0 * f64::from(i % 80)],
            [0.0, 1.0, 0.0, 3.0 * f64::from(i / 80)],
            [0.0, 0.0, 1.0, 0.0],
        ],
    };
    let instances = (0..5000).map(|i| Instance { mesh: 0, transform: at(i), node: i, name: String::new() });
    Scene { instances: instances.collect(), ..scene_of(mesh) }
}

/// As text, more bytes than are hashed on one thread where several may be had.
fn write_obj(mesh: &Mesh, path: &std::path::Path) {
    let mut text = String::new();
    for [x, y, z] in &mesh.positions {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|v| v + 1)) {
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    assert!(text.len() > 2 * Executor::HASH_IN_PARALLEL_FROM);
    std::fs::write(path, text).unwrap();
}

#[test]
fn a_sequential_executor_starts_no_thread() {
    let (exec, watch, folder) = (Executor::sequential(), Watch::default(), tempfile::tempdir().unwrap());
    let before = threads();
    let path = |name: &str| folder.path().join(name);
    write_obj(&sphere(40, 1.0, [0.0; 3]), &path("sphere.obj"));
    let scene = scene::read(&path("sphere.obj"), &ReadOptions::default()).expect("a scene");
    watch.none_since(before, "reading");

    // Every method with every pass, and a top level over thousands of instances.
    let small = many_instances(sphere(2, 1.0, [0.0; 3]));
    for row in METHODS {
        let options =
            BuildOptions { method: row.method, reinsert: 2, adapt: 100, collapse: true, ..Default::default() };
        compile(scene.clone(), &options, &exec, &watch).expect("a tree");
        watch.none_since(before, row.name);
    }
    let options = BuildOptions { method: Method::Sbvh, levels: Levels::Two, ..BuildOptions::preset(Preset::Draft) };
    let two = compile(small.clone(), &options, &exec, &watch).expect("trees");
    let flat = compile(small.clone(), &BuildOptions { levels: Levels::One, ..options.clone() }, &exec, &watch);
    assert!(two.tlas.is_some() && flat.expect("a tree").tlas.is_none());
    watch.none_since(before, "a top level");

    let one = compile(scene.clone(), &options, &exec, &watch).expect("a tree");
    for (accel, scene) in [(&one, &scene), (&two, &small)] {
        let image = Image::new(accel, &exec).expect("an image");
        watch.none_since(before, "laying out");
        let packed = WriteOptions { codec: Codec::Zstd { level: 1 }, ..WriteOptions::default() };
        write_file(&path("packed.bvhc"), &image, &Meta::default(), &packed, &exec).expect("a file");
        let (from, to) = (path("packed.bvhc"), path("raw.bvhc"));
        convert(&from, &to, &OpenOptions::default(), &ConvertOptions::default(), &exec).expect("a file");
        hash_file(&to, &exec).expect("a hash");
        watch.none_since(before, "writing");

        let bytes = std::fs::read(&from).unwrap();
        assert!(check_bytes(&bytes, Level::Tree, None, &Limits::default(), &exec).is_valid());
        watch.none_since(before, "checking");
        for cache in [
            Cache::from_slice_on(&bytes, &OpenOptions::default(), &exec),
            Cache::from_bytes_on(&bytes, &OpenOptions::default(), &exec),
        ] {
            assert!(cache.expect("a sound file").check(&Limits::default(), &exec).is_valid());
        }
        watch.none_since(before, "opening bytes");

        let cache = Cache::open_on(&from, &OpenOptions::default(), &exec).expect("a sound file");
        let subject = Subject::new(cache.view(), scene, &exec);
        let plan = Plan { rays: 3000, oracle_work: 1 << 20, ..Plan::default() };
        let outcome = run(&subject, &mut Cpu::new(cache.view(), &exec), &mut [], &plan, &watch).expect("a verdict");
        assert!(outcome.is_right());
        let few = Measure { rays: 500, timed: 64, rounds: 1, ..Measure::default() };
        measure(&cache.view(), &subject.oracle, &subject.sampler, &few, &exec, &watch).expect("a report");
        watch.none_since(before, "verifying");
    }

    let (mesh, image) = (&scene.meshes[0], Image::new(&one, &exec).expect("an image"));
    let eyes = eyes_inside(mesh, 2, 1, &exec);
    escapes(&mut Cpu::new(image.view(), &exec), mesh, &eyes, 1000, 1, &exec).expect("a walk");
    watch.none_since(before, "shooting at edges");

    let built = Build::of_scene(small).expect("a scene").threads(1).run().expect("a build");
    built.write(path("built.bvhc")).expect("a file");
    watch.none_since(before, "a build by the way in for programs");
}
