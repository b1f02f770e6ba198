//! Cutting large triangles before the build: within the budget, complete, the same for any number of threads, and no hit lost,
//! whichever method builds on it.

use bvhc::build::{BuildOptions, Executor, METHODS, Method, NoProgress, Preset, option};
use bvhc::cache::Image;
use bvhc::cache::check::{Limits, check_image};
use bvhc::compile::build_tree;
use bvhc::geom::{Affine, Point};
use bvhc::random::Random;
use bvhc::scene::{Instance, Mesh, Part, Scene};
use bvhc::trace::brute::Oracle;
use bvhc::trace::compare::compare;
use bvhc::trace::rays::{RaySet, Sampler};
use bvhc::tree::{Accel, Tree, quality};

type Corners = [Point; 3];

/// The methods that build on references cut before.
fn cutters() -> impl Iterator<Item = Method> {
    let presplit = option("presplit").expect("a row of the table of options");
    METHODS.iter().map(|row| row.method).filter(|method| presplit.is_read_by(*method))
}

fn mesh_of(triangles: &[Corners]) -> Mesh {
    let count = triangles.len() as u32;
    Mesh {
        positions: triangles.iter().flatten().copied().collect(),
        triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        parts: vec![Part { triangle_count: count, prim_count: count, ..Part::default() }],
        ..Mesh::default()
    }
}

fn options(method: Method, presplit: f32) -> BuildOptions {
    BuildOptions { method, presplit, ..BuildOptions::preset(Preset::Draft) }
}

fn build(mesh: &Mesh, options: &BuildOptions, jobs: usize) -> Tree {
    build_tree(mesh, options, &Executor::new(jobs).unwrap(), &NoProgress).unwrap()
}

fn image_of(mesh: &Mesh, tree: Tree) -> Image {
    Image::new(&Accel { meshes: vec![mesh.clone()], blases: vec![tree], ..Accel::default() }, &Executor::current())
        .unwrap()
}

fn needles(count: usize, extent: f64) -> Vec<Corners> {
    let mut random = Random::new(3);
    let mut point = || [0; 3].map(|_| (random.unit() * extent) as f32);
    let needle = |_| {
        let (a, b) = (point(), point());
        [a, b, [a[0] + 1e-3 * (b[1] - a[1]), a[1] - 1e-3 * (b[0] - a[0]), a[2]]]
    };
    (0..count).map(needle).collect()
}

fn soup(count: usize, extent: f64, size: f64) -> Vec<Corners> {
    let mut random = Random::new(4);
    let triangle = |_| {
        let at = [0; 3].map(|_| random.unit() * extent);
        [0; 3].map(|_| at.map(|v| (v + random.unit() * size) as f32))
    };
    (0..count).map(triangle).collect()
}

/// Small triangles on a floor of two.
fn floor_and_grass() -> Vec<Corners> {
    let mut scene = soup(3000, 10.0, 0.05);
    scene.push([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 0.0, 10.0]]);
    scene.push([[0.0, 0.0, 0.0], [10.0, 0.0, 10.0], [0.0, 0.0, 10.0]]);
    scene
}

fn hostile_scenes() -> Vec<(&'static str, Vec<Corners>)> {
    let one = [[1.0, 2.0, 3.0], [2.0, 2.0, 3.0], [1.0, 4.0, 5.0]];
    let series = (0..400).map(|i| {
        let (near, far) = (0.9f32.powi(i), 0.9f32.powi(i + 3));
        [[near, 0.0, 0.0], [far, near, 0.0], [near, far, near]]
    });
    vec![
        ("nothing", vec![]),
        ("one", needles(1, 10.0)),
        ("two", needles(2, 10.0)),
        ("needles", needles(500, 1000.0)),
        ("huge needles", needles(100, 3e38)),
        ("tiny needles", needles(100, 1e-37)),
        ("denormal needles", needles(100, 1e-42)),
        ("identical", vec![one; 2000]),
        ("a geometric series", series.collect()),
        ("floor and grass", floor_and_grass()),
        ("a point", vec![[[1.0; 3]; 3]; 9]),
        ("a line", needles(300, 1.0).into_iter().map(|t| t.map(|p| [p[0], 0.0, 0.0])).collect()),
        ("far away", needles(300, 1.0).into_iter().map(|t| t.map(|p| p.map(|v| v + 1e7))).collect()),
    ]
}

#[test]
fn trees_are_valid_and_keep_to_the_budget_on_every_scene() {
    for (name, triangles) in hostile_scenes() {
        let mesh = mesh_of(&triangles);
        for method in cutters() {
            for share in [0.01, 0.5, 20.0] {
                let tree = build(&mesh, &options(method, share), 2);
                let most = triangles.len() + (triangles.len() as f64 * f64::from(share)) as usize;
                assert!(tree.refs.len() <= most, "{name}, {method}: {} of {most} references", tree.refs.len());
                let mut seen = vec![false; triangles.len()];
                tree.refs.iter().for_each(|r| seen[*r as usize] = true);
                assert!(seen.iter().all(|s| *s), "{name}, {method}: a triangle is lost");
                let report = check_image(&image_of(&mesh, tree), &Limits::default(), &Executor::current());
                assert!(report.is_valid(), "{name}, {method}, share {share}: {report:?}");
            }
        }
    }
}

#[test]
fn no_share_cuts_nothing_and_a_share_cuts_needles_first() {
    let mut scene = soup(2000, 1000.0, 0.1);
    scene.extend(needles(100, 1000.0));
    let mesh = mesh_of(&scene);
    for method in cutters() {
        assert_eq!(build(&mesh, &options(method, 0.0), 1).refs.len(), scene.len());
        let tree = build(&mesh, &options(method, 0.5), 1);
        let mut uses = vec![0; scene.len()];
        tree.refs.iter().for_each(|r| uses[*r as usize] += 1);
        assert!(uses[..2000].iter().all(|n| *n == 1), "{method} cuts small triangles");
        assert!(uses[2000..].iter().sum::<i32>() > 250, "{method} makes {:?} of needles", &uses[2000..]);
    }
}

#[test]
fn cutting_needles_lowers_the_cost() {
    let mesh = mesh_of(&needles(2000, 100.0));
    for method in cutters() {
        let [plain, cut] = [0.0, 4.0].map(|share| quality::sah(&build(&mesh, &options(method, share), 2).nodes));
        assert!(cut < 0.8 * plain, "{method}: SAH {cut} with cuts, {plain} without");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_tree() {
    let mut scene = soup(30_000, 100.0, 0.5);
    scene.extend(needles(3_000, 100.0));
    let mesh = mesh_of(&scene);
    for method in cutters() {
        let one = build(&mesh, &options(method, 0.3), 1);
        assert!(one.refs.len() > scene.len());
        for jobs in [2, 3] {
            let many = build(&mesh, &options(method, 0.3), jobs);
            assert!(one.nodes == many.nodes && one.refs == many.refs, "{method} differs with {jobs} threads");
        }
    }
}

#[test]
fn rays_hit_what_brute_force_hits() {
    for (name, triangles) in [("needles", needles(400, 64.0)), ("floor and grass", floor_and_grass())] {
        let mesh = mesh_of(&triangles);
        let instance = Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() };
        let scene = Scene { meshes: vec![mesh.clone()], instances: vec![instance], ..Scene::default() };
        let sampler = Sampler::new(&scene);
        let rays: Vec<_> = RaySet::ALL.iter().flat_map(|&set| sampler.rays(set, 300, 1)).collect();
        let oracle = Oracle::new(&scene, &Executor::current());
        let answers = oracle.trace_all(&rays, &Executor::current());
        for method in cutters() {
            for share in [0.0, 0.3, 5.0] {
                let image = image_of(&mesh, build(&mesh, &options(method, share), 2));
                let tally = compare(&image.view(), &oracle, &rays, &answers, &Executor::current()).expect("a tree");
                assert!(tally.hits > 100 && tally.wrong() == 0, "{name}, {method}, share {share}: {tally:?}");
            }
        }
    }
}
