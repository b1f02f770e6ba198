//! Scenes with instances: when there are two levels, what is left out, and where everything ends up in world space.

mod far;

use bvhc::build::{BuildError, BuildOptions, Executor, Levels, Method, NoProgress, Preset, Progress};
use bvhc::compile::{LaidOut, bytes_to_reserve, compile, compile_laid_out, decide_tree, lay_out, primitives_to_build};
use bvhc::geom::{Aabb, Affine};
use bvhc::scene::{Degenerate, GeometryError, Instance, Loss, Mesh, Part, Scene};
use bvhc::tree::Accel;
use std::sync::atomic::{AtomicU64, Ordering};

/// A strip of `count` triangles along x.
fn strip(name: &str, count: u32) -> Mesh {
    let corner = |i: u32| [(i / 2) as f32, (i % 2) as f32, 0.25 * i as f32];
    Mesh {
        name: name.into(),
        positions: (0..count + 2).map(corner).collect(),
        triangles: (0..count).map(|i| [i, i + 1, i + 2]).collect(),
        parts: vec![Part { triangle_count: count, prim_count: count, ..Part::default() }],
        ..Mesh::default()
    }
}

fn place(mesh: u32, node: u32, transform: Affine) -> Instance {
    Instance { mesh, transform, node, name: String::new() }
}

fn shift(x: f64) -> Affine {
    Affine { rows: [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] }
}

fn scene(meshes: Vec<Mesh>, instances: Vec<Instance>) -> Scene {
    Scene { meshes, instances, ..Scene::default() }
}

fn options(levels: Levels) -> BuildOptions {
    BuildOptions { levels, ..BuildOptions::preset(Preset::Draft) }
}

fn run(scene: Scene, levels: Levels) -> Result<Accel, BuildError> {
    compile(scene, &options(levels), &Executor::sequential(), &NoProgress)
}

#[test]
fn auto_takes_two_levels_only_for_a_mesh_in_several_places() {
    let meshes = || vec![strip("a", 20), strip("b", 9)];
    let once = scene(meshes(), vec![place(0, 1, shift(1.0)), place(1, 2, shift(50.0))]);
    let accel = run(once, Levels::Auto).unwrap();
    assert!(accel.tlas.is_none() && accel.blases.len() == 1 && accel.instances.is_empty());
    assert_eq!(accel.meshes[0].triangles.len(), 29);

    let twice = scene(meshes(), vec![place(0, 1, shift(1.0)), place(1, 2, shift(50.0)), place(0, 3, shift(90.0))]);
    let accel = run(twice, Levels::Auto).unwrap();
    assert_eq!((accel.blases.len(), accel.instances.len()), (2, 3));
    assert_eq!(accel.tlas.unwrap().refs.len(), 3);
}

#[test]
fn nothing_visible_is_an_empty_file() {
    for levels in [Levels::Auto, Levels::One, Levels::Two] {
        for empty in [
            Scene::default(),
            scene(vec![strip("unused", 5)], vec![]),
            scene(vec![Mesh::default()], vec![place(0, 0, shift(1.0)), place(0, 1, shift(2.0))]),
        ] {
            let accel = run(empty, levels).unwrap();
            assert!(accel.blases.is_empty() && accel.tlas.is_none());
        }
    }
}

#[test]
fn unused_and_empty_meshes_are_left_out_and_the_rest_renumbered() {
    let meshes = vec![strip("unused", 3), Mesh::default(), strip("kept", 7)];
    let accel = run(scene(meshes, vec![place(1, 0, shift(0.0)), place(2, 5, shift(4.0))]), Levels::Two).unwrap();
    assert_eq!(accel.meshes.len(), 1);
    assert_eq!(accel.meshes[0].name, "kept");
    assert_eq!((accel.instances.len(), accel.instances[0].mesh, accel.instances[0].node), (1, 0, 5));
}

#[test]
fn a_single_instance_at_the_identity_is_left_as_it_is() {
    let accel = run(scene(vec![strip("a", 12)], vec![place(0, 3, Affine::IDENTITY)]), Levels::Auto).unwrap();
    let (mesh, original) = (&accel.meshes[0], strip("a", 12));
    assert_eq!(
        (&mesh.positions, &mesh.triangles, &mesh.parts),
        (&original.positions, &original.triangles, &original.parts)
    );
    assert!(mesh.source_prims.is_empty());
}

#[test]
fn baking_moves_positions_and_keeps_source_numbers_and_parts() {
    let mut mesh = strip("a", 4);
    mesh.source_prims = vec![0, 2, 3, 9];
    mesh.parts = vec![
        Part { source_part: 0, triangle_count: 3, prim_count: 4, ..Part::default() },
        Part { source_part: 1, first_triangle: 3, triangle_count: 1, first_prim: 4, prim_count: 6, ..Part::default() },
    ];
    let mirror = Affine { rows: [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
    let accel =
        run(scene(vec![mesh.clone()], vec![place(0, 7, shift(100.0)), place(0, 8, mirror)]), Levels::One).unwrap();
    let baked = &accel.meshes[0];
    assert_eq!(baked.source_prims, [0, 2, 3, 9, 0, 2, 3, 9]);
    assert_eq!(
        baked.corners(5),
        mesh.corners(1).map(|p| [-p[0], p[1], p[2]]),
        "corners keep their order under mirroring"
    );
    assert_eq!(baked.corners(0), mesh.corners(0).map(|p| [p[0] + 100.0, p[1], p[2]]));
    let parts: Vec<_> = baked
        .parts
        .iter()
        .map(|p| (p.baked_node, p.source_part, p.first_triangle, p.triangle_count, p.first_prim))
        .collect();
    assert_eq!(parts, [(Some(7), 0, 0, 3, 0), (Some(7), 1, 3, 1, 4), (Some(8), 0, 4, 3, 0), (Some(8), 1, 7, 1, 4)]);
}

#[test]
fn the_top_level_holds_the_boxes_of_the_transforms_as_written() {
    let third = Affine { rows: [[1.0 / 3.0, 0.1, 0.0, 7.0], [0.0, 0.7, 0.2, 1e5], [0.3, 0.0, 0.9, -2.0]] };
    let accel =
        run(scene(vec![strip("a", 30)], vec![place(0, 1, third), place(0, 2, shift(-5.0))]), Levels::Auto).unwrap();
    let tlas = accel.tlas.unwrap();
    for node in tlas.nodes.iter().enumerate().filter(|(i, n)| *i != 1 && n.is_leaf()).map(|(_, n)| n) {
        let union = tlas.refs[node.first as usize..][..node.count as usize].iter().fold(Aabb::EMPTY, |b, &r| {
            let written = Affine::from_f32(&accel.instances[r as usize].transform.to_f32());
            b.union(written.transform_box(&accel.blases[0].bounds()))
        });
        assert_eq!(node.bounds(), union);
    }
}

/// Both meshes say that they are part 0 of mesh 0, and their triangles have the same numbers.
#[test]
fn parts_that_were_numbered_alike_are_told_apart() {
    let meshes = || vec![strip("a", 20), strip("b", 9)];
    let parts = |accel: &Accel| -> Vec<(u32, u32)> {
        let parts = accel.meshes.iter().flat_map(|mesh| &mesh.parts);
        parts.map(|part| (part.source_mesh, part.source_part)).collect()
    };
    for levels in [Levels::One, Levels::Two] {
        let exec = Executor::sequential();
        let accel = run(scene(meshes(), vec![place(0, 1, shift(1.0)), place(1, 1, shift(50.0))]), levels).unwrap();
        assert_eq!(parts(&accel), [(0, 0), (1, 0)]);
        let image = bvhc::cache::Image::new(&accel, &exec).unwrap();
        let report = bvhc::cache::check::check_image(&image, &Default::default(), &exec);
        assert!(report.is_clean(), "{:?}", report.findings);

        // One mesh in two places is one mesh.
        let accel = run(scene(meshes(), vec![place(0, 1, shift(1.0)), place(0, 2, shift(50.0))]), levels).unwrap();
        assert!(parts(&accel).iter().all(|part| *part == (0, 0)));
    }
}

/// What is built of meshes made by hand can be written, whatever they say of themselves.
#[test]
fn equal_parts_and_places_without_a_node_are_told_apart() {
    let none = Instance::NO_NODE;
    // Two parts of one name whose numbers descend, and one of another mesh of the source.
    let mut parts = strip("parts", 12);
    let claim = |first_triangle, source_mesh, first_prim| Part {
        first_triangle,
        triangle_count: 4,
        source_mesh,
        first_prim,
        prim_count: 4,
        ..Part::default()
    };
    parts.parts = vec![claim(0, 0, 4), claim(4, 0, 0), claim(8, 5, 2)];
    parts.source_prims = vec![4, 5, 6, 7, 0, 1, 2, 3, 2, 3, 4, 5];
    let alike = || vec![strip("same", 5), strip("same", 5), strip("same", 5)];
    let at = |mesh, node, x| place(mesh, node, shift(x));
    for (name, scene) in [
        ("parts in another order", scene(vec![parts], vec![at(0, none, 0.0)])),
        ("equal meshes without nodes", scene(alike(), vec![at(0, none, 0.0), at(1, 7, 20.0), at(2, none, 40.0)])),
        ("one mesh twice", scene(vec![strip("a", 5)], vec![at(0, none, 0.0), at(0, none, 20.0)])),
    ] {
        for levels in [Levels::One, Levels::Two] {
            let exec = Executor::sequential();
            let accel = run(scene.clone(), levels).unwrap();
            let image = bvhc::cache::Image::new(&accel, &exec).unwrap();
            let report = bvhc::cache::check::check_image(&image, &Default::default(), &exec);
            assert!(report.is_clean(), "{name}, {levels:?}: {:?}", report.findings);
        }
    }
}

/// No numbering of parts would make these triangles lead back to one triangle each.
#[test]
fn parts_that_claim_the_same_triangles_are_refused() {
    let mut twice = strip("twice", 8);
    let claim = |first_triangle| Part { first_triangle, triangle_count: 4, prim_count: 4, ..Part::default() };
    (twice.parts, twice.source_prims) = (vec![claim(0), claim(4)], vec![0, 1, 2, 3, 0, 1, 2, 3]);
    let refused = GeometryError::PartNumbers { mesh: 0, part: 1, other: 0, number: 0 };
    assert_eq!(twice.validate(0, &Executor::sequential()), Err(refused.clone()));
    let error = run(scene(vec![twice.clone()], vec![place(0, 1, shift(0.0))]), Levels::Auto).unwrap_err();
    assert_eq!(error, BuildError::Geometry(refused));

    // Copies that a node tells from each other are sound.
    twice.parts.iter_mut().zip([3, 4]).for_each(|(part, node)| part.baked_node = Some(node));
    assert_eq!(twice.validate(0, &Executor::sequential()), Ok(()));
}

#[test]
fn what_was_laid_out_and_changed_is_looked_at_again() {
    let lay = |levels| {
        let two = scene(vec![strip("a", 20), strip("b", 9)], vec![place(0, 0, shift(1.0)), place(1, 1, shift(50.0))]);
        lay_out(two, &options(levels), &Executor::sequential()).unwrap()
    };
    let refused = |laid: LaidOut| {
        compile_laid_out(laid, &options(Levels::Auto), &Executor::sequential(), &NoProgress).unwrap_err()
    };
    for levels in [Levels::One, Levels::Two] {
        let mut laid = lay(levels);
        laid.meshes[0].triangles[3][1] = 4_000_000;
        let error = refused(laid);
        assert!(matches!(error, BuildError::Geometry(GeometryError::IndexOutOfRange { triangle: 3, .. })), "{error:?}");
    }
    let mut laid = lay(Levels::Two);
    laid.instances.as_mut().unwrap()[1].mesh = 2;
    assert!(matches!(refused(laid), BuildError::Geometry(GeometryError::MeshOutOfRange { instance: 1, .. })));
    let mut laid = lay(Levels::Two);
    laid.instances = None;
    assert_eq!(refused(laid), BuildError::OneLevel { meshes: 2 });

    let mut unsound = strip("a", 3);
    unsound.positions.truncate(2);
    let decided = decide_tree(&unsound, &options(Levels::Auto), &Executor::sequential(), &NoProgress);
    assert!(matches!(decided, Err(BuildError::Geometry(_))));
}

#[test]
fn what_cannot_be_placed_is_refused() {
    let far =
        |levels| run(scene(vec![strip("a", 30)], vec![place(0, 1, shift(1e39)), place(0, 2, shift(0.0))]), levels);
    assert_eq!(far(Levels::One).unwrap_err(), BuildError::OutOfRange { instance: 0, mesh: 0 });
    assert_eq!(far(Levels::Two).unwrap_err(), BuildError::OutOfRange { instance: 0, mesh: 0 });
    let stray = run(scene(vec![strip("a", 3)], vec![place(4, 1, shift(0.0))]), Levels::Auto);
    assert_eq!(
        stray.unwrap_err(),
        BuildError::Geometry(GeometryError::MeshOutOfRange { instance: 0, mesh: 4, meshes: 1 })
    );
    let bad = BuildOptions { bins: 0, ..options(Levels::Auto) };
    let refused = compile(Scene::default(), &bad, &Executor::sequential(), &NoProgress);
    assert!(matches!(refused, Err(BuildError::Option { option: "bins", .. })));
}

#[test]
fn meshes_with_and_without_the_numbers_of_vertices_do_not_mix() {
    let mut numbered = strip("numbered", 3);
    numbered.vertices.clone_from(&numbered.triangles);
    let both =
        |second: Mesh| scene(vec![numbered.clone(), second], vec![place(0, 0, shift(0.0)), place(1, 1, shift(9.0))]);
    for levels in [Levels::Auto, Levels::One, Levels::Two] {
        assert!(matches!(run(both(strip("plain", 2)), levels), Err(BuildError::NoVertices { .. })));
        assert!(run(both(numbered.clone()), levels).is_ok());
        assert!(run(both(Mesh::default()), levels).is_ok(), "without triangles there is nothing to number");
    }
}

#[test]
fn too_many_instanced_triangles_are_refused_before_memory_is_asked_for() {
    let instances = (0..40_000).map(|i| place(0, i, shift(f64::from(i)))).collect();
    match run(scene(vec![strip("a", 60_000)], instances), Levels::One) {
        Err(BuildError::TooLarge { needed, .. }) => assert_eq!(needed, 2_400_000_000),
        other => panic!("{other:?}"),
    }
}

#[derive(Default)]
struct Counter {
    done: AtomicU64,
    /// Cancel from so many finished primitives on.
    limit: Option<u64>,
}

impl Progress for Counter {
    fn is_cancelled(&self) -> bool {
        self.limit.is_some_and(|limit| self.done.load(Ordering::Relaxed) >= limit)
    }

    fn advance(&self, primitives: u64) {
        self.done.fetch_add(primitives, Ordering::Relaxed);
    }
}

#[test]
fn progress_adds_up_and_cancelling_ends_the_build() {
    for (method, jobs, levels) in [
        (Method::Binned, 1, Levels::One),
        (Method::Binned, 2, Levels::Two),
        (Method::Sbvh, 2, Levels::One),
        (Method::Sbvh, 1, Levels::Two),
        (Method::Sweep, 1, Levels::One),
        (Method::Sweep, 2, Levels::Two),
        (Method::Bonsai, 1, Levels::Two),
        (Method::Bonsai, 2, Levels::One),
    ] {
        let exec = Executor::new(jobs).unwrap();
        let options = BuildOptions { method, ..options(levels) };
        let make = || {
            let meshes = vec![strip("a", 20_001), strip("b", 1), strip("unused", 9)];
            scene(meshes, vec![place(0, 0, shift(0.0)), place(0, 1, shift(3.0)), place(1, 2, shift(0.5))])
        };
        let counter = Counter::default();
        let total = primitives_to_build(&make(), &options);
        assert_eq!(total, if levels == Levels::One { 40_003 } else { 20_002 });
        compile(make(), &options, &exec, &counter).unwrap();
        assert_eq!(counter.done.into_inner(), total);

        for limit in [0, 5_000] {
            let stop = Counter { limit: Some(limit), ..Counter::default() };
            assert_eq!(compile(make(), &options, &exec, &stop).unwrap_err(), BuildError::Cancelled);
        }
    }
}

#[test]
fn threads_change_nothing_in_a_two_level_scene() {
    let make = || {
        let meshes = (1..40).map(|i| strip("m", i * i * 7)).collect();
        let instances = (0..200u32).map(|i| place(i * 31 % 39, i, shift(f64::from(i * 17 % 97)))).collect();
        scene(meshes, instances)
    };
    let build = |jobs| compile(make(), &options(Levels::Auto), &Executor::new(jobs).unwrap(), &NoProgress).unwrap();
    let (one, three) = (build(1), build(3));
    assert!(one.blases == three.blases && one.tlas == three.tlas);
}

#[test]
fn flattening_is_priced_before_it_is_done() {
    let many = scene(vec![strip("a", 1000)], (0..1_000_000).map(|i| place(0, i, shift(f64::from(i)))).collect());
    let [flat, apart] = [Levels::One, Levels::Two].map(|levels| bytes_to_reserve(&many, &options(levels)));
    let (triangle, position, reference) = (16, 12, 32);
    assert!(flat >= 1_000_000 * (1000 * (triangle + reference) + 1002 * position), "{flat}");
    assert_eq!(apart, 1000 * reference);
    let alone = scene(vec![strip("a", 1000)], vec![place(0, 0, Affine::IDENTITY)]);
    assert_eq!(bytes_to_reserve(&alone, &options(Levels::One)), 1000 * reference);
}
