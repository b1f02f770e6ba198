//! The accuracy report tells arithmetics apart: each of the others is wrong where it must be, and ours never is.

mod common;

use bvhc::build::{BuildOptions, Executor, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::compile::compile;
use bvhc::geom::{Affine, Ray};
use bvhc::random::Random;
use bvhc::scene::Scene;
use bvhc::trace::arithmetic::{Arithmetic, BoxArithmetic, TriangleArithmetic, closest_hit_by};
use bvhc::trace::brute::Oracle;
use bvhc::trace::rays::{RaySet, Sampler};
use bvhc::trace::{NoObserver, closest_hit, try_closest_hit};
use bvhc::verify::accuracy::{Measure, Report, Row, measure};
use common::meshes::{cube, place, scene_of, sphere};

fn image(scene: &Scene) -> Image {
    let exec = Executor::new(0).expect("threads");
    Image::new(&compile(scene.clone(), &BuildOptions::preset(Preset::Best), &exec, &NoProgress).expect("a tree"), &exec)
        .unwrap()
}

fn report(scene: &Scene) -> Report {
    let (image, exec) = (image(scene), Executor::new(0).expect("threads"));
    let few = Measure { rays: 14_000, timed: 96, rounds: 1, ..Measure::default() };
    let report = measure(&image.view(), &Oracle::new(scene, &exec), &Sampler::new(scene), &few, &exec, &NoProgress);
    let report = report.expect("a well-formed tree");
    assert!(report.judged() >= 14_000 && report.rows.len() == 12, "{report:?}");
    let ours = report.ours();
    assert_eq!((ours.fair.wrong(), ours.hard.wrong()), (0, 0), "ours: {ours:?}");
    assert!(ours.distance.hits() + ours.hard_distance.hits() > 1000, "ours: {ours:?}");
    assert!(ours.distance.max() <= 0.5, "ours: {:?}", ours.distance.max());
    assert!(report.rows.iter().all(|r| r.mrays_per_second > 0.0 && r.inner_nodes_per_ray > 0.0));
    report
}

fn row(report: &Report, triangles: TriangleArithmetic, boxes: BoxArithmetic) -> &Row {
    let arithmetic = Arithmetic { triangles, boxes };
    report.rows.iter().find(|r| r.arithmetic == arithmetic).expect("every combination has a row")
}

/// Rays from inside at the vertices and along the edges of a closed mesh: how many get out.
fn escapes(scene: &Scene, triangles: TriangleArithmetic) -> usize {
    let (image, mesh) = (image(scene), &scene.meshes[0]);
    let by = Arithmetic { triangles, boxes: BoxArithmetic::Conservative };
    let mut random = Random::new(3);
    let mut escaped = 0;
    for i in 0..mesh.triangles.len() {
        let c = mesh.corners(i);
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let s = [0.0, 0.5, random.unit() as f32][random.below(3) as usize];
            let target = [0, 1, 2].map(|k| c[a][k] + s * (c[b][k] - c[a][k]));
            let origin = [0; 3].map(|_| (random.unit() - 0.5) as f32);
            let ray = Ray::new(origin, [0, 1, 2].map(|k| target[k] - origin[k]));
            let hit = closest_hit_by(by, &image.view(), &ray).expect("a well-formed tree");
            escaped += usize::from(hit.is_none());
        }
    }
    escaped
}

#[test]
fn moller_trumbore_leaks_at_edges_where_the_others_are_closed() {
    let scene = scene_of(sphere(40, 1.0, [0.0; 3]));
    let leaks = TriangleArithmetic::ALL.map(|t| escapes(&scene, t));
    assert!(leaks[0] > 0 && leaks[1] > 0, "Möller–Trumbore lets rays out: {leaks:?}");
    assert_eq!(leaks[2..], [0, 0], "the others do not: {leaks:?}");

    let report = report(&scene);
    for boxes in BoxArithmetic::ALL {
        let errors = row(&report, TriangleArithmetic::MollerTrumbore, boxes).hard;
        assert!(errors.wrong() > 0, "{boxes:?}: {errors:?}");
    }
}

#[test]
fn an_absolute_bound_loses_a_small_model() {
    let report = report(&scene_of(sphere(10, 1e-3, [0.0; 3])));
    let hits = |t| row(&report, t, BoxArithmetic::Conservative).distance.hits();
    let found = [TriangleArithmetic::MollerTrumboreEpsilon, TriangleArithmetic::MollerTrumbore].map(hits);
    let all = report.ours().distance.hits();
    assert!(found[0] * 10 < all, "nearly all hits are lost: {found:?} of {all}");
    assert!(found[1] * 10 > all * 9, "the bound is to blame: {found:?} of {all}");
}

#[test]
fn single_precision_fails_over_long_distances() {
    // Two spheres 10⁵ radii apart: corners relative to a far origin lose the digits that decide.
    let far = Affine { rows: [[1.0, 0.0, 0.0, 1e5], [0.0, 1.0, 0.0, -3e4], [0.0, 0.0, 1.0, 7e4]] };
    let report = report(&place(sphere(10, 1.0, [0.0; 3]), &[Affine::IDENTITY, far]));
    for triangles in [TriangleArithmetic::MollerTrumbore, TriangleArithmetic::Watertight] {
        let row = row(&report, triangles, BoxArithmetic::Conservative);
        assert!(row.hard.wrong() > 0, "{triangles:?}: {:?}", row.hard);
        assert!(row.hard_distance.max() > 2.0, "{triangles:?}: {}", row.hard_distance.max());
    }
}

#[test]
fn plain_boxes_lose_hits_that_conservative_ones_keep() {
    // Triangles are decided in f64 by all three, so the boxes alone are to blame.
    let skewed = Affine { rows: [[0.8, -0.6, 0.1, 0.3], [0.6, 0.8, -0.2, -0.2], [0.05, 0.3, 0.9, 0.7]] };
    let mesh = || cube(12, |p| skewed.transform_point(p).map(|v| v as f32));
    let lost = |boxes| {
        let of = |scene: &Scene| row(&report(scene), TriangleArithmetic::Double, boxes).hard.wrong();
        of(&scene_of(mesh())) + of(&place(mesh(), &[Affine::IDENTITY, skewed]))
    };
    assert!(lost(BoxArithmetic::Plain) > 0);
    assert_eq!(lost(BoxArithmetic::Conservative), 0);
}

#[test]
fn the_last_combination_is_the_default_traversal() {
    let scene = place(sphere(8, 1.0, [0.1; 3]), &[Affine::IDENTITY; 2]);
    let image = image(&scene);
    let sampler = Sampler::new(&scene);
    assert_eq!(Arithmetic::all().last(), Some(Arithmetic::OURS));
    for set in RaySet::ALL {
        for ray in sampler.rays(set, 200, 9) {
            let hit = closest_hit_by(Arithmetic::OURS, &image.view(), &ray);
            assert_eq!(hit, try_closest_hit(&image.view(), &ray, &mut NoObserver));
            assert_eq!(hit, closest_hit(&image.view(), &ray));
        }
    }
}
