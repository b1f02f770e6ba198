use super::sources::{Place, Sources};
use super::*;
use crate::build::{BuildOptions, Levels, NoProgress, Preset};
use crate::cache::Image;
use crate::compile::compile;
use crate::geom::Affine;
use crate::scene::{Instance, Mesh};
use crate::trace::rays::grid::GridScene;

fn build(scene: &Scene, levels: Levels) -> Image {
    let options = BuildOptions { levels, ..BuildOptions::preset(Preset::Draft) };
    let exec = Executor::sequential();
    let accel = compile(scene.clone(), &options, &exec, &NoProgress).expect("a tree");
    Image::new(&accel, &exec).expect("an image")
}

fn moved(scene: &Scene, by: [f64; 3]) -> Scene {
    let mut scene = scene.clone();
    scene.instances.iter_mut().for_each(|i| i.transform = Affine::translation(by).then_inner(&i.transform));
    scene
}

#[test]
fn a_file_of_its_own_model_is_right_however_it_is_laid_out() {
    for seed in 0..8 {
        let scene = GridScene::new(seed, 0).scene;
        for levels in [Levels::One, Levels::Two, Levels::Auto] {
            let placed = placed(&build(&scene, levels).view(), &scene, &Executor::sequential());
            assert!(placed.is_right() && placed.instanced_triangles > 0, "seed {seed}: {placed:?}");
        }
    }
}

#[test]
fn a_corner_that_no_rounding_moved_is_astray() {
    let scene = GridScene::new(3, 0).scene;
    for levels in [Levels::One, Levels::Two] {
        let mut image = build(&scene, levels);
        let corner = &mut image.triangles[5].v1[2];
        *corner += 1.0 + corner.abs() * 1e-3;
        let spoilt = placed(&image.view(), &scene, &Executor::sequential());
        assert!(!spoilt.is_right() && spoilt.astray > 0, "{spoilt:?}");
        let mut image = build(&scene, levels);
        image.triangles[5].prim = 999_999;
        assert!(placed(&image.view(), &scene, &Executor::sequential()).astray > 0);
    }
    let mut image = build(&scene, Levels::Two);
    image.instances[0].world_to_object[3] += 1.0;
    assert!(placed(&image.view(), &scene, &Executor::sequential()).astray > 0);
}

#[test]
fn rounding_that_takes_the_shape_is_told() {
    let point = |k: u32| [0.1 * (k % 11) as f32, 0.03 * (k % 4) as f32, 0.1 * (k / 11) as f32];
    let cell = |c: u32| {
        let a = c / 10 * 11 + c % 10;
        [[a, a + 1, a + 12], [a, a + 12, a + 11]]
    };
    let mesh = Mesh::new("sheet", (0..121).map(point).collect(), (0..100).flat_map(cell).collect()).expect("a mesh");
    let scene = moved(&Scene::of_mesh(mesh), [500_123.26, 7.7, -4_649_776.77]);
    let flat = placed(&build(&scene, Levels::One).view(), &scene, &Executor::sequential());
    assert!(!flat.is_right() && flat.astray == 0 && flat.instance == Some(0), "{flat:?}");
    assert!(flat.loss.share > 0.5 && (0.1..0.5).contains(&flat.loss.farthest), "{flat:?}");
    for levels in [Levels::Auto, Levels::Two] {
        let beside = placed(&build(&scene, levels).view(), &scene, &Executor::sequential());
        assert!(beside.is_right() && beside.instanced_triangles == 200 && beside.loss.farthest < 1e-6, "{beside:?}");
    }
    let read = Scene { rounding: crate::scene::Rounding { loss: flat.loss, ..Default::default() }, ..scene };
    assert!(!placed(&build(&read, Levels::Auto).view(), &read, &Executor::sequential()).is_right());
}

/// A mean over a mesh does not tell of a small part.
#[test]
fn small_parts_that_come_to_nothing_are_told() {
    let sheet = |cells: u32, size: f32, first: u32| {
        let side = cells + 1;
        let points = (0..side * side).map(move |k| [size * (k % side) as f32, 0.0, size * (k / side) as f32]);
        let cell = move |c: u32| {
            let a = first + c / cells * side + c % cells;
            [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
        };
        (points, (0..cells * cells).flat_map(cell))
    };
    let ((ground, coarse), (patch, fine)) = (sheet(70, 100.0, 0), sheet(8, 0.25, 71 * 71));
    let mesh = Mesh::new("ground", ground.chain(patch).collect(), coarse.chain(fine).collect()).expect("a mesh");
    let scene = moved(&Scene::of_mesh(mesh), [500_123.26, 7.7, -4_649_776.77]);
    let flat = placed(&build(&scene, Levels::One).view(), &scene, &Executor::sequential());
    assert!(flat.astray == 0 && flat.loss.share < Loss::MOST && flat.loss.gone > 0.001, "{flat:?}");
    assert!(!flat.is_right());
    // A matrix of floats moves all corners of a triangle alike.
    let beside = placed(&build(&scene, Levels::Two).view(), &scene, &Executor::sequential());
    assert!(beside.is_right() && beside.loss.gone == 0.0, "{beside:?}");
}

/// One mesh in a row of places, all of one node, as `EXT_mesh_gpu_instancing` puts it there.
fn row_of(count: u32) -> Scene {
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mesh = Mesh::new("leaf", corners, vec![[0, 1, 2], [0, 2, 3]]).expect("a mesh");
    let at = |i: u32| Instance {
        mesh: 0,
        transform: Affine::translation([3.0 * f64::from(i), 0.0, 0.0]),
        node: 7,
        name: String::new(),
    };
    Scene { instances: (0..count).map(at).collect(), ..Scene::of_mesh(mesh) }
}

/// Which of many copies a triangle is of is known without trying them all: no look is left here for that.
#[test]
fn copies_that_one_node_places_are_told_apart_in_their_order() {
    let scene = row_of(500);
    for levels in [Levels::One, Levels::Two] {
        let image = build(&scene, levels);
        let view = image.view();
        let sources = Sources::new(&view, &scene, 0);
        let places: Vec<Place<'_>> = match levels {
            Levels::One => vec![Place::new(None)],
            _ => view.instances.iter().map(|i| Place::new(Some(i))).collect(),
        };
        let mut seen = vec![0; scene.instances.len()];
        for (place, record) in places.iter().flat_map(|place| view.triangles.iter().map(move |t| (place, t))) {
            let (number, judged) = sources.nearest(record, place, &mut 0).expect("it is of the scene");
            assert!(!judged.astray, "{record:?}");
            seen[number as usize] += 1;
        }
        assert!(seen.iter().all(|count| *count == 2), "{levels:?}: {seen:?}");
    }
}

/// Other orders are found by looking around.
#[test]
fn copies_in_another_order_are_right_and_a_missing_one_is_astray() {
    let scene = row_of(60);
    let mut turned = scene.clone();
    turned.instances.reverse();
    let exec = Executor::sequential();
    assert!(placed(&build(&turned, Levels::One).view(), &scene, &exec).is_right());
    let mut other = scene.clone();
    other.instances[17].transform = Affine::translation([0.0, 5.0, 0.0]);
    let spoilt = placed(&build(&other, Levels::One).view(), &scene, &exec);
    assert_eq!((spoilt.instanced_triangles, spoilt.astray), (120, 2), "{spoilt:?}");
}
