//! Traversal finds what brute force finds: on the samples, on real scenes, and on scenes made to break it.

mod common;

use bvhc::build::{BuildOptions, Executor, Levels, Method, NoProgress, Preset};
use bvhc::cache::{Image, View};
use bvhc::compile::compile;
use bvhc::geom::{Affine, Point, Ray};
use bvhc::random::Random;
use bvhc::scene::{Mesh, ReadOptions, Scene, read};
use bvhc::trace::brute::{Answer, Oracle, Order};
use bvhc::trace::compare::{Tally, compare};
use bvhc::trace::rays::Sampler;
use bvhc::trace::rays::grid::GridScene;
use bvhc::trace::{any_hit, closest_hit};
use common::meshes::{cube, place, scene_of, sphere, visible};
use common::scenes::{model_files, real_scenes, samples_dir};

fn options(method: Method, levels: Levels) -> BuildOptions {
    BuildOptions { method, levels, ..BuildOptions::preset(Preset::Best) }
}

/// The same with all passes.
fn improved(method: Method, levels: Levels) -> BuildOptions {
    BuildOptions { reinsert: 6, adapt: 500, collapse: true, ..options(method, levels) }
}

fn build(scene: &Scene, options: &BuildOptions) -> Image {
    let exec = Executor::new(0).expect("threads");
    Image::new(&compile(scene.clone(), options, &exec, &NoProgress).expect("a tree"), &Executor::current()).unwrap()
}

/// Every way to build the scene: both methods, and with instances both numbers of levels.
fn builds(scene: &Scene) -> Vec<(String, Image)> {
    let instanced = scene.instances.len() > 1;
    let flat = scene.instanced_triangles() <= 1_000_000;
    let mut out = Vec::new();
    for (method, name) in [(Method::Binned, "binned"), (Method::Sbvh, "sbvh")] {
        for (levels, label) in [(Levels::One, "one level"), (Levels::Two, "two levels")] {
            if (levels == Levels::Two && instanced) || (levels == Levels::One && (flat || !instanced)) {
                out.push((format!("{name}, {label}"), build(scene, &options(method, levels))));
            }
        }
        let levels = if flat { Levels::One } else { Levels::Two };
        out.push((format!("{name}, passes"), build(scene, &improved(method, levels))));
    }
    // Neighbours merged, over triangles cut before: what else makes duplicates or clusters.
    if !instanced && scene.instanced_triangles() <= 300_000 {
        let cut = BuildOptions { presplit: 0.3, ..options(Method::Agglomerative, Levels::One) };
        out.push(("agglomerative over cut triangles".into(), build(scene, &cut)));
    }
    out
}

/// Judge every build of a scene by brute force with about `count` rays, spread over all sets, and print a row each.
///
/// The oracle knows the source, and of the file only what rounding made of matrices or moved vertices. Nothing may be left undecided, and
/// where triangles are given exactly, traversal decides as exactly but for rays that touch an edge without a neighbour.
fn judge(name: &str, scene: Scene, count: usize) {
    let scene = visible(scene);
    let sampler = Sampler::new(&scene);
    let rays = sampler.mixed(count as u64, 1);
    let (mut of_one_level, mut of_two_levels) = (None, None);
    for (build, image) in builds(&scene) {
        // All builds of so many levels hold the same vertices and matrices.
        let (view, one_level) = (image.view(), image.view().tlas_nodes.is_empty());
        let oracle = Oracle::of_file(&scene, &view, &Executor::current());
        let answers = if one_level { &mut of_one_level } else { &mut of_two_levels };
        let answers = answers.get_or_insert_with(|| oracle.trace_all(&rays, &Executor::current()));
        let tally = judge_build(name, &build, &view, &oracle, &rays, answers);
        assert_eq!(tally.unsure, 0, "{name}, {build}");
        // Of rays that start at a vertex, one in fifty, an instance's matrix puts many a rounding before or behind it.
        let least = if one_level { 200 } else { 30 };
        assert!(tally.grazing * least <= tally.rays(), "{name}, {build}: {} grazing", tally.grazing);
    }
}

fn judge_build(
    name: &str,
    build: &str,
    view: &View<'_>,
    oracle: &Oracle<'_>,
    rays: &[Ray],
    answers: &[Answer],
) -> Tally {
    let tally = compare(view, oracle, rays, answers, &Executor::current()).expect("a tree");
    report(name, build, &tally);
    assert_right(name, build, &tally);
    let certain = rays.iter().zip(answers).filter(|(_, a)| a.certain().is_some());
    let lost = certain.filter(|(ray, _)| any_hit(view, ray) != Ok(true)).count();
    assert_eq!(lost, 0, "{name}, {build}: any_hit lost hits");
    tally
}

fn report(name: &str, build: &str, t: &Tally) {
    println!(
        "{name}, {build}: {} rays, {} hits, {} agree, {} tie, {} grazing, {} unsure, {} missed, {} farther, {} false",
        t.rays(),
        t.hits,
        t.agree,
        t.tie,
        t.grazing,
        t.unsure,
        t.missed,
        t.farther,
        t.false_hits
    );
}

fn assert_right(name: &str, build: &str, tally: &Tally) {
    assert!(tally.wrong() == 0, "{name}, {build}: {} wrong; the first: {:#?}", tally.wrong(), tally.first_wrong);
}

#[test]
fn samples_agree_with_brute_force() {
    let mut files = model_files(&samples_dir());
    files.retain(|f| !f.to_string_lossy().contains("frame") || f.to_string_lossy().contains("0000"));
    assert!(files.len() >= 5, "{files:?}");
    for file in files {
        let name = file.file_name().expect("a name").to_string_lossy();
        match read(&file, &ReadOptions::default()) {
            Ok(scene) => judge(&name, scene, 3000),
            Err(e) => panic!("{name}: {e}"),
        }
    }
}

#[test]
#[ignore = "long: every sample with 50 000 rays"]
fn long_samples_agree_with_brute_force() {
    for file in model_files(&samples_dir()) {
        let scene = read(&file, &ReadOptions::default()).expect("a scene");
        judge(&file.file_name().expect("a name").to_string_lossy(), scene, 50_000);
    }
}

#[test]
#[ignore = "long: every real scene with 50 000 rays"]
fn long_real_scenes_agree_with_brute_force() {
    let Some(files) = real_scenes() else { return };
    for (name, file) in &files {
        match read(file, &ReadOptions::default()) {
            Ok(scene) if scene.instances.is_empty() => println!("{name}: no triangles"),
            Ok(scene) => judge(name, scene, 50_000),
            Err(e) => panic!("{name}: {e}"),
        }
    }
}

/// From points inside of a closed mesh, shoot at every vertex, at every edge's midpoint and at random points of edges: a ray
/// that gets out went through a crack.
fn assert_no_escape(name: &str, mesh: Mesh, inside: &[[f64; 3]], map: Affine) {
    let scene = place(mesh, &[map, map]);
    let mesh = &scene.meshes[0];
    let mut random = Random::new(5);
    let mut targets: Vec<[f64; 3]> = Vec::new();
    for i in 0..mesh.triangles.len() {
        let c = mesh.corners(i).map(|p| map.transform_point(p.map(f64::from)));
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let s = random.unit();
            targets.extend([c[a], mix(c[a], c[b], 0.5), mix(c[a], c[b], s)]);
        }
    }
    for (build, image) in builds(&scene) {
        let view = image.view();
        for &eye in inside {
            let eye = map.transform_point(eye);
            for &target in &targets {
                let origin = eye.map(|v| v as f32);
                let ray = Ray::new(origin, [0, 1, 2].map(|a| (target[a] - f64::from(origin[a])) as f32));
                assert!(closest_hit(&view, &ray).unwrap().is_some(), "{name}, {build}: {ray:?} escapes");
                assert_eq!(any_hit(&view, &ray), Ok(true), "{name}, {build}: {ray:?} escapes any_hit");
            }
        }
    }
}

fn mix(a: [f64; 3], b: [f64; 3], s: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]))
}

fn skewed(scale: f64, offset: f64) -> Affine {
    let s = scale;
    Affine {
        rows: [
            [0.8 * s, -0.6 * s, 0.1 * s, offset],
            [0.6 * s, 0.8 * s, -0.2 * s, -2.0 * offset],
            [0.05 * s, 0.3 * s, 0.9 * s, 0.5 * offset],
        ],
    }
}

#[test]
fn no_ray_escapes_a_closed_mesh() {
    let eyes = [[0.0; 3], [0.5, -0.25, 0.125], [0.3, 0.1, -0.7], [0.55, 0.55, 0.55]];
    let unit = |p: [f64; 3]| p.map(|v| v as f32);
    for map in [Affine::IDENTITY, skewed(1.0, 0.0), skewed(1e-3, 0.1), skewed(1e4, 1e5)] {
        assert_no_escape("cube", cube(8, unit), &eyes, map);
        assert_no_escape("cube off the grid", cube(7, unit), &eyes, map);
        assert_no_escape("sphere", sphere(10, 1.0, [0.0; 3]), &eyes, map);
    }

    // A thin shell far from the origin, where f32 resolves a few hundred steps over its width.
    let far: [f64; 3] = [1.0e5, -3.0e5, 7.0e4];
    let eyes: Vec<[f64; 3]> = eyes.iter().map(|e| [0, 1, 2].map(|a| far[a] + 2.0 * e[a])).collect();
    assert_no_escape("far sphere", sphere(10, 4.0, far), &eyes, Affine::IDENTITY);
}

/// Integer coordinates, rays along the axes at integers and halves: nothing rounds anywhere, so distance and triangle must
/// be exactly those of integer arithmetic, edges and vertices included.
#[test]
fn grid_scenes_are_exact() {
    let mut random = Random::new(3);
    for round in 0..20 {
        let mut coordinate = || random.below(17) as f32 - 8.0;
        let triangles: Vec<[Point; 3]> =
            (0..60).map(|_| [0; 3].map(|_| [coordinate(), coordinate(), coordinate()])).collect();
        let mesh = Mesh {
            positions: triangles.iter().flatten().copied().collect(),
            triangles: (0..60).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            ..Mesh::default()
        };
        let scene = scene_of(mesh);
        for (build, image) in builds(&scene) {
            for _ in 0..2000 {
                let axis = random.below(3) as usize;
                let mut origin = [0; 3].map(|_| (random.below(37) as f32 - 18.0) / 2.0);
                let sign = if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
                origin[axis] = (-20.0f32 * sign).max(-20.0);
                let mut direction = [0; 3].map(|_| if random.bits() & 1 == 0 { 0.0f32 } else { -0.0 });
                direction[axis] = sign;
                let ray = Ray::new(origin, direction);
                let expected = exact(&triangles, &ray, axis);
                let got = closest_hit(&image.view(), &ray).unwrap().map(|h| (h.t, h.prim));
                // Halves of rational distances round once, so t is compared after the same rounding.
                assert_eq!(got, expected, "round {round}, {build}: {ray:?}");
            }
        }
    }
}

/// The nearest hit by integer arithmetic in half units: the smallest distance, then the smallest number.
fn exact(triangles: &[[Point; 3]], ray: &Ray, axis: usize) -> Option<(f32, u32)> {
    let (kx, ky) = ((axis + 1) % 3, (axis + 2) % 3);
    let half = |v: f32| (2.0 * v) as i64;
    let mut best: Option<(i128, i128, u32)> = None;
    for (number, triangle) in triangles.iter().enumerate() {
        let c =
            triangle.map(|p| [half(p[kx]) - half(ray.origin[kx]), half(p[ky]) - half(ray.origin[ky]), half(p[axis])]);
        let edge = |p: [i64; 3], q: [i64; 3]| i128::from(p[0] * q[1] - p[1] * q[0]);
        let (u, v, w) = (edge(c[2], c[1]), edge(c[0], c[2]), edge(c[1], c[0]));
        let sum = u + v + w;
        if sum == 0 || ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) {
            continue;
        }
        let depth = u * i128::from(c[0][2]) + v * i128::from(c[1][2]) + w * i128::from(c[2][2]);
        let start = i128::from(half(ray.origin[axis]));
        let toward = ray.direction[axis] as i128;
        // The distance as a fraction with a positive denominator.
        let (mut top, mut bottom) = ((depth - start * sum) * toward, sum);
        if bottom < 0 {
            (top, bottom) = (-top, -bottom);
        }
        if top >= 0 && best.is_none_or(|(t, b, _)| top * b < t * bottom) {
            best = Some((top, bottom, number as u32));
        }
    }
    best.map(|(top, bottom, number)| ((top as f64 / (2 * bottom) as f64) as f32, number))
}

/// On the grid nothing but the last division rounds: the triangle is the nearest one of the smallest number, and distance and weights are
/// the exact ones, rounded once.
#[test]
fn grid_mode_is_exact_to_the_last_bit() {
    let (mut hits, mut ties) = (0, 0);
    for seed in 0..1000 {
        let GridScene { scene, rays } = GridScene::new(seed, 40);
        let levels = if scene.instances.len() > 1 { Levels::Two } else { Levels::One };
        let method = if seed % 2 == 0 { Method::Binned } else { Method::Sbvh };
        let accel = compile(scene.clone(), &options(method, levels), &Executor::sequential(), &NoProgress);
        let image = Image::new(&accel.expect("a tree"), &Executor::current()).unwrap();
        let oracle = Oracle::of_file(&scene, &image.view(), &Executor::current());
        for ray in &rays {
            let answer = oracle.trace(ray);
            let expected = answer.first().map(|c| {
                let exact = oracle.meeting(ray, c.source).expect("it is exact");
                let mesh = &scene.meshes[scene.instances[c.source.instance as usize].mesh as usize];
                let prim = mesh.source_prim(c.source.triangle as usize);
                (c.source.instance, prim, [&exact.t, &exact.u, &exact.v].map(|r| r.to_f32()))
            });
            let hit = closest_hit(&image.view(), ray).unwrap();
            let hit = hit.map(|h| (h.instance.unwrap_or(0), h.prim, [h.t, h.u, h.v]));
            assert_eq!(hit, expected, "seed {seed}: {ray:?}");
            assert_eq!(any_hit(&image.view(), ray), Ok(expected.is_some()), "seed {seed}: {ray:?}");
            hits += usize::from(hit.is_some());
            ties += usize::from(answer.candidates.iter().any(|c| c.order == Order::Equal));
        }
    }
    assert!(hits > 20_000 && ties > 5000, "{hits} hits, {ties} ties");
}

/// Random triangles: small ones, long ones and slivers.
fn soup(count: usize, seed: u64, map: impl Fn([f64; 3]) -> Point) -> Mesh {
    let mut random = Random::new(seed);
    let mut mesh = Mesh::default();
    for i in 0..count {
        let at = [0; 3].map(|_| random.unit());
        let size = [0.02, 0.1, 0.8][i % 3];
        for _ in 0..3 {
            let d = random.direction();
            mesh.positions.push(map([0, 1, 2].map(|a| at[a] + size * d[a])));
        }
        if i % 7 == 0 {
            let last = mesh.positions.len();
            mesh.positions[last - 1] =
                [0, 1, 2].map(|a| 0.5 * mesh.positions[last - 2][a] + 0.5 * mesh.positions[last - 3][a]);
        }
        mesh.triangles.push([3 * i as u32, 3 * i as u32 + 1, 3 * i as u32 + 2]);
    }
    mesh
}

#[test]
fn offsets_and_scales_lose_no_hits() {
    type Map = fn([f64; 3]) -> Point;
    let maps: [(&str, Map); 6] = [
        ("as it is", |p| p.map(|v| v as f32)),
        ("at 1e7, 8 units wide", |p| p.map(|v| (1e7 + 8.0 * v) as f32)),
        ("at -1e7, 1000 units wide", |p| p.map(|v| (-1e7 + 1e3 * v) as f32)),
        ("1e-20 wide", |p| p.map(|v| (1e-20 * v) as f32)),
        ("1e20 wide", |p| p.map(|v| (1e20 * v) as f32)),
        ("flat", |p| [p[0] as f32, 0.25, p[2] as f32]),
    ];
    for (name, map) in maps {
        judge(name, scene_of(soup(400, 2, map)), 6000);
    }
}

#[test]
fn instances_far_off_and_of_all_sizes_lose_no_hits() {
    let transforms: Vec<Affine> =
        [(1.0, 0.0), (1.0, 3.0), (0.01, 1.5), (-2.0, -4.0), (1.0, 1e6)].iter().map(|&(s, o)| skewed(s, o)).collect();
    judge("instances", place(soup(200, 4, |p| p.map(|v| v as f32)), &transforms), 6000);
    let near: Vec<Affine> = (0..40).map(|i| skewed(0.3, f64::from(i) * 0.1)).collect();
    judge("a row of instances", place(sphere(6, 1.0, [0.0; 3]), &near), 6000);
}

#[test]
fn ties_go_to_the_smallest_number_whatever_the_tree() {
    // The same two triangles forty times over, in two levels as well: the first of the first instance wins.
    let quad = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]];
    let mesh = Mesh { positions: quad.to_vec(), triangles: [[0, 1, 2], [0, 2, 3]].repeat(40), ..Mesh::default() };
    let scene = place(mesh, &[Affine::IDENTITY; 3]);
    for (build, image) in builds(&scene) {
        let hit = closest_hit(&image.view(), &Ray::new([0.5, 0.5, 0.0], [0.0, 0.0, 1.0]));
        let hit = hit.unwrap().expect("a hit on the diagonal");
        assert_eq!((hit.prim, hit.instance.unwrap_or(0)), (0, 0), "{build}");
        let hit = closest_hit(&image.view(), &Ray::new([0.25, 0.75, 0.0], [0.0, 0.0, 1.0])).unwrap().expect("a hit");
        assert_eq!((hit.prim, hit.instance.unwrap_or(0)), (1, 0), "{build}");
    }
}
