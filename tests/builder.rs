//! What the library takes from programs and what it refuses: nothing behind it writes a file that a rule forbids.

use bvhc::build::{BuildError, BuildOptions, Levels, Method, NoProgress, Preset};
use bvhc::cache::{CacheError, Image, OpenOptions, Validation, WriteOptions, to_bytes};
use bvhc::compile::{build_tree, compile};
use bvhc::exec::Executor;
use bvhc::geom::Affine;
use bvhc::scene::{GeometryError, Instance, Mesh, Part, Scene};
use bvhc::trace::BatchError;
use bvhc::tree::{Accel, Tree};
use bvhc::{Build, Cache, Hit, Ray};

const POSITIONS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 1.0]];
const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [1, 3, 2]];

fn mesh() -> Mesh {
    Mesh::new("m", POSITIONS.to_vec(), TRIANGLES.to_vec()).unwrap()
}

fn compiled(scene: Scene) -> Result<Accel, BuildError> {
    compile(scene, &BuildOptions::preset(Preset::Draft), &Executor::sequential(), &NoProgress)
}

/// A mesh that was sound and was changed afterwards, as every field allows.
fn spoilt(change: impl Fn(&mut Mesh)) -> GeometryError {
    let mut mesh = mesh();
    change(&mut mesh);
    let by_tree = build_tree(&mesh, &BuildOptions::preset(Preset::Draft), &Executor::sequential(), &NoProgress);
    let by_scene = compiled(Scene::of_mesh(mesh.clone()));
    let by_image = Image::of_tree(&mesh, &Tree::default(), &Executor::sequential());
    assert!(matches!(by_image, Err(CacheError::Unwritable { .. })), "{by_image:?}");
    match (by_tree, by_scene) {
        // As text: a NaN is unlike itself.
        (Err(BuildError::Geometry(a)), Err(BuildError::Geometry(b))) if a.to_string() == b.to_string() => a,
        other => panic!("{other:?}"),
    }
}

#[test]
fn geometry_that_no_file_can_hold_is_refused_by_every_build() {
    assert!(matches!(
        spoilt(|m| m.triangles[1][2] = 4),
        GeometryError::IndexOutOfRange { mesh: 0, triangle: 1, index: 4, positions: 4 }
    ));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let error = spoilt(|m| m.positions[3][1] = bad);
        assert!(matches!(error, GeometryError::NotFinite { triangle: 1, index: 3, .. }), "{error:?}");
    }
    assert!(matches!(spoilt(|m| m.parts[0].triangle_count = 1), GeometryError::Parts { expected: 2, found: 1, .. }));
    assert!(matches!(spoilt(|m| m.parts[0].first_triangle = 1), GeometryError::Parts { expected: 0, found: 1, .. }));
    assert!(matches!(spoilt(|m| m.source_prims = vec![0]), GeometryError::SourcePrims { numbers: 1, .. }));
    assert!(matches!(
        spoilt(|m| m.source_prims = vec![1, 1]),
        GeometryError::SourceNumber { triangle: 1, number: 1, .. }
    ));
    assert!(matches!(
        spoilt(|m| m.parts[0].prim_count = 1),
        GeometryError::SourceNumber { triangle: 1, number: 1, .. }
    ));
    // A position that no triangle uses may be anything.
    let unused = Mesh::new("m", [&POSITIONS[..], &[[f32::NAN; 3]]].concat(), TRIANGLES.to_vec());
    assert!(compiled(Scene::of_mesh(unused.unwrap())).is_ok());
}

#[test]
fn a_mesh_that_was_added_and_not_placed_is_told() {
    let mut build = Build::new(&POSITIONS, &TRIANGLES).unwrap();
    let second = build.add_mesh("second", &POSITIONS, &TRIANGLES).unwrap();
    let error = build.clone().run().unwrap_err();
    assert_eq!(error, BuildError::Unplaced { mesh: second, name: "second".into() });
    build.add_instance(second, Affine::translation([9.0, 0.0, 0.0])).unwrap();
    assert_eq!(build.run().unwrap().view().triangles.len(), 2 * TRIANGLES.len());
}

#[test]
fn a_preset_and_options_exclude_each_other_in_either_order() {
    let build = || Build::new(&POSITIONS, &TRIANGLES).unwrap();
    let options = BuildOptions { max_leaf: 1, ..BuildOptions::preset(Preset::Draft) };
    let both = [
        build().preset(Preset::Best).options(options.clone()),
        build().options(options.clone()).preset(Preset::Best),
        // Not even where they say the same.
        build().options(BuildOptions::preset(Preset::Best)).preset(Preset::Best),
    ];
    for build in both {
        assert_eq!(build.run().unwrap_err(), BuildError::TwoRecipes { preset: "best" });
    }
    // Of the same kind the last one holds.
    let is_search = |build: Build| !build.run().unwrap().notes().is_empty();
    assert!(!is_search(build().options(BuildOptions::default()).options(options)));
    assert!(is_search(build().preset(Preset::Draft).preset(Preset::Best)));
}

#[test]
fn options_that_the_method_does_not_read_are_refused() {
    let build = |options| Build::new(&POSITIONS, &TRIANGLES).unwrap().options(options).run();
    let sweep = BuildOptions { method: Method::Sweep, ..BuildOptions::preset(Preset::Draft) };
    // Draft's 32 bins mean nothing to sweep and came along.
    assert!(build(sweep.clone()).is_ok());
    for (options, method) in
        [(BuildOptions { bins: 31, ..sweep }, "sweep"), (BuildOptions { bins: 31, ..BuildOptions::default() }, "auto")]
    {
        let error = build(options).unwrap_err();
        let BuildError::NotRead { option, value, method: by, readers } = &error else { panic!("{error:?}") };
        assert_eq!((*option, value.as_str(), *by, readers.as_str()), ("bins", "31", method, "binned, sbvh"));
    }
}

#[test]
fn instances_that_lead_nowhere_are_refused() {
    let place = |mesh, transform| Instance { mesh, transform, node: 0, name: String::new() };
    let scene = |instance| Scene::new(vec![mesh()], vec![instance]);
    let error = scene(place(1, Affine::IDENTITY)).unwrap_err();
    assert_eq!(error, GeometryError::MeshOutOfRange { instance: 0, mesh: 1, meshes: 1 });
    let singular = Affine { rows: [[0.0; 4]; 3] };
    assert!(matches!(scene(place(0, singular)).unwrap_err(), GeometryError::Transform { instance: 0, .. }));
    let mut build = Build::empty();
    let number = build.add_mesh("m", &POSITIONS, &TRIANGLES).unwrap();
    assert!(matches!(build.add_instance(number + 1, Affine::IDENTITY), Err(GeometryError::MeshOutOfRange { .. })));
    assert!(matches!(build.add_instance(number, singular), Err(GeometryError::Transform { instance: 0, .. })));
    assert!(Build::new(&POSITIONS, &[[0, 1, 9]]).is_err());

    // Its determinant is 2⁻⁴⁸, of terms near 1 that cancel.
    let u = f64::from(1f32.next_down());
    let needle = Affine { rows: [[1.0, 1.0, 1.0, 0.0], [1.0, u, 1.0, 0.0], [1.0, 1.0, u, 0.0]] };
    assert!(matches!(scene(place(0, needle)).unwrap_err(), GeometryError::Transform { instance: 0, .. }));
    assert!(matches!(build.add_instance(number, needle), Err(GeometryError::Transform { instance: 0, .. })));
}

#[test]
fn no_writer_writes_what_a_rule_forbids() {
    let exec = Executor::sequential();
    let accel = compiled(Scene::of_mesh(mesh())).unwrap();
    let image = Image::new(&accel, &exec).unwrap();
    let written = |image: &Image| to_bytes(image, &Default::default(), &WriteOptions::default(), &exec);
    assert!(written(&image).is_ok());
    type Spoil<'a> = &'a dyn Fn(&mut Image);
    let broken: [(&str, Spoil); 4] = [
        ("E0417", &|i| i.triangles[0].v1[2] = f32::NAN),
        ("E0412", &|i| i.nodes[0].min[0] = 9.0),
        ("E0311", &|i| i.blases[0].ref_count += 1),
        ("E0415", &|i| i.triangles[0].prim = 77),
    ];
    for (rule, spoil) in broken {
        let mut image = image.clone();
        spoil(&mut image);
        let error = written(&image).unwrap_err();
        assert!(matches!(error, CacheError::Unwritable { .. }) && error.to_string().contains(rule), "{rule}: {error}");
    }
    // A tree or a top level over things that are not there has no image at all.
    let refs = |refs| Accel { blases: vec![Tree { refs, ..accel.blases[0].clone() }], ..accel.clone() };
    assert!(Image::new(&refs(vec![0, 2]), &exec).is_err());
    let top = Accel { tlas: Some(Tree { refs: vec![3], ..Tree::default() }), ..accel.clone() };
    assert!(Image::new(&top, &exec).is_err());
    let nameless = Accel { meshes: vec![Mesh { parts: Vec::<Part>::new(), ..mesh() }], ..accel };
    assert!(Image::new(&nameless, &exec).is_err());
}

#[test]
fn what_is_built_is_traced_written_and_opened_alike() {
    let built = Build::new(&POSITIONS, &TRIANGLES).unwrap().preset(Preset::Best).threads(2).run().unwrap();
    let rays: Vec<Ray> =
        (0..5000).map(|i| Ray::new([(i % 71) as f32 / 70.0, (i / 71) as f32 / 70.0, 5.0], [0.0, 0.0, -1.0])).collect();
    let mut hits: Vec<Option<Hit>> = vec![None; rays.len()];
    built.closest_hits(&rays, &mut hits).unwrap();
    assert!(hits.iter().filter(|h| h.is_some()).count() > 1000);

    let bytes = built.to_bytes().unwrap();
    let cache = Cache::from_bytes(&bytes, &OpenOptions::default()).unwrap();
    let mut again = vec![None; rays.len()];
    cache.closest_hits(&rays, &mut again).unwrap();
    assert_eq!(hits, again);
    for (ray, hit) in rays.iter().zip(&hits) {
        assert_eq!((built.closest_hit(ray), built.any_hit(ray)), (Ok(*hit), Ok(hit.is_some())));
    }
    // Threads do not change a byte.
    let alone = Build::new(&POSITIONS, &TRIANGLES).unwrap().preset(Preset::Best).threads(1).run().unwrap();
    assert_eq!(alone.to_bytes().unwrap(), bytes);
}

#[test]
fn rays_and_places_for_hits_are_as_many() {
    let built = Build::new(&POSITIONS, &TRIANGLES).unwrap().run().unwrap();
    let bytes = built.to_bytes().unwrap();
    let cache = Cache::from_bytes(&bytes, &OpenOptions::default()).unwrap();
    let meets = Ray::new([0.2, 0.2, 5.0], [0.0, 0.0, -1.0]);
    let misses = Ray::new([9.0, 9.0, 5.0], [0.0, 0.0, -1.0]);
    let stale = built.closest_hit(&meets).unwrap();
    for (rays, places) in [(0, 1), (1, 0), (2, 1), (1, 2), (3000, 2999), (2999, 3000)] {
        let mut hits = vec![stale; places];
        for answer in
            [built.closest_hits(&vec![misses; rays], &mut hits), cache.closest_hits(&vec![misses; rays], &mut hits)]
        {
            assert_eq!(answer, Err(BatchError::Lengths { rays, hits: places }));
            assert!(answer.unwrap_err().to_string().contains(&format!("{rays} rays and places for {places} hits")));
        }
        assert!(hits.iter().all(|hit| *hit == stale), "nothing is touched");
    }
    assert_eq!(cache.closest_hits(&[], &mut []), Ok(()));
    let mut hits = [None, stale];
    assert_eq!(cache.closest_hits(&[meets, misses], &mut hits), Ok(()));
    assert_eq!(hits, [stale, None]);
}

#[test]
fn a_slice_is_opened_where_it_lies() {
    let bytes = Build::new(&POSITIONS, &TRIANGLES).unwrap().run().unwrap().to_bytes().unwrap();
    let mut room = vec![0u64; bytes.len() / 8 + 2];
    let room: &mut [u8] = bytemuck::cast_slice_mut(&mut room);
    let options = OpenOptions { validation: Validation::Tree, ..OpenOptions::default() };
    for shift in [0, 8, 3] {
        room[shift..shift + bytes.len()].copy_from_slice(&bytes);
        let given = &room[shift..shift + bytes.len()];
        let cache = Cache::from_slice(given, &options).unwrap();
        let lies_inside = given.as_ptr_range().contains(&cache.nodes().as_ptr().cast());
        assert_eq!(lies_inside, shift % 8 == 0, "borrowed where it is aligned, copied where it is not");
        assert!(cache.any_hit(&Ray::new([0.2, 0.2, 5.0], [0.0, 0.0, -1.0])).unwrap());
    }
    assert!(Cache::from_slice(&bytes[..bytes.len() - 1], &options).is_err());
}

/// What would break a rule in the file is refused at the door.
#[test]
fn no_scene_becomes_a_file_that_a_rule_forbids() {
    let of = |mesh: Mesh, nodes: &[u32]| {
        let placed = |node: &u32| Instance { mesh: 0, transform: Affine::IDENTITY, node: *node, name: String::new() };
        let scene = Scene { meshes: vec![mesh], instances: nodes.iter().map(placed).collect(), ..Scene::default() };
        let options = BuildOptions { levels: Levels::Two, ..BuildOptions::preset(Preset::Draft) };
        Build::of_scene(scene).unwrap().options(options).run().unwrap().to_bytes()
    };
    assert!(of(mesh(), &[1, 2]).is_ok());
    let mut torn = mesh();
    torn.vertices = vec![[0, 1, 2], [0, 3, 2]]; // vertex 0 would stand in two places
    let mut alike = mesh();
    let part = Part { triangle_count: 1, prim_count: 1, ..Part::default() };
    alike.source_prims = vec![0, 0];
    alike.parts = vec![part.clone(), Part { first_triangle: 1, ..part }];
    let refused = Build::of_scene(Scene { meshes: vec![torn], ..Scene::default() });
    assert!(matches!(refused, Err(GeometryError::VertexPlaces { mesh: 0, vertex: 0, triangles: [0, 1], .. })));
    let refused = Build::of_scene(Scene { meshes: vec![alike], ..Scene::default() });
    assert!(matches!(refused, Err(GeometryError::PartNumbers { mesh: 0, part: 1, other: 0, number: 0 })));
    assert!(Executor::new(Executor::MOST_THREADS + 1).is_err());
    let nowhere = Instance { mesh: 9, transform: Affine::IDENTITY, node: 0, name: String::new() };
    assert_eq!(Scene { instances: vec![nowhere], ..Scene::default() }.instanced_triangles(), 0);
}

/// A model that a program adds to is no longer what `bvhc build` makes of it.
#[test]
fn a_changed_model_is_not_up_to_date() {
    let folder = tempfile::tempdir().unwrap();
    let (model, path) = (folder.path().join("a.obj"), folder.path().join("a.bvhc"));
    std::fs::write(&model, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let inputs = |build: Build| {
        build.run().unwrap().write(&path).unwrap();
        Cache::open(&path).unwrap().meta().unwrap().dependencies.len()
    };
    assert_eq!(inputs(Build::of_model(&model).unwrap()), 1);
    let mut more = Build::of_model(&model).unwrap();
    let mesh = more.add_mesh("more", &POSITIONS, &TRIANGLES).unwrap();
    assert_eq!(more.add_instance(mesh, Affine::translation([5.0, 0.0, 0.0])).unwrap(), 1, "node 0 is the model's");
    assert_eq!(inputs(more), 0);
}

#[test]
fn a_hit_tells_the_place_whatever_the_levels_are() {
    for (levels, shift) in [(Levels::One, 9.0), (Levels::Two, 9.0), (Levels::Auto, 1e7)] {
        let mut build = Build::empty();
        // What is empty takes a number as well.
        let nothing = build.add_mesh("nothing", &[], &[]).unwrap();
        let mesh = build.add_mesh("mesh", &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]).unwrap();
        let first = build.add_instance(nothing, Affine::IDENTITY).unwrap();
        let places = [1.0, 2.0].map(|k| build.add_instance(mesh, Affine::translation([k * shift, 0.0, 0.0])).unwrap());
        assert_eq!((first, places), (0, [1, 2]));
        let options = BuildOptions { levels, ..BuildOptions::preset(Preset::Draft) };
        let built = build.options(options).run().unwrap();
        let bytes = built.to_bytes().unwrap();
        let cache = Cache::from_bytes(&bytes, &OpenOptions::default()).unwrap();
        for (place, k) in places.into_iter().zip([1.0, 2.0]) {
            let ray = Ray::new([(k * shift) as f32 + 0.25, 0.25, -3.0], [0.0, 0.0, 1.0]);
            let hit = built.closest_hit(&ray).unwrap().expect("a hit");
            assert_eq!((built.node(&hit), cache.node(&hit)), (Some(place), Some(place)), "{levels:?}");
        }
    }
}

#[test]
fn what_is_lost_on_the_way_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("a.obj");
    std::fs::write(&model, "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let nothing = Build::of_model(&model).unwrap().run();
    assert!(matches!(nothing, Err(BuildError::NothingLeft { read: 1, placed: 0 })), "{nothing:?}");
    std::fs::write(&model, "v 0 0 0\nv nan 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 3\nf 1 3 4\n").unwrap();
    let built = Build::of_model(&model).unwrap().run().unwrap();
    assert_eq!((built.read_report().non_finite_triangles, built.placing().collapsed), (1, 0));

    // Far out, rounding leaves nothing of small triangles in one tree.
    let mut build = Build::empty();
    let mesh = build.add_mesh("small", &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]).unwrap();
    for k in 0..10 {
        let rows = [[1e-6, 0.0, 0.0, 1000.0 * f64::from(k)], [0.0, 1e-6, 0.0, 0.0], [0.0, 0.0, 1e-6, 0.0]];
        build.add_instance(mesh, Affine { rows }).unwrap();
    }
    let options = BuildOptions { levels: Levels::One, ..BuildOptions::preset(Preset::Draft) };
    assert_eq!(build.options(options).run().unwrap().placing().collapsed, 9);
}

/// Nothing passes the door that no file could hold.
#[test]
fn what_cannot_be_stored_is_refused_at_the_door() {
    let mut build = Build::new(&POSITIONS, &TRIANGLES).unwrap();
    for scale in [1e-39, 1e-40, 1e-300] {
        let small = Affine { rows: [[scale, 0.0, 0.0, 0.0], [0.0, scale, 0.0, 0.0], [0.0, 0.0, scale, 0.0]] };
        let refused = build.add_instance(0, small);
        let Err(GeometryError::Transform { instance: 1, determinant, largest }) = refused else {
            panic!("{scale}: {refused:?}")
        };
        assert_eq!((determinant, largest), (scale * scale * scale, scale));
    }
    let exec = Executor::sequential();
    let refused = |change: fn(&mut Mesh)| {
        let mut mesh = mesh();
        change(&mut mesh);
        mesh.validate(0, &exec).unwrap_err()
    };
    let error = refused(|mesh| mesh.remainders = vec![[0.0, f32::NAN, 0.0]; mesh.positions.len()]);
    assert!(matches!(error, GeometryError::Remainder { mesh: 0, index: 0, .. }), "{error}");
    let error = refused(|mesh| (mesh.parts, mesh.source_prims) = (Vec::new(), vec![0, u32::MAX]));
    assert_eq!(error, GeometryError::SourceNumber { mesh: 0, triangle: 1, number: u32::MAX });

    let tree = bvhc::compile::build_tree(&mesh(), &BuildOptions::default(), &exec, &NoProgress).unwrap();
    let accel = Accel {
        meshes: vec![mesh(), mesh()],
        blases: vec![tree.clone()],
        tlas: None,
        instances: Vec::new(),
        notes: Vec::new(),
    };
    assert!(bvhc::cache::Image::new(&accel, &exec).is_err(), "a mesh without its tree");
    let mut nodes = tree.nodes;
    nodes[0] = bvhc::tree::Node::inner(nodes[0].bounds(), 0);
    assert!(bvhc::tree::refit(&mut nodes, |_| [[0.0; 3]; 3]).is_err(), "a node below itself");
}

#[test]
fn options_out_of_their_range_are_refused_before_anything_is_built() {
    type Change = fn(&mut BuildOptions);
    let changes: [(&str, Change); 8] = [
        ("adapt", |o| o.adapt = u32::MAX),
        ("reinsert", |o| o.reinsert = u32::MAX),
        ("max-leaf", |o| o.max_leaf = 1000),
        ("max-leaf", |o| o.max_leaf = 0),
        ("bins", |o| o.bins = 1000),
        ("split-alpha", |o| o.split_alpha = f32::NAN),
        ("presplit", |o| o.presplit = 1e6),
        ("sah-trav", |o| o.traversal_cost = f32::NAN),
    ];
    for (name, change) in changes {
        let method = if name == "presplit" { Method::Binned } else { Method::Sbvh };
        let mut options = BuildOptions { method, ..BuildOptions::preset(Preset::Balanced) };
        change(&mut options);
        let refused = Build::new(&POSITIONS, &TRIANGLES).unwrap().options(options).run().unwrap_err();
        assert!(matches!(&refused, BuildError::Option { option, .. } if *option == name), "{name}: {refused:?}");
    }
}

#[test]
fn nothing_that_was_given_vanishes_in_silence() {
    let unplaced = Build::of_scene(Scene::new(vec![mesh()], vec![]).unwrap()).unwrap().run().unwrap_err();
    assert!(matches!(unplaced, BuildError::Unplaced { mesh: 0, .. }), "{unplaced:?}");
    // Placed there, its corners fall together.
    let mut build = Build::empty();
    let small = POSITIONS.map(|p| p.map(|c| 1e-3 * c));
    let number = build.add_mesh("m", &small, &TRIANGLES[..1]).unwrap();
    build.add_instance(number, Affine::translation([1e30, 0.0, 0.0])).unwrap();
    let options = BuildOptions { levels: Levels::One, ..BuildOptions::preset(Preset::Draft) };
    let gone = build.options(options).run().unwrap_err();
    assert!(matches!(gone, BuildError::NothingLeft { read: 0, placed: 1 }), "{gone:?}");
}

#[test]
fn numbers_that_lead_to_two_places_are_refused_at_the_door() {
    let scene = |change: fn(&mut Mesh), node| {
        let mut mesh = mesh();
        change(&mut mesh);
        let place = Instance { mesh: 0, transform: Affine::IDENTITY, node, name: String::new() };
        Scene::new(vec![mesh], vec![place]).unwrap_err()
    };
    let twice = scene(|m| (m.parts, m.source_prims) = (Vec::new(), vec![4, 4]), 0);
    assert_eq!(twice, GeometryError::SourceNumber { mesh: 0, triangle: 1, number: 4 });
    let beyond = scene(|m| (m.parts[0].first_prim, m.source_prims) = (u32::MAX - 1, vec![u32::MAX - 1, u32::MAX]), 0);
    assert_eq!(beyond, GeometryError::PartRange { mesh: 0, part: 0, first: u32::MAX - 1, count: 2 });
    let elsewhere = scene(|m| m.parts[0].baked_node = Some(5), 3);
    assert_eq!(elsewhere, GeometryError::PartNode { mesh: 0, part: 0, node: 5, placed: 3 });
    let nowhere = scene(|m| m.parts[0].baked_node = Some(Instance::NO_NODE), Instance::NO_NODE);
    assert!(matches!(nowhere, GeometryError::PartNode { node: Instance::NO_NODE, .. }), "{nowhere:?}");
    // In any order, each once.
    let mut mesh = mesh();
    (mesh.parts, mesh.source_prims) = (Vec::new(), vec![7, 4]);
    Build::of_scene(Scene::of_mesh(mesh)).unwrap().run().unwrap().to_bytes().unwrap();
}

/// What is built tells of a hit what its file tells.
#[test]
fn a_hit_leads_back_to_what_was_given_without_a_file() {
    let mut build = Build::empty();
    let numbers = ["left", "right"].map(|name| build.add_mesh(name, &POSITIONS, &TRIANGLES).unwrap());
    let mut nodes = Vec::new();
    for place in 0..20_000 {
        let x = 3.0 * f64::from(place);
        let mirror = if place % 3 == 0 { -1.0 } else { 1.0 };
        let transform = Affine { rows: [[mirror, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
        nodes.push(build.add_instance(numbers[place as usize % 2], transform).unwrap());
    }
    assert_eq!(nodes, (0..20_000).collect::<Vec<u32>>());
    for levels in [Levels::One, Levels::Two] {
        let options = BuildOptions { levels, ..BuildOptions::preset(Preset::Draft) };
        let built = build.clone().vertices(true).options(options).run().unwrap();
        let bytes = built.to_bytes().unwrap();
        let cache = Cache::from_bytes(&bytes, &OpenOptions::default()).unwrap();
        for place in (0..20_000u32).step_by(37) {
            let side = if place % 3 == 0 { -0.25 } else { 0.25 };
            let ray = Ray::new([3.0 * place as f32 + side, 0.25, -2.0], [0.0, 0.0, 1.0]);
            let hit = built.closest_hit(&ray).unwrap().unwrap();
            assert_eq!(Some(hit), cache.closest_hit(&ray).unwrap());
            assert_eq!(built.node(&hit), Some(place), "{levels:?}");
            assert_eq!(built.node(&hit), cache.node(&hit));
            assert_eq!(built.name(hit.geom), ["left", "right"][place as usize % 2]);
            assert_eq!(built.name(hit.geom), cache.name(hit.geom));
            assert_eq!(built.material(hit.geom), cache.material(hit.geom));
            assert_eq!(built.is_mirrored(hit.geom), cache.is_mirrored(hit.geom));
            assert_eq!(built.vertices(&hit), Some(TRIANGLES[hit.prim as usize]));
            assert_eq!(built.vertices(&hit), cache.vertices().get(hit.triangle).copied());
            let normal = built.normal(&hit).unwrap();
            // Its corners turn the other way round where it is mirrored, and the front is where it was.
            assert!(Some(normal) == cache.normal(&hit) && normal[2] > 0.0, "{levels:?} {place} {normal:?}");
        }
    }
}
