use super::volumes::OneBox;
use super::*;
use crate::build::recipe::options::Method;
use crate::geom::Aabb;
use crate::tree::{MAX_DEPTH, Node, quality};

fn unit_box(x: f32) -> Aabb {
    Aabb { min: [x, 0.0, 0.0], max: [x + 1.0, 1.0, 1.0] }
}

/// A tree by hand.
enum Shape {
    /// The box, and the references from the next on.
    Leaf(Aabb, Vec<u32>),
    Pair(Box<(Shape, Shape)>),
}

fn leaf(x: f32, refs: &[u32]) -> Shape {
    Shape::Leaf(unit_box(x), refs.to_vec())
}

fn pair(a: Shape, b: Shape) -> Shape {
    Shape::Pair(Box::new((a, b)))
}

fn tree_of(shape: &Shape) -> Tree {
    fn put(tree: &mut Tree, at: usize, shape: &Shape) -> Aabb {
        match shape {
            Shape::Leaf(bounds, refs) => {
                tree.nodes[at] = Node::leaf(*bounds, tree.refs.len() as u32, refs.len() as u32);
                tree.refs.extend(refs);
            }
            Shape::Pair(children) => {
                let first = tree.nodes.len();
                tree.nodes.extend([<Node as bytemuck::Zeroable>::zeroed(); 2]);
                let (a, b) = (put(tree, first, &children.0), put(tree, first + 1, &children.1));
                tree.nodes[at] = Node::inner(a.union(b), first as u32);
            }
        }
        tree.nodes[at].bounds()
    }
    let mut tree = Tree { nodes: vec![bytemuck::Zeroable::zeroed(); 2], refs: Vec::new() };
    put(&mut tree, 0, shape);
    tree
}

fn passes(tree: Tree, options: &BuildOptions) -> Tree {
    run(tree, None, options, &Executor::sequential(), &super::super::progress::NoProgress).unwrap().into_tree()
}

fn options(reinsert: u32, collapse: bool) -> BuildOptions {
    BuildOptions { method: Method::Sbvh, reinsert, collapse, ..BuildOptions::default() }
}

#[test]
fn a_misplaced_leaf_goes_home() {
    // Neighbours at 0, 1 and at 100, 101, paired across.
    let bad = pair(pair(leaf(0.0, &[0]), leaf(100.0, &[1])), pair(leaf(1.0, &[2]), leaf(101.0, &[3])));
    let good = pair(pair(leaf(0.0, &[0]), leaf(1.0, &[2])), pair(leaf(100.0, &[1]), leaf(101.0, &[3])));
    let after = passes(tree_of(&bad), &options(8, false));
    assert_eq!(quality::sah(&after.nodes), quality::sah(&tree_of(&good).nodes));
}

#[test]
fn nothing_to_do_changes_nothing() {
    let good = tree_of(&pair(pair(leaf(0.0, &[0]), leaf(1.0, &[2])), pair(leaf(100.0, &[1]), leaf(101.0, &[3]))));
    assert_eq!(passes(good.clone(), &options(8, false)), good);
    for shape in [leaf(3.0, &[0, 1]), pair(leaf(0.0, &[1]), leaf(9.0, &[0]))] {
        let tree = tree_of(&shape);
        assert_eq!(passes(tree.clone(), &options(8, true)), tree);
    }
    assert_eq!(passes(Tree::default(), &options(8, true)), Tree::default());
}

#[test]
fn subtrees_that_separate_nothing_become_leaves() {
    // All four boxes are the same, so no ray is spared anything: a leaf of three, since one triangle stands there twice.
    let same = || leaf(0.0, &[7]);
    let tree = tree_of(&pair(pair(same(), leaf(0.0, &[2])), pair(same(), leaf(0.0, &[5]))));
    let after = passes(tree.clone(), &options(0, true));
    assert_eq!((after.nodes[0], &after.refs[..]), (Node::leaf(unit_box(0.0), 0, 3), &[2, 5, 7][..]));

    // With room for two a leaf, and where a box test costs next to nothing, they stay apart.
    let after = passes(tree.clone(), &BuildOptions { max_leaf: 2, ..options(0, true) });
    assert_eq!(after.refs, [2, 7, 5, 7]);
    let apart = tree_of(&pair(leaf(0.0, &[0]), leaf(100.0, &[1])));
    let after = passes(apart.clone(), &BuildOptions { traversal_cost: 0.01, ..options(0, true) });
    assert_eq!(after, apart);
}

#[test]
fn high_subtrees_with_few_references_become_leaves_too() {
    // A chain of forty leaves of the same triangle, higher than what a task keeps together.
    let chain = (0..40).fold(leaf(0.0, &[1]), |below, _| pair(leaf(0.0, &[1]), below));
    let after = passes(tree_of(&pair(chain, leaf(500.0, &[0]))), &options(0, true));
    assert_eq!((after.live_nodes(), &after.refs[..]), (3, &[1, 0][..]));
}

#[test]
fn no_move_makes_the_tree_deeper_than_allowed() {
    // A chain that is as deep as may be, and a leaf at the top that belongs to its lower end.
    let chain = (1..64).fold(leaf(0.0, &[0]), |below, i| pair(below, leaf((1u64 << i) as f32, &[i])));
    let tree = tree_of(&pair(leaf(0.0, &[100]), chain));
    assert_eq!(tree.max_depth(), MAX_DEPTH);
    for rounds in [1, 4, 30] {
        let after = passes(tree.clone(), &options(rounds, false));
        assert!(after.max_depth() <= MAX_DEPTH);
        assert!(quality::sah(&after.nodes) <= quality::sah(&tree.nodes));
    }

    let mut work = WorkTree::new(&tree, &Executor::sequential()).unwrap();
    let deepest = (2..work.slots.len() as u32).find(|&s| work.height(s) == 0 && depth(&work, s) == MAX_DEPTH).unwrap();
    assert!(!work.move_subtree(2, deepest), "one level too deep");
}

fn depth(work: &WorkTree, mut slot: u32) -> u32 {
    let mut depth = 0;
    while let Some(above) = work.parent(slot) {
        (slot, depth) = (above, depth + 1);
    }
    depth
}

#[test]
fn a_subtree_is_not_moved_into_itself() {
    // 0 holds 2 and 3; 2 holds 4 and 5; 4 holds 6 and 7.
    let tree = tree_of(&pair(pair(pair(leaf(0.0, &[0]), leaf(1.0, &[1])), leaf(2.0, &[2])), leaf(3.0, &[3])));
    let fresh = || WorkTree::new(&tree, &Executor::sequential()).unwrap();
    for (from, to, possible) in
        [(2, 6, false), (2, 4, false), (2, 2, false), (2, 3, false), (2, 0, false), (3, 6, true)]
    {
        assert_eq!(fresh().move_subtree(from, to), possible, "{from} to {to}");
    }

    // The second move would close a ring that the first has prepared.
    let wide = tree_of(&pair(
        pair(pair(leaf(0.0, &[0]), leaf(1.0, &[1])), pair(leaf(2.0, &[2]), leaf(3.0, &[3]))),
        pair(pair(leaf(4.0, &[4]), leaf(5.0, &[5])), pair(leaf(6.0, &[6]), leaf(7.0, &[7]))),
    ));
    let mut work = WorkTree::new(&wide, &Executor::sequential()).unwrap();
    let [a, b] = [work.slots[2].children()[0], work.slots[3].children()[0]];
    let (in_a, in_b) = (work.slots[a as usize].children()[0], work.slots[b as usize].children()[0]);
    assert!(work.move_subtree(a, in_b));
    assert!(!work.move_subtree(b, in_a));
    work.refit(&mut OneBox { scale: work.scale });
    let after = emit(&work, &wide.refs, None, &Executor::sequential());
    assert_eq!((after.live_nodes(), after.refs.len()), (15, 8));
}
