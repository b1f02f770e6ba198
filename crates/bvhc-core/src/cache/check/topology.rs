use crate::cache::report::{Place, Report};
use crate::cache::rules;
use crate::layout::{MAX_DEPTH, MAX_LEAF, Node, SectionKind};

/// Which tree is looked at, so that findings can name the record.
#[derive(Clone, Copy, Debug)]
pub struct TreePlace {
    pub kind: SectionKind,
    /// `None` for the TLAS.
    pub tree: Option<u32>,
    /// First record of the tree in its section.
    pub start: u64,
}

impl TreePlace {
    pub fn node(&self, i: usize) -> Place {
        let index = i as u64;
        Place { tree: self.tree.map(|t| (t, index)), ..Place::record(self.kind, self.start + index) }
    }
}

/// What the walk learnt of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shape {
    /// Depth of the deepest leaf; `None` where part of the tree could not be reached.
    pub depth: Option<u32>,
    /// The leaves' ranges lie within the list and tile it, and every record is part of the tree.
    pub tiled: bool,
}

/// Follow the tree once in depth-first order, with a stack of at most 65 entries and no recursion: O(n) on every input.
///
/// A node is entered only through a pair that nobody claimed before, so each is entered at most once even where the pairs
/// form a ladder (two nodes that share their children, and these again), which is in range and acyclic but takes 2^depth visits
/// to follow blindly. Children must lie behind their parent: with that, every pair claimed once makes a tree.
pub fn walk(nodes: &[Node], items: u64, at: TreePlace, out: &mut Report) -> Shape {
    if nodes.is_empty() {
        return Shape { depth: Some(0), tiled: items == 0 };
    }
    const NOBODY: u32 = u32::MAX;
    let mut parents: Vec<u32> = Vec::new();
    if parents.try_reserve_exact(nodes.len() / 2).is_err() {
        match at.tree {
            Some(tree) => out.starve(at.node(0), &format!("The shape of tree {tree}")),
            None => out.starve(at.node(0), "The shape of the top level"),
        }
        return Shape::default();
    }
    parents.resize(nodes.len() / 2, NOBODY);

    if let Some(byte) = nodes.get(1).and_then(|unused| bytemuck::bytes_of(unused).iter().position(|b| *b != 0)) {
        out.add(&rules::E0413, at.node(1), || ("zero".into(), format!("{byte} is not")));
    }

    // A cut is a claim that failed: behind it order and completeness cannot be judged, and only direct faults are reported.
    let mut cut = false;
    let mut shape = Shape { depth: Some(0), tiled: true };
    let (mut deepest, mut next_pair, mut cursor) = (0u32, 2u32, 0u64);
    let mut stack: Vec<(u32, u32)> = Vec::with_capacity(MAX_DEPTH as usize + 2);
    stack.push((0, 0));
    while let Some((index, depth)) = stack.pop() {
        let i = index as usize;
        let node = &nodes[i];
        deepest = deepest.max(depth);
        if node.is_leaf() {
            let (first, count) = (u64::from(node.first), u64::from(node.count));
            if node.count > MAX_LEAF {
                out.add(&rules::E0410, at.node(i), || {
                    (format!("{MAX_LEAF} items a leaf"), format!("this one has {count}"))
                });
            }
            if first + count > items {
                shape.tiled = false;
                out.add(&rules::E0408, at.node(i), || (items.to_string(), (first + count).to_string()));
                cursor += count;
                continue;
            }
            if first != cursor {
                shape.tiled = false;
                if !cut {
                    out.add(&rules::E0409, at.node(i), || (cursor.to_string(), first.to_string()));
                }
            }
            cursor = first + count;
            continue;
        }

        // Claim the pair of children, unless that would leave the tree, go back in it, or share them.
        let first = node.first;
        if !first.is_multiple_of(2) || first < 2 {
            cut = true;
            out.add(&rules::E0401, at.node(i), || ("even and at least 2".into(), first.to_string()));
            continue;
        }
        if first <= index {
            cut = true;
            out.add(&rules::E0402, at.node(i), || (index.to_string(), first.to_string()));
            continue;
        }
        if u64::from(first) + 1 >= nodes.len() as u64 {
            cut = true;
            out.add(&rules::E0403, at.node(i), || (nodes.len().to_string(), (u64::from(first) + 1).to_string()));
            continue;
        }
        let parent = &mut parents[first as usize / 2];
        if *parent != NOBODY {
            cut = true;
            let other = *parent;
            out.add(&rules::E0404, at.node(i), || ("one".into(), format!("{other} (pair {first})")));
            continue;
        }
        *parent = index;
        if depth + 1 > MAX_DEPTH {
            cut = true;
            out.add(&rules::E0406, at.node(i), || (MAX_DEPTH.to_string(), (depth + 1).to_string()));
            continue;
        }
        if !cut && first != next_pair {
            out.add(&rules::E0426, at.node(i), || (next_pair.to_string(), first.to_string()));
        }
        next_pair = first.saturating_add(2);
        stack.push((first + 1, depth + 1));
        stack.push((first, depth + 1));
    }

    // Look for what was not reached, unless a failed claim explains it.
    if cut {
        return Shape { depth: None, tiled: false };
    }
    for pair in 1..parents.len() {
        if parents[pair] == NOBODY {
            // Leaves that are not in the tree may state any range: nobody is to follow those.
            shape.tiled = false;
            out.add(&rules::E0405, at.node(pair * 2), || ("one".into(), "none".into()));
        }
    }
    if shape.tiled && cursor != items {
        shape.tiled = false;
        out.add(&rules::E0409, at.node(0), || {
            (
                format!("the list's end, which is {items}; the last one must end there"),
                format!("{cursor}, and no leaf does"),
            )
        });
    }
    shape.depth = Some(deepest);
    shape
}
