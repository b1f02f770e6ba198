//! The searches `auto` and `best`: the same bytes for any number of threads, sound trees of every kind of scene, and never far from the
//! best recipe.

mod common;

use bvhc::build::{BuildOptions, Executor, Method, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::cache::check::{Limits, check_image};
use bvhc::compile::{compile, decide_tree, lay_out};
use bvhc::geom::Affine;
use bvhc::scene::{Mesh, ReadOptions, read};
use bvhc::search::Choice;
use bvhc::trace::probe::{Family, FamilyCost, FamilyRays};
use bvhc::tree::quality::sah;
use bvhc::tree::{MAX_DEPTH, Tree};
use common::meshes::{place, scene_of, sphere};
use common::scenes::sample;

const SEARCHES: [Preset; 2] = [Preset::Auto, Preset::Best];

#[test]
fn threads_change_neither_bytes_nor_notes() {
    for name in ["colonnade.obj", "forest.gltf"] {
        for preset in SEARCHES {
            let options = BuildOptions::preset(preset);
            let build = |jobs| compile(sample(name), &options, &Executor::new(jobs).unwrap(), &NoProgress).unwrap();
            let (one, four) = (build(1), build(4));
            assert!(!one.notes.is_empty() && one.notes == four.notes, "{name}: {:?} {:?}", one.notes, four.notes);
            assert!(
                Image::new(&one, &Executor::current()).unwrap() == Image::new(&four, &Executor::current()).unwrap(),
                "{name} {preset}"
            );
        }
    }
}

#[test]
fn a_recipe_that_the_user_names_leaves_no_notes() {
    for preset in [Preset::Draft, Preset::Balanced] {
        let scene = scene_of(sphere(12, 1.0, [0.0; 3]));
        let accel = compile(scene, &BuildOptions::preset(preset), &Executor::sequential(), &NoProgress).unwrap();
        assert!(accel.notes.is_empty());
    }
}

/// Triangles by their corners.
fn soup(triangles: Vec<[[f32; 3]; 3]>) -> Mesh {
    Mesh {
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        positions: triangles.into_iter().flatten().collect(),
        ..Mesh::default()
    }
}

#[test]
fn tiny_degenerate_and_hostile_meshes_get_sound_trees() {
    let one = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let scaled = |by: f32| one.map(|p| p.map(|c: f32| c * by));
    let mut meshes: Vec<(String, Mesh)> = (0..6).map(|n| (format!("{n} alike"), soup(vec![one; n]))).collect();
    meshes.push(("2000 alike".into(), soup(vec![one; 2000])));
    meshes.push(("points".into(), soup(vec![[[2.0; 3]; 3]; 900])));
    meshes.push(("powers".into(), soup((0..600).map(|i| scaled(0.5f32.powi(i % 140))).collect())));
    meshes.push(("huge".into(), soup((0..600).map(|i| scaled(1e35 * (1.0 + i as f32))).collect())));
    meshes.push(("flat".into(), soup((0..600).map(|i| one.map(|p| [p[0] + i as f32 * 0.1, p[1], 0.0])).collect())));
    for (name, mesh) in meshes {
        for preset in SEARCHES {
            let count = mesh.triangles.len();
            let options = BuildOptions::preset(preset);
            let (tree, choice) = decide_tree(&mesh, &options, &Executor::sequential(), &NoProgress).unwrap();
            let choice = choice.expect("a search says what it did");
            assert!(choice.taken < choice.trials.len() && !choice.reason.is_empty(), "{name}");
            assert!(tree.max_depth() <= MAX_DEPTH, "{name}");
            let mut held = tree.refs.clone();
            held.sort_unstable();
            held.dedup();
            assert!(held.into_iter().eq(0..count as u32), "{name}: a triangle is lost");
            if count > 0 {
                let scene = scene_of(mesh.clone());
                let accel = compile(scene, &options, &Executor::sequential(), &NoProgress).unwrap();
                let checked = check_image(
                    &Image::new(&accel, &Executor::current()).unwrap(),
                    &Limits::default(),
                    &Executor::current(),
                );
                assert!(checked.is_valid(), "{name}: {:?}", checked.findings);
            }
        }
    }
}

#[test]
fn instanced_scenes_are_decided_mesh_by_mesh() {
    let mut scene = place(sphere(16, 1.0, [0.0; 3]), &[Affine::IDENTITY, Affine::IDENTITY]);
    let small = place(sphere(2, 1.0, [5.0; 3]), &[Affine::IDENTITY]);
    scene.meshes.extend(small.meshes);
    scene.instances.extend(small.instances.into_iter().map(|i| bvhc::scene::Instance { mesh: 1, ..i }));
    let accel = compile(scene, &BuildOptions::default(), &Executor::sequential(), &NoProgress).unwrap();
    assert_eq!((accel.blases.len(), accel.instances.len()), (2, 3));
    assert!(accel.notes[0].starts_with("auto: of 2 trees took "), "{:?}", accel.notes);
    assert!(accel.notes.iter().any(|n| n.starts_with("auto, tree 0: ")), "{:?}", accel.notes);

    let nothing = compile(Default::default(), &BuildOptions::default(), &Executor::sequential(), &NoProgress).unwrap();
    assert!(nothing.notes.is_empty() && nothing.blases.is_empty());
}

#[test]
fn auto_moves_nothing_on_a_smooth_surface_and_cuts_where_triangles_are_long() {
    let auto = |mesh: &Mesh| {
        let built = decide_tree(mesh, &BuildOptions::default(), &Executor::sequential(), &NoProgress).unwrap();
        (built.0, built.1.expect("a search says what it did"))
    };
    let (tree, choice) = auto(&sphere(40, 1.0, [0.0; 3]));
    let tried: Vec<&str> = choice.trials.iter().map(|t| t.name()).collect();
    assert_eq!(tried[..2], ["sweep", "sbvh"], "{choice:?}");
    assert!(tried.iter().all(|name| !name.contains("rounds")), "{choice:?}");
    assert!(choice.overlap.unwrap() < 0.09 && tree.refs.len() <= 6 * 40 * 40 * 2 * 6 / 5);

    // Bars from corner to corner of a cube, in all directions.
    let mut state = 1u64;
    let mut unit = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    let bars = (0..9000).map(|_| {
        let [a, b] = [0; 2].map(|_| [0; 3].map(|_| 10.0 * unit()));
        [a, b, b.map(|c| c + 0.05)]
    });
    let (tree, choice) = auto(&soup(bars.collect()));
    assert!(choice.recipe().starts_with("sbvh") && tree.refs.len() > 9000, "{choice:?}");
    assert!(choice.overlap.unwrap() > 0.35 && choice.trials.iter().all(|t| t.name() != "sweep + 8 rounds"));
}

/// Recipes that are best somewhere.
fn rivals() -> Vec<BuildOptions> {
    let of = |method, presplit, reinsert| BuildOptions { method, presplit, reinsert, ..BuildOptions::default() };
    vec![
        of(Method::Sbvh, 0.0, 0),
        of(Method::Sbvh, 0.0, 8),
        of(Method::Sweep, 0.0, 8),
        of(Method::Agglomerative, 0.0, 8),
        of(Method::Bonsai, 0.3, 8),
        BuildOptions { adapt: 4096, ..of(Method::Sbvh, 0.0, 8) },
    ]
}

/// What the rays pay in the tree: they neither judged nor formed any.
fn paid(mesh: &Mesh, tree: &Tree, rays: &FamilyRays, exec: &Executor) -> FamilyCost {
    rays.cost(&Image::of_tree(mesh, tree, exec).unwrap().view(), exec)
}

fn means(cost: &FamilyCost) -> Vec<f64> {
    Family::ALL.into_iter().filter_map(|family| cost.mean(family)).collect()
}

fn other_rays(mesh: &Mesh, count: usize, exec: &Executor) -> FamilyRays {
    let draft = decide_tree(mesh, &BuildOptions::preset(Preset::Draft), exec, &NoProgress).unwrap().0;
    FamilyRays::new(&Image::of_tree(mesh, &draft, exec).unwrap().view(), count, 64, exec)
}

/// The worst regret of each search's tree beyond the least worst regret of any rival.
fn behind(mesh: &Mesh, rays: usize) -> Vec<(Choice, f64)> {
    let exec = Executor::new(0).unwrap();
    let rays = other_rays(mesh, rays, &exec);
    let mut trees: Vec<(Option<Choice>, Vec<f64>)> = Vec::new();
    for options in rivals().into_iter().chain(SEARCHES.map(BuildOptions::preset)) {
        let (tree, choice) = decide_tree(mesh, &options, &exec, &NoProgress).unwrap();
        trees.push((choice, means(&paid(mesh, &tree, &rays, &exec))));
    }
    let best = |family: usize| trees.iter().map(|(_, paid)| paid[family]).fold(f64::INFINITY, f64::min);
    let worst = |paid: &[f64]| {
        let regrets = paid.iter().enumerate().map(|(family, cost)| cost / best(family) - 1.0);
        regrets.fold(0.0, f64::max)
    };
    let rivals = trees.iter().filter(|(choice, _)| choice.is_none());
    let least = rivals.map(|(_, paid)| worst(paid)).fold(f64::INFINITY, f64::min);
    let behind = |(choice, paid): &(Option<Choice>, Vec<f64>)| Some((choice.clone()?, worst(paid) - least));
    trees.iter().filter_map(behind).collect()
}

fn within_the_margin(name: &str, mesh: &Mesh, rays: usize) {
    for (choice, behind) in behind(mesh, rays) {
        println!("{name}: {} took {}, {:+.1} %", choice.method, choice.recipe(), behind * 100.0);
        assert!(behind <= 0.02, "{name}: {behind} {choice:?}");
    }
}

#[test]
fn samples_stay_within_the_margin() {
    for name in ["colonnade.obj", "corrugated_roof.obj", "stadium.obj"] {
        let scene = sample(name);
        within_the_margin(name, &scene.meshes[0], 1 << 12);
    }
}

/// The mesh of a model in one level, if it is there.
fn model(file: &str) -> Option<Mesh> {
    let Ok(scene) = read(&common::models_dir()?.join(file), &ReadOptions::default()) else {
        println!("skipped: {file} is not there");
        return None;
    };
    let options = BuildOptions { levels: bvhc::build::Levels::One, ..BuildOptions::default() };
    lay_out(scene, &options, &Executor::sequential()).unwrap().meshes.into_iter().next()
}

/// No family pays for adaptation, by rays that neither formed nor judged it, unless chance may have it so; the ratio of the mean costs.
fn adaptation_harms_nobody(name: &str, mesh: &Mesh, rays: usize) -> f64 {
    let exec = Executor::new(0).unwrap();
    let base = BuildOptions { method: Method::Sbvh, reinsert: 8, ..BuildOptions::default() };
    let trees = [0, 4096].map(|adapt| {
        let options = BuildOptions { adapt, ..base.clone() };
        decide_tree(mesh, &options, &exec, &NoProgress).unwrap().0
    });
    let rays = other_rays(mesh, rays, &exec);
    let [before, after] = trees.each_ref().map(|tree| paid(mesh, tree, &rays, &exec));
    let beyond: Vec<(f64, f64)> = Family::ALL.into_iter().filter_map(|family| after.beyond(&before, family)).collect();
    let rise = f64::from(sah(&trees[1].nodes) / sah(&trees[0].nodes)) - 1.0;
    println!("{name}: {beyond:.4?}, SAH {rise:+.3}");
    assert!(beyond.iter().all(|(over, error)| over - 2.0 * error <= 0.01), "{name}: {beyond:?}");
    let over = beyond.iter().map(|(over, _)| over).sum::<f64>() / beyond.len() as f64;
    assert!(rise <= 0.04f64.max(-over), "{name}: SAH {rise} for {over}");
    1.0 + over
}

#[test]
fn adaptation_of_samples_harms_no_family() {
    for name in ["colonnade.obj", "stadium.obj"] {
        adaptation_harms_nobody(name, &sample(name).meshes[0], 1 << 13);
    }
}

#[test]
#[ignore = "long: real scenes with and without adaptation"]
fn long_adaptation_harms_no_family_of_real_scenes() {
    let mut means = Vec::new();
    for file in [
        "luxcore_kitchen/kitchen.obj",
        "city_munich/munich.obj",
        "sponza_dabrovic/sponza.obj",
        "obvhs_kitchen/kitchen.obj",
        "sf_japanese_temple/sf_japanese_temple.glb",
        "sf_lamborghini/sf_lamborghini.glb",
        "ldraw_cafe_corner/ldraw_cafe_corner.glb",
    ] {
        let Some(mesh) = model(file) else { continue };
        means.push(adaptation_harms_nobody(file, &mesh, 1 << 14));
    }
    let gained = means.iter().filter(|mean| **mean < 0.995).count();
    assert!(2 * gained >= means.len(), "adaptation is of use nowhere: {means:?}");
}

#[test]
#[ignore = "long: eight recipes of ten real scenes"]
fn long_real_scenes_stay_within_the_margin() {
    for file in [
        "sponza_dabrovic/sponza.obj",
        "sponza_crytek_partial/sponza_crytek_partial.obj",
        "obvhs_kitchen/kitchen.obj",
        "stanford_bunny/stanford_bunny.obj",
        "stanford_dragon/dragon_202k.obj",
        "city_san_francisco/san_francisco.obj",
        "sf_lamborghini/sf_lamborghini.glb",
        "sf_macross_city/sf_macross_city.glb",
        "luxcore_kitchen/kitchen.obj",
        "city_munich/munich.obj",
    ] {
        let Some(mesh) = model(file) else { continue };
        within_the_margin(file, &mesh, 1 << 13);
    }
}
