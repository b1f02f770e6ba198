//! A finished tree whose subtrees may lie along bases of their own, and what rays do in it.

use super::{Basis, OrientedBox};
use crate::geom::clip::Polygon;
use crate::geom::vector::dot;
use crate::geom::{Aabb, Ray};
use crate::layout::{BlasView, Node};

/// Half the distance from 1 to the next number.
const UNIT: f64 = f64::EPSILON / 2.0;
/// What an inner node costs, in triangle tests.
pub const NODE: f64 = 1.2;
/// What it costs to turn a ray. An inner node is two boxes of 24 operations each; to turn a ray takes 30 and three divisions, and so about two thirds of
/// that.
pub const TURN: f64 = NODE * 33.0 / 48.0;

/// A ray up to where it ends: everything that it must ask to be sure of that.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    origin: [f64; 3],
    direction: [f64; 3],
    end: f64,
    /// Part and number of the triangle that it ends at. Where it was cut, any of its leaves will do.
    triangle: Option<(u32, u32)>,
}

impl Segment {
    /// `hit` is where it ends: a distance, and the triangle's part and number. `scene` holds all that may be met.
    pub fn new(ray: &Ray, hit: Option<(f32, (u32, u32))>, scene: &Aabb) -> Segment {
        let (origin, direction) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
        // Rays that hit nothing end behind all boxes.
        let reach: f64 = (0..3).map(|k| f64::from(scene.max[k]).abs().max(f64::from(scene.min[k]).abs())).sum();
        let length = dot(direction, direction).sqrt();
        let behind = (reach + origin.iter().map(|c| c.abs()).sum::<f64>()) / length;
        let end = hit.map_or(f64::from(ray.t_max).min(behind), |(t, _)| f64::from(t.next_up()));
        Segment { origin, direction, end, triangle: hit.map(|(_, triangle)| triangle) }
    }

    /// Whether it meets a box on the way to its end; never `false` where exact arithmetic says that it does.
    ///
    /// The ray's coordinates are wrong by at most `3.1u` times the sum of its own, so the slab is moved by `8u` times what the ray reaches: rounding
    /// of the slab's own ends is in that. What divisions and products round is less than `4u` of the result.
    fn meets(&self, turned: &Turn, bounds: &OrientedBox) -> bool {
        let (mut enter, mut leave) = (0.0f64, self.end);
        for k in 0..3 {
            let (low, high) = (bounds.low[k] - turned.margin, bounds.high[k] + turned.margin);
            if turned.direction[k] == 0.0 {
                if !(low..=high).contains(&turned.origin[k]) {
                    return false;
                }
                continue;
            }
            let (a, b) =
                ((low - turned.origin[k]) / turned.direction[k], (high - turned.origin[k]) / turned.direction[k]);
            let (near, far) = if a < b { (a, b) } else { (b, a) };
            enter = enter.max(near - 4.0 * UNIT * near.abs());
            leave = leave.min(far + 4.0 * UNIT * far.abs());
        }
        enter <= leave
    }

    fn turned(&self, basis: &Basis) -> Turn {
        let sum = |v: [f64; 3]| v.iter().map(|c| c.abs()).sum::<f64>();
        let margin = 8.0 * UNIT * (sum(self.origin) + self.end * sum(self.direction));
        Turn { origin: basis.coordinates(self.origin), direction: basis.coordinates(self.direction), margin }
    }
}

/// A ray's coordinates along a basis.
struct Turn {
    origin: [f64; 3],
    direction: [f64; 3],
    margin: f64,
}

/// What rays did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Inner nodes entered.
    pub nodes: u64,
    /// Triangles tested.
    pub triangles: u64,
    /// Times that a ray was turned.
    pub turns: u64,
    /// Rays that did not come to the triangle that they end at.
    pub lost: u64,
}

impl Work {
    /// In triangle tests.
    pub fn cost(&self) -> f64 {
        NODE * self.nodes as f64 + self.triangles as f64 + TURN * self.turns as f64
    }
}

impl std::ops::Add for Work {
    type Output = Work;

    fn add(self, other: Work) -> Work {
        Work {
            nodes: self.nodes + other.nodes,
            triangles: self.triangles + other.triangles,
            turns: self.turns + other.turns,
            lost: self.lost + other.lost,
        }
    }
}

/// A tree, the polygons in its leaves, and the basis that each inner node's two boxes lie along.
pub struct Turned<'a> {
    tree: BlasView<'a>,
    /// Of all slots in their order, what of the triangle is in its leaf.
    points: Vec<[f64; 3]>,
    /// Where those of each slot begin, and the end.
    starts: Vec<usize>,
    bases: Vec<Basis>,
    /// Along the basis of its parent.
    boxes: Vec<OrientedBox>,
}

impl<'a> Turned<'a> {
    /// Along the axes everywhere. The tree's records are sound.
    pub fn new(tree: BlasView<'a>) -> Turned<'a> {
        let (mut points, mut starts) =
            (Vec::with_capacity(3 * tree.triangles.len()), vec![0; tree.triangles.len() + 1]);
        let mut leaf_of: Vec<&Node> = tree.nodes.iter().filter(|node| node.is_leaf()).collect();
        leaf_of.sort_by_key(|leaf| leaf.first);
        for leaf in leaf_of {
            for slot in leaf.first as usize..(leaf.first + leaf.count) as usize {
                let corners = tree.triangles[slot].corners();
                let part = match leaf.bounds().contains(&Aabb::from_points(&corners)) {
                    true => Polygon::triangle(&corners),
                    false => Polygon::inside(&corners, &leaf.bounds()),
                };
                match part.corners() {
                    [] => points.extend(corners.map(|p| p.map(f64::from))),
                    some => points.extend_from_slice(some),
                }
                starts[slot + 1] = points.len();
            }
        }
        let bases = vec![Basis::AXES; tree.nodes.len()];
        Turned { tree, points, starts, bases, boxes: tree.nodes.iter().map(along_axes).collect() }
    }

    /// The basis that the boxes of a node's two children lie along.
    pub fn basis(&self, node: usize) -> Basis {
        self.bases[node]
    }

    /// The children of an inner node.
    pub fn children(&self, node: usize) -> Option<[usize; 2]> {
        let record = self.tree.nodes[node];
        (!record.is_leaf()).then_some([record.first as usize, record.first as usize + 1])
    }

    /// Corners of all that is below: leaves tile the triangles in the order of the tree.
    pub fn points(&self, node: usize) -> &[[f64; 3]] {
        let end = |child: usize| {
            let mut record = self.tree.nodes[node];
            while !record.is_leaf() {
                record = self.tree.nodes[record.first as usize + child];
            }
            record
        };
        let (low, high) = (end(0), end(1));
        &self.points[self.starts[low.first as usize]..self.starts[(high.first + high.count) as usize]]
    }

    /// Let all that is below a node lie along a basis. Along the axes the boxes are those of the tree.
    pub fn turn(&mut self, node: usize, basis: Basis) {
        self.bases[node] = basis;
        for child in self.children(node).into_iter().flatten() {
            self.turn_box(child, basis);
        }
    }

    /// Returns the box. Rounding of clipped corners is some units in their last place, which the factor covers.
    fn turn_box(&mut self, node: usize, basis: Basis) -> OrientedBox {
        self.bases[node] = basis;
        let bounds = match self.children(node) {
            Some([a, b]) => {
                let (a, b) = (self.turn_box(a, basis), self.turn_box(b, basis));
                let pick = |x: [f64; 3], y: [f64; 3], f: fn(f64, f64) -> f64| [0, 1, 2].map(|k| f(x[k], y[k]));
                OrientedBox { basis, low: pick(a.low, b.low, f64::min), high: pick(a.high, b.high, f64::max) }
            }
            None => {
                let points = self.points(node);
                let most = points.iter().flatten().fold(0.0f64, |most, c| most.max(c.abs()));
                // A leaf has triangles, so the other case is never there.
                let bounds = OrientedBox::in_basis(basis, points).unwrap_or(self.boxes[node]);
                let [low, high] = [(bounds.low, -64.0), (bounds.high, 64.0)];
                let moved = |(end, units): ([f64; 3], f64)| end.map(|v| v + units * UNIT * most);
                OrientedBox { basis, low: moved(low), high: moved(high) }
            }
        };
        self.boxes[node] = if basis == Basis::AXES { along_axes(&self.tree.nodes[node]) } else { bounds };
        self.boxes[node]
    }

    /// Which rays come to each of a node's two.
    pub fn divided(&self, node: usize, rays: &[u32], all: &[Segment]) -> [Vec<u32>; 2] {
        let Some(children) = self.children(node) else { return [Vec::new(), Vec::new()] };
        children.map(|child| {
            let comes = |ray: &&u32| {
                let segment = &all[**ray as usize];
                segment.meets(&segment.turned(&self.bases[node]), &self.boxes[child])
            };
            rays.iter().filter(comes).copied().collect()
        })
    }

    /// What rays that come to a node do below. `above` is the basis that they come in.
    pub fn work<'r>(&self, node: usize, above: &Basis, rays: impl IntoIterator<Item = &'r Segment>) -> Work {
        let mut work = Work::default();
        let mut open = Vec::new();
        for ray in rays {
            let mut is_found = ray.triangle.is_none();
            open.push((node, *above, None));
            while let Some((node, above, came)) = open.pop() {
                let Some(children) = self.children(node) else {
                    let record = self.tree.nodes[node];
                    work.triangles += u64::from(record.count);
                    let held = &self.tree.triangles[record.first as usize..(record.first + record.count) as usize];
                    is_found |= ray.triangle.is_some_and(|is_it| held.iter().any(|t| (t.geom, t.prim) == is_it));
                    continue;
                };
                work.nodes += 1;
                let basis = self.bases[node];
                work.turns += u64::from(basis != above && basis != Basis::AXES);
                let turned = match came {
                    Some(turned) if basis == above => turned,
                    _ => std::rc::Rc::new(ray.turned(&basis)),
                };
                for child in children {
                    if ray.meets(&turned, &self.boxes[child]) {
                        open.push((child, basis, Some(turned.clone())));
                    }
                }
            }
            work.lost += u64::from(!is_found);
        }
        work
    }
}

fn along_axes(node: &Node) -> OrientedBox {
    OrientedBox { basis: Basis::AXES, low: node.min.map(f64::from), high: node.max.map(f64::from) }
}
