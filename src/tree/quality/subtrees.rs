use crate::tree::Node;

/// Which triangles have a reference below which node.
///
/// The leaves are numbered through in depth-first order, so that what stands below a node is one run of slots; a triangle
/// belongs to a node if one of its slots lies in the run. Built in one pass and asked in O(log references of the triangle).
/// Nodes that break the tree's rules (a file that was not checked) are left out, with all below them.
#[derive(Clone, Debug)]
pub struct Subtrees<'a> {
    nodes: &'a [Node],
    /// The run of slots below each node; empty for records that no parent reaches.
    runs: Vec<[u32; 2]>,
    /// `slots[starts[t]..starts[t + 1]]`: the slots of triangle `t`, ascending.
    starts: Vec<u32>,
    slots: Vec<u32>,
}

impl<'a> Subtrees<'a> {
    /// `refs` are the tree's references, each the number of one of `triangles` triangles; a number beyond is left out.
    pub fn new(nodes: &'a [Node], refs: &[u32], triangles: usize) -> Subtrees<'a> {
        let mut out =
            Subtrees { nodes, runs: vec![[0; 2]; nodes.len()], starts: vec![0; triangles + 1], slots: Vec::new() };
        let order = out.preorder();

        // Number the slots in the order of the leaves: a node's run begins with the number that the walk has reached.
        let mut items: Vec<u32> = Vec::with_capacity(refs.len());
        for &i in &order {
            let node = &nodes[i as usize];
            out.runs[i as usize] = [items.len() as u32; 2];
            if node.is_leaf() {
                let first = node.first as usize;
                items.extend(refs.get(first..first.saturating_add(node.count as usize)).unwrap_or_default());
                out.runs[i as usize][1] = items.len() as u32;
            }
        }
        // Backward, since a run ends where that of the node's last child does.
        for &i in order.iter().rev() {
            if let Some(children) = out.children(i) {
                let ends = children.map(|c| out.runs[c as usize][1]);
                out.runs[i as usize][1] = out.runs[i as usize][1].max(ends[0]).max(ends[1]);
            }
        }

        // Sort the slots by triangle, counting first.
        for t in &items {
            if let Some(n) = out.starts.get_mut(*t as usize + 1) {
                *n += 1;
            }
        }
        for t in 0..triangles {
            out.starts[t + 1] += out.starts[t];
        }
        let mut next = out.starts.clone();
        out.slots = vec![0; out.starts[triangles] as usize];
        for (slot, t) in items.iter().enumerate() {
            if (*t as usize) < triangles {
                out.slots[next[*t as usize] as usize] = slot as u32;
                next[*t as usize] += 1;
            }
        }
        out
    }

    /// The tree's records, as given.
    pub fn nodes(&self) -> &'a [Node] {
        self.nodes
    }

    /// How many triangles the tree is over, as given.
    pub fn triangles(&self) -> usize {
        self.starts.len() - 1
    }

    /// The two children of an inner node, if they lie behind it as they must.
    pub fn children(&self, node: u32) -> Option<[u32; 2]> {
        let n = &self.nodes[node as usize];
        let fits = !n.is_leaf() && n.first > node && (n.first as usize) < self.nodes.len().saturating_sub(1);
        fits.then_some([n.first, n.first.wrapping_add(1)])
    }

    /// Whether a reference to the triangle stands below the node.
    pub fn owns(&self, node: u32, triangle: usize) -> bool {
        let [begin, end] = self.runs[node as usize];
        let slots = &self.slots[self.starts[triangle] as usize..self.starts[triangle + 1] as usize];
        let at = slots.partition_point(|s| *s < begin);
        slots.get(at).is_some_and(|s| *s < end)
    }

    /// Every node once, parents first and first children before second ones.
    fn preorder(&self) -> Vec<u32> {
        let mut order = Vec::with_capacity(self.nodes.len());
        let mut claimed = vec![false; self.nodes.len()];
        let mut stack = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(i) = stack.pop() {
            if std::mem::replace(&mut claimed[i as usize], true) {
                continue;
            }
            order.push(i);
            if let Some([left, right]) = self.children(i) {
                stack.extend([right, left]);
            }
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Aabb;

    const BOX: Aabb = Aabb { min: [0.0; 3], max: [1.0; 3] };

    fn zero() -> Node {
        bytemuck::Zeroable::zeroed()
    }

    #[test]
    fn a_split_triangle_belongs_to_both_sides() {
        let nodes = [Node::inner(BOX, 2), zero(), Node::leaf(BOX, 0, 2), Node::leaf(BOX, 2, 1)];
        let s = Subtrees::new(&nodes, &[0, 1, 0], 3);
        let owned = |n| [0, 1, 2].map(|t| s.owns(n, t));
        assert_eq!(owned(0), [true, true, false]);
        assert_eq!(owned(2), [true, true, false]);
        assert_eq!(owned(3), [true, false, false]);
    }

    #[test]
    fn leaves_may_stand_in_any_order() {
        let nodes = [Node::inner(BOX, 2), zero(), Node::leaf(BOX, 2, 1), Node::leaf(BOX, 0, 2)];
        let s = Subtrees::new(&nodes, &[0, 1, 2], 3);
        assert_eq!([0, 1, 2].map(|t| s.owns(2, t)), [false, false, true]);
        assert_eq!([0, 1, 2].map(|t| s.owns(3, t)), [true, true, false]);
    }

    #[test]
    fn records_that_are_no_tree_are_left_out() {
        for first in [0, 3, 7, u32::MAX] {
            let nodes = [Node::inner(BOX, first), zero(), zero(), Node::leaf(BOX, u32::MAX, 5)];
            let s = Subtrees::new(&nodes, &[9, 0], 1);
            assert!(!s.owns(0, 0), "{first}");
        }
        assert_eq!(Subtrees::new(&[], &[], 0).triangles(), 0);
    }
}
