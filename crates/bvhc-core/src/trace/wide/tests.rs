use super::block::LANES;
use super::{Collapse, CompactTrees, WideTrees, WideView};
use crate::geom::{Aabb, Ray};
use crate::layout::{BlasRecord, MAX_DEPTH, Node, TriangleRecord, View, WideNode, WideRow};
use crate::random::Random;
use crate::trace::{Malformed, closest_hit};
use bytemuck::Zeroable;

/// One tree over triangles that stand in a row.
struct Scene {
    nodes: Vec<Node>,
    triangles: Vec<TriangleRecord>,
    blases: [BlasRecord; 1],
}

/// A tree to be: a leaf of some triangles, or two of them.
enum Sketch {
    Leaf(u32),
    Pair(Box<Sketch>, Box<Sketch>),
}

impl Sketch {
    fn pair(left: Sketch, right: Sketch) -> Sketch {
        Sketch::Pair(Box::new(left), Box::new(right))
    }

    /// A random tree of so many leaves.
    fn random(leaves: u64, random: &mut Random) -> Sketch {
        if leaves == 1 {
            return Sketch::Leaf(1 + random.below(5) as u32);
        }
        let left = 1 + random.below(leaves - 1);
        Sketch::pair(Sketch::random(left, random), Sketch::random(leaves - left, random))
    }
}

impl Scene {
    fn new(sketch: &Sketch, random: &mut Random) -> Scene {
        let zero = Node::zeroed();
        let mut scene = Scene { nodes: vec![zero; 2], triangles: Vec::new(), blases: [BlasRecord::zeroed()] };
        scene.fill(0, sketch, random);
        scene.blases[0].node_count = scene.nodes.len() as u32;
        scene.blases[0].ref_count = scene.triangles.len() as u32;
        scene
    }

    fn fill(&mut self, at: usize, sketch: &Sketch, random: &mut Random) -> Aabb {
        let (bounds, node) = match sketch {
            Sketch::Leaf(count) => {
                let first = self.triangles.len() as u32;
                let mut bounds = Aabb::EMPTY;
                for i in 0..*count {
                    let mut corner = || [0; 3].map(|_| random.unit() as f32 * 4.0);
                    let (v0, v1, v2) = (corner(), corner(), corner());
                    bounds = bounds.union(Aabb::from_points(&[v0, v1, v2]));
                    self.triangles.push(TriangleRecord { v0, prim: first + i, v1, geom: 0, v2, flags: 0 });
                }
                (bounds, Node::leaf(bounds, first, *count))
            }
            Sketch::Pair(left, right) => {
                let first = self.nodes.len();
                self.nodes.extend([Node::zeroed(); 2]);
                let bounds = self.fill(first, left, random).union(self.fill(first + 1, right, random));
                (bounds, Node::inner(bounds, first as u32))
            }
        };
        self.nodes[at] = node;
        bounds
    }

    fn view(&self) -> View<'_> {
        let Scene { nodes, triangles, blases } = self;
        View { nodes, triangles, geoms: &[], blases, tlas_nodes: &[], instances: &[] }
    }
}

fn area(b: &Aabb) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|axis| f64::from(b.max[axis]) - f64::from(b.min[axis]));
    x * y + y * z + z * x
}

/// What wide nodes cost, read off the nodes themselves.
fn cost_of<const N: usize>(nodes: &[WideNode<N>], root: &Aabb, collapse: &Collapse) -> f64 {
    let own = |(i, node): (usize, &WideNode<N>)| {
        let parent = nodes
            .iter()
            .find_map(|n| (0..N).find(|l| n.count[*l] == 0 && n.first[*l] == i as u32).map(|l| n.bounds(l)));
        let bounds = if i == 0 { *root } else { parent.expect("a parent") };
        let leaves = (0..N).filter(|lane| node.count[*lane] > 0);
        let leaves: f64 = leaves.map(|lane| area(&node.bounds(lane)) * collapse.leaf_cost(node.count[lane])).sum();
        area(&bounds) * collapse.node_cost + leaves
    };
    nodes.iter().enumerate().map(own).sum()
}

/// The least cost of a node in one lane, by trying every set of nodes that could be its children.
fn least<const N: usize>(scene: &Scene, node: u32, collapse: &Collapse) -> f64 {
    let record = &scene.nodes[node as usize];
    let size = area(&record.bounds());
    let count = below(scene, node);
    let as_leaf =
        if record.is_leaf() || count <= collapse.max_leaf { size * collapse.leaf_cost(count) } else { f64::INFINITY };
    if record.is_leaf() {
        return as_leaf;
    }
    let both = cuts(scene, record.first, N - 1).into_iter().flat_map(|left| {
        let room = N - left.len();
        cuts(scene, record.first + 1, room).into_iter().map(move |right| [left.clone(), right].concat())
    });
    let of_cut = |cut: Vec<u32>| cut.iter().map(|n| least::<N>(scene, *n, collapse)).sum::<f64>();
    as_leaf.min(both.map(of_cut).fold(f64::INFINITY, f64::min) + size * collapse.node_cost)
}

fn below(scene: &Scene, node: u32) -> u32 {
    let record = &scene.nodes[node as usize];
    if record.is_leaf() { record.count } else { below(scene, record.first) + below(scene, record.first + 1) }
}

/// All ways to put what is below a node into at most so many lanes.
fn cuts(scene: &Scene, node: u32, lanes: usize) -> Vec<Vec<u32>> {
    let mut out = vec![vec![node]];
    let record = &scene.nodes[node as usize];
    if lanes > 1 && !record.is_leaf() {
        for left in cuts(scene, record.first, lanes - 1) {
            let rights = cuts(scene, record.first + 1, lanes - left.len());
            out.extend(rights.into_iter().map(|right| [left.clone(), right].concat()));
        }
    }
    out
}

fn assert_least<const N: usize>(scene: &Scene, collapse: &Collapse) {
    let trees = WideTrees::<N>::new(&scene.view(), collapse).unwrap();
    let root = scene.nodes[0].bounds();
    let mut want = least::<N>(scene, 0, collapse);
    if trees.nodes[0].children() == 1 {
        // A tree of one leaf has a node about it nevertheless.
        want += area(&root) * collapse.node_cost;
    }
    let cost = cost_of(&trees.nodes, &root, collapse);
    assert!((cost - want).abs() <= 1e-9 * want, "{N} lanes, {collapse:?}: {cost} instead of {want}");
}

#[test]
fn no_set_of_nodes_costs_less_than_the_plan() {
    let mut random = Random::new(3);
    for case in 0..300 {
        let sketch = Sketch::random(1 + case % 12, &mut random);
        let scene = Scene::new(&sketch, &mut random);
        for (max_leaf, group_cost) in [(8, 1.0), (4, 0.3), (1, 1.0), (255, 0.1), (u32::MAX, 0.01)] {
            let collapse = Collapse { max_leaf, group_cost, ..Collapse::default() };
            assert_least::<4>(&scene, &collapse);
            assert_least::<8>(&scene, &collapse);
        }
    }
}

/// Every triangle once and in order, every box that of what is below, children in the first lanes, nodes before those below them, and leaves in blocks of
/// their own.
fn assert_sound<const N: usize>(scene: &Scene, trees: &WideTrees<N>) {
    let mut next_ref = 0;
    let mut next_node = 1;
    let mut pending = vec![0u32];
    while let Some(index) = pending.pop() {
        let node = &trees.nodes[index as usize];
        let children = node.children();
        assert!(children > 0 && (0..N).all(|lane| node.has(lane) == (lane < children)), "{node:?}");
        assert!((children..N).all(|lane| node.bounds(lane) == Aabb::EMPTY));
        for lane in (0..children).rev().filter(|lane| node.count[*lane] == 0) {
            pending.push(node.first[lane]);
        }
        if let Some(lane) = (0..children).find(|lane| node.count[*lane] == 0) {
            assert_eq!(node.first[lane], next_node, "a node's first child stands behind it");
        }
        next_node += 1;
    }
    assert_eq!(next_node as usize, trees.nodes.len() + 1);
    // References, lane after lane, as a walk in order comes to them.
    let mut walk = vec![(0u32, 0usize)];
    while let Some((index, lane)) = walk.pop() {
        let node = &trees.nodes[index as usize];
        if lane == node.children() {
            continue;
        }
        walk.push((index, lane + 1));
        if node.count[lane] == 0 {
            walk.push((node.first[lane], 0));
            let inside = &trees.nodes[node.first[lane] as usize];
            let union = (0..inside.children()).fold(Aabb::EMPTY, |b, l| b.union(inside.bounds(l)));
            assert_eq!(union, node.bounds(lane));
        } else {
            let (first, count) = (node.first[lane] as usize, node.count[lane]);
            let refs: Vec<u32> = (next_ref..next_ref + count).collect();
            assert_eq!((first % LANES, &trees.order[first..][..refs.len()]), (0, &refs[..]));
            for (place, slot) in (first..).zip(&refs) {
                let corners = trees.blocks[place / LANES].triangle(place % LANES).corners();
                assert_eq!(corners, scene.triangles[*slot as usize].corners());
            }
            next_ref += count;
        }
    }
    assert_eq!(next_ref as usize, scene.triangles.len());
    assert_eq!(trees.order.iter().filter(|slot| **slot != u32::MAX).count(), scene.triangles.len());
    assert_eq!(trees.order.len(), trees.blocks.len() * LANES);
}

#[test]
fn wide_trees_are_sound() {
    let mut random = Random::new(4);
    for case in 0..200 {
        let sketch = Sketch::random(1 + case, &mut random);
        let scene = Scene::new(&sketch, &mut random);
        let view = scene.view();
        assert_sound(&scene, &WideTrees::<8>::new(&view, &Collapse::default()).unwrap());
        assert_sound(&scene, &WideTrees::<4>::new(&view, &Collapse { max_leaf: 1, ..Collapse::default() }).unwrap());
        assert_sound(&scene, &WideTrees::<8>::greedy(&view).unwrap());
    }
}

/// Leaves that are not consecutive become no common leaf, which would have other triangles than theirs.
#[test]
fn leaves_in_another_order_are_kept_apart() {
    let mut random = Random::new(5);
    let three = Sketch::pair(Sketch::Leaf(1), Sketch::pair(Sketch::Leaf(1), Sketch::Leaf(1)));
    let mut scene = Scene::new(&three, &mut random);
    let leaves = |trees: WideTrees<8>| {
        let node = trees.nodes[0];
        (0..node.children()).map(|l| (trees.order[node.first[l] as usize], node.count[l])).collect::<Vec<_>>()
    };
    let collapse = Collapse { group_cost: 0.01, ..Collapse::default() };
    assert_eq!(leaves(WideTrees::new(&scene.view(), &collapse).unwrap()), [(0, 3)]);
    let turned: Vec<usize> = (0..scene.nodes.len()).filter(|i| scene.nodes[*i].is_leaf()).collect();
    let firsts = turned.iter().map(|i| scene.nodes[*i].first).collect::<Vec<_>>();
    for (i, first) in turned.iter().zip(firsts.iter().rev()) {
        scene.nodes[*i].first = *first;
    }
    assert_eq!(leaves(WideTrees::new(&scene.view(), &collapse).unwrap()), [(2, 1), (1, 1), (0, 1)]);
}

/// Lane by lane the same leaves, in boxes that hold those of the wide nodes, and each triangle once.
fn assert_alike(wide: &WideTrees<8>, compact: &CompactTrees, scene: &Scene) {
    let mut pairs = vec![(0usize, 0usize)];
    let mut seen = 0;
    while let Some((from, to)) = pairs.pop() {
        let (node, small) = (&wide.nodes[from], &compact.nodes[to]);
        assert_eq!(usize::from(small.children), node.children());
        let (mut next_node, mut next_ref) = (small.first_node as usize, small.first_ref as usize);
        for lane in 0..node.children() {
            let (b, held) = (small.bounds(lane), node.bounds(lane));
            assert!((0..3).all(|axis| b.min[axis] <= held.min[axis] && b.max[axis] >= held.max[axis]), "{small:?}");
            let count = node.count[lane] as usize;
            assert_eq!(usize::from(small.counts[lane]), count);
            if count == 0 {
                pairs.push((node.first[lane] as usize, next_node));
                next_node += 1;
            } else {
                let refs = &wide.order[node.first[lane] as usize..][..count];
                assert_eq!(&compact.order[next_ref..next_ref + count], refs);
                next_ref += count;
            }
        }
        seen += 1;
    }
    assert_eq!(seen, compact.nodes.len());
    let mut order = compact.order.clone();
    order.sort_unstable();
    assert!(order.iter().copied().eq(0..scene.triangles.len() as u32));
}

#[test]
fn compact_trees_are_the_wide_ones_and_answer_like_them() {
    let mut random = Random::new(8);
    let mut hits = 0;
    for case in 0..60 {
        let sketch = Sketch::random(1 + 3 * case, &mut random);
        let scene = Scene::new(&sketch, &mut random);
        let view = scene.view();
        let wide = WideTrees::<8>::new(&view, &Collapse::default()).unwrap();
        let compact = CompactTrees::new(&wide);
        assert_alike(&wide, &compact, &scene);
        for ray in rays(100, &mut random) {
            let want = closest_hit(&view, &ray);
            assert_eq!(wide.view(&view).closest_hit(&ray), want, "{ray:?}");
            assert_eq!(compact.view(&view).closest_hit(&ray), want, "{ray:?}");
            hits += usize::from(want.unwrap().is_some());
        }
    }
    assert!(hits > 1000, "{hits}");
    let none = CompactTrees::new(&WideTrees {
        rows: vec![WideRow { node_offset: 0, node_count: 0, waiting: 0 }],
        ..WideTrees::default()
    });
    assert_eq!((none.nodes.len(), none.order.len(), none.rows.len()), (0, 0, 1));
}

#[test]
fn an_order_that_leads_nowhere_ends_in_an_error() {
    let mut random = Random::new(9);
    let scene = Scene::new(&Sketch::random(40, &mut random), &mut random);
    let view = scene.view();
    let compact = CompactTrees::new(&WideTrees::new(&view, &Collapse::default()).unwrap());
    let rays = rays(300, &mut random);
    let errors = |order: &[u32]| {
        let wide = WideView { order, ..compact.view(&view) };
        rays.iter().filter_map(|ray| wide.closest_hit(ray).err()).collect::<Vec<_>>()
    };
    assert_eq!(errors(&compact.order), []);
    let refs = scene.triangles.len();
    assert!(errors(&vec![u32::MAX; refs]).contains(&Malformed::LeafOutOfRange { first: u32::MAX, count: 1, refs }));
    assert_eq!(errors(&compact.order[1..])[0], Malformed::TreeOutOfRange { tree: 0 });
}

fn rays(count: usize, random: &mut Random) -> Vec<Ray> {
    let mut point = |scale: f32| [0; 3].map(|_| scale * (random.unit() as f32 - 0.25));
    (0..count).map(|_| Ray::new(point(8.0), point(2.0))).collect()
}

/// At each level of the deepest tree seven children wait.
#[test]
fn the_stack_has_room_for_the_deepest_trees() {
    let mut random = Random::new(6);
    let seven = |random: &mut Random| Sketch::random(7, random);
    let mut sketch = Sketch::Leaf(1);
    for _ in 0..MAX_DEPTH - 6 {
        sketch = Sketch::pair(seven(&mut random), sketch);
    }
    let scene = Scene::new(&sketch, &mut random);
    let view = scene.view();
    let trees = WideTrees::<8>::new(&view, &Collapse { max_leaf: 1, ..Collapse::default() }).unwrap();
    assert!(trees.rows[0].waiting > 6 * (MAX_DEPTH - 6), "{:?}", trees.rows);
    for ray in rays(500, &mut random) {
        assert_eq!(trees.view(&view).closest_hit(&ray), closest_hit(&view, &ray), "{ray:?}");
    }
}

#[test]
fn records_that_are_no_tree_end_in_an_error() {
    let mut random = Random::new(7);
    let scene = Scene::new(&Sketch::random(60, &mut random), &mut random);
    let view = scene.view();
    let trees = WideTrees::<8>::new(&view, &Collapse::default()).unwrap();
    let rays = rays(300, &mut random);
    let errors = |nodes: &[WideNode<8>], rows: &[WideRow]| {
        let wide = WideView { nodes, rows, ..trees.view(&view) };
        rays.iter().filter_map(|ray| wide.closest_hit(ray).err()).collect::<Vec<_>>()
    };
    assert_eq!(errors(&trees.nodes, &trees.rows), []);
    let inner = (0..8).find(|lane| trees.nodes[0].count[*lane] == 0).expect("a node below the root");
    let leaf = trees.nodes.iter().position(|n| n.count[0] > 0).expect("a leaf");
    let broken = |change: &dyn Fn(&mut Vec<WideNode<8>>)| {
        let mut nodes = trees.nodes.clone();
        change(&mut nodes);
        errors(&nodes, &trees.rows)
    };
    let count = trees.nodes.len();
    assert!(broken(&|n| n[0].first[inner] = 9999).contains(&Malformed::ChildOutOfRange { first: 9999, nodes: count }));
    let loops = |n: &mut Vec<WideNode<8>>| {
        (1..count).for_each(|i| n[i] = WideNode { first: [i as u32; 8], count: [0; 8], ..n[i] })
    };
    assert!(broken(&loops).iter().any(|e| matches!(e, Malformed::NotATree { .. } | Malformed::TooDeep)));
    let far = |n: &mut Vec<WideNode<8>>| n[leaf].first[0] = 1 << 30;
    assert!(broken(&far).iter().any(|e| matches!(e, Malformed::LeafOutOfRange { .. })));
    assert_eq!(errors(&trees.nodes, &[])[0], Malformed::TreeOutOfRange { tree: 0 });
    let beyond = WideRow { node_offset: u64::MAX, ..trees.rows[0] };
    assert_eq!(errors(&trees.nodes, &[beyond])[0], Malformed::TreeOutOfRange { tree: 0 });
    // What a walk cannot come to its end in is not collapsed either.
    let mut nodes = scene.nodes.clone();
    let inner = (2..nodes.len()).find(|i| !nodes[*i].is_leaf()).expect("an inner node");
    nodes[inner].first = inner as u32 & !1;
    let view = View { nodes: &nodes, ..view };
    assert!(WideTrees::<8>::new(&view, &Collapse::default()).is_err());
    assert!(WideTrees::<8>::greedy(&view).is_err());
}
