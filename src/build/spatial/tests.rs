use super::*;
use crate::build::prim_ref::{PrimRefs, bounds_of};
use crate::build::{Method, NoProgress, Preset, initial_tree};
use crate::geom::Point;
use crate::tree::quality::sah;
use crate::tree::{MAX_DEPTH, Node, Tree};
use proptest::prelude::{Strategy as _, prop, prop_assert, proptest};

fn best() -> BuildOptions {
    BuildOptions { method: Method::Sbvh, ..BuildOptions::preset(Preset::Best) }
}

fn build(mesh: &Mesh, options: &BuildOptions) -> Tree {
    initial_tree(mesh, options, &Executor::sequential(), &NoProgress).unwrap()
}

fn mesh(triangles: &[[Point; 3]]) -> Mesh {
    let positions = triangles.iter().flatten().copied().collect();
    let triangles = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

/// Numbers in 0..1, the same on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// The twelve triangles of a brick, its corners mapped by `place`.
fn brick(out: &mut Vec<[Point; 3]>, min: Point, max: Point, place: impl Fn(Point) -> Point) {
    let corner = |i: usize| place([0, 1, 2].map(|a| if i >> a & 1 == 0 { min[a] } else { max[a] }));
    for axis in 0..3 {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        for side in [0, 1 << axis] {
            out.push([side, side | u, side | u | v].map(corner));
            out.push([side, side | u | v, side | v].map(corner));
        }
    }
}

/// A hall of long thin beams and tall columns, turned by 45° about the vertical: every beam's box is a square of the floor.
fn turned_colonnade(beams: usize) -> Mesh {
    let turn =
        |[x, y, z]: Point| [(x - z) * std::f32::consts::FRAC_1_SQRT_2, y, (x + z) * std::f32::consts::FRAC_1_SQRT_2];
    let (mut out, length) = (Vec::new(), beams as f32);
    for i in 0..beams {
        let x = i as f32;
        brick(&mut out, [x, 5.0, 0.0], [x + 0.1, 5.1, length], turn);
        brick(&mut out, [0.0, 5.2, x], [length, 5.3, x + 0.1], turn);
        brick(&mut out, [x, 0.0, x], [x + 0.3, 5.0, x + 0.3], turn);
    }
    mesh(&out)
}

/// `side`² unit squares of two triangles, integer coordinates.
fn grid(side: usize) -> Mesh {
    let mut out = Vec::new();
    for (x, y) in (0..side).flat_map(|x| (0..side).map(move |y| (x as f32, y as f32))) {
        let height = |x: f32, y: f32| ((x * 3.0 + y * 5.0) as i32 % 4) as f32;
        let at = |x: f32, y: f32| [x, y, height(x, y)];
        out.push([at(x, y), at(x + 1.0, y), at(x + 1.0, y + 1.0)]);
        out.push([at(x, y), at(x + 1.0, y + 1.0), at(x, y + 1.0)]);
    }
    mesh(&out)
}

fn needles(count: usize) -> Mesh {
    let mut random = Random(7);
    let triangles: Vec<_> = (0..count)
        .map(|_| {
            let mut end = || [0; 3].map(|_| (random.next() * 1024.0).round());
            let (a, b) = (end(), end());
            [a, b, [b[0] + 1.0, b[1], b[2]]]
        })
        .collect();
    mesh(&triangles)
}

/// Leaves with their nodes; on the way children are found inside their parents, references in range and no primitive twice in a leaf.
fn leaves<'a>(tree: &'a Tree, mesh: &Mesh) -> Vec<(&'a Node, &'a [u32])> {
    let (mut out, mut stack) = (Vec::new(), vec![0usize]);
    while let Some(i) = stack.pop() {
        let node = &tree.nodes[i];
        if node.is_leaf() {
            let refs = &tree.refs[node.first as usize..][..node.count as usize];
            assert!(refs.windows(2).all(|w| w[0] < w[1]) && refs.iter().all(|r| (*r as usize) < mesh.triangles.len()));
            out.push((node, refs));
            continue;
        }
        for child in [node.first as usize, node.first as usize + 1] {
            assert!(node.bounds().contains(&tree.nodes[child].bounds()), "child {child} leaves its parent {i}");
            stack.push(child);
        }
    }
    out
}

/// Every point of every triangle lies in a leaf that holds the triangle. Coordinates are multiples of 2⁻¹⁰ below 2¹², so that the
/// sample points are exact in `f64`.
fn assert_covered(tree: &Tree, mesh: &Mesh) {
    assert!(tree.max_depth() <= MAX_DEPTH);
    let mut boxes = vec![Vec::new(); mesh.triangles.len()];
    for (node, refs) in leaves(tree, mesh) {
        refs.iter().for_each(|r| boxes[*r as usize].push(node.bounds()));
    }
    const STEPS: u32 = 32;
    for (i, boxes) in boxes.iter().enumerate() {
        let corners = mesh.corners(i).map(|c| c.map(f64::from));
        for (a, b) in (0..=STEPS).flat_map(|a| (0..=STEPS - a).map(move |b| (a, b))) {
            let weights = [a, b, STEPS - a - b].map(|w| f64::from(w) / f64::from(STEPS));
            let p = [0, 1, 2].map(|k| (0..3).map(|c| corners[c][k] * weights[c]).sum::<f64>());
            let covered =
                boxes.iter().any(|b| (0..3).all(|k| f64::from(b.min[k]) <= p[k] && p[k] <= f64::from(b.max[k])));
            assert!(covered, "point {p:?} of triangle {i} is in none of {boxes:?}");
        }
    }
}

#[test]
fn alpha_one_never_splits_space_and_alpha_zero_does_most() {
    let mesh = turned_colonnade(12);
    let with = |split_alpha| build(&mesh, &BuildOptions { split_alpha, split_budget: 2.0, ..best() });
    let [full, some, plain] = [0.0, 0.3, 1.0].map(with);
    assert_eq!(plain.refs.len(), mesh.triangles.len());
    assert!(full.refs.len() > some.refs.len() && some.refs.len() >= plain.refs.len());
    assert!(sah(&full.nodes) < sah(&plain.nodes));
    [full, some, plain].iter().for_each(|t| assert_covered_roughly(t, &mesh));
}

/// For meshes whose coordinates are no dyadic numbers: corners only.
fn assert_covered_roughly(tree: &Tree, mesh: &Mesh) {
    let mut boxes = vec![Aabb::EMPTY; mesh.triangles.len()];
    for (node, refs) in leaves(tree, mesh) {
        refs.iter().for_each(|r| boxes[*r as usize] = boxes[*r as usize].union(node.bounds()));
    }
    assert!((0..boxes.len()).all(|i| boxes[i].contains(&mesh.triangle_box(i))));
}

#[test]
fn splits_pay_on_a_colonnade_that_stands_askew() {
    let mesh = turned_colonnade(24);
    let plain = sah(&build(&mesh, &BuildOptions { method: Method::Binned, ..best() }).nodes);
    let split = sah(&build(&mesh, &best()).nodes);
    assert!(split <= 0.8 * plain, "{split} against {plain}");
}

#[test]
fn a_budget_of_one_makes_no_duplicates_and_no_worse_a_tree_than_binned() {
    let mesh = turned_colonnade(16);
    let tree = build(&mesh, &BuildOptions { split_budget: 1.0, ..best() });
    let binned = build(&mesh, &BuildOptions { method: Method::Binned, ..best() });
    assert_eq!(tree.refs.len(), mesh.triangles.len());
    assert!(sah(&tree.nodes) <= 1.02 * sah(&binned.nodes), "{} against {}", sah(&tree.nodes), sah(&binned.nodes));
}

#[test]
fn needles_across_the_scene_stay_in_the_budget() {
    let mesh = needles(700);
    for (split_budget, unsplit, clip) in
        [(1.1, true, Clip::Exact), (1.5, false, Clip::Exact), (4.0, true, Clip::Box), (8.0, false, Clip::Exact)]
    {
        let options = BuildOptions { split_alpha: 0.0, split_budget, unsplit, clip, ..best() };
        let tree = build(&mesh, &options);
        assert!(tree.refs.len() <= budgeted_slots(700, split_budget));
        // Every plane cuts more needles than a tight budget pays for, and half of a needle's box is no tighter than the box.
        let pays = split_budget >= 1.5 && clip == Clip::Exact;
        assert!(tree.refs.len() > 700 || !pays, "no split at all with a budget of {split_budget}");
        assert_covered(&tree, &mesh);
    }
}

#[test]
fn exact_clipping_beats_box_clipping_on_slanted_triangles() {
    let mesh = needles(2000);
    let with = |clip| sah(&build(&mesh, &BuildOptions { split_budget: 3.0, clip, ..best() }).nodes);
    let (exact, boxes) = (with(Clip::Exact), with(Clip::Box));
    assert!(exact <= boxes, "{exact} against {boxes}");
}

#[test]
fn unsplitting_saves_duplicates() {
    let mesh = turned_colonnade(16);
    let with = |unsplit| build(&mesh, &BuildOptions { unsplit, split_budget: 3.0, ..best() });
    let (on, off) = (with(true), with(false));
    assert!(on.refs.len() < off.refs.len(), "{} against {}", on.refs.len(), off.refs.len());
    assert!(sah(&on.nodes) <= 1.05 * sah(&off.nodes));
}

#[test]
fn a_regular_grid_is_hardly_split_though_planes_hit_its_corners() {
    let mesh = grid(48);
    for split_alpha in [0.0, 1e-4] {
        let tree = build(&mesh, &BuildOptions { split_alpha, ..best() });
        assert!(tree.refs.len() as f64 <= 1.02 * mesh.triangles.len() as f64, "{}", tree.refs.len());
        assert_covered(&tree, &mesh);
    }
}

#[test]
fn threads_make_no_difference() {
    let mut mesh = grid(110);
    let long = needles(3000);
    let base = mesh.positions.len() as u32;
    mesh.triangles.extend(long.triangles.iter().map(|t| t.map(|v| v + base)));
    mesh.positions.extend(long.positions.iter().map(|p| p.map(|v| v / 8.0)));
    assert!(mesh.triangles.len() > CHUNKED);
    let alone = build(&mesh, &best());
    for jobs in [2, 7] {
        let tree = initial_tree(&mesh, &best(), &Executor::new(jobs).unwrap(), &NoProgress).unwrap();
        assert!(tree == alone, "{jobs} threads");
    }
}

#[test]
fn hopeless_geometry_ends_in_a_tree() {
    let same = [[0.0, 0.0, 0.0], [4.0, 1.0, 0.0], [0.0, 4.0, 2.0]];
    let scenes = [
        mesh(&[same; 500]),
        mesh(&[[[1.0; 3]; 3]; 100]),
        mesh(&(0..200).map(|i| [[0.0; 3], [i as f32, 0.0, 0.0], [512.0, 0.0, 0.0]]).collect::<Vec<_>>()),
        mesh(&(0..200).map(|i| [[-512.0, 0.0, 0.0], [512.0, 0.0, i as f32], [0.0, 512.0, 0.0]]).collect::<Vec<_>>()),
        mesh(&[same]),
    ];
    for mesh in &scenes {
        for unsplit in [true, false] {
            let tree = build(mesh, &BuildOptions { split_alpha: 0.0, split_budget: 3.0, unsplit, ..best() });
            assert_covered(&tree, mesh);
        }
    }
    let far = |size: f32| {
        mesh(&(0..300).map(|i| [[-size; 3], [size; 3], [size, -size, size * (i as f32 / 300.0)]]).collect::<Vec<_>>())
    };
    for size in [f32::MAX, 1e30, 1e-30, 1e-44] {
        let mesh = far(size);
        let tree = build(&mesh, &BuildOptions { split_alpha: 0.0, split_budget: 3.0, ..best() });
        assert!(tree.refs.len() <= 900 && tree.max_depth() <= MAX_DEPTH);
        assert_covered_roughly(&tree, &mesh);
    }
}

#[test]
fn what_the_children_of_an_object_split_share_speaks_for_dividing_space() {
    let (mut random, exec) = (Random(5), Executor::sequential());
    let mut dearer = 0;
    for _ in 0..200 {
        let triangles: Vec<[Point; 3]> = (0..40)
            .map(|_| {
                let at = [0; 3].map(|_| random.next() * 64.0);
                [0; 3].map(|_| at.map(|c| c + random.next() * 24.0))
            })
            .collect();
        let mesh = mesh(&triangles);
        let mut refs = PrimRefs::of_mesh(&mesh, 40, &exec);
        let node = NodeTask { bounds: refs.bounds, centroids: refs.centroids, live: 40, depth: 0 };
        let strategy = Spatial::new(&mesh, &node.bounds, &BuildOptions { unsplit: false, ..best() });
        let object = strategy.find_object(&node, &refs.refs[..40], &exec).unwrap();
        let plane = strategy.planes.best(&node, &refs.refs[..40], 40, f32::INFINITY, &exec).unwrap();
        let Decision::Split { left, right } = strategy.split(&node, &mut refs.refs, &exec) else { continue };
        if left.live + right.live > 40 && plane.weight > object.weight() {
            let shared = shared_area(&object, area_scale(&node.bounds));
            assert!(plane.weight < object.weight() + SHARED * shared * 40.0);
            dearer += 1;
        }
    }
    assert!(dearer > 10, "{dearer}");
}

/// A multiple of 2⁻⁴ within ±64, small integers often.
fn coordinate() -> impl proptest::strategy::Strategy<Value = f32> {
    proptest::prop_oneof![(-8i32..=8).prop_map(|i| i as f32), (-1024i32..=1024).prop_map(|i| i as f32 / 16.0)]
}

proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(96))]

    #[test]
    fn soups_are_covered_whatever_the_options(
        triangles in prop::collection::vec([[coordinate(), coordinate(), coordinate()], [coordinate(), coordinate(), coordinate()], [coordinate(), coordinate(), coordinate()]], 1..120),
        split_alpha in proptest::prop_oneof![prop::strategy::Just(0.0f32), 0.0f32..0.1],
        split_budget in 1.0f32..6.0,
        spatial_bins in 2u32..64,
        max_leaf in 1u32..9,
        unsplit: bool,
        exact: bool,
    ) {
        let mesh = mesh(&triangles);
        let clip = if exact { Clip::Exact } else { Clip::Box };
        let tree = build(&mesh, &BuildOptions { split_alpha, split_budget, spatial_bins, max_leaf, unsplit, clip, ..best() });
        prop_assert!(tree.refs.len() <= budgeted_slots(triangles.len(), split_budget));
        assert_covered(&tree, &mesh);
    }
}

/// References may have boxes that their triangles miss in part: what earlier cuts on other axes left. A plane may then turn out to
/// divide nothing, after the references were put in another order.
#[test]
fn children_contain_their_references_however_loose_the_boxes() {
    let mut random = Random(11);
    let mut divided = 0;
    for round in 0..40_000 {
        let mut point = || [0; 3].map(|_| (random.next() * 64.0).round());
        let count = 2 + round % 7;
        let triangles: Vec<[Point; 3]> = (0..count).map(|_| [point(), point(), point()]).collect();
        let mesh = mesh(&triangles);
        let mut slots: Vec<PrimRef> = (0..count)
            .map(|i| {
                let bounds = mesh.triangle_box(i).intersection(Aabb::from_points(&[point(), point()]));
                PrimRef::new(&if bounds.is_empty() { mesh.triangle_box(i) } else { bounds }, i as u32)
            })
            .collect();
        let (bounds, centroids) = bounds_of(&slots);
        slots.resize(2 * count, PrimRef::new(&Aabb::EMPTY, 0));
        let options = BuildOptions { split_alpha: 0.0, unsplit: round % 2 == 0, max_leaf: 1, ..best() };
        let node = NodeTask { bounds, centroids, live: count, depth: 0 };
        let decision = Spatial::new(&mesh, &bounds, &options).split(&node, &mut slots, &Executor::sequential());
        let Decision::Split { left, right } = decision else { continue };
        divided += usize::from(left.live + right.live > count);
        let sides = [(left, &slots[..left.live]), (right, &slots[left.slots..left.slots + right.live])];
        let mut found = vec![false; count];
        for (child, refs) in sides {
            for r in refs {
                assert!(child.bounds.contains(&r.bounds()), "round {round}: {:?} in {:?}", r.bounds(), child.bounds);
                found[r.prim as usize] = true;
            }
        }
        assert!(found.iter().all(|f| *f), "round {round}");
    }
    assert!(divided > 0);
}
