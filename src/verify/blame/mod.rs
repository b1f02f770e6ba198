//! Which record of a file makes traversal go wrong.
//!
//! A lost hit has few causes, and each leaves its mark between the root and the triangle: an instance's matrices are not those of the
//! scene, the triangle's record is missing or has other corners, a box on the way does not hold the hit. They are looked for in this
//! order; where all records are right the traversal itself is to blame, and the leaf that it should have reached is named.

mod records;
mod way;

use super::class::Class;
use super::subject::Subject;
use crate::cache::TriangleRecord;
use crate::geom::clip::Polygon;
use crate::geom::{Aabb, Affine, Ray};
use crate::trace::Hit;
use crate::trace::brute::{Answer, Source};
use crate::tree::Node;
use records::{copies_share_a_node, corners, instance, is_of, moved, source_of};
use serde::Serialize;
use way::{Way, first_narrow, first_without, leaves_at, ways_to};

/// A record and what is wrong with it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Blame {
    /// Four letters, as in the file.
    pub section: &'static str,
    /// Number of the record in the section.
    pub record: u64,
    /// The BLAS that it belongs to.
    pub tree: Option<u32>,
    /// How deep the node lies in its tree.
    pub depth: Option<u32>,
    /// A phrase that says what the record should be.
    pub why: String,
}

impl Blame {
    fn new(section: &'static str, record: u64, why: impl Into<String>) -> Blame {
        Blame { section, record, tree: None, depth: None, why: why.into() }
    }

    fn in_tree(self, tree: u32) -> Blame {
        Blame { tree: Some(tree), ..self }
    }

    fn at_depth(self, depth: usize) -> Blame {
        Blame { depth: Some(depth as u32), ..self }
    }
}

impl std::fmt::Display for Blame {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}[{}]", self.section, self.record)?;
        match (self.tree, self.depth) {
            (Some(tree), Some(depth)) => write!(f, " (tree {tree}, depth {depth})")?,
            (Some(tree), None) => write!(f, " (tree {tree})")?,
            (None, Some(depth)) => write!(f, " (depth {depth})")?,
            (None, None) => {}
        }
        write!(f, ": {}", self.why)
    }
}

/// Find the record to blame for a wrong answer. `word` is what the oracle says, `got` the hit that the device returned.
pub(super) fn blame(
    subject: &Subject<'_>,
    ray: &Ray,
    class: Class,
    word: Option<&Answer>,
    got: Option<&Hit>,
) -> Option<Blame> {
    let wrong = || got.and_then(|hit| returned(subject, hit));
    let lost = || {
        let certain = word.and_then(|w| w.certain().or(w.first()))?;
        Some(lost(subject, ray, certain.source, 0.5 * (certain.nearest + certain.farthest)))
    };
    match class {
        Class::False => wrong().or_else(lost),
        Class::Missed | Class::Farther | Class::Tree | Class::AnyHit | Class::Bits => lost().or_else(wrong),
        _ => None,
    }
}

/// Why a returned hit is none: its instance or its triangle is not that of the scene.
fn returned(subject: &Subject<'_>, hit: &Hit) -> Option<Blame> {
    if let Some(blame) = hit.instance.and_then(|id| instance(subject, id)) {
        return Some(blame);
    }
    let record = subject.view.triangles.get(hit.triangle)?;
    let tree = subject.view.geoms.get(record.geom as usize)?.blas;
    match source_of(subject, hit, record) {
        Some(source) => moved(record, &corners(subject, source), hit.triangle, tree),
        None => {
            let why = format!("the scene has no triangle {} of part {}", record.prim, record.geom);
            Some(Blame::new("TRIS", hit.triangle as u64, why).in_tree(tree))
        }
    }
}

/// Why the triangle `source`, which the ray meets at `t`, is not found.
fn lost(subject: &Subject<'_>, ray: &Ray, source: Source, t: f64) -> Blame {
    let (view, place) = (&subject.view, &subject.scene().instances[source.instance as usize]);
    let point = [0, 1, 2].map(|a| f64::from(ray.origin[a]) + t * f64::from(ray.direction[a]));
    if view.tlas_nodes.is_empty() {
        let rounding = if place.transform == Affine::IDENTITY { FINE } else { COARSE };
        return lost_in_tree(subject, source, 0, point, rounding);
    }

    // On the top level: the instance's record, and the boxes above it.
    if let Some(blame) = instance(subject, source.instance) {
        return blame;
    }
    let Some(at) = view.instances.iter().position(|i| i.id == source.instance) else {
        return Blame::new("INST", 0, format!("no record has the id {}, an instance of the scene", source.instance));
    };
    let ways = ways_to(view.tlas_nodes, |leaf| names(leaf, at));
    let Some(way) = ways.first() else {
        return Blame::new("INST", at as u64, "no leaf of TNOD names this instance");
    };
    if let Some(step) = first_without(view.tlas_nodes, way, &point, COARSE) {
        return narrow_box("TNOD", 0, view.tlas_nodes, way, step);
    }
    let inside = place.transform.inverse().unwrap_or(Affine::IDENTITY).transform_point(point);
    let tree = view.instances[at].blas;
    lost_in_tree(subject, source, tree, inside, COARSE)
}

/// How far a hit may lie outside of a box that holds it, relative to the coordinates: the arithmetic of `f64` alone, or matrices
/// and corners rounded to `f32` too.
const FINE: f64 = 1.0 / (1u64 << 40) as f64;
const COARSE: f64 = 1.0 / (1u64 << 20) as f64;

/// In one tree; `point` is the hit in the tree's own space.
fn lost_in_tree(subject: &Subject<'_>, source: Source, tree: u32, point: [f64; 3], rounding: f64) -> Blame {
    let view = &subject.view;
    let scene = subject.scene();
    let place = &scene.instances[source.instance as usize];
    let prim = scene.meshes[place.mesh as usize].source_prim(source.triangle as usize);
    let Some(blas) = view.blas(tree as usize) else {
        return Blame::new("BLAS", u64::from(tree), "its ranges lie outside of the sections");
    };
    let record = view.blases[tree as usize];
    let slot_number = |slot: usize| record.ref_offset + slot as u64;

    // The triangle's records. Copies of one mesh that one node placed in one tree bear equal numbers: then only those at this place are meant.
    let expected = corners(subject, source);
    let mut slots: Vec<usize> =
        (0..blas.triangles.len()).filter(|&s| is_of(subject, source, &blas.triangles[s])).collect();
    let in_place = |s: &usize| blas.triangles[*s].corners() == expected;
    if copies_share_a_node(subject, source) && slots.iter().any(in_place) {
        slots.retain(in_place);
    }
    let Some(&some_slot) = slots.first() else {
        let why = format!("none of its records is triangle {prim}, which the ray meets");
        return Blame::new("BLAS", u64::from(tree), why);
    };
    let altered = slots.iter().find_map(|&s| moved(&blas.triangles[s], &expected, slot_number(s) as usize, tree));
    if let Some(blame) = altered {
        return blame;
    }

    // The boxes above it: on a way that holds the hit all through, else on one with a box that does not fit, else on the one that comes
    // nearest to the hit.
    let slot_in = |leaf: &Node| slots.iter().copied().find(|&s| names(leaf, s));
    let ways = ways_to(blas.nodes, |leaf| slot_in(leaf).is_some());
    let fits = |way: &Way, step: usize| {
        let leaf = way.last().map(|&leaf| &blas.nodes[leaf]);
        first_narrow(blas.nodes, &way[step..]).is_none()
            && leaf.is_some_and(|leaf| holds_whole_triangles(leaf, blas.triangles))
    };
    let steps = ways.iter().map(|way| (way, first_without(blas.nodes, way, &point, rounding)));
    let suspicion = |&(way, step): &(&Way, Option<usize>)| match step {
        None => (2, 0),
        Some(step) => (usize::from(!fits(way, step)), step),
    };
    let Some((way, step)) = steps.max_by_key(suspicion) else {
        let why = format!("no leaf names this record of triangle {prim}, which the ray meets");
        return Blame::new("TRIS", slot_number(some_slot), why).in_tree(tree);
    };
    let leaf = *way.last().unwrap_or(&0);
    let slot = slot_in(&blas.nodes[leaf]).unwrap_or(some_slot);
    let triangle = format!("triangle {prim}, TRIS[{}]", slot_number(slot));
    let Some(step) = step else {
        let why = format!(
            "this leaf names {triangle}, which the ray meets, and its box and all boxes above it hold the hit: the records are right, so the traversal is not"
        );
        return Blame::new("NODE", record.node_offset + leaf as u64, why).in_tree(tree).at_depth(way.len() - 1);
    };

    // A triangle that is cut into several leaves may lack one of them.
    let cut = blas.triangles[slot].flags & TriangleRecord::DUPLICATED != 0;
    if cut && fits(way, step) {
        let lacking = |other: &Way| other.last().is_some_and(|&leaf| slot_in(&blas.nodes[leaf]).is_none());
        let others = leaves_at(blas.nodes, &point, rounding).into_iter().filter(lacking);
        let slack = |other: &Way| other.last().map_or(0.0, |&leaf| slack_of(&blas.nodes[leaf], blas.triangles));
        let other = others.max_by(|a, b| slack(a).total_cmp(&slack(b)));
        if let Some(other) = other {
            let why = format!(
                "its box holds a hit of {triangle}, which it does not name, and the leaves that do end before the hit: a reference is missing"
            );
            let node = record.node_offset + other[other.len() - 1] as u64;
            return Blame::new("NODE", node, why).in_tree(tree).at_depth(other.len() - 1);
        }
    }
    let blame = narrow_box("NODE", record.node_offset, blas.nodes, way, step).in_tree(tree);
    Blame { why: format!("{} ({triangle})", blame.why), ..blame }
}

/// The box at `step` of the way does not hold the hit: it is to blame, or one below it that does not hold its children.
fn narrow_box(section: &'static str, offset: u64, nodes: &[Node], way: &Way, step: usize) -> Blame {
    let number = |node: usize| offset + node as u64;
    let Some((below, child)) = first_narrow(nodes, &way[step..]) else {
        let why = "its box does not hold the hit on what is in it";
        return Blame::new(section, number(way[step]), why).at_depth(step);
    };
    let depth = step + below;
    let mut why = format!("its box does not hold that of its child {section}[{}], nor the hit", number(child));

    // Children that were exchanged without their boxes, or boxes without their children.
    let node = way[depth];
    let sibling = if depth == 0 { node } else { node ^ 1 };
    let children =
        |n: usize| nodes.get(nodes[n].first as usize..).and_then(|c| c.get(..2)).filter(|_| !nodes[n].is_leaf());
    let holds_all = |holder: usize, n: usize| {
        children(n).is_some_and(|c| c.iter().all(|c| nodes[holder].bounds().contains(&c.bounds())))
    };
    if sibling != node && nodes.get(sibling).is_some() && holds_all(sibling, node) {
        why.push_str(&format!("; the box of its sibling {section}[{}] would: they seem exchanged", number(sibling)));
    }
    Blame::new(section, number(node), why).at_depth(depth)
}

fn names(leaf: &Node, item: usize) -> bool {
    let first = leaf.first as usize;
    (first..first + leaf.count as usize).contains(&item)
}

/// How much of a leaf's box its triangles leave empty, as a share of the surface: a builder makes boxes that fit, so a box that does
/// not has lost something.
fn slack_of(leaf: &Node, triangles: &[TriangleRecord]) -> f32 {
    let bounds = leaf.bounds();
    let parts = triangles_of(leaf, triangles).map(|t| Polygon::inside(&t.corners(), &bounds).bounds(&bounds));
    let filled = parts.fold(Aabb::EMPTY, Aabb::union);
    let (all, filled) = (bounds.half_area(), if filled.is_empty() { 0.0 } else { filled.half_area() });
    if all > 0.0 { 1.0 - filled / all } else { 0.0 }
}

fn triangles_of<'a>(leaf: &Node, triangles: &'a [TriangleRecord]) -> impl Iterator<Item = &'a TriangleRecord> {
    triangles.iter().skip(leaf.first as usize).take(leaf.count as usize)
}

/// Whether a leaf's box holds every triangle of it that stands in no other leaf.
fn holds_whole_triangles(leaf: &Node, triangles: &[TriangleRecord]) -> bool {
    let mut whole = triangles_of(leaf, triangles).filter(|t| t.flags & TriangleRecord::DUPLICATED == 0);
    whole.all(|t| leaf.bounds().contains(&Aabb::from_points(&t.corners())))
}
