//! Where finished nodes go: pieces of a tree that grow side by side, and their concatenation in canonical order.

use crate::exec::Executor;
use crate::geom::Aabb;
use crate::tree::{Node, Tree};

/// Everything below one node, in canonical order, with indices that count from the piece's own start.
#[derive(Debug, Default)]
pub(in crate::build) struct Piece {
    pub nodes: Vec<Node>,
    pub refs: Vec<u32>,
}

const UNUSED: Node = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };

impl Piece {
    /// Room for the subtree of so many references, about two a leaf.
    pub fn for_refs(count: usize) -> Piece {
        Piece { nodes: Vec::with_capacity(count + count / 8), refs: Vec::with_capacity(count) }
    }

    /// Append a leaf's references in ascending order, each once, whatever order the partitions left them in. Spatial
    /// splits may have put two parts of a primitive into one leaf.
    pub fn leaf(&mut self, bounds: Aabb, prims: impl Iterator<Item = u32>) -> Node {
        let first = self.refs.len();
        self.refs.extend(prims);
        if self.refs.len() - first > 1 {
            self.refs[first..].sort_unstable();
        }
        let mut kept = first + 1;
        for i in first + 1..self.refs.len() {
            if self.refs[i] != self.refs[kept - 1] {
                self.refs[kept] = self.refs[i];
                kept += 1;
            }
        }
        self.refs.truncate(kept);
        Node::leaf(bounds, first as u32, (kept - first) as u32)
    }

    /// Append what is below another piece's root; returns that root as this piece's.
    pub fn append(&mut self, root: Node, piece: &Piece) -> Node {
        let base = Base { nodes: self.nodes.len() as u32, refs: self.refs.len() as u32 };
        self.nodes.extend(piece.nodes.iter().map(|node| base.shift(*node)));
        self.refs.extend_from_slice(&piece.refs);
        base.shift(root)
    }

    /// Room for two siblings; their subtrees follow.
    pub fn reserve_pair(&mut self) -> u32 {
        let pair = self.nodes.len();
        self.nodes.extend([UNUSED; 2]);
        pair as u32
    }

    /// A piece that is the whole tree: its root goes where no child stands.
    pub fn into_tree(mut self, pair: u32, root: Node) -> Tree {
        self.fill_pair(pair, root, UNUSED);
        self.nodes.shrink_to_fit();
        self.refs.shrink_to_fit();
        Tree { nodes: self.nodes, refs: self.refs }
    }

    /// The longest way from the root's record down to a leaf.
    pub fn height(&self, root: &Node) -> u32 {
        let mut open = vec![(*root, 0)];
        let mut height = 0;
        while let Some((node, depth)) = open.pop() {
            height = height.max(depth);
            if !node.is_leaf() {
                open.extend([0, 1].map(|k| (self.nodes[node.first as usize + k], depth + 1)));
            }
        }
        height
    }

    pub fn fill_pair(&mut self, pair: u32, first: Node, second: Node) {
        self.nodes[pair as usize] = first;
        self.nodes[pair as usize + 1] = second;
    }
}

/// The upper part of a tree whose subtrees were built as separate tasks.
#[derive(Debug)]
pub(in crate::build) enum Branch {
    /// A finished subtree: its root's record, and everything below.
    Piece {
        root: Node,
        piece: Piece,
    },
    Fork {
        bounds: Aabb,
        children: Box<(Branch, Branch)>,
    },
}

/// A grown tree before its parts are put together.
#[derive(Debug)]
pub(in crate::build) enum Grown {
    /// Everything in one piece, with a pair reserved for the root.
    Whole {
        pair: u32,
        root: Node,
        piece: Piece,
    },
    Parts(Branch),
}

impl Grown {
    pub fn into_tree(self, exec: &Executor) -> Tree {
        match self {
            Grown::Whole { pair, root, piece } => piece.into_tree(pair, root),
            Grown::Parts(branch) => exec.run(|| branch.assemble(exec)),
        }
    }
}

/// A run of the output that nobody else writes.
enum Job<'a> {
    Pair { at: &'a mut [Node], nodes: [Node; 2] },
    Piece { piece: Piece, nodes: &'a mut [Node], refs: &'a mut [u32], base: Base },
    Stem { from: &'a Piece, stem: &'a Stem, nodes: &'a mut [Node], refs: &'a mut [u32], base: Base },
}

impl Job<'_> {
    fn run(self) {
        match self {
            Job::Pair { at, nodes } => at.copy_from_slice(&nodes),
            Job::Piece { piece, nodes, refs, base } => base.copy((&piece.nodes, &piece.refs), nodes, refs),
            Job::Stem { from, stem, nodes, refs, base } => {
                base.copy((&from.nodes[stem.nodes.clone()], &from.refs[stem.refs.clone()]), nodes, refs);
            }
        }
    }
}

/// Where a subtree starts in the output, less where it starts in its piece.
#[derive(Clone, Copy)]
struct Base {
    nodes: u32,
    refs: u32,
}

impl Base {
    fn shift(self, node: Node) -> Node {
        Node { first: node.first.wrapping_add(if node.is_leaf() { self.refs } else { self.nodes }), ..node }
    }

    fn copy(self, from: (&[Node], &[u32]), nodes: &mut [Node], refs: &mut [u32]) {
        for (to, from) in nodes.iter_mut().zip(from.0) {
            *to = self.shift(*from);
        }
        refs.copy_from_slice(from.1);
    }
}

impl Branch {
    /// Concatenate. Canonical order is the order of the recursion, so every piece is one run of the output and all are
    /// copied at once.
    pub fn assemble(self, exec: &Executor) -> Tree {
        let (node_count, ref_count) = self.size();
        let mut tree = Tree { nodes: bytemuck::zeroed_vec(node_count + 2), refs: vec![0; ref_count] };
        let mut layout = Layout::over(&mut tree);
        let pair = layout.take_pair();
        let root = layout.place(self);
        layout.jobs.push(Job::Pair { at: pair, nodes: [root, UNUSED] });
        exec.map(layout.jobs, |_, job| job.run());
        tree
    }

    /// Nodes below this one, and references.
    fn size(&self) -> (usize, usize) {
        match self {
            Branch::Piece { piece, .. } => (piece.nodes.len(), piece.refs.len()),
            Branch::Fork { children, .. } => {
                let ((a, b), (c, d)) = (children.0.size(), children.1.size());
                (a + c + 2, b + d)
            }
        }
    }
}

/// A subtree inside a piece: a run of its nodes and one of its references.
#[derive(Clone, Debug)]
pub(in crate::build) struct Stem {
    pub root: Node,
    pub piece: usize,
    nodes: std::ops::Range<usize>,
    refs: std::ops::Range<usize>,
}

impl Stem {
    /// The subtree below a node of a piece, the node itself included.
    pub fn of(root: Node, index: usize, piece: &Piece) -> Stem {
        let pair = |node: Node| [piece.nodes[node.first as usize], piece.nodes[node.first as usize + 1]];
        let (mut first, mut last) = (root, root);
        while !first.is_leaf() {
            first = pair(first)[0];
        }
        while !last.is_leaf() {
            last = pair(last)[1];
        }
        // Each reference's leaf comes in order, and so does each pair: the last is below the last inner node.
        let mut nodes = 0..0;
        let mut inner = root;
        while !inner.is_leaf() {
            let at = inner.first as usize;
            nodes = if nodes.is_empty() { at..at + 2 } else { nodes.start..at + 2 };
            let [left, right] = pair(inner);
            inner = if right.is_leaf() { left } else { right };
        }
        Stem { root, piece: index, nodes, refs: first.first as usize..(last.first + last.count) as usize }
    }
}

/// One tree of a top tree and the stems that its references name, a single one in each leaf.
pub(in crate::build) fn splice(top: &Tree, stems: &[Stem], pieces: &[&Piece], exec: &Executor) -> Tree {
    let Some(&root) = top.nodes.first() else { return Tree::default() };
    let below: usize = stems.iter().map(|stem| stem.nodes.len()).sum();
    let ref_count = stems.iter().map(|stem| stem.refs.len()).sum();
    let mut tree = Tree { nodes: bytemuck::zeroed_vec(top.nodes.len() + below), refs: vec![0; ref_count] };
    let mut layout = Layout::over(&mut tree);
    let pair = layout.take_pair();
    let root = layout.place_top(top, root, stems, pieces);
    layout.jobs.push(Job::Pair { at: pair, nodes: [root, UNUSED] });
    exec.map(layout.jobs, |_, job| job.run());
    tree
}

/// Cuts the output into the jobs' runs, front to back.
struct Layout<'a> {
    base: Base,
    nodes: &'a mut [Node],
    refs: &'a mut [u32],
    jobs: Vec<Job<'a>>,
}

impl<'a> Layout<'a> {
    fn over(tree: &'a mut Tree) -> Layout<'a> {
        let base = Base { nodes: 0, refs: 0 };
        Layout { base, nodes: &mut tree.nodes, refs: &mut tree.refs, jobs: Vec::new() }
    }

    /// Returns the record of the branch's root.
    fn place(&mut self, branch: Branch) -> Node {
        let base = self.base;
        match branch {
            Branch::Piece { root, piece } => {
                let nodes = take(&mut self.nodes, piece.nodes.len());
                let refs = take(&mut self.refs, piece.refs.len());
                self.base = Base { nodes: base.nodes + nodes.len() as u32, refs: base.refs + refs.len() as u32 };
                self.jobs.push(Job::Piece { piece, nodes, refs, base });
                base.shift(root)
            }
            Branch::Fork { bounds, children } => {
                let at = self.take_pair();
                let (left, right) = *children;
                let nodes = [self.place(left), self.place(right)];
                self.jobs.push(Job::Pair { at, nodes });
                Node::inner(bounds, base.nodes)
            }
        }
    }

    /// [`Layout::place`] for a node of a top tree, whose leaves are stems.
    fn place_top(&mut self, top: &Tree, node: Node, stems: &'a [Stem], pieces: &[&'a Piece]) -> Node {
        let base = self.base;
        if !node.is_leaf() {
            let at = self.take_pair();
            let nodes = [0, 1].map(|k| self.place_top(top, top.nodes[node.first as usize + k], stems, pieces));
            self.jobs.push(Job::Pair { at, nodes });
            return Node::inner(node.bounds(), base.nodes);
        }
        let stem = &stems[top.refs[node.first as usize] as usize];
        let nodes = take(&mut self.nodes, stem.nodes.len());
        let refs = take(&mut self.refs, stem.refs.len());
        self.base = Base { nodes: base.nodes + nodes.len() as u32, refs: base.refs + refs.len() as u32 };
        let base = Base {
            nodes: base.nodes.wrapping_sub(stem.nodes.start as u32),
            refs: base.refs.wrapping_sub(stem.refs.start as u32),
        };
        self.jobs.push(Job::Stem { from: pieces[stem.piece], stem, nodes, refs, base });
        base.shift(stem.root)
    }

    fn take_pair(&mut self) -> &'a mut [Node] {
        self.base.nodes += 2;
        take(&mut self.nodes, 2)
    }
}

fn take<'a, T>(slice: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (head, tail) = std::mem::take(slice).split_at_mut(count);
    *slice = tail;
    head
}
