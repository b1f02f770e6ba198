//! One ray again, with all that traversal does on its way.

use crate::cache::View;
use crate::geom::{Aabb, Ray};
use crate::trace::{Hit, Malformed, Observer, try_any_hit, try_closest_hit};
use crate::tree::Node;
use serde::Serialize;
use std::collections::BTreeMap;

/// What traversal on the CPU did with a ray.
#[derive(Clone, Debug)]
pub struct Replay {
    pub steps: Vec<Step>,
    /// Steps that were too many to keep.
    pub left_out: u64,
    pub hit: Result<Option<Hit>, Malformed>,
    /// The answer to the same ray as a shadow ray.
    pub any: Result<bool, Malformed>,
}

/// A moment of a walk. Records are numbered as in the whole section.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "step", rename_all = "kebab-case")]
pub enum Step {
    /// The root of a tree: the top level, or the tree of an instance.
    Root { section: &'static str, node: u64, bounds: [[f32; 3]; 2], met: bool },
    /// A child of the node that was entered, at this depth.
    Child { section: &'static str, node: u64, depth: u32, bounds: [[f32; 3]; 2], leaf: bool, near: Option<f32> },
    /// A node that was put off is taken up, or dropped because the best hit is nearer.
    Resume { section: &'static str, node: u64, near: f32, dropped: bool },
    /// The ray crosses a triangle; all others of the leaf it misses.
    Triangle { record: u64, prim: u32, geom: u32, t: f64, accepted: bool },
    /// The ray is mapped into an instance.
    Instance { record: u64, id: u32, tree: u32 },
    /// The walk returns to the top level.
    Return,
}

impl Replay {
    /// Steps that are kept.
    pub const MOST_STEPS: usize = 100_000;
}

/// Trace a ray and keep a log.
pub fn replay(view: &View<'_>, ray: &Ray) -> Replay {
    let mut log =
        Log { view, tree: None, steps: Vec::new(), left_out: 0, depths: BTreeMap::new(), outer: BTreeMap::new() };
    if view.tlas_nodes.is_empty() {
        log.tree = Some(0);
    }
    let hit = try_closest_hit(view, ray, &mut log);
    let any = try_any_hit(view, ray, &mut crate::trace::NoObserver);
    Replay { steps: log.steps, left_out: log.left_out, hit, any }
}

struct Log<'a> {
    view: &'a View<'a>,
    /// The BLAS being walked; `None` on the top level.
    tree: Option<u32>,
    steps: Vec<Step>,
    left_out: u64,
    /// Depth of the pairs seen in this tree, by their first node; and those of the top level while an instance is walked.
    depths: BTreeMap<u32, u32>,
    outer: BTreeMap<u32, u32>,
}

impl Log<'_> {
    fn note(&mut self, step: Step) {
        if self.steps.len() < Replay::MOST_STEPS { self.steps.push(step) } else { self.left_out += 1 }
    }

    /// The tree's section, the number of its first node in it, and its nodes.
    fn nodes(&self) -> (&'static str, u64, &[Node]) {
        let Some(tree) = self.tree else { return ("TNOD", 0, self.view.tlas_nodes) };
        let offset = self.view.blases.get(tree as usize).map_or(0, |b| b.node_offset);
        ("NODE", offset, self.view.blas(tree as usize).map_or(&[], |b| b.nodes))
    }
}

fn corners(b: &Aabb) -> [[f32; 3]; 2] {
    [b.min, b.max]
}

impl Observer for Log<'_> {
    fn root(&mut self, met: bool) {
        let (section, offset, nodes) = self.nodes();
        let Some(root) = nodes.first() else { return };
        let step = Step::Root { section, node: offset, bounds: corners(&root.bounds()), met };
        let first = root.first;
        self.note(step);
        self.depths.clear();
        self.depths.insert(first, 1);
    }

    fn pair(&mut self, first: u32, near: [f32; 2], met: u32) {
        let depth = self.depths.get(&first).copied().unwrap_or(0);
        for i in 0..2 {
            let (section, offset, nodes) = self.nodes();
            let Some(child) = nodes.get(first as usize + i).copied() else { continue };
            let near = (met & 1 << i != 0).then_some(near[i]);
            let (node, bounds) = (offset + u64::from(first) + i as u64, corners(&child.bounds()));
            self.note(Step::Child { section, node, depth, bounds, leaf: child.is_leaf(), near });
            if !child.is_leaf() {
                self.depths.insert(child.first, depth + 1);
            }
        }
    }

    fn resume(&mut self, node: u32, near: f32, dropped: bool) {
        let (section, offset, _) = self.nodes();
        self.note(Step::Resume { section, node: offset + u64::from(node), near, dropped });
    }

    fn crossing(&mut self, slot: usize, t: f64, accepted: bool) {
        let tree = self.tree.unwrap_or(0) as usize;
        let offset = self.view.blases.get(tree).map_or(0, |b| b.ref_offset);
        let Some(record) = self.view.blas(tree).and_then(|b| b.triangles.get(slot)) else { return };
        let (prim, geom) = (record.prim, record.geom);
        self.note(Step::Triangle { record: offset + slot as u64, prim, geom, t, accepted });
    }

    fn enter(&mut self, record: usize) {
        let Some(instance) = self.view.instances.get(record) else { return };
        let (id, tree) = (instance.id, instance.blas);
        self.note(Step::Instance { record: record as u64, id, tree });
        self.outer = std::mem::take(&mut self.depths);
        self.tree = Some(tree);
    }

    fn leave(&mut self) {
        self.note(Step::Return);
        self.depths = std::mem::take(&mut self.outer);
        self.tree = None;
    }
}
