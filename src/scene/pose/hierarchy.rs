use crate::geom::Affine;

/// The nodes that matter to a scene, each behind its parent.
#[derive(Debug, Default)]
pub struct Hierarchy {
    /// Node and parent, parents first.
    order: Vec<(u32, Option<u32>)>,
    contains: Vec<bool>,
}

impl Hierarchy {
    /// An empty hierarchy over nodes that are numbered below `nodes`.
    pub fn new(nodes: usize) -> Hierarchy {
        Hierarchy { order: Vec::new(), contains: vec![false; nodes] }
    }

    /// Add a node whose parent, if it has one, was added before. `false` where the node is there already.
    pub fn add(&mut self, node: u32, parent: Option<u32>) -> bool {
        let is_new = self.contains.get_mut(node as usize).is_some_and(|c| !std::mem::replace(c, true));
        if is_new {
            self.order.push((node, parent));
        }
        is_new
    }

    pub fn contains(&self, node: u32) -> bool {
        self.contains.get(node as usize) == Some(&true)
    }

    /// The nodes in order.
    pub fn nodes(&self) -> impl Iterator<Item = u32> {
        self.order.iter().map(|(node, _)| *node)
    }

    /// Of each node, by its number, whether one of `nodes` is at it or below.
    pub fn carriers(&self, nodes: impl Iterator<Item = u32>) -> Vec<bool> {
        let mut carries = vec![false; self.contains.len()];
        nodes.for_each(|node| carries[node as usize] = self.contains(node));
        for &(node, parent) in self.order.iter().rev() {
            if let Some(parent) = parent.filter(|_| carries[node as usize]) {
                carries[parent as usize] = true;
            }
        }
        carries
    }

    /// Every node's transform to world space, from each node's own; both by node number. Nodes outside of the hierarchy keep what they
    /// have.
    pub fn to_world(&self, mut own: Vec<Affine>) -> Vec<Affine> {
        for &(node, parent) in &self.order {
            if let Some(parent) = parent {
                own[node as usize] = own[parent as usize].then_inner(&own[node as usize]);
            }
        }
        own
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_compose_from_root_to_leaf() {
        let moved = |x: f64, scale: f64| Affine {
            rows: [[scale, 0.0, 0.0, x], [0.0, scale, 0.0, 0.0], [0.0, 0.0, scale, 0.0]],
        };
        let mut hierarchy = Hierarchy::new(4);
        assert!(hierarchy.add(2, None) && hierarchy.add(0, Some(2)) && hierarchy.add(3, Some(0)));
        assert!(!hierarchy.add(0, None) && !hierarchy.contains(1));
        assert_eq!(hierarchy.carriers([0, 1].into_iter()), [true, false, true, false]);
        let world = hierarchy.to_world(vec![moved(1.0, 2.0), moved(7.0, 7.0), moved(10.0, 3.0), moved(1.0, 1.0)]);
        assert_eq!(world, [moved(13.0, 6.0), moved(7.0, 7.0), moved(10.0, 3.0), moved(19.0, 6.0)]);
    }
}
