use super::super::emit::emit;
use super::super::links::Links;
use super::guide::Segment;
use super::*;
use crate::build::{BuildOptions, Method, NoProgress, Preset, initial_tree};
use crate::geom::{Aabb, Ray};
use crate::random::Random;
use crate::scene::Mesh;
use crate::tree::{MAX_DEPTH, Node, Tree, quality};

fn point(random: &mut Random, size: f32) -> [f32; 3] {
    [0; 3].map(|_| size * random.unit() as f32)
}

/// A tree of single boxes.
#[derive(Clone)]
enum Shape {
    Leaf(u32),
    Pair(Box<(Shape, Shape)>),
}

use Shape::Leaf;

fn pair(a: Shape, b: Shape) -> Shape {
    Shape::Pair(Box::new((a, b)))
}

fn tree_of(shape: &Shape, boxes: &[Aabb]) -> Tree {
    fn put(tree: &mut Tree, at: usize, shape: &Shape, boxes: &[Aabb]) -> Aabb {
        match shape {
            Leaf(i) => {
                tree.nodes[at] = Node::leaf(boxes[*i as usize], tree.refs.len() as u32, 1);
                tree.refs.push(*i);
            }
            Shape::Pair(children) => {
                let first = tree.nodes.len();
                tree.nodes.extend([<Node as bytemuck::Zeroable>::zeroed(); 2]);
                let (a, b) = (put(tree, first, &children.0, boxes), put(tree, first + 1, &children.1, boxes));
                tree.nodes[at] = Node::inner(a.union(b), first as u32);
            }
        }
        tree.nodes[at].bounds()
    }
    let mut tree = Tree { nodes: vec![bytemuck::Zeroable::zeroed(); 2], refs: Vec::new() };
    put(&mut tree, 0, shape, boxes);
    tree
}

/// Adapted on so many threads, and how many treelets were changed; whatever happened, the work tree must be in order.
fn adapted(tree: &Tree, guide: &Guide, jobs: usize) -> (Tree, usize) {
    let exec = Executor::new(jobs).unwrap();
    let Some(mut work) = WorkTree::new(tree, &exec) else { return (tree.clone(), 0) };
    let mut visits = guide.visits(&work, &exec);
    let changed = descend(&mut work, &mut visits, guide, &exec, &NoProgress).unwrap();
    assert_eq!(visits, guide.visits(&work, &exec), "visits are kept right");
    for at in 0..work.slots.len() as u32 {
        if at != 1 && !work.slots[at as usize].is_leaf() {
            for child in work.slots[at as usize].children() {
                assert_eq!(work.parent(child), Some(at));
            }
        }
    }
    let after = emit(&work, &tree.refs, None, &exec);
    let heights = Links::of(&after, &exec).heights;
    assert_eq!(work.height(0), heights[0]);
    let inner_area: f64 =
        work.slots.iter().enumerate().filter(|(i, s)| *i != 1 && !s.is_leaf()).map(|(_, s)| f64::from(s.area)).sum();
    assert!((work.inner_area - inner_area).abs() <= 1e-9 * inner_area, "{} {inner_area}", work.inner_area);
    (after, changed)
}

/// Inner nodes that the rays visit, and imagined ones by their areas.
fn price(tree: &Tree, guide: &Guide) -> f64 {
    let root = f64::from(tree.bounds().half_area());
    let inner = tree.nodes.iter().enumerate().filter(|(i, n)| *i != 1 && !n.is_leaf()).map(|(_, n)| n);
    inner
        .map(|n| {
            let met = guide.segments.iter().filter(|s| s.meets(&n.min, &n.max)).count();
            met as f64 + f64::from(best::PSEUDO_RAYS) * f64::from(n.bounds().half_area()) / root
        })
        .sum()
}

fn unit_box(x: f32, y: f32) -> Aabb {
    Aabb { min: [x, y, 0.0], max: [x + 1.0, y + 1.0, 1.0] }
}

#[test]
fn what_most_rays_meet_comes_to_the_top() {
    // Four boxes in a row, the outer and the inner ones paired, and rays through the first one only.
    let boxes = [0.0, 10.0, 20.0, 30.0].map(|x| unit_box(x, 0.0));
    let tree = tree_of(&pair(pair(Leaf(0), Leaf(3)), pair(Leaf(1), Leaf(2))), &boxes);
    let rays = [Ray::new([0.5, 0.5, -1.0], [0.0, 0.0, 1.0]); 500];
    let (after, changed) = adapted(&tree, &Guide::new(&rays), 1);
    assert!(changed > 0);
    let top = [2, 3].map(|i| after.nodes[i]);
    let alone = top.iter().find(|n| n.is_leaf()).expect("one box stands alone under the root");
    assert_eq!((alone.bounds(), after.refs.len()), (boxes[0], 4));

    // Fewer rays than are looked at, or none, decide nothing.
    for count in [0, LEAST_RAYS - 1] {
        assert_eq!(adapted(&tree, &Guide::new(&rays[..count]), 1), (tree.clone(), 0));
    }
}

/// All trees over the boxes.
fn all_shapes(count: u32) -> Vec<Shape> {
    fn with(shape: &Shape, leaf: u32, out: &mut Vec<Shape>) {
        out.push(pair(shape.clone(), Leaf(leaf)));
        if let Shape::Pair(children) = shape {
            let mut inside = Vec::new();
            with(&children.0, leaf, &mut inside);
            out.extend(inside.drain(..).map(|a| pair(a, children.1.clone())));
            with(&children.1, leaf, &mut inside);
            out.extend(inside.into_iter().map(|b| pair(children.0.clone(), b)));
        }
    }
    let mut shapes = vec![Leaf(0)];
    for leaf in 1..count {
        let mut next = Vec::new();
        shapes.iter().for_each(|shape| with(shape, leaf, &mut next));
        shapes = next;
    }
    shapes
}

#[test]
fn no_tree_over_a_handful_of_boxes_is_cheaper() {
    let mut random = Random::new(5);
    let shapes = all_shapes(6);
    assert_eq!(shapes.len(), 945);
    let mut changes = 0;
    for round in 0..20 {
        let boxes: Vec<Aabb> = (0..6)
            .map(|_| {
                let min = point(&mut random, 8.0);
                let size = point(&mut random, 3.0);
                Aabb { min, max: [0, 1, 2].map(|k| min[k] + size[k]) }
            })
            .collect();
        let rays: Vec<Ray> = (0..400)
            .map(|_| {
                let (from, to) = (point(&mut random, 10.0), point(&mut random, 10.0));
                Ray::new(from, [0, 1, 2].map(|k| to[k] - from[k])).until(1.0)
            })
            .collect();
        let guide = Guide::new(&rays);
        let tree = tree_of(&shapes[(round * 97) % shapes.len()], &boxes);
        let exec = Executor::sequential();
        let mut work = WorkTree::new(&tree, &exec).unwrap();
        let mut visits = guide.visits(&work, &exec);
        // At the root alone: where its parts are looked at in their turn, imagined rays pass through those.
        let Found { treelet, rays } = Workshop::default().best(&work, &visits, &guide, 0, 0, &guide.all());
        if let Some(treelet) = treelet {
            changes += 1;
            put_together(&mut work, &mut visits, &treelet);
        }
        for (child, rays) in work.slots[0].children().into_iter().zip(rays) {
            let child = &work.slots[child as usize];
            assert_eq!(rays, guide.among(&guide.all(), &child.min, &child.max));
        }
        let after = emit(&work, &tree.refs, None, &exec);
        let least = shapes.iter().map(|s| price(&tree_of(s, &boxes), &guide)).fold(f64::INFINITY, f64::min);
        // A gain of one visit is not worth a change.
        assert!(price(&after, &guide) <= least + 1.01, "{} above {least}", price(&after, &guide));
    }
    assert!(changes >= 15, "{changes}");
}

/// Triangles strewn over a cube, so dense that few of those inside are seen from outside.
fn mesh(count: u32) -> Mesh {
    let mut random = Random::new(1);
    let mut positions = Vec::new();
    for _ in 0..count {
        let at = point(&mut random, 10.0);
        positions.extend([0; 3].map(|_| {
            let d = point(&mut random, 1.0);
            [0, 1, 2].map(|k| at[k] + d[k])
        }));
    }
    let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh { positions, triangles, ..Mesh::default() }
}

#[test]
fn a_whole_tree_gets_cheaper_for_its_rays_keeps_its_leaves_and_depends_on_no_thread() {
    let (mesh, mut random) = (mesh(6000), Random::new(3));
    // Short ones, all in a corner, where areas say nothing about them.
    let rays: Vec<Ray> =
        (0..6000).map(|_| Ray::new(point(&mut random, 4.0), random.direction().map(|c| c as f32)).until(2.0)).collect();
    for method in [Method::Binned, Method::Sbvh] {
        let options = BuildOptions { method, ..BuildOptions::preset(Preset::Draft) };
        let tree = initial_tree(&mesh, &options, &Executor::sequential(), &NoProgress).unwrap();
        let guide = Guide::new(&rays);
        let (after, changed) = adapted(&tree, &guide, 1);
        assert!(changed > 50, "{changed}");
        let [was, is] = [&tree, &after].map(|t| {
            let inner = t.nodes.iter().enumerate().filter(|(i, n)| *i != 1 && !n.is_leaf()).map(|(_, n)| n);
            inner.map(|n| guide.segments.iter().filter(|s| s.meets(&n.min, &n.max)).count()).sum::<usize>()
        });
        assert!(is * 100 < was * 98, "{was} visits became {is}");

        let leaves = |t: &Tree| {
            let leaf = |n: &Node| {
                (t.refs[n.first as usize..(n.first + n.count) as usize].to_vec(), n.bounds().min.map(f32::to_bits))
            };
            let mut all: Vec<_> = t.nodes.iter().filter(|n| n.is_leaf()).map(leaf).collect();
            all.sort();
            all
        };
        assert!(leaves(&tree) == leaves(&after));
        assert_eq!(adapted(&tree, &guide, 3).0, after);
        assert!(quality::sah(&after.nodes) < 1.2 * quality::sah(&tree.nodes));
    }
}

#[test]
fn no_leaf_comes_to_lie_deeper_than_allowed() {
    // A chain as deep as may be, and rays that would have its lower end at the top, or at the bottom of something else.
    let boxes: Vec<Aabb> = (0..65).map(|i| unit_box(3.0 * i as f32, (i % 7) as f32)).collect();
    let chain = (1..65).fold(Leaf(0), |below, i| pair(below, Leaf(i)));
    let tree = tree_of(&chain, &boxes);
    assert_eq!(tree.max_depth(), MAX_DEPTH);
    for target in [0usize, 20, 63] {
        let at = boxes[target].min;
        let rays = vec![Ray::new([at[0] + 0.5, at[1] + 0.5, -1.0], [0.0, 0.0, 1.0]); 900];
        let (after, changed) = adapted(&tree, &Guide::new(&rays), 1);
        assert!(after.max_depth() <= MAX_DEPTH && after.refs.len() == 65);
        assert!(changed > 0 || target == 63, "{target}");
    }
}

#[test]
fn rays_along_an_axis_and_from_within_a_face_count_as_others() {
    let b = unit_box(0.0, 0.0);
    let meets = |origin: [f32; 3], direction: [f32; 3]| Segment::of(&Ray::new(origin, direction)).meets(&b.min, &b.max);
    assert!(meets([0.5, 0.5, -3.0], [0.0, 0.0, 1.0]) && meets([0.0, 0.5, -3.0], [0.0, 0.0, 1.0]));
    assert!(meets([0.5, 0.5, 0.5], [1.0, -0.0, 0.0]) && !meets([1.5, 0.5, 0.5], [1.0, 0.0, 0.0]));
    assert!(!meets([2.0, 0.5, -3.0], [0.0, -0.0, 1.0]) && !meets([0.5, 0.5, -3.0], [0.0, 0.0, -1.0]));
    let short = Segment::of(&Ray::new([0.5, 0.5, -3.0], [0.0, 0.0, 1.0]).until(2.9));
    assert!(!short.meets(&b.min, &b.max));
}
