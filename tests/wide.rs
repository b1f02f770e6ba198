//! Wide trees give each ray the answer of the binary tree, bit by bit, whatever instructions the processor has.

mod common;

use bvhc::build::{BuildOptions, Executor, Levels, METHODS, Method, NoProgress, Preset};
use bvhc::cache::{Codec, Image, Meta, OpenOptions, Validation, View, WriteOptions, to_bytes};
use bvhc::compile::compile;
use bvhc::geom::{Affine, Point, Ray};
use bvhc::random::Random;
use bvhc::scene::{Mesh, ReadOptions, Scene, read};
use bvhc::simd::{Level, Runs, Widest, at_most};
use bvhc::trace::brute::Oracle;
use bvhc::trace::compare::judge;
use bvhc::trace::rays::Sampler;
use bvhc::trace::rays::grid::GridScene;
use bvhc::trace::wide::{Collapse, CompactTrees, WideRecord, WideTrees, WideView};
use bvhc::trace::{Counters, Hit, any_hit, closest_hit};
use bvhc::{Build, Cache};
use common::meshes::{cube, place, scene_of, sphere, visible};
use common::scenes::{model_files, real_scenes, samples_dir};

fn build(scene: &Scene, options: &BuildOptions) -> Image {
    let exec = Executor::sequential();
    Image::new(&compile(scene.clone(), options, &exec, &NoProgress).expect("a tree"), &exec).unwrap()
}

/// Every bit of a hit that does not say which of several records of one triangle was found, and whether that is a record of this triangle.
fn bits(view: &View<'_>, hit: Option<Hit>) -> Option<([u32; 5], Option<u32>)> {
    let hit = hit?;
    let record = view.triangles[hit.triangle];
    assert_eq!((record.geom, record.prim), (hit.geom, hit.prim), "{hit:?}");
    Some(([hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.geom, hit.prim], hit.instance))
}

/// Whether no triangle of the file stands in several leaves: then hits are equal in all.
fn is_whole(view: &View<'_>) -> bool {
    view.triangles.iter().all(|t| t.flags == 0)
}

/// Every ray in some wide trees as in the binary ones, by the widest instructions and by the narrowest, which enter the same nodes. Returns how many hit.
fn assert_equal<const N: usize, T: WideRecord<N>>(name: &str, wide: &WideView<'_, N, T>, rays: &[Ray]) -> usize
where
    Widest: Runs<N>,
{
    let view = &wide.view;
    let whole = is_whole(view);
    let mut hits = 0;
    for ray in rays {
        let (want, any) = (closest_hit(view, ray).unwrap(), any_hit(view, ray).unwrap());
        let ask = || {
            let mut counters = [Counters::default(); 2];
            let hit = wide.try_closest_hit(ray, &mut counters[0]).unwrap();
            (hit, wide.try_any_hit(ray, &mut counters[1]).unwrap(), counters)
        };
        let (hit, found, counters) = ask();
        assert_eq!(bits(view, hit), bits(view, want), "{name}, {N} lanes: {ray:?}: {hit:?} and {want:?}");
        assert!(!whole || hit == want, "{name}, {N} lanes: {ray:?}: {hit:?} and {want:?}");
        assert_eq!(found, any, "{name}, {N} lanes: {ray:?}");
        let narrow = at_most(Level::BASE, ask);
        assert_eq!((bits(view, narrow.0), narrow.1, narrow.2), (bits(view, hit), found, counters), "{name}: {ray:?}");
        hits += usize::from(hit.is_some());
    }
    let mut together = vec![None; rays.len()];
    wide.closest_hits(rays, &mut together, &Executor::new(3).unwrap()).unwrap();
    assert_eq!(together.iter().filter(|hit| hit.is_some()).count(), hits, "{name}");
    hits
}

/// All forms, which hit as often.
fn hits_of_all(name: &str, view: &View<'_>, rays: &[Ray]) -> usize {
    let eight = WideTrees::<8>::new(view, &Collapse::default()).expect("trees");
    let compact = CompactTrees::new(&eight);
    let hits = [
        assert_equal(
            &format!("{name}, wide"),
            &WideTrees::<4>::new(view, &Collapse::default()).unwrap().view(view),
            rays,
        ),
        assert_equal(&format!("{name}, wide"), &eight.view(view), rays),
        assert_equal(&format!("{name}, compact"), &compact.view(view), rays),
    ];
    assert_eq!([hits[0]; 3], hits, "{name}");
    hits[0]
}

/// Some rays must hit something, or the test would show little.
fn assert_all(name: &str, view: &View<'_>, rays: &[Ray]) {
    assert!(hits_of_all(name, view, rays) > 0, "{name}");
}

fn recipe(method: Method, levels: Levels) -> BuildOptions {
    BuildOptions { method, levels, ..BuildOptions::preset(Preset::Best) }
}

#[test]
fn every_method_s_tree_answers_alike() {
    let sampled = Sampler::new(&scene_of(sphere(10, 1.0, [0.0; 3]))).mixed(1_500, 1);
    for method in METHODS.iter().map(|row| row.method).filter(|m| !m.is_search()) {
        for max_leaf in [1, 4, 255] {
            let options = BuildOptions { max_leaf, ..recipe(method, Levels::One) };
            let image = build(&scene_of(sphere(10, 1.0, [0.0; 3])), &options);
            assert_all(&format!("{method:?}, leaves of {max_leaf}"), &image.view(), &sampled);
        }
    }
}

#[test]
fn scenes_that_seek_trouble_answer_alike() {
    let soup = |count: usize, size: f32, seed: u64| {
        let mut random = Random::new(seed);
        let mut unit = || random.unit() as f32 - 0.5;
        let positions: Vec<Point> = (0..count)
            .flat_map(|_| {
                let at = [unit(), unit(), unit()];
                [0; 3].map(|_| [0, 1, 2].map(|axis: usize| at[axis] + size * unit()))
            })
            .collect();
        let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        scene_of(Mesh { positions, triangles, ..Mesh::default() })
    };
    let turned = Affine { rows: [[0.6, -0.8, 0.0, 3.0], [0.8, 0.6, 0.0, -2.0], [0.0, 0.0, -1.5, 8.0]] };
    let scenes = [
        ("cube", scene_of(cube(6, |p| p.map(|v| v as f32)))),
        ("far", scene_of(sphere(8, 4.0, [1.0e5, -3.0e5, 7.0e4]))),
        ("flat", scene_of(cube(8, |p| [p[0] as f32, p[1] as f32, 0.0]))),
        ("huge", scene_of(sphere(6, 1.0e18, [0.0; 3]))),
        ("tiny", scene_of(sphere(6, 1.0e-30, [0.0; 3]))),
        ("small triangles", soup(600, 0.05, 1)),
        ("large triangles, often cut", soup(200, 1.5, 2)),
        ("one", soup(1, 1.0, 3)),
        ("two", soup(2, 1.0, 4)),
        ("instances", place(cube(4, |p| p.map(|v| v as f32)), &[Affine::IDENTITY, turned, turned.then_inner(&turned)])),
    ];
    for (name, scene) in scenes {
        let rays = Sampler::new(&scene).mixed(2_000, 5);
        let levels: &[Levels] = if scene.instances.len() > 1 { &[Levels::One, Levels::Two] } else { &[Levels::One] };
        for (method, levels) in levels.iter().flat_map(|l| [Method::Sbvh, Method::Sweep].map(|m| (m, *l))) {
            let image = build(&scene, &recipe(method, levels));
            assert_all(&format!("{name}, {method:?}, {levels:?}"), &image.view(), &rays);
        }
    }
}

/// Where no arithmetic rounds, ties and rays through edges and corners abound.
#[test]
fn grids_answer_as_brute_force_does() {
    let exec = Executor::sequential();
    let mut hits = 0;
    for seed in 0..64 {
        let GridScene { scene, rays } = GridScene::new(seed, 200);
        let scene = visible(scene);
        let levels = if scene.instances.len() > 1 { Levels::Two } else { Levels::One };
        let image = build(&scene, &recipe([Method::Sbvh, Method::Sweep][seed as usize % 2], levels));
        let view = image.view();
        hits += hits_of_all(&format!("grid {seed}"), &view, &rays);

        let oracle = Oracle::of_file(&scene, &view, &exec);
        let trees = WideTrees::<8>::new(&view, &Collapse::default()).unwrap();
        for (ray, answer) in rays.iter().zip(oracle.trace_all(&rays, &exec)) {
            let hit = trees.view(&view).closest_hit(ray).unwrap();
            assert!(judge(&view, &oracle, &answer, hit.as_ref()).is_right(), "grid {seed}: {ray:?}: {hit:?}");
        }
    }
    assert!(hits > 1_000, "{hits}");
}

/// An open file asks its compact trees, mapped or packed, and a build asks those that it made.
#[test]
fn files_with_compact_trees_answer_as_files_without_them() {
    let exec = Executor::sequential();
    let turned = Affine { rows: [[0.6, -0.8, 0.0, 3.0], [0.8, 0.6, 0.0, -2.0], [0.0, 0.0, -1.5, 8.0]] };
    let scenes = [
        (Levels::One, scene_of(sphere(12, 1.0, [0.3, 0.0, -9.0]))),
        (Levels::Two, place(cube(5, |p| p.map(|v| v as f32)), &[Affine::IDENTITY, turned])),
    ];
    for (levels, scene) in scenes {
        let built =
            Build::of_scene(scene.clone()).unwrap().options(recipe(Method::Sbvh, levels)).compact(true).run().unwrap();
        let image = build(&scene, &recipe(Method::Sbvh, levels));
        let view = image.view();
        let mut wide = image.clone();
        wide.add_compact().unwrap();
        let rays = Sampler::new(&scene).mixed(2_000, 3);
        for codec in [Codec::Raw, Codec::Zstd { level: 3 }] {
            let write = WriteOptions { codec, ..WriteOptions::default() };
            let bytes = |image: &Image| to_bytes(image, &Meta::default(), &write, &exec).unwrap();
            for validation in [Validation::Quick, Validation::Tree] {
                let open = OpenOptions { validation, ..OpenOptions::default() };
                let with = Cache::from_bytes(&bytes(&wide), &open).unwrap();
                let without = Cache::from_bytes(&bytes(&image), &open).unwrap();
                assert!(with.compact().is_some() && without.compact().is_none());
                let (mut hits, mut built_hits) = (vec![None; rays.len()], vec![None; rays.len()]);
                with.closest_hits(&rays, &mut hits).unwrap();
                built.closest_hits(&rays, &mut built_hits).unwrap();
                for ((ray, together), of_build) in rays.iter().zip(hits).zip(built_hits) {
                    let want = bits(&view, without.closest_hit(ray).unwrap());
                    assert_eq!(bits(&view, with.closest_hit(ray).unwrap()), want, "{ray:?}");
                    assert_eq!((bits(&view, together), bits(&view, of_build)), (want, want), "{ray:?}");
                    assert_eq!(with.any_hit(ray), without.any_hit(ray), "{ray:?}");
                    assert_eq!(built.any_hit(ray), without.any_hit(ray), "{ray:?}");
                }
            }
        }
    }
}

#[test]
fn rays_that_ask_nothing_and_scenes_without_triangles_meet_nothing() {
    let image = build(&scene_of(sphere(4, 1.0, [0.0; 3])), &recipe(Method::Sweep, Levels::One));
    let ray = |direction: Point| Ray::new([0.0; 3], direction);
    let odd = [
        ray([0.0; 3]),
        ray([f32::NAN, 1.0, 0.0]),
        ray([f32::INFINITY, 1.0, 0.0]),
        Ray { t_min: 2.0, t_max: 1.0, ..ray([1.0, 0.0, 0.0]) },
        Ray { origin: [f32::NAN; 3], ..ray([1.0, 0.0, 0.0]) },
    ];
    assert_eq!(hits_of_all("odd rays", &image.view(), &odd), 0);
    // Directions too short for a reciprocal: no axis counts, and every box is met, those of unused lanes too.
    let image = build(&scene_of(sphere(4, 1.0e-30, [0.0; 3])), &recipe(Method::Sweep, Levels::One));
    let short = [ray([1.0e-40, 0.0, 0.0]), ray([1.0e-44, -1.0e-42, 1.0e-44])];
    assert_eq!(hits_of_all("short rays", &image.view(), &short), 2);
    let empty = Image::default();
    assert_eq!(hits_of_all("nothing", &empty.view(), &[ray([1.0, 0.0, 0.0])]), 0);
}

#[test]
fn samples_cost_less_collapsed_by_plan_than_by_pulling_up() {
    for file in model_files(&samples_dir()).into_iter().filter(|f| f.extension().is_some_and(|e| e == "obj")) {
        let scene = visible(read(&file, &ReadOptions::default()).expect("a scene"));
        let image = build(&scene, &recipe(Method::Sweep, Levels::One));
        let view = image.view();
        let rays = Sampler::new(&scene).mixed(2_000, 9);
        let count = |trees: WideTrees<8>| {
            let mut counters = Counters::default();
            for ray in &rays {
                trees.view(&view).try_closest_hit(ray, &mut counters).unwrap();
            }
            counters.inner_nodes
        };
        let (planned, greedy) =
            (count(WideTrees::new(&view, &Collapse::default()).unwrap()), count(WideTrees::greedy(&view).unwrap()));
        println!("{}: {planned} nodes by plan, {greedy} by pulling up", file.display());
        assert!(planned < greedy, "{}: {planned} and {greedy}", file.display());
    }
}

#[test]
#[ignore = "long: ten million rays in the real scenes, by each form"]
fn long_ten_million_rays_of_the_real_scenes_answer_alike() {
    let Some(files) = real_scenes() else { return };
    let exec = Executor::new(0).unwrap();
    let each = 10_000_000usize.div_ceil(files.len());
    for (number, (name, file)) in files.iter().enumerate() {
        let scene = visible(read(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}")));
        let levels = if scene.instances.len() > 1 { Levels::Two } else { Levels::One };
        let options =
            BuildOptions { method: [Method::Sbvh, Method::Bonsai][number % 2], levels, ..BuildOptions::default() };
        let image = Image::new(&compile(scene.clone(), &options, &exec, &NoProgress).expect("a tree"), &exec).unwrap();
        let rays = Sampler::new(&scene).mixed(each as u64, number as u64);
        exec.map_chunks(&rays, each.div_ceil(4), |_, some| assert_all(name, &image.view(), some));
        println!("{name}: {} rays alike in wide trees of 4 and of 8 lanes", rays.len());
    }
}
