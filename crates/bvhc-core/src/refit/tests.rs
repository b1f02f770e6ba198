use super::*;
use crate::geom::Aabb;
use crate::random::Random;

/// A tree in a file's order over so many triangles, with leaves of one to seven, and triangles that are anywhere.
fn tree(triangles: u32, random: &mut Random) -> (Vec<Node>, Vec<IndexedTriangleRecord>) {
    let empty = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };
    let mut nodes = vec![empty; 2];
    let mut stack = vec![(0usize, 0, triangles)];
    while let Some((at, first, count)) = stack.pop() {
        if count <= 1 + (random.unit() * 7.0) as u32 {
            nodes[at] = Node::leaf(Aabb { min: [9.0; 3], max: [-9.0; 3] }, first, count);
        } else {
            let pair = nodes.len();
            nodes[at] = Node::inner(Aabb { min: [9.0; 3], max: [-9.0; 3] }, pair as u32);
            nodes.extend([empty; 2]);
            let left = 1 + (random.unit() * f64::from(count - 1)) as u32;
            // One side is often a leaf, and the tree is not balanced.
            stack.extend([(pair + 1, first + left, count - left), (pair, first, left)]);
        }
    }
    let corner = |random: &mut Random| (random.unit() * f64::from(triangles)) as u32;
    let triangle = |prim| {
        let corners = [0; 3].map(|_| corner(random));
        IndexedTriangleRecord { corners, prim, geom: 0, flags: 0 }
    };
    (nodes, (0..triangles).map(triangle).collect())
}

fn vertices(count: u32, random: &mut Random) -> Vec<Point> {
    (0..count).map(|_| [0; 3].map(|_| (random.unit() * 20.0 - 10.0) as f32)).collect()
}

/// Box by box, as it is defined.
fn plain(nodes: &mut [Node], corners: impl Fn(usize) -> [Point; 3]) {
    for i in (0..nodes.len()).rev().filter(|i| *i != 1) {
        let first = nodes[i].first as usize;
        let bounds = match nodes[i].count as usize {
            0 => nodes[first].bounds().union(nodes[first + 1].bounds()),
            count => (first..first + count).fold(Aabb::EMPTY, |b, slot| b.union(Aabb::from_points(&corners(slot)))),
        };
        (nodes[i].min, nodes[i].max) = (bounds.min, bounds.max);
    }
}

/// Level by level: children behind their parents, and in no file's order.
fn by_levels(nodes: &[Node]) -> Vec<Node> {
    let mut out = nodes[..2].to_vec();
    let mut i = 0;
    while i < out.len() {
        if i != 1 && !out[i].is_leaf() {
            let pair = out[i].first as usize;
            out[i].first = out.len() as u32;
            out.extend_from_slice(&nodes[pair..pair + 2]);
        }
        i += 1;
    }
    out
}

#[test]
fn every_box_is_the_smallest_whatever_the_tree_and_the_threads() {
    let mut random = Random::new(3);
    let several = Executor::metered();
    for triangles in [1, 2, 3, 9, 300, 3000, 60_000] {
        let (nodes, records) = tree(triangles, &mut random);
        let moved = vertices(triangles, &mut random);
        let corners = |slot: usize| records[slot].corners.map(|v| moved[v as usize]);
        for nodes in [nodes.clone(), by_levels(&nodes)] {
            let mut want = nodes.clone();
            plain(&mut want, corners);
            let fitted = |by: &dyn Fn(&mut [Node])| {
                let mut nodes = nodes.clone();
                by(&mut nodes);
                nodes
            };
            assert!(fitted(&|nodes| refit(nodes, &records, &moved).unwrap()) == want, "{triangles} triangles");
            assert!(fitted(&|nodes| refit_on(nodes, &records, &moved, &several).unwrap()) == want);
            assert!(fitted(&|nodes| refit_by(nodes, records.len(), corners, &several).unwrap()) == want);
        }
    }
    assert_eq!(refit(&mut [], &[], &[]), Ok(()));
}

#[test]
fn a_tree_that_is_large_is_shared_out_whole() {
    let (nodes, _) = tree(60_000, &mut Random::new(8));
    let cut = cut(&nodes).unwrap();
    assert!(cut.parts.len() > 4 && cut.parts.iter().all(|(start, end)| start < end && end - start <= TASK));
    let mut covered: Vec<(usize, usize)> = cut.parts;
    covered.extend(cut.above.iter().map(|pair| (*pair, pair + 2)));
    covered.sort_unstable();
    assert!(covered[0].0 == 0 && covered.windows(2).all(|w| w[0].1 == w[1].0));
    assert_eq!(covered.last().unwrap().1, nodes.len());
}

#[test]
fn what_leads_nowhere_is_told() {
    let mut random = Random::new(5);
    let several = Executor::metered();
    let (nodes, records) = tree(40_000, &mut random);
    let places = vertices(40_000, &mut random);
    let inner = (2..nodes.len()).find(|i| !nodes[*i].is_leaf()).unwrap();
    let leaf = (2..nodes.len()).rfind(|i| nodes[*i].is_leaf()).unwrap();
    let all = nodes.len();
    for (node, first, count) in
        [(inner, 0, 0), (inner, inner as u32, 0), (inner, all as u32 - 1, 0), (inner, u32::MAX, 0)]
    {
        let mut bad = nodes.clone();
        (bad[node].first, bad[node].count) = (first, count);
        let told = RefitError::Child { node, first, nodes: all };
        assert_eq!(refit(&mut bad.clone(), &records, &places), Err(told));
        assert_eq!(refit_on(&mut bad, &records, &places, &several), Err(told));
        assert!(told.to_string().contains("children"));
    }
    for (first, count) in [(39_999, 2), (u32::MAX, 1), (0, u32::MAX), (u32::MAX, u32::MAX)] {
        let mut bad = nodes.clone();
        (bad[leaf].first, bad[leaf].count) = (first, count);
        let told = RefitError::Leaf { node: leaf, first, count, triangles: 40_000 };
        assert_eq!(refit(&mut bad.clone(), &records, &places), Err(told));
        assert_eq!(refit_by(&mut bad, 40_000, |_| [[0.0; 3]; 3], &several), Err(told));
    }
    for vertex in [40_000, u32::MAX] {
        let mut bad = records.clone();
        bad[777].corners[1] = vertex;
        let told = RefitError::Vertex { triangle: 777, vertex, vertices: 40_000 };
        assert_eq!(refit(&mut nodes.clone(), &bad, &places), Err(told));
    }
}
