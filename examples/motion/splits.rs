//! What spatial splits leave of a tree once it holds whole triangles, since parts cannot follow a motion.
//!
//! The ray cost, the mean over the frames and the worst of them, relative to the one tree for all frames that starts without spatial splits (`all frames` of the first table). The
//! trees are those of the frame in the middle:
//!
//! - `sweep`: a tree without splits, refitted, for comparison; like the next two its subtrees were not moved;
//! - `splits, whole`: every part of a triangle becomes the whole;
//! - `splits, once`: each triangle stays in one leaf alone (the one with the largest box);
//! - `splits, moved`: the same with a triangle a leaf, its subtrees then moved for all frames, as those of `all frames` were.
//!
//! `again` has the references that the splits made, as a share of the triangles.

use crate::clip::Clip;
use crate::{Result, fresh};
use bvhc::build::motion::{self, Pose, Trees};
use bvhc::build::{BuildOptions, Executor, Method, NoProgress, Preset};
use bvhc::geom::Aabb;
use bvhc::tree::{Node, Tree};
use bytemuck::Zeroable;

const WAYS: [&str; 4] = ["sweep", "splits, whole", "splits, once", "splits, moved"];
/// Poses that trees are moved for, as many as for the tree that they are compared with.
const POSES: usize = 8;

/// The first lines of the table.
pub fn heading() {
    println!("| clip | triangles | frames | again | {} |", WAYS.join(" | "));
    println!("|---|--:|--:|--:|{}", "--:|".repeat(WAYS.len()));
}

/// Print the row of a clip.
pub fn measure(clip: &Clip, rays: usize, exec: &Executor) -> Result<()> {
    let motion = clip.motion()?;
    let frames = motion.frames();
    let options = fresh(8);
    let all = motion::keyed(&motion, Trees::AtMost(1), &options, exec, &NoProgress)?;
    let [all] = <[Tree; 1]>::try_from(all.trees).map_err(|_| "no tree")?;
    let middle = &clip.meshes[frames / 2];
    let build = |options: &BuildOptions| bvhc::compile::build_tree(middle, options, exec, &NoProgress);
    let cut = BuildOptions { method: Method::Sbvh, reinsert: 0, ..BuildOptions::preset(Preset::Balanced) };
    let split = build(&cut)?;
    let single = whole(&build(&BuildOptions { max_leaf: 1, ..cut.clone() })?);
    let numbers: Vec<usize> = (0..frames).collect();
    let mut poses: Vec<Pose> = motion::representatives(&motion, &numbers, POSES, exec);
    for pose in &mut poses {
        let unit = motion::triangle_cost(&motion, pose.frame, &options);
        pose.weight /= if unit > 0.0 { unit } else { 1.0 };
    }
    let moved = motion::optimise(&single, &motion, &poses, &options, exec, &NoProgress)?;
    if moved.refs.len() != clip.triangles() {
        return Err("a triangle is not there once".into());
    }
    let again = split.refs.len() as f64 / clip.triangles() as f64 - 1.0;
    let once = whole(&split);
    let trees = [build(&fresh(0))?, split, once, moved];
    let ratios: Vec<[f64; 4]> = (0..frames)
        .map(|frame| {
            let probes = clip.rays(frame, &all, rays, exec);
            let base = clip.ray_cost(frame, &all, &probes, exec);
            std::array::from_fn(|way| clip.ray_cost(frame, &trees[way], &probes, exec) / base)
        })
        .collect();
    let cell = |way: usize| {
        let mean = ratios.iter().map(|row| row[way]).sum::<f64>() / frames as f64;
        let worst = ratios.iter().map(|row| row[way]).fold(0.0, f64::max);
        format!("{mean:.3} · {worst:.3}")
    };
    let cells: Vec<String> = (0..WAYS.len()).map(cell).collect();
    println!("| {} | {} | {frames} | {again:.2} | {} |", clip.name, clip.triangles(), cells.join(" | "));
    Ok(())
}

/// The tree with each triangle in one leaf alone: the one with the largest box, of equal ones the first. That leaf has most of the triangle, so it grows least when it has
/// to hold the whole. Leaves that held nothing else go, and so does each inner node that is left with one child.
///
/// Boxes stay what they were, which is too small for whole triangles: they are to be [fitted](bvhc::tree::refit) next. A tree without duplicates comes back as it is.
fn whole(tree: &Tree) -> Tree {
    let leaves = |i: &usize| *i != 1 && tree.nodes[*i].is_leaf();
    let slots = |node: &Node| node.first as usize..node.first as usize + node.count as usize;
    // By triangle the leaf that keeps it.
    let most = tree.refs.iter().max().map_or(0, |last| *last as usize + 1);
    let mut keeps: Vec<Option<(u32, f64)>> = vec![None; most];
    for leaf in (0..tree.nodes.len()).filter(leaves) {
        let area = half_area(&tree.nodes[leaf].bounds());
        for triangle in &tree.refs[slots(&tree.nodes[leaf])] {
            let kept = &mut keeps[*triangle as usize];
            if kept.is_none_or(|(_, largest)| area > largest) {
                *kept = Some((leaf as u32, area));
            }
        }
    }
    let mut out = Tree { nodes: Vec::with_capacity(tree.nodes.len()), refs: Vec::with_capacity(most) };
    if tree.nodes.is_empty() {
        return out;
    }
    out.nodes.resize(2, Node::zeroed());
    // What a subtree becomes is known once both of its children are, and the pair of a node stands before those below it. So first it is found which
    // nodes have anything left, from the last one up.
    let keeps = |leaf: usize, triangle: u32| keeps[triangle as usize].is_some_and(|(kept, _)| kept as usize == leaf);
    let mut has_any = vec![false; tree.nodes.len()];
    for i in (0..tree.nodes.len()).rev().filter(|i| *i != 1) {
        let node = &tree.nodes[i];
        has_any[i] = match node.is_leaf() {
            true => tree.refs[slots(node)].iter().any(|triangle| keeps(i, *triangle)),
            false => has_any[node.first as usize] || has_any[node.first as usize + 1],
        };
    }
    // The order is that of the tree, depth first: the second child waits while the first one's subtree is laid out.
    let mut waiting: Vec<(usize, usize)> = vec![(0, 0)];
    while let Some((mut from, to)) = waiting.pop() {
        while let Some(only) = only_child(&tree.nodes[from], &has_any) {
            from = only;
        }
        let node = &tree.nodes[from];
        if node.is_leaf() {
            let first = out.refs.len();
            out.refs.extend(tree.refs[slots(node)].iter().filter(|triangle| keeps(from, **triangle)));
            out.nodes[to] = Node::leaf(node.bounds(), first as u32, (out.refs.len() - first) as u32);
        } else {
            let pair = out.nodes.len();
            out.nodes.resize(pair + 2, Node::zeroed());
            out.nodes[to] = Node::inner(node.bounds(), pair as u32);
            let first = node.first as usize;
            waiting.extend([(first + 1, pair + 1), (first, pair)]);
        }
    }
    out
}

/// The child that has anything left, where the other one has nothing.
fn only_child(node: &Node, has_any: &[bool]) -> Option<usize> {
    let first = node.first as usize;
    match node.is_leaf() {
        true => None,
        false => match [first, first + 1].map(|child| has_any[child]) {
            [true, false] => Some(first),
            [false, true] => Some(first + 1),
            _ => None,
        },
    }
}

/// Half of it, in `f64`.
fn half_area(b: &Aabb) -> f64 {
    let [x, y, z] = b.extent().map(f64::from);
    x * y + y * z + z * x
}
