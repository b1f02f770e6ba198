//! Ten million rays over the real scenes, on the CPU and on OpenCL: not one hit is missed, and none is wrong.

mod common;

use bvhc::build::{BuildOptions, Executor, Levels, Method, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::compile::compile;
use bvhc::scene::{ReadOptions, Scene, read};
use bvhc::verify::{Cpu, OracleOutcome, Outcome, Plan, Subject, run};
use common::devices::others;
use common::scenes::real_scenes;

const RAYS: u64 = 10_000_000;

/// As `bvhc verify` does it for a fresh build, with so many rays of the ten million's total.
fn verify(scene: &Scene, method: Method, rays: u64) -> Outcome {
    let levels = if scene.instances.len() > 1 { Levels::Two } else { Levels::One };
    let options = BuildOptions { method, levels, ..BuildOptions::preset(Preset::Best) };
    let exec = Executor::new(0).expect("threads");
    let image =
        Image::new(&compile(scene.clone(), &options, &exec, &NoProgress).expect("a tree"), &Executor::current())
            .unwrap();
    let subject = Subject::new(image.view(), scene, &exec);
    let plan = Plan { rays, oracle_work: Plan::ORACLE_WORK / 10, ..Plan::default() };
    run(&subject, &mut Cpu::new(image.view(), &exec), &mut others(image.view()), &plan, &NoProgress).expect("a verdict")
}

#[test]
#[ignore = "long: ten million rays on each device"]
fn long_ten_million_rays_are_right() {
    let Some(files) = real_scenes() else { return };
    let share = RAYS.div_ceil(files.len() as u64);
    let (mut rays, mut sum) = (Vec::new(), OracleOutcome::default());
    for (number, (name, file)) in files.iter().enumerate() {
        let mut scene = read(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let meshes = &scene.meshes;
        scene.instances.retain(|i| !meshes[i.mesh as usize].triangles.is_empty());
        let (method, label) = [(Method::Sbvh, "sbvh"), (Method::Bonsai, "bonsai")][number % 2];
        let outcome = verify(&scene, method, share);
        assert!(outcome.is_right(), "{name}, {label}: {:#?}", outcome.first_mismatch());
        rays.resize(outcome.devices.len(), (0, 0));
        let mut cells = Vec::new();
        for (device, (rays, ties)) in outcome.devices.iter().zip(&mut rays) {
            let total = device.total();
            (*rays, *ties) = (*rays + total.rays, *ties + total.ties);
            cells.push(format!("{} {:.2} M/s", device.name, total.rays as f64 / total.seconds / 1e6));
        }
        let oracle = outcome.oracle;
        println!(
            "{name:<48} {label:<6} {:>9} triangles  {}  {} hits tested, {} rays by brute force, {} ties",
            oracle.instanced_triangles,
            cells.join("  "),
            oracle.hits_tested,
            oracle.rays,
            oracle.ties
        );
        sum.hits_tested += oracle.hits_tested;
        sum.rays += oracle.rays;
        sum.ties += oracle.ties;
    }
    println!(
        "{} rays on each of {} devices: 0 missed, 0 farther, 0 false; {} hits tested, {} rays by brute force, {} ties",
        rays[0].0,
        rays.len(),
        sum.hits_tested,
        sum.rays,
        sum.ties
    );
    assert!(std::env::var_os("BVHC_ONLY").is_some() || rays.iter().all(|(rays, _)| *rays >= RAYS), "{rays:?}");
}
