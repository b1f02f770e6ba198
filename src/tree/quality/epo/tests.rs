use super::*;
use crate::build::{BuildOptions, Method, NoProgress, Preset, initial_tree};
use crate::scene::Mesh;

fn flat(min: [f32; 3], max: [f32; 3]) -> Aabb {
    Aabb { min, max }
}

/// A unit right triangle at height z.
fn triangle(x: f32, z: f32) -> [Point; 3] {
    [[x, 0.0, z], [x + 1.0, 0.0, z], [x, 1.0, z]]
}

/// Two leaves: the first holds triangle 0 and reaches over half of the corner of triangle 1.
#[test]
fn a_hand_made_overlap() {
    let corners = [triangle(0.0, 0.0), triangle(1.0, 0.0)];
    let zero: Node = bytemuck::Zeroable::zeroed();
    let nodes = [
        Node::inner(flat([0.0; 3], [2.0, 1.0, 0.0]), 2),
        zero,
        Node::leaf(flat([0.0; 3], [1.5, 1.0, 0.0]), 0, 1),
        Node::leaf(flat([1.0, 0.0, 0.0], [2.0, 1.0, 0.0]), 1, 1),
    ];
    let tree = Subtrees::new(&nodes, &[0, 1], 2);
    // The half of triangle 1 with x < 1.5 has area 3/8; the surface 1. Triangle 0 only touches the other leaf, in a point.
    let one = exact(&tree, |t| corners[t], &Executor::sequential());
    assert!((one.epo() - 0.375).abs() < 1e-12, "{one:?}");
    assert_eq!(one.standard_error(), 0.0);
    let points = sampled(&tree, |t| corners[t], 10_000, MOST_VISITS, &Executor::sequential());
    assert!((points.epo() - 0.375).abs() < 0.01 && points.standard_error() < 0.01, "{points:?}");
    assert!((points.area - 1.0).abs() < 1e-12);

    // Two trees side by side: weighted by area, so twice the same is the same.
    assert!(((one + one).epo() - one.epo()).abs() < 1e-15);
}

#[test]
fn one_leaf_overlaps_with_nothing_and_no_tree_has_none() {
    let corners = [triangle(0.0, 0.0), triangle(0.0, 0.0)];
    let nodes = [Node::leaf(flat([0.0; 3], [1.0, 1.0, 0.0]), 0, 2), bytemuck::Zeroable::zeroed()];
    let tree = Subtrees::new(&nodes, &[0, 1], 2);
    assert_eq!(exact(&tree, |t| corners[t], &Executor::sequential()).epo(), 0.0);
    assert_eq!(sampled(&tree, |t| corners[t], 64, MOST_VISITS, &Executor::sequential()).epo(), 0.0);
    let none = Subtrees::new(&[], &[], 0);
    assert_eq!(exact(&none, |_| [[0.0; 3]; 3], &Executor::sequential()), EndPointOverlap::default());
    assert_eq!(sampled(&none, |_| [[0.0; 3]; 3], 64, MOST_VISITS, &Executor::sequential()), EndPointOverlap::default());
}

/// Slivers in all directions, so that boxes overlap and splits happen.
fn straw(count: usize) -> Mesh {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let mut mesh = Mesh::default();
    for i in 0..count as u32 {
        let (a, b) = ([next(), next(), next()], [next(), next(), next()]);
        mesh.positions.extend([a, b, [a[0] + 0.02, a[1], a[2] + 0.01]]);
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

/// The definition, node by node, with neither runs of slots nor a walk down.
fn by_definition(mesh: &Mesh, nodes: &[Node], refs: &[u32]) -> f64 {
    let held = |i: usize| {
        let (mut held, mut stack) = (vec![false; mesh.triangles.len()], vec![i]);
        while let Some(i) = stack.pop() {
            let (first, count) = (nodes[i].first as usize, nodes[i].count as usize);
            if count == 0 {
                stack.extend([first, first + 1]);
                continue;
            }
            refs[first..][..count].iter().for_each(|t| held[*t as usize] = true);
        }
        held
    };
    let mut sum = 0.0;
    for i in (0..nodes.len()).filter(|i| *i != 1) {
        let foreign = held(i).into_iter().enumerate().filter(|(_, held)| !held);
        let area = foreign.map(|(t, _)| Polygon::inside(&mesh.corners(t), &nodes[i].bounds()).area());
        sum += cost_of_visit(&nodes[i]) * area.sum::<f64>();
    }
    sum / (0..mesh.triangles.len()).map(|t| Polygon::triangle(&mesh.corners(t)).area()).sum::<f64>()
}

#[test]
fn the_walk_agrees_with_the_definition_with_and_without_splits() {
    let mesh = straw(600);
    for method in [Method::Binned, Method::Sbvh] {
        let options = BuildOptions { method, ..BuildOptions::preset(Preset::Draft) };
        let tree = initial_tree(&mesh, &options, &Executor::sequential(), &NoProgress).unwrap();
        assert_eq!(method == Method::Sbvh, tree.refs.len() > 600);
        let subtrees = Subtrees::new(&tree.nodes, &tree.refs, 600);
        let expected = by_definition(&mesh, &tree.nodes, &tree.refs);
        let ours = exact(&subtrees, |t| mesh.corners(t), &Executor::sequential());
        assert!((ours.epo() - expected).abs() < 1e-9 * expected, "{method}: {} for {expected}", ours.epo());
        assert!(expected > 1.0, "a scene that tests something: {expected}");

        // Points agree within three of their standard errors, and threads change no bit.
        let points = sampled(&subtrees, |t| mesh.corners(t), 20_000, MOST_VISITS, &Executor::sequential());
        assert!((points.epo() - expected).abs() < 3.0 * points.standard_error(), "{points:?} for {expected}");
        let two = Executor::new(2).unwrap();
        assert_eq!(exact(&subtrees, |t| mesh.corners(t), &two), ours);
        assert_eq!(exact_within(&subtrees, |t| mesh.corners(t), 1 << 30, &two), Ok(ours));
        let visited = exact_within(&subtrees, |t| mesh.corners(t), 10_000, &two);
        assert!(visited.is_err_and(|visits| visits < ours.visits()), "{visited:?}, {}", ours.visits());
        assert_eq!(sampled(&subtrees, |t| mesh.corners(t), 20_000, MOST_VISITS, &two), points);
    }
}
