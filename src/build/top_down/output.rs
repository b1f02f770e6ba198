//! Where finished nodes go: pieces of a tree that grow side by side, and their concatenation in canonical order.

use crate::build::exec::Executor;
use crate::build::prim_ref::PrimRef;
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
    pub fn leaf(&mut self, bounds: Aabb, refs: &[PrimRef]) -> Node {
        let first = self.refs.len();
        for r in refs {
            self.refs.push(r.prim);
        }
        if refs.len() > 1 {
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

/// A run of the output that nobody else writes.
enum Job<'a> {
    Pair { at: &'a mut [Node], nodes: [Node; 2] },
    Piece { piece: Piece, nodes: &'a mut [Node], refs: &'a mut [u32], base: Base },
}

/// Where a subtree starts in the output.
#[derive(Clone, Copy)]
struct Base {
    nodes: u32,
    refs: u32,
}

impl Base {
    fn shift(self, node: Node) -> Node {
        Node { first: node.first + if node.is_leaf() { self.refs } else { self.nodes }, ..node }
    }
}

impl Branch {
    /// Concatenate. Canonical order is the order of the recursion, so every piece is one run of the output and all are
    /// copied at once.
    pub fn assemble(self, exec: &Executor) -> Tree {
        let (node_count, ref_count) = self.size();
        let mut tree = Tree { nodes: vec![UNUSED; node_count + 2], refs: vec![0; ref_count] };
        let mut layout =
            Layout { base: Base { nodes: 0, refs: 0 }, nodes: &mut tree.nodes, refs: &mut tree.refs, jobs: Vec::new() };
        let pair = layout.take_pair();
        let root = layout.place(self);
        layout.jobs.push(Job::Pair { at: pair, nodes: [root, UNUSED] });
        exec.map(layout.jobs, |_, job| match job {
            Job::Pair { at, nodes } => at.copy_from_slice(&nodes),
            Job::Piece { piece, nodes, refs, base } => {
                for (to, from) in nodes.iter_mut().zip(&piece.nodes) {
                    *to = base.shift(*from);
                }
                refs.copy_from_slice(&piece.refs);
            }
        });
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

/// Cuts the output into the jobs' runs, front to back.
struct Layout<'a> {
    base: Base,
    nodes: &'a mut [Node],
    refs: &'a mut [u32],
    jobs: Vec<Job<'a>>,
}

impl<'a> Layout<'a> {
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
