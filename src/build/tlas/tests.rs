use super::*;
use crate::tree::quality;

/// On the calling thread.
fn build(boxes: &[Aabb]) -> Tree {
    super::build(boxes, &Executor::sequential())
}

/// Boxes of random size at random places; the generator is the 64-bit finaliser of SplitMix.
fn random_boxes(n: usize, seed: u64, size: f32) -> Vec<Aabb> {
    let mut state = seed;
    let mut next = move || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    };
    let mut one = || {
        let min = [next(), next(), next()];
        Aabb { min, max: min.map(|v| v + size * next() * next()) }
    };
    (0..n).map(|_| one()).collect()
}

/// Assert the promises of [`Tree`]: canonical order, every box once, tight parents, bounded depth.
fn assert_well_formed(tree: &Tree, boxes: &[Aabb]) {
    let mut seen = tree.refs.clone();
    seen.sort_unstable();
    let expected: Vec<u32> = (0..boxes.len() as u32).filter(|&i| !boxes[i as usize].is_empty()).collect();
    assert_eq!(seen, expected);
    assert!(tree.max_depth() <= MAX_DEPTH, "depth {}", tree.max_depth());
    let (mut next_pair, mut next_ref) = (2u32, 0u32);
    let mut stack = vec![0usize];
    while let Some(i) = stack.pop() {
        let node = tree.nodes[i];
        if node.is_leaf() {
            assert_eq!((node.first, node.count), (next_ref, 1));
            assert_eq!(node.bounds(), boxes[tree.refs[next_ref as usize] as usize]);
            next_ref += 1;
        } else {
            assert_eq!(node.first, next_pair);
            next_pair += 2;
            let pair = [tree.nodes[node.first as usize], tree.nodes[node.first as usize + 1]];
            assert_eq!(node.bounds(), pair[0].bounds().union(pair[1].bounds()));
            stack.extend([node.first as usize + 1, node.first as usize]);
        }
    }
    assert_eq!((next_pair as usize, next_ref as usize), (tree.nodes.len(), tree.refs.len()));
}

/// The textbook form: merge the pair of smallest common area among all pairs, n − 1 times. O(n³).
fn greedy_cost(boxes: &[Aabb]) -> f64 {
    let mut clusters = boxes.to_vec();
    let mut inner_area = 0.0;
    while clusters.len() > 1 {
        let pairs = (0..clusters.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
        let area = |&(a, b): &(usize, usize)| clusters[a].union(clusters[b]).half_area();
        let (a, b) = pairs.min_by(|p, q| area(p).total_cmp(&area(q))).unwrap();
        let union = clusters[a].union(clusters[b]);
        inner_area += f64::from(union.half_area());
        clusters.swap_remove(b);
        clusters[a] = union;
    }
    inner_area
}

fn inner_area(tree: &Tree) -> f64 {
    let inner = tree.nodes.iter().enumerate().filter(|(i, n)| *i != 1 && !n.is_leaf());
    inner.map(|(_, n)| f64::from(n.bounds().half_area())).sum()
}

#[test]
fn clustering_by_mutual_best_matches_is_the_greedy_one() {
    for (n, seed) in [(2, 1), (3, 2), (17, 3), (60, 4), (100, 5)] {
        let boxes = random_boxes(n, seed, 0.3);
        let tree = build(&boxes);
        assert_well_formed(&tree, &boxes);
        let (ours, greedy) = (inner_area(&tree), greedy_cost(&boxes));
        assert!((ours - greedy).abs() <= 1e-4 * greedy, "n {n}: {ours} against {greedy}");
    }
}

#[test]
fn nothing_one_and_empty_boxes() {
    assert_eq!(build(&[]), Tree::default());
    assert_eq!(build(&[Aabb::EMPTY]), Tree::default());
    let one = random_boxes(1, 9, 1.0);
    let tree = build(&one);
    assert_eq!((tree.nodes.len(), tree.refs.len()), (2, 1));
    let mixed = [Aabb::EMPTY, one[0], Aabb::EMPTY, one[0]];
    assert_well_formed(&build(&mixed), &mixed);
}

#[test]
fn identical_boxes_end_in_a_tree_and_always_the_same() {
    for n in [2usize, 64, 1000, 5000] {
        let boxes = vec![Aabb { min: [1.0; 3], max: [2.0; 3] }; n];
        let tree = build(&boxes);
        assert_well_formed(&tree, &boxes);
        assert_eq!(tree, build(&boxes));
    }
    let points = vec![Aabb { min: [3.0; 3], max: [3.0; 3] }; 300];
    assert_well_formed(&build(&points), &points);
}

#[test]
fn a_geometric_series_stays_within_the_depth_limit() {
    // Each box is twice as large as all before it, so the clustering is one long chain until the limit cuts it.
    let chain: Vec<Aabb> = (0..120).map(|i| Aabb { min: [0.0; 3], max: [2f32.powi(i - 60); 3] }).collect();
    let tree = build(&chain);
    assert_well_formed(&tree, &chain);
    assert!(tree.max_depth() > 50, "the chain should survive as far as it fits: depth {}", tree.max_depth());
    let rows: Vec<Aabb> = (0..3000).map(|i| Aabb { min: [0.0; 3], max: [1.0 + i as f32; 3] }).collect();
    assert_well_formed(&build(&rows), &rows);
}

#[test]
fn extreme_scales_give_the_same_tree() {
    let boxes = random_boxes(200, 7, 0.2);
    let topology = |t: &Tree| (t.refs.clone(), t.nodes.iter().map(|n| (n.first, n.count)).collect::<Vec<_>>());
    let reference = topology(&build(&boxes));
    for exponent in [-80, 80] {
        let s = 2f32.powi(exponent);
        let moved: Vec<Aabb> =
            boxes.iter().map(|b| Aabb { min: b.min.map(|v| v * s), max: b.max.map(|v| v * s) }).collect();
        assert_eq!(topology(&build(&moved)), reference);
    }
}

#[test]
fn grouping_costs_little_quality_and_is_independent_of_threads() {
    let boxes = random_boxes(6000, 11, 0.05);
    let grouped = build(&boxes);
    assert_well_formed(&grouped, &boxes);
    assert_eq!(super::build(&boxes, &Executor::new(3).unwrap()), grouped);

    // The same boxes without grouping.
    let items: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut forest = Forest::new(&boxes, &items);
    let root = forest.agglomerate_all(&items);
    let exact = Emitter { boxes: &boxes, forest: &forest, tree: Tree::default() }.emit(root);
    let (g, e) = (quality::sah(&grouped.nodes), quality::sah(&exact.nodes));
    assert!(g <= 1.1 * e, "grouped {g}, exact {e}");
}

#[test]
#[ignore = "long: a million boxes"]
fn long_a_million_boxes_end() {
    for size in [0.0, 0.01, 1.0] {
        let boxes = random_boxes(1 << 20, 13, size);
        let start = std::time::Instant::now();
        let tree = build(&boxes);
        let seconds = start.elapsed().as_secs_f64();
        assert_well_formed(&tree, &boxes);
        println!("2^20 boxes of size {size}: {seconds:.1} s, SAH {}", quality::sah(&tree.nodes));
        // That it ends is the test: comparing each with each would take hours.
    }
    let same = vec![Aabb { min: [1.0; 3], max: [2.0; 3] }; 1 << 20];
    assert_well_formed(&build(&same), &same);
}
