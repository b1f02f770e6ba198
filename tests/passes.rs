//! Passes over finished trees: nothing is lost, boxes stay unions, order stays canonical, depth and time stay bounded, the SAH
//! does not rise, and threads change nothing.

use bvhc::build::{BuildOptions, Executor, Method, NoProgress, Preset};
use bvhc::compile::build_tree;
use bvhc::geom::Aabb;
use bvhc::scene::{Mesh, ReadOptions, read};
use bvhc::tree::quality::sah;
use bvhc::tree::{MAX_DEPTH, Node, Tree};
use std::collections::{BTreeMap, BTreeSet};

type Corners = [[f32; 3]; 3];

fn mesh_of(triangles: &[Corners]) -> Mesh {
    Mesh {
        positions: triangles.iter().flatten().copied().collect(),
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    }
}

/// Splitmix64: scenes are the same on every machine and in every run.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    fn soup(&mut self, count: usize, extent: f32, size: f32) -> Vec<Corners> {
        let mut triangle = || {
            let at = [0; 3].map(|_| self.unit() * extent);
            [0; 3].map(|_| at.map(|c| c + self.unit() * size))
        };
        (0..count).map(|_| triangle()).collect()
    }

    /// Long thin triangles in all directions: what reinsertion gains most on.
    fn needles(&mut self, count: usize) -> Vec<Corners> {
        let mut needle = || {
            let [a, b] = [0; 2].map(|_| [0; 3].map(|_| 10.0 * self.unit()));
            [a, b, b.map(|c| c + 0.01 * self.unit())]
        };
        (0..count).map(|_| needle()).collect()
    }
}

fn build(mesh: &Mesh, options: &BuildOptions, jobs: usize) -> Tree {
    build_tree(mesh, options, &Executor::new(jobs).unwrap(), &NoProgress).unwrap()
}

/// Every method, without passes.
fn bases() -> Vec<BuildOptions> {
    [Method::Binned, Method::Sbvh]
        .map(|method| BuildOptions {
            method,
            reinsert: 0,
            adapt: 0,
            collapse: false,
            ..BuildOptions::preset(Preset::Best)
        })
        .to_vec()
}

/// The leaves with their references, in order. Asserts what every tree must be: tiled, in canonical order, tight above the leaves,
/// shallow.
fn leaves(tree: &Tree) -> Vec<(Node, &[u32])> {
    assert!(tree.max_depth() <= MAX_DEPTH, "depth {}", tree.max_depth());
    assert_eq!(tree.nodes[1], Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 });
    let (mut next_pair, mut next_ref) = (2, 0);
    let (mut stack, mut leaves) = (vec![0usize], Vec::new());
    while let Some(at) = stack.pop() {
        let node = tree.nodes[at];
        assert!(node.bounds().is_valid());
        if node.is_leaf() {
            assert_eq!(node.first, next_ref, "leaf out of order");
            next_ref += node.count;
            let refs = &tree.refs[node.first as usize..next_ref as usize];
            assert!(refs.is_sorted_by(|a, b| a < b), "{refs:?}: ascending, each once");
            leaves.push((node, refs));
        } else {
            assert_eq!(node.first, next_pair, "pair out of order");
            next_pair += 2;
            let [left, right] = [0, 1].map(|k| tree.nodes[node.first as usize + k].bounds());
            assert_eq!(node.bounds(), left.union(right), "an inner box is the box of its children");
            stack.extend([node.first as usize + 1, node.first as usize]);
        }
    }
    assert_eq!((next_pair as usize, next_ref as usize), (tree.nodes.len(), tree.refs.len()));
    leaves
}

fn bits(b: &Aabb) -> [u32; 6] {
    let [x, y, z] = b.min.map(f32::to_bits);
    let [u, v, w] = b.max.map(f32::to_bits);
    [x, y, z, u, v, w]
}

/// The same leaves in another order.
fn assert_same_leaves(before: &Tree, after: &Tree) {
    let sorted = |tree: &Tree| {
        let mut all: Vec<_> = leaves(tree).iter().map(|(node, refs)| (refs.to_vec(), bits(&node.bounds()))).collect();
        all.sort();
        all
    };
    assert!(sorted(before) == sorted(after), "a leaf changed");
}

/// Every part of a triangle that stood in a leaf stands in one whose box contains that leaf's, and no leaf is larger than allowed.
fn assert_nothing_lost(before: &Tree, after: &Tree, max_leaf: u32) {
    let mut of_triangle: BTreeMap<u32, Vec<Aabb>> = BTreeMap::new();
    for (node, refs) in leaves(after) {
        assert!(node.count <= max_leaf);
        refs.iter().for_each(|&r| of_triangle.entry(r).or_default().push(node.bounds()));
    }
    for (node, refs) in leaves(before) {
        for r in refs {
            let boxes = of_triangle.get(r).map_or(&[][..], Vec::as_slice);
            assert!(boxes.iter().any(|b| b.contains(&node.bounds())), "triangle {r} is lost");
        }
    }
    let triangles = |tree: &Tree| tree.refs.iter().copied().collect::<BTreeSet<_>>();
    assert_eq!(triangles(before), triangles(after));
}

/// All promises, for the trees of every method.
fn assert_good(name: &str, mesh: &Mesh) {
    for base in bases() {
        let before = build(mesh, &base, 1);
        let moved = build(mesh, &BuildOptions { reinsert: 6, ..base.clone() }, 1);
        let cut = build(mesh, &BuildOptions { collapse: true, ..base.clone() }, 1);
        let both = BuildOptions { reinsert: 6, collapse: true, ..base.clone() };
        let cut_and_moved = build(mesh, &both, 1);
        if mesh.triangles.is_empty() {
            assert!(cut_and_moved.nodes.is_empty());
            continue;
        }
        let adapted = build(mesh, &BuildOptions { adapt: 300, ..base.clone() }, 1);
        let all_three = BuildOptions { adapt: 300, ..both.clone() };
        let after_all = build(mesh, &all_three, 1);
        assert_same_leaves(&before, &moved);
        assert_same_leaves(&before, &adapted);
        assert_nothing_lost(&before, &after_all, base.max_leaf);
        for tree in [&moved, &cut, &cut_and_moved] {
            assert_nothing_lost(&before, tree, base.max_leaf);
            let [was, is] = [&before, tree].map(|t| sah(&t.nodes));
            assert!(is <= was * (1.0 + 1e-5), "{name}, {}: SAH {was} became {is}", base.method);
        }
        for jobs in [2, 3] {
            let other = build(mesh, &both, jobs);
            let bytes = |t: &Tree| bytemuck::cast_slice::<Node, u8>(&t.nodes).to_vec();
            assert!(
                bytes(&other) == bytes(&cut_and_moved) && other.refs == cut_and_moved.refs,
                "{name}: {jobs} threads"
            );
            let other = build(mesh, &all_three, jobs);
            assert!(bytes(&other) == bytes(&after_all) && other.refs == after_all.refs, "{name}: {jobs} threads");
        }
    }
}

#[test]
fn samples() {
    let mut seen = 0;
    for entry in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/samples")).unwrap() {
        let path = entry.unwrap().path();
        if !path.extension().is_some_and(|e| e == "obj" || e == "gltf" || e == "glb") {
            continue;
        }
        let scene = read(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        scene.meshes.iter().for_each(|mesh| assert_good(&path.display().to_string(), mesh));
        seen += 1;
    }
    assert!(seen >= 5, "{seen} samples");
}

#[test]
fn every_small_size() {
    for count in 0..40 {
        assert_good("soup", &mesh_of(&Random(count as u64).soup(count, 10.0, 3.0)));
        assert_good("needles", &mesh_of(&Random(count as u64).needles(count)));
    }
}

#[test]
fn needles_and_soups() {
    assert_good("needles", &mesh_of(&Random(1).needles(4_000)));
    assert_good("soup", &mesh_of(&Random(2).soup(4_000, 10.0, 2.0)));
    let mut stadium = Random(3).soup(3_000, 1.0, 0.01);
    stadium.push([[-1e6, -1e6, 0.0], [1e6, -1e6, 0.0], [0.0, 1e6, 0.0]]);
    assert_good("stadium", &mesh_of(&stadium));
    let grid: Vec<Corners> = Random(4).soup(3_000, 9.0, 3.0).iter().map(|t| t.map(|p| p.map(f32::floor))).collect();
    assert_good("ties", &mesh_of(&grid));
}

#[test]
fn identical_triangles_and_equal_centres() {
    assert_good("identical", &mesh_of(&vec![[[1.0, 2.0, 3.0], [2.0, 2.0, 3.0], [1.0, 4.0, 5.0]]; 4_000]));
    let nested = |i: usize| {
        let r = 1.0 + i as f32 / 64.0;
        [[-r, -r, -r], [r, r, r], [-r, r, 0.0]]
    };
    assert_good("nested", &mesh_of(&(0..2_000).map(nested).collect::<Vec<_>>()));
}

#[test]
fn geometric_series_stay_shallow() {
    for base in [0.5f32, 0.9, 0.1] {
        let at = |i: usize| base.powi(i as i32);
        let series: Vec<Corners> =
            (0..1_500).map(|i| [[at(i), 0.0, 0.0], [at(i + 1), 0.0, 0.0], [at(i), at(i) / 4.0, at(i)]]).collect();
        assert_good("geometric series", &mesh_of(&series));
        let nested: Vec<Corners> = (0..1_500).map(|i| [[0.0; 3], [at(i), 0.0, at(i)], [0.0, at(i), 0.0]]).collect();
        assert_good("nested series", &mesh_of(&nested));
    }
}

#[test]
fn huge_tiny_and_flat_coordinates() {
    for extent in [1e38f32, 3e38, 1e-38, 1e-44, 1e18, 1e-20] {
        let soup: Vec<Corners> = (Random(5).soup(600, 0.7, 0.25).into_iter())
            .map(|t| t.map(|p| p.map(|c| (2.0 * c - 1.0) * extent)))
            .collect();
        assert_good("extreme scale", &mesh_of(&soup));
    }
    let mut mixed = Random(6).soup(300, 1e-38, 1e-39);
    mixed.extend(Random(7).soup(300, 1e38, 1e37));
    assert_good("mixed scales", &mesh_of(&mixed));
    for axis in 0..3 {
        let mut plane = Random(9).soup(800, 100.0, 20.0);
        plane.iter_mut().flatten().for_each(|p| p[axis] = 7.5);
        assert_good("plane", &mesh_of(&plane));
        plane.iter_mut().flatten().for_each(|p| p[(axis + 1) % 3] = -2.0);
        assert_good("line", &mesh_of(&plane));
    }
}

#[test]
fn reinsertion_gains_where_top_down_splits_are_greedy() {
    let mesh = mesh_of(&Random(10).needles(2_000));
    for base in bases() {
        let [was, is] = [0, 12].map(|reinsert| sah(&build(&mesh, &BuildOptions { reinsert, ..base.clone() }, 1).nodes));
        assert!(is < 0.97 * was, "{}: SAH {was} became {is}", base.method);
    }
}
