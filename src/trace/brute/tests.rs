use super::*;
use crate::geom::Point;
use crate::scene::{Instance, Mesh};
use crate::trace::exact::Line;
use crate::trace::rays::grid::GridScene;

fn scene(corners: &[[Point; 3]], transform: Affine) -> Scene {
    let positions: Vec<Point> = corners.iter().flatten().copied().collect();
    let triangles = (0..corners.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = Mesh { positions, triangles, ..Mesh::default() };
    let instance = Instance { mesh: 0, transform, node: 0, name: String::new() };
    Scene { meshes: vec![mesh], instances: vec![instance], ..Scene::default() }
}

const FLOOR: [Point; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn standings(scene: &Scene, ray: &Ray) -> Vec<(u32, Standing, Order)> {
    let candidates = Oracle::new(scene, &Executor::sequential()).trace(ray).candidates;
    candidates.iter().map(|c| (c.source.triangle, c.standing, c.order)).collect()
}

#[test]
fn edges_corners_and_limits_belong_to_the_triangle() {
    use Order::{First, Unknown};
    use Standing::{BareHit, BareMiss, Hit};
    let scene = scene(&[FLOOR], Affine::IDENTITY);
    let down = |x: f32, y: f32| Ray::new([x, y, 2.0], [0.0, 0.0, -1.0]);
    assert_eq!(standings(&scene, &down(0.25, 0.25)), [(0, Hit, First)]);
    assert_eq!(standings(&scene, &down(0.5, 0.5)), [(0, BareHit, First)]);
    assert_eq!(standings(&scene, &down(0.0, 0.0)), [(0, BareHit, First)]);
    assert_eq!(standings(&scene, &down(-1e-30, 0.5)), [(0, BareMiss, Unknown)]);
    assert_eq!(standings(&scene, &down(-1e-3, 0.5)), []);

    // The ends of the ray: the distance is exactly 2.
    let ray = down(0.25, 0.25);
    assert_eq!(standings(&scene, &ray.until(2.0)), [(0, BareHit, First)]);
    assert_eq!(standings(&scene, &ray.until(2f32.next_down())), []);
    assert_eq!(standings(&scene, &Ray { t_min: 2.0, ..ray }), [(0, BareHit, First)]);
    let on_it = Ray::new([0.25, 0.25, 0.0], [0.3, 0.1, 0.7]);
    assert_eq!(standings(&scene, &on_it), [(0, BareHit, First)]);
    let under_it = Ray::new([0.25, 0.25, -1e-40], [0.0, 0.0, -1.0]);
    assert_eq!(standings(&scene, &under_it), [(0, BareMiss, Unknown)]);
}

#[test]
fn equal_distances_are_told_from_nearly_equal_ones() {
    use Order::{Equal, First, Later, Rounded};
    // The same triangle twice, one a hair below it in f32, and one that only f64 tells apart from far away.
    let lowered = |z: f32| FLOOR.map(|p| [p[0], p[1], z]);
    let scene = scene(&[lowered(-1.0), FLOOR, FLOOR, lowered(-1e-9), lowered(-1e-30)], Affine::IDENTITY);
    let orders = |ray: &Ray| -> Vec<(u32, Order)> {
        standings(&scene, ray).iter().filter(|s| s.1 != Standing::BareMiss).map(|s| (s.0, s.2)).collect()
    };
    let mut found = orders(&Ray::new([0.25, 0.25, 2.0], [0.0, 0.0, -1.0]));
    found.sort_by_key(|f| f.0);
    assert_eq!(found, [(1, First), (2, Equal), (4, Rounded)]);
    let mut found = orders(&Ray::new([0.25, 0.25, -2.0], [0.0, 0.0, 2.0]));
    found.sort_by_key(|f| f.0);
    assert_eq!(found[0], (0, First));
    let close = Ray::new([0.25, 0.25, 1e-28], [0.0, 0.0, -1.0]);
    let found = orders(&close);
    assert_eq!(found.iter().find(|f| f.0 == 4), Some(&(4, Later)), "{found:?}");
}

#[test]
fn a_moved_instance_is_unsure_until_its_stored_matrix_is_known() {
    let turned = Affine { rows: [[0.6, -0.8, 0.0, 3.1], [0.8, 0.6, 0.0, -0.7], [0.0, 0.0, 1.0, 0.1]] };
    let scene = scene(&[FLOOR], turned);
    let corner = turned.transform_point([0.0; 3]).map(|v| v as f32);
    let ray = Ray::new([corner[0], corner[1], 4.0], [0.0, 0.0, -1.0]);
    assert_eq!(Oracle::new(&scene, &Executor::sequential()).trace(&ray).candidates[0].standing, Standing::Unsure);
    let world_to_object = Affine::from_f32(&turned.to_f32()).inverse().expect("an inverse").to_f32();
    let mut oracle = Oracle::new(&scene, &Executor::sequential());
    let map = Map::stored(Affine::from_f32(&world_to_object));
    oracle.places[0].exactly = Exactly::Stored { map, matrix: world_to_object };
    let decided = oracle.trace(&ray);
    assert!(!decided.has(Standing::Unsure), "{decided:?}");
    let expected = Line::mapped(&ray, &world_to_object).meet(FLOOR).is_some();
    assert_eq!(decided.first().is_some(), expected);
}

/// The nearest hit with every triangle asked exactly, no filter and no skipping.
fn exhaustive(scene: &Scene, ray: &Ray) -> Option<(Source, Ratio)> {
    let mut best: Option<(Source, Ratio)> = None;
    for (i, instance) in scene.instances.iter().enumerate() {
        let mesh = &scene.meshes[instance.mesh as usize];
        let matrix = instance.transform.inverse().expect("an inverse").to_f32();
        let line = Line::mapped(ray, &matrix);
        for triangle in 0..mesh.triangles.len() {
            let Some(meeting) = line.meet(mesh.corners(triangle)) else { continue };
            let in_range = meeting.t.compare(ray.t_min).is_some_and(Ordering::is_ge)
                && meeting.t.compare(ray.t_max).is_some_and(Ordering::is_le);
            if in_range && best.as_ref().is_none_or(|(_, t)| meeting.t < *t) {
                best = Some((Source { instance: i as u32, triangle: triangle as u32 }, meeting.t));
            }
        }
    }
    best
}

#[test]
fn filter_and_skipping_change_no_answer() {
    let mut hits = 0;
    for seed in 0..60 {
        let GridScene { scene, rays } = GridScene::new(seed, 60);
        let mut oracle = Oracle::new(&scene, &Executor::sequential());
        for (place, instance) in oracle.places.iter_mut().zip(&scene.instances) {
            let matrix = instance.transform.inverse().expect("an inverse").to_f32();
            if matches!(place.exactly, Exactly::Nothing) {
                place.exactly = Exactly::Stored { map: Map::stored(Affine::from_f32(&matrix)), matrix };
            }
        }
        for ray in &rays {
            let (answer, expected) = (oracle.trace(ray), exhaustive(&scene, ray));
            let first = answer.first().map(|c| c.source);
            assert_eq!(first, expected.as_ref().map(|(source, _)| *source), "seed {seed}: {ray:?} {answer:#?}");
            if let (Some(c), Some((_, t))) = (answer.first(), &expected) {
                assert!((c.t - t.to_f64()).abs() <= 1e-13 * c.t.abs(), "{c:?} {t:?}");
                hits += 1;
            }
        }
    }
    assert!(hits > 1000, "{hits}");
}
