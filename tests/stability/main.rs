//! Scenes on which builders are known to fail, built by every preset, method and pass: the hits are right and the trees bounded on all of them, and
//! where a method does badly, that is known.
//!
//! `bvhc chart --stability` prints the whole table.

#[path = "../../examples/oriented/growth.rs"]
mod growth;
mod hard;
mod oriented;
#[path = "../../examples/oriented/saving.rs"]
mod saving;

use bvhc::build::{Executor, NoProgress};
use bvhc::cache::Image;
use bvhc::compile::compile;
use bvhc::geom::Ray;
use bvhc::stability::heap::Counting;
use bvhc::stability::{
    AUTO, Effort, FAILURES, Failure, GROWTH, Judge, MOTIONS, REFUSED, Row, SceneReport, asks_rays, gates, recipes,
    splits,
};
use bvhc::trace::closest_hit;
use std::sync::{Mutex, MutexGuard, PoisonError};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const SIZE: usize = 240;
const RAYS: usize = 260;

fn named(id: &str) -> &'static Failure {
    Failure::named(id).expect("it is in the list")
}

/// Memory is counted over all threads, so tests of this file take turns.
fn alone() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::new(());
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

fn effort(rays: usize, rounds: u32) -> Effort {
    Effort { sizes: [SIZE; 2], rays, judged_rays: rays, rounds }
}

/// By every recipe, without a clock.
fn rows(failure: &Failure, size: usize, exec: &Executor) -> Vec<Row> {
    let scene = failure.scene(size);
    let mut judge = Judge::new(&scene, &effort(RAYS, 0), exec);
    recipes().iter().map(|recipe| judge.row(recipe).unwrap()).collect()
}

#[test]
fn every_scene_keeps_its_promises_by_every_recipe() {
    let _turn = alone();
    let exec = Executor::new(0).unwrap();
    // Below 512 triangles searches build one tree and measure nothing, so what they hold would seem to jump.
    let effort = Effort { sizes: [700, 2100], ..effort(RAYS, 0) };
    let mut broken = Vec::new();
    for failure in &FAILURES {
        let report = SceneReport::of(failure, &effort, &exec, |_| true).unwrap().expect("nobody stopped it");
        let told = report.broken().into_iter().map(|what| format!("{} {}, {what}", failure.id, failure.name));
        broken.extend(told);
        assert_eq!(report.promises.len(), gates(failure.id).count(), "{}", failure.id);
        for row in report.recipes.iter().flat_map(|row| [&row.small, &row.large]) {
            // A binary tree over so many references has no more nodes than this, the unused one and the root's pair included.
            let most = 2.0 * row.references * row.triangles as f64 + 1.0;
            assert!(row.nodes as f64 <= most, "{} nodes over {} triangles", row.nodes, row.triangles);
            assert!(row.peak_bytes > 0 || row.triangles == 0, "nobody counts");
        }
        let auto = report.auto().expect("it is among the recipes");
        assert!(auto.poor.is_none(), "{}: auto costs {} times the cheapest", failure.id, auto.over);
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

/// Four times the triangles: what is linear takes four times as long, what is quadratic 16 times. The least of many builds on each side, and another
/// try where something else ran meanwhile.
#[test]
fn build_time_grows_about_as_triangles_do() {
    let _turn = alone();
    let exec = Executor::sequential();
    for id in ["F04", "F05", "F06", "F07", "F09", "F20", "F33"] {
        let times = |size: usize| {
            let scene = named(id).scene(size);
            let mut judge = Judge::new(&scene, &effort(1, 3), &exec);
            let all = recipes().into_iter().filter(|recipe| !asks_rays(recipe.name));
            all.map(|recipe| (recipe.name, judge.row(&recipe).unwrap().seconds)).collect::<Vec<_>>()
        };
        let mut least = [times(600), times(2400)];
        for _ in 0..4 {
            let is_slow = |i: usize| least[1][i].1 > 4.0 * GROWTH[0] * least[0][i].1;
            if !(0..least[0].len()).any(is_slow) {
                break;
            }
            // Of the larger size the least counts, of the smaller one the first.
            let again = times(2400);
            least[1].iter_mut().zip(again).for_each(|(known, new)| known.1 = known.1.min(new.1));
        }
        for (small, large) in least[0].iter().zip(&least[1]) {
            assert!(large.1 <= 4.0 * GROWTH[0] * small.1, "{id}, {}: {} s and {} s", small.0, small.1, large.1);
        }
    }
}

#[test]
fn no_scene_and_no_recipe_depends_on_threads() {
    let _turn = alone();
    let [one, three] = [1, 3].map(|jobs| Executor::new(jobs).unwrap());
    for failure in &FAILURES {
        let scene = failure.scene(SIZE);
        let asked = ["sbvh", "agglomerative", "oabb", "bonsai", AUTO];
        for recipe in recipes().iter().filter(|recipe| asked.contains(&recipe.name)) {
            let build = |exec: &Executor| {
                let accel = compile(scene.clone(), &recipe.options, exec, &NoProgress).unwrap();
                let image = Image::new(&accel, exec).unwrap();
                (image.nodes, image.triangles)
            };
            assert!(build(&one) == build(&three), "{} {}, {}", failure.id, failure.name, recipe.name);
        }
    }
}

#[test]
fn every_size_from_none_to_five_triangles_is_built() {
    let _turn = alone();
    let exec = Executor::sequential();
    for size in 0..6 {
        for row in rows(named("F24"), size, &exec) {
            assert_eq!((row.triangles, row.broken()), (size as u64, None), "{}", row.recipe);
        }
    }
}

/// A scale by a power of two changes no bit of a mantissa, so it changes no decision.
#[test]
fn the_scale_of_a_scene_decides_nothing() {
    let _turn = alone();
    let exec = Executor::sequential();
    let scene = named("F36").scene(300);
    for recipe in recipes() {
        let build = |scale: f32| {
            let mut scene = scene.clone();
            scene.meshes[0].positions.iter_mut().flatten().for_each(|c| *c *= scale);
            let accel = compile(scene, &recipe.options, &exec, &NoProgress).unwrap();
            let nodes = &accel.blases[0].nodes;
            (nodes.iter().map(|n| (n.first, n.count)).collect::<Vec<_>>(), accel.blases[0].refs.clone())
        };
        let plain = build(1.0);
        for power in [-20, 20] {
            assert!(build(2f32.powi(power)) == plain, "{}, 2^{power}", recipe.name);
        }
    }
}

/// A ray that starts inside every box meets the innermost first, in whatever order it looks.
#[test]
fn from_within_all_boxes_the_nearest_is_hit() {
    let _turn = alone();
    let exec = Executor::sequential();
    let scene = named("F39").scene(480);
    for recipe in recipes() {
        let name = recipe.name;
        let image = Judge::new(&scene, &effort(1, 0), &exec).build(&recipe.options).unwrap();
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
    let _turn = alone();
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
