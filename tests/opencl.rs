//! OpenCL devices give the bits of the library's own traversal. Where there is no device, these tests say so and pass.
#![cfg(feature = "opencl")]

mod common;

use bvhc::build::{BuildOptions, Executor, Levels, Method, NoProgress, Preset};
use bvhc::cache::{Image, OpenOptions, Sequence};
use bvhc::compile::compile;
use bvhc::geom::{Aabb, Affine, Ray};
use bvhc::random::Random;
use bvhc::scene::{Instance, Mesh, Part, ReadOptions, Scene, read};
use bvhc::trace::rays::Sampler;
use bvhc::verify::opencl::{Context, Fault, OpenCl, Options, list_devices};
use bvhc::verify::{Cpu, Device, DeviceError, HitRecord, Query};
use common::devices::opencl;
use common::scenes::{real_scenes, sample};
use common::vectors::sequences;
use std::path::Path;
use std::process::Command;

/// The threads of the machine.
static EXEC: Executor = Executor::current();

fn native() -> Option<&'static Context> {
    opencl(Options::default())
}

fn soft() -> Option<&'static Context> {
    opencl(Options { soft_f64: true, ..Options::default() })
}

fn build(scene: &Scene, method: Method, levels: Levels) -> Image {
    let options = BuildOptions { method, levels, ..BuildOptions::preset(Preset::Best) };
    Image::new(&compile(scene.clone(), &options, &EXEC, &NoProgress).expect("a tree"), &EXEC).unwrap()
}

/// Rays of every set.
fn all_rays(scene: &Scene, count: usize) -> Vec<Ray> {
    Sampler::new(scene).mixed(count as u64, 7)
}

/// Records with every bit equal, the first difference told with its ray. A device whose arithmetic deviates says so and
/// is let off.
fn assert_equal(name: &str, device: &dyn Device, rays: &[Ray], got: &[HitRecord], want: &[HitRecord]) {
    assert_eq!(got.len(), want.len());
    if let Some(deviation) = device.deviation() {
        println!("{name}: not compared bit for bit: {deviation}");
        return;
    }
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        assert_eq!(got, want, "{name}, ray {i}: {:?}", rays[i]);
    }
}

/// All bits of all answers, to both questions.
fn assert_same(name: &str, opencl: &mut OpenCl<'_>, image: &Image, rays: &[Ray]) {
    let mut cpu = Cpu::new(image.view(), &EXEC);
    for query in [Query::Closest, Query::Any] {
        let want = cpu.trace(rays, query).expect("a tree");
        let got = opencl.trace(rays, query).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_equal(name, opencl, rays, &got, &want);
        let hits = want.iter().filter(|r| r.is_hit()).count();
        println!("{name}, {query:?}, {}: {} rays, {hits} hits, all bits equal", opencl.name(), rays.len());
    }
}

#[test]
fn the_device_computes_as_ieee_754_says() {
    for context in [native(), soft()].into_iter().flatten() {
        let image = build(&sample("pillar.obj"), Method::Binned, Levels::One);
        let opencl = OpenCl::new(context, image.view()).expect("memory");
        println!("{}: {}", opencl.name(), opencl.description());
        if context.info().name.contains("pthread") {
            assert_eq!(opencl.deviation(), None);
        }
    }
}

#[test]
fn samples_give_the_cpus_bits() {
    let contexts = [native(), soft()];
    for (file, levels) in [
        ("pillar.obj", Levels::One),
        ("colonnade.obj", Levels::One),
        ("forest.gltf", Levels::Two),
        ("forest.gltf", Levels::One),
    ] {
        let scene = sample(file);
        let rays = all_rays(&scene, 10_000);
        for method in [Method::Binned, Method::Sbvh] {
            let image = build(&scene, method, levels);
            for context in contexts.iter().flatten() {
                let mut opencl = OpenCl::new(context, image.view()).expect("memory");
                assert_same(&format!("{file}, {method:?}, {levels:?}"), &mut opencl, &image, &rays);
            }
        }
    }
}

/// Without `triangle`: of a triangle that stands in several slots, brute force names the first, traversal the first
/// that it met.
fn without_slot(records: &[HitRecord]) -> Vec<HitRecord> {
    records.iter().map(|r| HitRecord { triangle: if r.is_hit() { 0 } else { r.triangle }, ..*r }).collect()
}

/// Frames are handed out as still files are: raw and as differences, one pose and several, refitted and built anew, with moved instances.
#[test]
fn frames_of_sequences_give_the_cpus_bits() {
    let contexts = [native(), soft()];
    let files = [
        ("refitted", sequences::refitted().file()),
        ("rebuilt", sequences::rebuilt().file()),
        ("empty frame", sequences::empty_frame().file()),
        ("zstd", sequences::large().packed()),
        ("differences", sequences::walk().differences()),
    ];
    let (mut frames, mut hits) = (0, 0);
    for (name, file) in &files {
        let sequence = Sequence::from_slice(file, &OpenOptions::default()).unwrap();
        let bounds = sequence.header().scene_bounds();
        for index in 0..sequence.frame_count() {
            let frame = sequence.frame(index).unwrap();
            let rays = rays_across(&bounds, 500, index as u64);
            let mut cpu = Cpu::new(frame.view(), &EXEC);
            let want = cpu.trace(&rays, Query::Closest).expect("a tree");
            hits += want.iter().filter(|record| record.is_hit()).count();
            for context in contexts.iter().flatten() {
                let mut device = OpenCl::new(context, frame.view()).expect("memory");
                for query in [Query::Closest, Query::Any] {
                    let (want, got) = (cpu.trace(&rays, query).unwrap(), device.trace(&rays, query).unwrap());
                    assert_equal(&format!("{name}, frame {index}, {query:?}"), &device, &rays, &got, &want);
                }
            }
            frames += 1;
        }
    }
    assert!(frames == 17 && hits > 1000, "{frames} frames, {hits} hits");
}

/// From around a box to points in it.
fn rays_across(bounds: &Aabb, count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed);
    let middle = [0, 1, 2].map(|a| (bounds.min[a] + bounds.max[a]) / 2.0);
    let far = 1.0 + (0..3).map(|a| bounds.max[a] - bounds.min[a]).fold(0.0, f32::max);
    let ray = |_| {
        let (away, within) = (random.direction(), [0; 3].map(|_| random.unit() as f32));
        let origin = [0, 1, 2].map(|a| middle[a] + far * away[a] as f32);
        let aim = [0, 1, 2].map(|a| bounds.min[a] + within[a] * (bounds.max[a] - bounds.min[a]));
        Ray::new(origin, [0, 1, 2].map(|a| aim[a] - origin[a]))
    };
    (0..count).map(ray).collect()
}

#[test]
fn brute_force_agrees_with_the_tree() {
    let Some(context) = native() else { return };
    for (file, levels, count) in [("pillar.obj", Levels::One, 3000), ("forest.gltf", Levels::Two, 140)] {
        let scene = sample(file);
        let rays = all_rays(&scene, count);
        for method in [Method::Binned, Method::Sbvh] {
            let image = build(&scene, method, levels);
            let mut opencl = OpenCl::new(context, image.view()).expect("memory");
            let brute = without_slot(&opencl.brute_force(&rays).expect("hits"));
            let want = without_slot(&Cpu::new(image.view(), &EXEC).trace(&rays, Query::Closest).expect("a tree"));
            assert_equal(file, &opencl, &rays, &brute, &want);
            assert!(brute.iter().filter(|r| r.is_hit()).count() > rays.len() / 4);
        }
    }
}

/// A scene and rays whose coordinates are all small integers or halves: products and sums are exact, so every device
/// must agree.
fn grid_scene(seed: u64) -> (Scene, Vec<Ray>) {
    let mut random = Random::new(seed);
    let mut integer = |reach: u64| random.below(2 * reach + 1) as f32 - reach as f32;
    let mut meshes = Vec::new();
    for _ in 0..1 + seed % 3 {
        let count = 1 + (integer(12).abs() as u32 + integer(6).abs() as u32);
        let positions: Vec<[f32; 3]> = (0..3 * count).map(|_| [0; 3].map(|_| integer(4))).collect();
        let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let part = Part { triangle_count: count, prim_count: count, ..Part::default() };
        meshes.push(Mesh { positions, triangles, parts: vec![part], ..Mesh::default() });
    }
    let instance = |mesh: usize, integer: &mut dyn FnMut(u64) -> f32| {
        let turn = (integer(1) + 1.0) as usize;
        let mut rows = [[0.0; 4]; 3];
        for (axis, row) in rows.iter_mut().enumerate() {
            row[(axis + turn) % 3] = if integer(1) < 0.0 { -1.0 } else { 1.0 };
            row[3] = f64::from(integer(3));
        }
        Instance { mesh: mesh as u32, transform: Affine { rows }, node: 0, name: String::new() }
    };
    let mut instances: Vec<Instance> = (0..meshes.len()).map(|mesh| instance(mesh, &mut integer)).collect();
    if seed.is_multiple_of(2) {
        instances.push(instance(0, &mut integer));
    }
    let mut ray = || {
        let origin = [0; 3].map(|_| integer(16) / 2.0);
        let direction = [0, 1, 2].map(|axis| integer(3) - origin[axis]);
        let direction = if direction == [0.0; 3] { [0.0, -0.0, 1.0] } else { direction };
        Ray::new(origin, direction)
    };
    let rays = (0..64).map(|_| ray()).collect();
    (Scene { meshes, instances, ..Scene::default() }, rays)
}

#[test]
fn on_a_grid_cpu_tree_and_brute_force_agree_on_every_bit() {
    let contexts = [native(), soft()];
    if contexts.iter().all(Option::is_none) {
        return;
    }
    let (mut rays_in_all, mut hits_in_all) = (0, 0);
    for seed in 0..1000 {
        let (scene, rays) = grid_scene(seed);
        let method = if seed % 3 == 0 { Method::Sbvh } else { Method::Binned };
        let levels = if seed % 4 == 0 { Levels::One } else { Levels::Two };
        let image = build(&scene, method, levels);
        let want = Cpu::new(image.view(), &EXEC).trace(&rays, Query::Closest).expect("a tree");

        // The soft twin on every tenth scene.
        for context in contexts.iter().take(if seed % 10 == 0 { 2 } else { 1 }).flatten() {
            let mut opencl = OpenCl::new(context, image.view()).expect("memory");
            let got = opencl.trace(&rays, Query::Closest).expect("a tree");
            let name = format!("grid scene {seed}");
            assert_equal(&name, &opencl, &rays, &got, &want);
            let brute = without_slot(&opencl.brute_force(&rays).expect("hits"));
            assert_equal(&name, &opencl, &rays, &brute, &without_slot(&want));
        }
        rays_in_all += rays.len();
        hits_in_all += want.iter().filter(|r| r.is_hit()).count();
    }
    println!(
        "1000 grid scenes, {rays_in_all} rays, {hits_in_all} hits: CPU, OpenCL and brute force agree on every bit"
    );
    assert!(hits_in_all > rays_in_all / 4);
}

#[test]
fn sections_larger_than_a_buffer_are_cut_and_what_cannot_fit_is_refused() {
    let scene = sample("colonnade.obj");
    let image = build(&scene, Method::Sbvh, Levels::One);
    let rays = all_rays(&scene, 2000);
    let view = image.view();
    let largest = size_of_val(view.nodes).max(size_of_val(view.triangles)) as u64;
    for copy in [false, true] {
        let Some(context) = opencl(Options { max_allocation: Some(largest / 4), copy, ..Options::default() }) else {
            return;
        };
        let mut opencl = OpenCl::new(context, view).expect("it is cut");
        assert_same("cut", &mut opencl, &image, &rays);
        let brute = without_slot(&opencl.brute_force(&rays).expect("hits"));
        let want = without_slot(&Cpu::new(view, &EXEC).trace(&rays, Query::Closest).expect("a tree"));
        assert_equal("cut", &opencl, &rays, &brute, &want);
        assert_eq!(opencl.copied_bytes() > 0, copy || !context.info().unified_memory);
    }
    let Some(context) = opencl(Options { max_allocation: Some(largest / 64), ..Options::default() }) else { return };
    match OpenCl::new(context, view) {
        Err(DeviceError::OutOfMemory { needed, available, .. }) => assert!(needed > available),
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("it fits"),
    }
}

#[test]
fn mistakes_in_the_kernel_show() {
    let scene = sample("colonnade.obj");
    let image = build(&scene, Method::Binned, Levels::One);
    let rays = all_rays(&scene, 2000);
    let want = Cpu::new(image.view(), &EXEC).trace(&rays, Query::Closest).expect("a tree");
    for fault in [Fault::DroppedChild, Fault::WrongOctant] {
        let options = Options { fault: Some(fault), believed: true, ..Options::default() };
        let Some(context) = opencl(options) else { return };
        let got = OpenCl::new(context, image.view()).expect("memory").trace(&rays, Query::Closest).expect("a tree");
        let wrong = got.iter().zip(&want).filter(|(a, b)| a != b).count();
        assert!(wrong > rays.len() / 100, "{fault:?}: {wrong}");
    }
}

#[test]
fn a_device_that_computes_a_known_scene_wrongly_is_not_believed() {
    let Some(device) = native().map(|context| context.info().index) else { return };
    for fault in [Fault::DroppedChild, Fault::WrongOctant] {
        match Context::open(device, Options { fault: Some(fault), ..Options::default() }) {
            Err(error @ DeviceError::SelfTest { .. }) => {
                let text = error.to_string();
                println!("{text}");
                assert!(text.contains("are not the CPU's") && text.contains("the ray from ["), "{text}");
            }
            Err(error) => panic!("{fault:?}: {error}"),
            Ok(_) => panic!("{fault:?}: it is believed"),
        }
    }
}

#[test]
fn a_device_that_is_not_there_is_refused_with_the_list() {
    let Ok(devices) = list_devices() else { return };
    match Context::open(devices.len(), Options::default()) {
        Err(error @ DeviceError::NoSuchDevice { .. }) => {
            let text = error.to_string();
            assert!(
                text.contains(&format!("there are {}", devices.len())) && text.contains(&devices[0].name),
                "{text}"
            );
        }
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("it opened"),
    }
}

/// Run this program's test `child_says_what_is_missing` with a variable set.
fn child(variable: &str, value: &Path) -> String {
    let output = Command::new(std::env::current_exe().expect("a path"))
        .args(["--exact", "child_says_what_is_missing", "--ignored", "--nocapture"])
        .env(variable, value)
        .output()
        .expect("it runs");
    assert!(output.status.success(), "{output:?}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
#[ignore = "run by the next test in a process of its own"]
fn child_says_what_is_missing() {
    match list_devices() {
        Ok(devices) => println!("devices: {}", devices.len()),
        Err(error) => println!("error: {error}"),
    }
}

#[test]
#[cfg(target_os = "linux")]
fn without_a_library_or_a_driver_there_is_an_error_and_no_crash() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("libOpenCL.so.1"), "no library").expect("a file");
    let text = child("LD_LIBRARY_PATH", folder.path());
    assert!(text.contains("no OpenCL library could be loaded") && text.contains("libOpenCL.so.1"), "{text}");

    // Loaders differ in how their drivers are found; Debian's reads this variable.
    let text = child("OCL_ICD_VENDORS", Path::new("/nonexistent"));
    if list_devices().is_ok() {
        assert!(text.contains("there is no device") || text.contains("devices:"), "{text}");
    }
}

/// The driver is loaded at run time: the program names no OpenCL library that it would need to start.
#[test]
#[cfg(all(target_os = "linux", feature = "cli"))]
fn the_program_does_not_link_opencl() {
    let Ok(output) = Command::new("ldd").arg(env!("CARGO_BIN_EXE_bvhc")).output() else {
        println!("skipped: no ldd");
        return;
    };
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("libc.so") && !text.contains("OpenCL"), "{text}");
}

#[test]
#[ignore = "long: f64 in integers on real scenes"]
fn long_real_scenes_give_the_cpus_bits_without_double() {
    let (Some(files), Some(soft)) = (real_scenes(), soft()) else { return };
    for (name, file) in files.iter().filter(|(name, _)| name.contains("kitchen") || name.contains("cafe")) {
        let scene = read(file, &ReadOptions::default()).expect("a scene");
        let levels = if scene.instances.len() > 1 { Levels::Two } else { Levels::One };
        let image = build(&scene, Method::Binned, levels);
        let mut device = OpenCl::new(soft, image.view()).expect("memory");
        assert_same(name, &mut device, &image, &all_rays(&scene, 35_000));
    }
}
