use super::*;
use crate::build::{BuildOptions, Executor, Method, NoProgress, Preset, initial_tree};
use crate::geom::{Aabb, Point};
use crate::scene::Mesh;
use crate::tree::{MAX_DEPTH, Tree, refit};

const LIMBS: u32 = 6;
const JOINTS: u32 = 30;

fn options() -> BuildOptions {
    BuildOptions { method: Method::Sweep, reinsert: 8, ..BuildOptions::preset(Preset::Draft) }
}

/// Ribbons from the middle outward, which turn at different speeds: they lie on each other in other frames than those in which they cross.
fn ribbons() -> Vec<[u32; 3]> {
    let cell = |c: u32| {
        let v = c / (JOINTS - 1) * 2 * JOINTS + c % (JOINTS - 1) * 2;
        [[v, v + 1, v + 2], [v + 1, v + 3, v + 2]]
    };
    (0..LIMBS * (JOINTS - 1)).flat_map(cell).collect()
}

fn turned(time: f32) -> Vec<Point> {
    let at = |i: u32| {
        let (limb, joint, side) = (i / (2 * JOINTS), i / 2 % JOINTS, (i % 2) as f32);
        let angle = time * (1.0 + limb as f32) + limb as f32;
        let reach = 1.0 + joint as f32;
        [reach * angle.cos(), reach * angle.sin(), 0.2 * limb as f32 + side]
    };
    (0..LIMBS * 2 * JOINTS).map(at).collect()
}

fn motion<'a>(triangles: &'a [[u32; 3]], frames: &'a [Vec<Point>]) -> Motion<'a> {
    let mut motion = Motion::new(triangles);
    frames.iter().for_each(|positions| motion.push(positions).expect("a sound frame"));
    motion
}

fn tree_of(motion: &Motion, frame: usize, max_leaf: u32) -> Tree {
    let (positions, triangles) = (motion.positions(frame).to_vec(), motion.triangles().to_vec());
    let mesh = Mesh { positions, triangles, ..Mesh::default() };
    let options = BuildOptions { max_leaf, reinsert: 0, ..options() };
    initial_tree(&mesh, &options, &Executor::sequential(), &NoProgress).expect("a tree")
}

fn alike(frames: impl Iterator<Item = usize>) -> Vec<Pose> {
    frames.map(|frame| Pose { frame, weight: 1.0 }).collect()
}

fn mean(tree: &Tree, motion: &Motion, poses: &[Pose]) -> f64 {
    let of = |pose: &Pose| pose.weight * cost(tree, motion, pose.frame, &options());
    poses.iter().map(of).sum::<f64>() / poses.iter().map(|pose| pose.weight).sum::<f64>()
}

/// Canonical order, each triangle once, leaves and depth within their limits, and boxes fitted to a frame.
fn assert_sound(tree: &Tree, motion: &Motion, frame: usize) {
    assert!(tree.max_depth() <= MAX_DEPTH);
    let mut refs = tree.refs.clone();
    refs.sort_unstable();
    assert!(refs.into_iter().eq(0..motion.triangles().len() as u32));
    let (mut next_ref, mut next_pair, mut open) = (0, 2, vec![0usize]);
    while let Some(i) = open.pop() {
        let node = tree.nodes[i];
        if node.is_leaf() {
            assert_eq!(node.first, next_ref);
            assert!(node.count <= options().max_leaf);
            next_ref += node.count;
        } else {
            assert_eq!(node.first, next_pair);
            next_pair += 2;
            open.extend([node.first as usize + 1, node.first as usize]);
        }
    }
    let mut fitted = tree.nodes.clone();
    refit(&mut fitted, |slot| motion.corners(frame, tree.refs[slot] as usize)).unwrap();
    assert_eq!(fitted, tree.nodes);
}

#[test]
fn a_tree_for_several_poses_is_cheaper_over_them_and_the_same_by_any_number_of_threads() {
    let (triangles, frames) = (ribbons(), (0..18).map(|f| turned(0.1 * f as f32)).collect::<Vec<_>>());
    let motion = motion(&triangles, &frames);
    let start = tree_of(&motion, 0, 1);
    for count in [1, 3, 4, 5, 8, 9, 16, 18] {
        let poses = alike((0..count).map(|i| i * 17 % 18));
        let tree = optimise(&start, &motion, &poses, &options(), &Executor::sequential(), &NoProgress).unwrap();
        assert_sound(&tree, &motion, poses[0].frame);
        let heeded = &poses[..count.min(16)];
        let (before, after) = (mean(&start, &motion, heeded), mean(&tree, &motion, heeded));
        // It starts from a good tree of the first pose.
        let most = if count == 1 { before } else { 0.95 * before };
        assert!(after < most, "{count} poses: {after} after {before}");
        for threads in [2, 3] {
            let exec = Executor::new(threads).unwrap();
            assert_eq!(optimise(&start, &motion, &poses, &options(), &exec, &NoProgress).unwrap(), tree);
        }
    }

    // Of the frames that it is for it is better than what any one of them suggests.
    let poses = alike(0..16);
    let tree = optimise(&start, &motion, &poses, &options(), &Executor::sequential(), &NoProgress).unwrap();
    let of_one = |frame| {
        let alone = [Pose { frame, weight: 1.0 }];
        let start = tree_of(&motion, frame, 1);
        optimise(&start, &motion, &alone, &options(), &Executor::sequential(), &NoProgress).unwrap()
    };
    let best = (0..16).map(|frame| mean(&of_one(frame), &motion, &poses)).fold(f64::INFINITY, f64::min);
    let ours = mean(&tree, &motion, &poses);
    assert!(ours < best, "{ours}, and the best frame's tree has {best}");
}

/// Four triangles in two places: which of them are neighbours differs between the poses.
fn pairs(near: [usize; 4]) -> Vec<Point> {
    near.iter()
        .flat_map(|&place| {
            let x = [0.0, 1.0, 100.0, 101.0][place];
            [[x, 0.0, 0.0], [x + 0.5, 0.0, 0.0], [x, 0.5, 0.5]]
        })
        .collect()
}

#[test]
fn weights_decide_between_poses_that_want_different_trees() {
    let triangles: Vec<[u32; 3]> = (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    // Triangles 0 and 1 are neighbours in the first pose, 0 and 2 in the second.
    let frames = [pairs([0, 1, 2, 3]), pairs([0, 2, 1, 3])];
    let motion = motion(&triangles, &frames);
    let options = BuildOptions { max_leaf: 1, ..options() };
    for (weights, like) in [([8.0, 1.0], 0), ([1.0, 8.0], 1)] {
        let poses = [0, 1].map(|frame| Pose { frame, weight: weights[frame] });
        for start in [0, 1] {
            let start = tree_of(&motion, start, 1);
            let tree = optimise(&start, &motion, &poses, &options, &Executor::sequential(), &NoProgress).unwrap();
            let best = cost(&tree_of(&motion, like, 1), &motion, like, &options);
            let ours = cost(&tree, &motion, like, &options);
            assert!((ours - best).abs() < 1e-9, "{weights:?}: {ours}, and {best} is possible");
        }
    }
}

#[test]
fn frames_without_area_count_for_nothing_and_nothing_panics() {
    let triangles = ribbons();
    let point = vec![[1.0; 3]; turned(0.0).len()];
    let line: Vec<Point> = (0..point.len()).map(|i| [i as f32, 0.0, 0.0]).collect();
    let huge: Vec<Point> = turned(0.3).iter().map(|p| p.map(|c| c * 5e36)).collect();
    let tiny: Vec<Point> = turned(0.6).iter().map(|p| p.map(|c| c * 1e-36)).collect();
    let frames = [point, turned(0.0), line, huge, tiny];
    let motion = motion(&triangles, &frames);
    let exec = Executor::sequential();
    let start = tree_of(&motion, 1, 1);
    let run = |poses: &[Pose]| optimise(&start, &motion, poses, &options(), &exec, &NoProgress).unwrap();
    let all = run(&alike(0..5));
    assert_sound(&all, &motion, 0);
    // The size of a frame does not matter.
    let only = run(&alike([1, 3, 4].into_iter()));
    assert_eq!(all.refs, only.refs);
    assert_eq!([0, 2].map(|frame| cost(&all, &motion, frame, &options())), [0.0; 2]);
    assert!([3, 4].iter().all(|frame| cost(&all, &motion, *frame, &options()) > 1.0));

    assert_eq!(run(&[]), start);
    for weight in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(run(&[Pose { frame: 1, weight }]).refs, start.refs);
    }
    let none = Motion::new(&triangles);
    assert!(keyed(&none, Trees::Auto, &options(), &exec, &NoProgress).unwrap().trees.is_empty());
    let empty = super::tests::motion(&[], &frames);
    let trees = keyed(&empty, Trees::AtMost(2), &options(), &exec, &NoProgress).unwrap();
    assert_eq!((trees.trees, trees.costs), (vec![Tree::default()], vec![0.0; 5]));
    let all = keyed(&motion, Trees::AtMost(0), &options(), &exec, &NoProgress).unwrap();
    assert_eq!((all.trees.len(), all.serves), (1, vec![0; 5]));
}

#[test]
fn frames_that_are_alike_share_a_representative() {
    let triangles = ribbons();
    // Where a pose stands does not make it another one.
    let moved = |time: f32, by: f32| turned(time).iter().map(|p| p.map(|c| c + by)).collect::<Vec<Point>>();
    let frames: Vec<_> = (0..21).map(|f| moved([0.0, 0.4, 1.1][f / 10], 3.0 * f as f32)).collect();
    let motion = motion(&triangles, &frames);
    let all: Vec<usize> = (0..21).collect();
    let poses = representatives(&motion, &all, 3, &Executor::sequential());
    assert_eq!(poses.iter().map(|p| p.frame / 10).collect::<Vec<_>>(), [0, 1, 2]);
    assert_eq!(poses.iter().map(|p| p.weight).collect::<Vec<_>>(), [10.0, 10.0, 1.0]);
    assert_eq!(representatives(&motion, &all, 21, &Executor::sequential()), alike(0..21));
    assert_eq!(representatives(&motion, &[], 4, &Executor::sequential()), []);
}

#[test]
fn as_many_trees_are_kept_as_there_are_kinds_of_poses() {
    let triangles = ribbons();
    let exec = Executor::sequential();
    let still: Vec<_> = (0..8).map(|_| turned(0.2)).collect();
    let still = motion(&triangles, &still);
    assert_eq!(keyed(&still, Trees::Auto, &options(), &exec, &NoProgress).unwrap().trees.len(), 1);

    // Two shots that alternate.
    let shots: Vec<_> = (0..12).map(|f| turned([0.0, 5.3][f / 3 % 2] + 0.002 * f as f32)).collect();
    let shots = motion(&triangles, &shots);
    let by = |trees| keyed(&shots, trees, &options(), &exec, &NoProgress).unwrap();
    let (one, two, auto) = (by(Trees::AtMost(1)), by(Trees::AtMost(2)), by(Trees::Auto));
    assert_eq!((one.trees.len(), two.trees.len(), auto.trees.len()), (1, 2, 2));
    assert!((0..12).all(|f| (two.serves[f] == two.serves[0]) == (f / 3 % 2 == 0)), "{:?}", two.serves);
    let sum = |keyed: &Keyed| keyed.costs.iter().sum::<f64>();
    assert!(sum(&two) < 0.95 * sum(&one), "{} and {}", sum(&two), sum(&one));
    for (frame, &serves) in two.serves.iter().enumerate() {
        assert_eq!(cost(&two.trees[serves], &shots, frame, &options()), two.costs[frame]);
        // A new tree of the frame is hardly better.
        let alone = [Pose { frame, weight: 1.0 }];
        let fresh = optimise(&tree_of(&shots, frame, 1), &shots, &alone, &options(), &exec, &NoProgress).unwrap();
        assert!(two.costs[frame] < 1.05 * cost(&fresh, &shots, frame, &options()));
    }
    let exec = Executor::new(3).unwrap();
    let again = keyed(&shots, Trees::AtMost(2), &options(), &exec, &NoProgress).unwrap();
    assert_eq!((again.trees, again.serves, again.costs), (two.trees, two.serves, two.costs));
}

#[test]
fn the_cost_in_a_frame_is_the_sah_of_the_fitted_tree() {
    let (triangles, frames) = (ribbons(), [turned(0.0), turned(0.7)]);
    let motion = motion(&triangles, &frames);
    let mut tree = tree_of(&motion, 0, 4);
    let before = cost(&tree, &motion, 1, &options());
    let refs = tree.refs.clone();
    refit(&mut tree.nodes, |slot| motion.corners(1, refs[slot] as usize)).unwrap();
    assert_eq!(before as f32, crate::tree::quality::sah(&tree.nodes));
    assert_eq!(tree.bounds(), Aabb::from_points(&frames[1]));
    let table = costs(&[tree.clone(), tree_of(&motion, 1, 4)], &motion, &options(), &Executor::new(2).unwrap());
    assert_eq!((table.len(), table[0].len(), table[1][0]), (2, 2, before));
    assert!(table[1][1] <= table[1][0]);
}
