//! Scenes on which builders are known to fail, built by every preset, method and pass: the hits are right and the trees bounded on all of them, and
//! where a method does badly, that is known.
//!
//! `cargo run --release --example stability` prints the whole table, in two sizes.

#[path = "../../samples/generator/failures/mod.rs"]
mod failures;
#[path = "../../examples/oriented/growth.rs"]
mod growth;
#[path = "../../samples/generator/failures/judge.rs"]
mod judge;
#[path = "../../examples/oriented/orient.rs"]
mod orient;
mod oriented;
#[path = "../../examples/oriented/saving.rs"]
mod saving;
#[path = "../../examples/oriented/turned.rs"]
mod turned;

use bvhc::build::{Executor, NoProgress};
use bvhc::cache::Image;
use bvhc::compile::compile;
use bvhc::geom::{Affine, Ray};
use bvhc::scene::Scene;
use bvhc::trace::brute::Oracle;
use bvhc::trace::closest_hit;
use bvhc::trace::compare::compare;
use bvhc::trace::rays::Sampler;
use failures::{FAILURES, Failure};
use judge::{Judge, Row, recipes};

const SIZE: usize = 240;
const RAYS: usize = 260;

fn named(id: &str) -> &'static Failure {
    FAILURES.iter().find(|f| f.id == id).expect("it is in the list")
}

/// By every recipe.
fn rows(failure: &Failure, size: usize, exec: &Executor) -> Vec<Row> {
    let scene = failure.scene(size);
    let mut judge = Judge::new(&scene, RAYS, exec);
    recipes().iter().map(|(name, options)| judge.row(name, options, exec)).collect()
}

fn cost(rows: &[Row], recipe: &str) -> f64 {
    rows.iter().find(|row| row.recipe == recipe).expect("a recipe").cost
}

#[test]
fn hits_are_right_and_trees_are_bounded_whatever_the_scene_and_the_recipe() {
    let exec = Executor::new(0).unwrap();
    let mut broken = Vec::new();
    for failure in &FAILURES {
        for row in rows(failure, SIZE, &exec) {
            if let Some(why) = row.broken() {
                broken.push(format!("{} {}, {}: {why}", failure.id, failure.name, row.recipe));
            }
            // A binary tree over so many references has no more nodes than this, the unused one and the root's pair included.
            let most = 2.0 * row.references * row.triangles as f64 + 1.0;
            assert!(row.nodes as f64 <= most, "{} nodes over {} triangles", row.nodes, row.triangles);
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn no_scene_and_no_recipe_depends_on_threads() {
    let [one, three] = [1, 3].map(|jobs| Executor::new(jobs).unwrap());
    for failure in &FAILURES {
        let scene = failure.scene(SIZE);
        for (name, options) in
            recipes().iter().filter(|(name, _)| ["sbvh", "agglomerative", "oabb", "bonsai", "auto"].contains(name))
        {
            let build = |exec: &Executor| {
                let accel = compile(scene.clone(), options, exec, &NoProgress).unwrap();
                let image = Image::new(&accel, exec).unwrap();
                (image.nodes, image.triangles)
            };
            assert!(build(&one) == build(&three), "{} {}, {name}", failure.id, failure.name);
        }
    }
}

#[test]
fn every_size_from_none_to_five_triangles_is_built() {
    let exec = Executor::sequential();
    for size in 0..6 {
        for row in rows(named("F24"), size, &exec) {
            assert_eq!((row.triangles, row.broken()), (size as u64, None), "{}", row.recipe);
        }
    }
}

/// What cutting is good for, and what it is not.
#[test]
fn known_failures_are_there_by_name() {
    let exec = Executor::new(0).unwrap();
    let hall = rows(named("F01"), 1500, &exec);
    assert!(cost(&hall, "longest axis") > cost(&hall, "draft"), "{hall:#?}");
    let turned = rows(named("F10"), 1500, &exec);
    assert!(cost(&turned, "sbvh") < 0.8 * cost(&turned, "sweep"), "{turned:#?}");
    let ball = rows(named("F08"), 1500, &exec);
    for searched in ["auto", "best"] {
        let references = ball.iter().find(|row| row.recipe == searched).unwrap().references;
        assert!(references <= 1.02, "{searched} cuts an even surface: {references}");
    }
}

/// A scale by a power of two changes no bit of a mantissa, so it changes no decision.
#[test]
fn the_scale_of_a_scene_decides_nothing() {
    let exec = Executor::sequential();
    let scene = named("F36").scene(300);
    for (name, options) in recipes() {
        let build = |scale: f32| {
            let mut scene = scene.clone();
            scene.meshes[0].positions.iter_mut().flatten().for_each(|c| *c *= scale);
            let accel = compile(scene, &options, &exec, &NoProgress).unwrap();
            let nodes = &accel.blases[0].nodes;
            (nodes.iter().map(|n| (n.first, n.count)).collect::<Vec<_>>(), accel.blases[0].refs.clone())
        };
        let plain = build(1.0);
        for power in [-20, 20] {
            assert!(build(2f32.powi(power)) == plain, "{name}, 2^{power}");
        }
    }
}

#[test]
fn vertices_that_no_triangle_has_are_in_no_box() {
    let exec = Executor::sequential();
    let mut scene = named("F36").scene(60);
    let tight = (0..60).map(|i| scene.meshes[0].triangle_box(i)).reduce(|a, b| a.union(b)).unwrap();
    scene.meshes[0].positions.extend([[1e9; 3], [-1e9; 3]]);
    for (name, options) in recipes() {
        let root = compile(scene.clone(), &options, &exec, &NoProgress).unwrap().blases[0].nodes[0].bounds();
        assert_eq!(root, tight, "{name}");
    }
}

#[test]
fn numbers_that_are_none_are_refused() {
    let exec = Executor::sequential();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut scene = named("F36").scene(60);
        scene.meshes[0].positions[7][1] = bad;
        for (name, options) in recipes() {
            assert!(compile(scene.clone(), &options, &exec, &NoProgress).is_err(), "{name}: {bad}");
        }
    }
}

/// A mirrored and a sheared instance of one mesh beside the mesh itself; one that a matrix without an inverse would flatten is refused.
#[test]
fn mirrored_instances_are_hit_where_they_stand_and_singular_ones_are_refused() {
    let exec = Executor::sequential();
    let mut scene = named("F36").scene(60);
    let rows: [[[f64; 4]; 3]; 2] = [
        [[-1.0, 0.0, 0.0, 4.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        [[1.0, 0.5, 0.0, 8.0], [0.0, 1.0, 0.25, 0.0], [0.0, 0.0, 2.0, 0.0]],
    ];
    let instance = scene.instances[0].clone();
    scene.instances.extend(rows.map(|rows| bvhc::scene::Instance { transform: Affine { rows }, ..instance.clone() }));
    let mut scene = Scene { meshes: scene.meshes, instances: scene.instances, ..Scene::default() };
    let rays = Sampler::new(&scene).mixed(RAYS as u64, 3);
    for (name, options) in recipes() {
        let accel = compile(scene.clone(), &options, &exec, &NoProgress).unwrap();
        let image = Image::new(&accel, &exec).unwrap();
        let oracle = Oracle::of_file(&scene, &image.view(), &exec);
        let answers = oracle.trace_all(&rays, &exec);
        let tally = compare(&image.view(), &oracle, &rays, &answers, &exec).unwrap();
        assert_eq!(tally.wrong(), 0, "{name}: {:#?}", tally.first_wrong);
    }

    scene.instances[1].transform.rows = [[1.0, 0.0, 0.0, 12.0], [0.0, 0.0, 0.0, 0.5], [0.0, 0.0, 1.0, 0.0]];
    for (name, options) in recipes() {
        assert!(compile(scene.clone(), &options, &exec, &NoProgress).is_err(), "{name}");
    }
}

/// A ray that starts inside every box meets the innermost first, in whatever order it looks.
#[test]
fn from_within_all_boxes_the_nearest_is_hit() {
    let exec = Executor::sequential();
    let scene = named("F39").scene(480);
    for (name, options) in recipes() {
        let image = Judge::new(&scene, 1, &exec).build(&options, &exec);
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut direction = [0.0, -0.0, 0.0];
                direction[axis] = sign;
                let hit = closest_hit(&image.view(), &Ray::new([0.1, 0.2, 0.05], direction)).unwrap().expect(name);
                assert!(hit.t <= 1.2 && hit.prim < 12, "{name}: {hit:?}");
            }
        }
    }
}

#[test]
fn the_list_names_each_scene_once_and_models_can_be_written() {
    let ids: std::collections::BTreeSet<_> = FAILURES.iter().map(|f| (f.id, f.name)).collect();
    assert!(ids.len() == FAILURES.len() && FAILURES.iter().all(|f| !f.breaks.is_empty()));
    let text = named("F33").obj(96);
    let read = bvhc::scene::read_bytes(
        text.into_bytes(),
        "lattice.obj",
        Some(bvhc::scene::Format::Obj),
        None,
        &bvhc::scene::ReadOptions::default(),
    );
    assert_eq!(read.unwrap().meshes[0].triangles.len(), 96);
}
