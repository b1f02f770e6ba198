//! From a hit back to the model by the file alone: vertices, materials, and the front side.

use bvhc::build::{BuildError, BuildOptions, Levels, Method, Preset};
use bvhc::cache::{Cache, OpenOptions, SectionKind, Validation, WriteOptions};
use bvhc::geom::Affine;
use bvhc::scene::{Instance, Mesh, ReadOptions, Scene, read_bytes};
use bvhc::{Build, Ray};

fn opened(build: Build) -> Cache {
    let options = OpenOptions { validation: Validation::Tree, ..OpenOptions::default() };
    Cache::from_bytes(&build.run().unwrap().to_bytes().unwrap(), &options).unwrap()
}

fn sections(cache: &Cache) -> Vec<String> {
    cache.sections().iter().map(|s| s.kind.to_string()).collect()
}

/// Strips of polygons over a hilly ground with long thin triangles among them, every corner with a texture coordinate of its own that is
/// its place seen from above; points and lines between, a triangle without area, and three materials.
fn ground() -> (String, Vec<[f64; 2]>) {
    let (mut text, mut corners, mut points) = (String::new(), Vec::new(), 0usize);
    let mut face = |text: &mut String, keyword: &str, at: &[[f64; 2]]| {
        let mut words = String::new();
        for [x, y] in at {
            points += 1;
            *text += &format!("v {x} {y} {}\nvt {x} {y}\n", 0.25 * x);
            words += &format!(" {points}/{points}");
            corners.push([*x, *y]);
        }
        *text += &format!("{keyword}{words}\n");
    };
    for i in 0..12 {
        let (x, y) = (f64::from(i), f64::from(i % 3) * 4.0);
        text += &format!("usemtl {}\n", ["stone", "wood 5%", ""][i as usize % 3]);
        face(&mut text, "f", &[[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]]);
        face(&mut text, "f", &[[x, y], [x + 1.0, y]]);
        // Concave: an ear at its third corner.
        face(
            &mut text,
            "fo",
            &[[x, y + 1.0], [x + 0.5, y + 1.75], [x + 1.0, y + 1.0], [x + 1.0, y + 2.0], [x, y + 2.0]],
        );
        face(&mut text, "f", &[[x, y], [x, y], [x + 1.0, y]]);
        face(&mut text, "f", &[[x, y + 2.0], [x + 30.0, y + 2.5], [x, y + 2.5]]);
        face(&mut text, "f", &[[x, y]]);
    }
    (text, corners)
}

fn scene_of(text: &str, vertices: bool) -> Scene {
    let options = ReadOptions { vertices, ..ReadOptions::default() };
    read_bytes(text.as_bytes().to_vec(), "ground.obj", None, None, &options).unwrap()
}

#[test]
fn texture_coordinates_and_materials_of_polygons_come_back() {
    let (text, corners) = ground();
    for method in [Method::Sbvh, Method::Binned] {
        for levels in [Levels::One, Levels::Two] {
            let base = BuildOptions { method, levels, ..BuildOptions::preset(Preset::Draft) };
            let options = match method {
                Method::Sbvh => BuildOptions { split_alpha: 0.0, split_budget: 2.0, ..base },
                _ => base,
            };
            let cache = opened(Build::of_scene(scene_of(&text, true)).unwrap().options(options));
            let copies = cache.triangles().len() as u64 - cache.header().prim_count;
            assert!(method != Method::Sbvh || copies > 0, "no triangle was cut");
            assert_eq!(cache.header().prim_count, 12 * (2 + 3 + 1));
            for (triangle, numbers) in cache.triangles().iter().zip(cache.vertices()) {
                let places = numbers.map(|n| corners[n as usize]);
                assert_eq!(triangle.corners().map(|[x, y, _]| [f64::from(x), f64::from(y)]), places);
            }
            let mut hits = 0;
            for i in 0..4000 {
                let [x, y] = [f64::from(i % 80) * 0.525 + 0.013, f64::from(i / 80) * 0.21 + 0.007];
                let ray = Ray::new([x as f32, y as f32, 50.0], [0.0, 0.0, -1.0]);
                let Some(hit) = cache.closest_hit(&ray).unwrap() else { continue };
                hits += 1;
                let uv = cache.vertices()[hit.triangle].map(|n| corners[n as usize]);
                let [u, v] = [hit.u, hit.v].map(f64::from);
                for (k, want) in [x, y].into_iter().enumerate() {
                    let got = (1.0 - u - v) * uv[0][k] + u * uv[1][k] + v * uv[2][k];
                    assert!((got - want).abs() < 1e-4, "{got} is not {want} at {x}, {y}");
                }
                let part = cache.geoms()[hit.geom as usize];
                assert_eq!(cache.material(hit.geom), ["stone", "wood 5%25", ""][part.source_part as usize % 3]);
                let normal = cache.normal(&hit).unwrap();
                assert!(normal[2] > 0.0 && (normal[0] + 0.25 * normal[2]).abs() < 1e-6 * normal[2], "{normal:?}");
            }
            assert!(hits > 400, "{hits} hits");
        }
    }
}

#[test]
fn a_file_has_what_was_asked_for_and_states_the_lowest_version_that_knows_it() {
    let (text, _) = ground();
    let plain: String = text.lines().filter(|l| !l.starts_with("usemtl")).map(|l| format!("{l}\n")).collect();
    let build = |text: &str, vertices| Build::of_scene(scene_of(text, vertices)).unwrap().preset(Preset::Draft);
    let expect = [
        (&plain, false, 0, vec![]),
        (&plain, true, 1, vec!["VERT"]),
        (&text, false, 1, vec!["MATS"]),
        (&text, true, 1, vec!["VERT", "MATS"]),
    ];
    let mut keys = std::collections::BTreeSet::new();
    for (text, vertices, minor, optional) in expect {
        let cache = opened(build(text, vertices));
        let found: Vec<String> =
            sections(&cache).into_iter().filter(|k| ["VERT", "SIDE", "MATS"].contains(&k.as_str())).collect();
        assert_eq!(
            (cache.header().minor, cache.header().min_minor, found),
            (minor, 0, optional.iter().map(|k| k.to_string()).collect())
        );
        assert_eq!(cache.vertices().len(), if vertices { cache.triangles().len() } else { 0 });
        let stated = cache.meta().unwrap().options.iter().any(|o| *o == ("vertices".into(), "true".into()));
        assert_eq!(stated, vertices);
        keys.insert(cache.header().build_key);
        // Numbers of vertices change nothing else.
        let without = opened(build(text, vertices).vertices(false));
        assert_eq!((without.nodes(), without.triangles()), (cache.nodes(), cache.triangles()));
        assert!(without.vertices().is_empty() && without.find(SectionKind::VERT, 0).is_none());
    }
    assert_eq!(keys.len(), 4);
}

#[test]
fn arrays_have_the_numbers_of_their_own_vertices_and_a_model_those_it_was_read_with() {
    let positions = [[0.0, 0.0, 0.0], [9.0, 9.0, 9.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let triangles = [[0, 2, 3], [4, 3, 2]];
    let build = || Build::new(&positions, &triangles).unwrap().preset(Preset::Draft);
    let cache = opened(build().vertices(true));
    for (record, numbers) in cache.triangles().iter().zip(cache.vertices()) {
        assert_eq!(*numbers, triangles[record.prim as usize]);
    }
    assert_eq!(cache.vertices().len(), 2);
    assert!(opened(build()).vertices().is_empty());
    let read_without = Build::of_scene(scene_of(&ground().0, false)).unwrap().vertices(true).run();
    assert!(matches!(read_without, Err(BuildError::NoVertices { mesh: 0 })), "{read_without:?}");
}

/// A triangle in the plane z = 0 whose front is at z > 0, in six places.
fn places() -> Vec<Affine> {
    let with = |x: [f64; 3], y: [f64; 3], z: [f64; 3], at: f64| Affine {
        rows: [[x[0], y[0], z[0], at], [x[1], y[1], z[1], 0.0], [x[2], y[2], z[2], 0.0]],
    };
    vec![
        Affine::IDENTITY,
        with([-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], 10.0),
        with([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -2.0], 20.0),
        with([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 3.0], 30.0),
        with([-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], 40.0),
        with([2.0, 0.0, 0.0], [0.5, -1.0, 0.0], [0.0, 0.5, 1.0], 50.0),
    ]
}

#[test]
fn normals_point_to_the_front_whatever_mirrors() {
    let mesh = Mesh::new("m", vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
    let instance = |(node, transform)| Instance { mesh: 0, transform, node, name: String::new() };
    let instances: Vec<Instance> = (0..).zip(places()).map(instance).collect();
    for levels in [Levels::One, Levels::Two] {
        let scene = Scene::new(vec![mesh.clone()], instances.clone()).unwrap();
        let options = BuildOptions { levels, ..BuildOptions::preset(Preset::Draft) };
        let cache = opened(Build::of_scene(scene).unwrap().options(options));
        assert_eq!(cache.find(SectionKind::SIDE, 0).is_some(), levels == Levels::One);
        let mirrored: Vec<u32> = (0..cache.geoms().len() as u32).filter(|g| cache.is_mirrored(*g)).collect();
        assert_eq!(mirrored, if levels == Levels::One { vec![1, 2, 3, 5] } else { vec![] });
        for (i, place) in places().iter().enumerate() {
            // From the front in the mesh's own space, where nothing is mirrored.
            let (from, to) = (place.transform_point([0.2, 0.3, 1.0]), place.transform_vector([0.0, 0.0, -1.0]));
            for turn in [1.0, -1.0] {
                let start = [0, 1, 2].map(|k| (if turn > 0.0 { from[k] } else { from[k] + 2.0 * to[k] }) as f32);
                let ray = Ray::new(start, to.map(|c| (turn * c) as f32));
                let hit = cache.closest_hit(&ray).unwrap().expect("the triangle is ahead");
                assert_eq!(hit.instance.unwrap_or(cache.geoms()[hit.geom as usize].baked_node), i as u32);
                let normal = cache.normal(&hit).unwrap();
                let towards: f64 = (0..3).map(|k| normal[k] * f64::from(ray.direction[k])).sum();
                assert!(towards * turn < 0.0, "place {i}, turn {turn}: {normal:?}");
                // And stands on the triangle.
                let edge = place.transform_vector([1.0, -1.0, 0.0]);
                let along: f64 = (0..3).map(|k| normal[k] * edge[k]).sum();
                assert!(along.abs() < 1e-6, "place {i}: {normal:?}");
            }
        }
    }
}

#[test]
fn nothing_is_marked_where_nothing_mirrors_and_a_foreign_hit_has_no_normal() {
    let mesh = Mesh::new("m", vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
    let instance = |(node, transform)| Instance { mesh: 0, transform, node, name: String::new() };
    let instances = [(0, places()[0]), (1, places()[4])].map(instance).to_vec();
    let scene = Scene::new(vec![mesh], instances).unwrap();
    let options = BuildOptions { levels: Levels::One, ..BuildOptions::preset(Preset::Draft) };
    let cache = opened(Build::of_scene(scene).unwrap().options(options));
    assert_eq!((cache.header().minor, cache.find(SectionKind::SIDE, 0)), (0, None));
    let hit = cache.closest_hit(&Ray::new([0.2, 0.3, 1.0], [0.0, 0.0, -1.0])).unwrap().unwrap();
    assert!(cache.normal(&hit).is_some());
    assert_eq!(cache.normal(&bvhc::Hit { triangle: 99, ..hit }), None);
    assert_eq!(cache.normal(&bvhc::Hit { instance: Some(3), ..hit }), None);
}

#[test]
fn a_writer_refuses_origins_that_break_a_rule() {
    let (text, _) = ground();
    let image = || {
        let exec = bvhc::exec::Executor::sequential();
        let options = BuildOptions::preset(Preset::Draft);
        let accel = bvhc::compile::compile(scene_of(&text, true), &options, &exec, &bvhc::build::NoProgress).unwrap();
        bvhc::cache::Image::new(&accel, &exec).unwrap()
    };
    let write = |image: &bvhc::cache::Image| {
        let exec = bvhc::exec::Executor::sequential();
        bvhc::cache::to_bytes(image, &Default::default(), &WriteOptions::default(), &exec).map_err(|e| e.to_string())
    };
    assert!(write(&image()).is_ok());
    let spoil = |edit: &dyn Fn(&mut bvhc::cache::Image)| {
        let mut image = image();
        edit(&mut image);
        write(&image).unwrap_err()
    };
    assert!(spoil(&|i| _ = i.vertices.pop()).contains("E0321"));
    assert!(spoil(&|i| i.vertices[0] = [i.vertices[0][0]; 3]).contains("E0323"));
    assert!(spoil(&|i| i.sides = vec![1; i.geoms.len()]).contains("E0325"));
    assert!(spoil(&|i| _ = i.materials.pop()).contains("no name for each part"));
}
