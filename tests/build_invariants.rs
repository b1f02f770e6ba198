//! What every tree must be, whatever the scene: complete, tight, in canonical order, shallow, and the same for any number of threads.

use bvhc::build::{Axes, BuildOptions, Executor, HullBasis, METHODS, Method, NoProgress, Preset};
use bvhc::compile::build_tree;
use bvhc::geom::Aabb;
use bvhc::scene::Mesh;
use bvhc::tree::{MAX_DEPTH, Node, Tree};
use proptest::prelude::*;
use std::time::Instant;

type Corners = [[f32; 3]; 3];

fn mesh_of(triangles: &[Corners]) -> Mesh {
    Mesh {
        positions: triangles.iter().flatten().copied().collect(),
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    }
}

/// A linear congruential generator: scenes are the same on every machine and in every run.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn triangle(&mut self, extent: f32, size: f32) -> Corners {
        let at = [0; 3].map(|_| self.unit() * extent);
        [0; 3].map(|_| at.map(|c| c + self.unit() * size))
    }

    fn soup(&mut self, count: usize, extent: f32, size: f32) -> Vec<Corners> {
        (0..count).map(|_| self.triangle(extent, size)).collect()
    }
}

fn draft() -> BuildOptions {
    BuildOptions::preset(Preset::Draft)
}

fn build(mesh: &Mesh, options: &BuildOptions, jobs: usize) -> Tree {
    build_tree(mesh, options, &Executor::new(jobs).unwrap(), &NoProgress).unwrap()
}

/// Every promise about a tree without duplicates.
fn assert_sound(mesh: &Mesh, tree: &Tree, max_leaf: u32) {
    let count = mesh.triangles.len();
    if count == 0 {
        assert!(tree.nodes.is_empty() && tree.refs.is_empty());
        return;
    }

    // Each triangle stands in exactly one leaf.
    let mut seen = vec![false; count];
    for &r in &tree.refs {
        assert!(!std::mem::replace(&mut seen[r as usize], true), "triangle {r} stands in two leaves");
    }
    assert_eq!(tree.refs.len(), count);
    assert!(tree.max_depth() <= MAX_DEPTH, "depth {}", tree.max_depth());

    // Nodes and leaves are used in the order of the depth-first walk, and all of them are used.
    assert_eq!(tree.nodes[1], Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 });
    let (mut next_pair, mut next_ref) = (2, 0);
    let mut stack = vec![0usize];
    while let Some(at) = stack.pop() {
        let node = tree.nodes[at];
        if node.is_leaf() {
            assert!(node.count <= max_leaf, "leaf of {}", node.count);
            assert_eq!(node.first, next_ref, "leaf out of order");
            next_ref += node.count;
            let refs = &tree.refs[node.first as usize..next_ref as usize];
            assert!(refs.is_sorted());
            let union = refs.iter().fold(Aabb::EMPTY, |b, &r| b.union(mesh.triangle_box(r as usize)));
            assert_eq!(node.bounds(), union, "a leaf's box is the box of its triangles");
        } else {
            assert_eq!(node.first, next_pair, "pair out of order");
            next_pair += 2;
            let [left, right] = [0, 1].map(|k| tree.nodes[node.first as usize + k].bounds());
            assert_eq!(node.bounds(), left.union(right), "an inner box is the box of its children");
            stack.push(node.first as usize + 1);
            stack.push(node.first as usize);
        }
    }
    assert_eq!((next_pair as usize, next_ref as usize), (tree.nodes.len(), count));
}

/// Every method but the searches.
fn methods() -> impl Iterator<Item = Method> {
    METHODS.iter().map(|row| row.method).filter(|method| !method.is_search())
}

/// The methods that make no duplicates.
fn methods_without_duplicates() -> impl Iterator<Item = Method> {
    methods().filter(|method| *method != Method::Sbvh)
}

/// The methods that make no duplicates, with the variants that differ in kind.
fn recipes() -> Vec<BuildOptions> {
    let mut recipes: Vec<_> = methods_without_duplicates().map(|method| BuildOptions { method, ..draft() }).collect();
    recipes.extend([
        BuildOptions { axes: Axes::Longest, ..draft() },
        // Every stem a leaf, and no mini tree opened.
        BuildOptions { method: Method::Bonsai, prune: 0.0, ..draft() },
        BuildOptions { method: Method::Bonsai, prune: 1e3, ..draft() },
        BuildOptions { method: Method::Agglomerative, radius: 1, ..draft() },
        BuildOptions { method: Method::Agglomerative, radius: 31, ..draft() },
        BuildOptions { method: Method::Oabb, basis: HullBasis::Leaf, ..draft() },
    ]);
    recipes
}

fn assert_good(triangles: &[Corners]) {
    let mesh = mesh_of(triangles);
    for recipe in recipes() {
        for max_leaf in [1, 8, 255] {
            let options = BuildOptions { max_leaf, ..recipe.clone() };
            assert_sound(&mesh, &build(&mesh, &options, 1), max_leaf);
        }
    }
}

#[test]
fn soups_of_every_small_size() {
    for count in (0..40).chain([63, 64, 65, 500]) {
        assert_good(&Random(count as u64).soup(count, 10.0, 1.0));
    }
}

#[test]
fn identical_triangles() {
    let one = [[1.0, 2.0, 3.0], [2.0, 2.0, 3.0], [1.0, 4.0, 5.0]];
    assert_good(&vec![one; 10_000]);
}

#[test]
fn equal_centres_of_different_boxes() {
    let nested = |i: usize| {
        let r = 1.0 + i as f32 / 64.0;
        [[-r, -r, -r], [r, r, r], [-r, r, 0.0]]
    };
    assert_good(&(0..5_000).map(nested).collect::<Vec<_>>());
}

#[test]
fn geometric_series_is_not_deep() {
    for base in [0.5f32, 0.9, 0.1] {
        let at = |i: usize| base.powi(i as i32);
        let series: Vec<Corners> =
            (0..3_000).map(|i| [[at(i), 0.0, 0.0], [at(i + 1), 0.0, 0.0], [at(i), at(i) / 4.0, 0.0]]).collect();
        assert_good(&series);
    }
}

#[test]
fn huge_and_tiny_coordinates() {
    for extent in [1e38f32, 3e38, 1e-38, 1e-44, 1e18, 1e-20] {
        let soup: Vec<Corners> = (Random(5).soup(2_000, 0.9, 0.05).into_iter())
            .map(|t| t.map(|p| p.map(|c| (2.0 * c - 1.0) * extent)))
            .collect();
        assert_good(&soup);
    }
    let mut mixed = Random(6).soup(1_000, 1e-38, 1e-39);
    mixed.extend(Random(7).soup(1_000, 1e38, 1e37));
    assert_good(&mixed);
}

#[test]
fn far_from_the_origin() {
    let soup: Vec<Corners> =
        Random(8).soup(3_000, 1.0, 0.01).into_iter().map(|t| t.map(|p| p.map(|c| c + 1e6))).collect();
    assert_good(&soup);
}

#[test]
fn flat_planes_and_lines() {
    for axis in 0..3 {
        let mut plane = Random(9).soup(4_000, 100.0, 1.0);
        plane.iter_mut().flatten().for_each(|p| p[axis] = 7.5);
        assert_good(&plane);
        plane.iter_mut().flatten().for_each(|p| p[(axis + 1) % 3] = -2.0);
        assert_good(&plane);
    }
}

#[test]
fn one_large_and_many_small() {
    let mut scene = Random(10).soup(5_000, 1.0, 0.01);
    scene.push([[-1e6, -1e6, 0.0], [1e6, -1e6, 0.0], [0.0, 1e6, 0.0]]);
    assert_good(&scene);
}

#[test]
fn negative_zeros_are_one_value() {
    let mut scene = Random(11).soup(3_000, 1.0, 0.1);
    for (i, p) in scene.iter_mut().flatten().enumerate() {
        p[i % 3] = if i % 2 == 0 { 0.0 } else { -0.0 };
    }
    assert_good(&scene);
    let tree = build(&mesh_of(&scene), &draft(), 2);
    let zeros = tree.nodes.iter().flat_map(|n| [n.min, n.max]).flatten().filter(|v| *v == 0.0);
    assert!(zeros.into_iter().all(f32::is_sign_positive));
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    // Large enough for chunked binning and partition, and for many tasks.
    let mut soup = Random(12).soup(90_000, 100.0, 0.5);
    soup.extend(Random(13).soup(10_000, 1.0, 0.001));
    soup.extend_from_within(0..5_000);
    let mesh = mesh_of(&soup);
    for method in methods() {
        let options = BuildOptions { method, ..draft() };
        let one = build(&mesh, &options, 1);
        for jobs in [2, 3, 7] {
            let many = build(&mesh, &options, jobs);
            assert!(
                bytemuck::cast_slice::<_, u8>(&one.nodes) == bytemuck::cast_slice::<_, u8>(&many.nodes)
                    && one.refs == many.refs,
                "{method} differs with {jobs} threads"
            );
        }
    }
    for options in recipes() {
        assert_sound(&mesh, &build(&mesh, &options, 2), options.max_leaf);
    }
}

#[test]
fn the_order_of_the_triangles_changes_nothing_but_their_numbers() {
    let soup = Random(14).soup(3_000, 10.0, 0.5);
    let reversed: Vec<Corners> = soup.iter().rev().copied().collect();
    let meshes = [soup, reversed].map(|s| mesh_of(&s));
    for options in recipes() {
        let [a, b] = meshes.each_ref().map(|mesh| build(mesh, &options, 1));
        assert!(a.nodes == b.nodes, "{options:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn random_scenes_give_sound_trees(
        seed in any::<u64>(),
        count in 0usize..600,
        extent in prop::sample::select(vec![0.0f32, 1.0, 1e-3, 1e9]),
        size in prop::sample::select(vec![0.0f32, 0.1, 10.0]),
        grid in any::<bool>(),
        bins in 2u32..=256,
        max_leaf in 1u32..=255,
        jobs in 1usize..=3,
        costs in (0.01f32..100.0, 0.01f32..100.0),
        method in prop::sample::select(methods_without_duplicates().collect::<Vec<_>>()),
        prune in prop::sample::select(vec![0.0f32, 0.01, 0.5, 1e3]),
    ) {
        let mut soup = Random(seed).soup(count, extent, size);
        if grid {
            soup.iter_mut().flatten().flatten().for_each(|c| *c = c.floor());
        }
        let mesh = mesh_of(&soup);
        let (traversal_cost, intersection_cost) = costs;
        let options = BuildOptions { method, bins, max_leaf, prune, traversal_cost, intersection_cost, ..draft() };
        assert_sound(&mesh, &build(&mesh, &options, jobs), max_leaf);
    }
}

#[test]
#[ignore = "long: five million triangles"]
fn long_five_million_triangles_stay_within_memory() {
    let mesh = mesh_of(&Random(15).soup(5_000_000, 1000.0, 1.0));
    let start = Instant::now();
    let tree = build(&mesh, &draft(), 2);
    println!(
        "5 M triangles: {:.2} s, {} nodes, depth {}",
        start.elapsed().as_secs_f32(),
        tree.nodes.len(),
        tree.max_depth()
    );
    assert_sound(&mesh, &tree, draft().max_leaf);
}
