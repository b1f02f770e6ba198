use super::topology::TreePlace;
use crate::cache::report::{Place, Report};
use crate::cache::rules::{self, Rule};
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::layout::{GeomRecord, MAX_LEAF, Node, SectionKind, TriangleRecord};

/// Nodes or triangles of one task. A constant: findings stand in the same order for any number of threads.
const CHUNK: usize = 1 << 14;

/// What a leaf of the tree refers to.
#[derive(Clone, Copy)]
pub struct Items<'a> {
    pub triangles: &'a [TriangleRecord],
    /// First triangle of the tree in `TRIS`.
    pub start: u64,
    pub tree: u32,
    /// `GEOM` rows of this tree.
    pub geoms: (u32, u32),
    /// For each row of `GEOM` its first primitive and how many it has.
    pub prims: &'a [GeomRecord],
    /// The tree has spatial splits: a leaf may hold a part of a triangle.
    pub split: bool,
}

impl Items<'_> {
    /// What a box that is larger than what it holds breaks in this tree.
    fn loose(&self) -> &'static Rule {
        if self.split { &rules::E0434 } else { &rules::E0428 }
    }

    pub fn place(&self, slot: usize) -> Place {
        Place { tree: Some((self.tree, slot as u64)), ..Place::record(SectionKind::TRIS, self.start + slot as u64) }
    }
}

/// Check each box, each child against its parent, and with `items` each triangle and where it lies.
///
/// `tiled`: the leaves are known to tile the triangles, so that each is looked at once, in its leaf. Otherwise triangles are
/// looked at one by one without their leaves: leaves that overlap could make a small file take hours.
pub fn check(
    nodes: &[Node],
    items: Option<Items<'_>>,
    tiled: bool,
    at: TreePlace,
    max_issues: usize,
    exec: &Executor,
) -> Report {
    let mut out = Report::new(max_issues);
    let in_leaves = items.filter(|_| tiled);
    let loose = items.map_or(&rules::E0508, |items| items.loose());
    let chunks = exec.map_range(nodes.len().div_ceil(CHUNK), |c| {
        let mut part = Report::new(max_issues);
        let end = ((c + 1) * CHUNK).min(nodes.len());
        for i in c * CHUNK..end {
            if i != 1 {
                check_node(nodes, i, in_leaves, loose, at, &mut part);
            }
        }
        part
    });
    chunks.into_iter().for_each(|part| out.append(part));

    if let (Some(items), false) = (items, tiled) {
        let chunks = exec.map_chunks(items.triangles, CHUNK, |c, chunk| {
            let mut part = Report::new(max_issues);
            for (k, triangle) in chunk.iter().enumerate() {
                check_fields(triangle, c * CHUNK + k, &items, &mut part);
            }
            part
        });
        chunks.into_iter().for_each(|part| out.append(part));
        let tree = items.tree;
        out.skip(format!("Whether the triangles of tree {tree} lie in their leaves: its leaves do not tile them."));
    }
    out
}

fn check_node(
    nodes: &[Node],
    i: usize,
    items: Option<Items<'_>>,
    loose: &'static Rule,
    at: TreePlace,
    out: &mut Report,
) {
    let node = &nodes[i];
    let bounds = node.bounds();
    if !bounds.is_valid() {
        out.add(&rules::E0412, at.node(i), || ("finite with min <= max".into(), format!("it is {}", show(&bounds))));
        return;
    }
    if !node.is_leaf() {
        // Only a pair that the walk would follow is a pair of children.
        let first = node.first as usize;
        if first <= i || !first.is_multiple_of(2) {
            return;
        }
        let mut below = Aabb::EMPTY;
        for child in [first, first + 1] {
            let Some(inner) = nodes.get(child).map(Node::bounds) else { return };
            if !inner.is_valid() {
                // It is told of as a node of its own.
                below = below.union(bounds);
                continue;
            }
            below = below.union(inner);
            if !bounds.contains(&inner) {
                below = below.union(bounds);
                out.add(&rules::E0411, at.node(child), || (show(&bounds), show(&inner)));
            }
        }
        check_tight(loose, &bounds, &below, at.node(i), out);
        return;
    }
    let Some(items) = items else { return };
    // A tiled leaf lies within the list, but a huge one is not worth a loop that trusts it.
    let first = node.first as usize;
    let Some(triangles) = items.triangles.get(first..first.saturating_add(node.count as usize)) else { return };
    let mut below = Aabb::EMPTY;
    for (k, triangle) in triangles.iter().enumerate() {
        let slot = first + k;
        if !check_fields(triangle, slot, &items, out) {
            below = below.union(bounds);
            continue;
        }
        let inner = Aabb::from_points(&triangle.corners());
        below = below.union(inner);
        if bounds.contains(&inner) {
            continue;
        }
        // A leaf need not hold the whole of a copy, and may reach as far as the whole does.
        let rule = if !items.split || triangle.flags & TriangleRecord::DUPLICATED == 0 {
            &rules::E0419
        } else if bounds.intersection(inner).is_empty() {
            &rules::E0420
        } else {
            continue;
        };
        below = below.union(bounds);
        out.add(rule, items.place(slot), || (show(&bounds), show(&inner)));
    }
    if items.split {
        check_repeats(triangles, first, &items, out);
    }
    check_tight(loose, &bounds, &below, at.node(i), out);
}

/// A box is no larger than what it holds. `below` reaches beyond it where that has been told already.
#[inline]
pub fn check_tight(rule: &'static Rule, bounds: &Aabb, below: &Aabb, place: Place, out: &mut Report) {
    if !below.contains(bounds) {
        out.add(rule, place, || (show(below), show(bounds)));
    }
}

/// The fields of one triangle; whether its corners are finite.
#[inline(always)]
fn check_fields(triangle: &TriangleRecord, slot: usize, items: &Items<'_>, out: &mut Report) -> bool {
    // Test everything at once on the way that nearly every triangle takes.
    let (mut infinite, mut minus_zero) = ([0u32; 3], [0u32; 3]);
    for corner in triangle.corners() {
        for axis in 0..3 {
            let bits = corner[axis].to_bits();
            infinite[axis] |= u32::from(bits & 0x7f80_0000 == 0x7f80_0000);
            minus_zero[axis] |= u32::from(bits == 0x8000_0000);
        }
    }
    let (infinite, minus_zero) = (infinite != [0; 3], minus_zero != [0; 3]);
    let (low, high) = items.geoms;
    let in_tree = low <= triangle.geom && triangle.geom < high;
    let row = items.prims.get(triangle.geom as usize).filter(|_| in_tree);
    let in_part = row.is_some_and(|g| holds(g, triangle.prim));
    let known = triangle.flags & !TriangleRecord::DUPLICATED == 0;
    if !infinite && !minus_zero && in_part && known {
        return true;
    }
    tell_fields(triangle, slot, items, out);
    !infinite
}

/// Say which fields are wrong, where [`check_fields`] found that some are.
#[cold]
fn tell_fields(triangle: &TriangleRecord, slot: usize, items: &Items<'_>, out: &mut Report) {
    let bits = triangle.corners().map(|p| p.map(f32::to_bits));
    let infinite = bits.as_flattened().iter().any(|b| b & 0x7f80_0000 == 0x7f80_0000);
    let minus_zero = bits.as_flattened().contains(&0x8000_0000);
    let (low, high) = items.geoms;
    let in_tree = low <= triangle.geom && triangle.geom < high;
    let row = items.prims.get(triangle.geom as usize).filter(|_| in_tree);
    let place = items.place(slot);
    if infinite {
        out.add(&rules::E0417, place, || ("finite".into(), format!("they are {}", show_corners(triangle))));
    }
    if minus_zero {
        out.add(&rules::W0401, place, || ("0.0".into(), format!("the corners are {}", show_corners(triangle))));
    }
    if !in_tree {
        out.add(&rules::E0416, place, || (format!("{low} .. {high}"), triangle.geom.to_string()));
    } else if let Some(g) = row.filter(|g| !holds(g, triangle.prim)) {
        let end = u64::from(g.first_prim) + u64::from(g.prim_count);
        out.add(&rules::E0415, place, || (format!("{} .. {end}", g.first_prim), triangle.prim.to_string()));
    }
    if triangle.flags & !TriangleRecord::DUPLICATED != 0 {
        out.add(&rules::E0418, place, || ("0x1".into(), format!("{:#x}", triangle.flags)));
    }
}

#[inline]
fn holds(row: &GeomRecord, prim: u32) -> bool {
    prim.checked_sub(row.first_prim).is_some_and(|within| within < row.prim_count)
}

/// No triangle stands in one leaf twice. Quadratic in the leaf's size, which is at most [`MAX_LEAF`], over flagged triangles only.
fn check_repeats(triangles: &[TriangleRecord], first: usize, items: &Items<'_>, out: &mut Report) {
    if triangles.len() > MAX_LEAF as usize {
        return;
    }
    for (k, t) in triangles.iter().enumerate().skip(1) {
        if t.flags & TriangleRecord::DUPLICATED == 0 {
            continue;
        }
        if let Some(j) = triangles[..k].iter().position(|o| o.prim == t.prim && o.geom == t.geom) {
            out.add(&rules::E0423, items.place(first + k), || {
                ((items.start + (first + j) as u64).to_string(), format!("prim {} of part {}", t.prim, t.geom))
            });
        }
    }
}

/// A box stated twice is the same to the bit, the signs of its zeros included.
pub fn bits(b: &Aabb) -> [[u32; 3]; 2] {
    [b.min, b.max].map(|p| p.map(f32::to_bits))
}

/// A box as text that shows every bit of its numbers.
pub fn show(b: &Aabb) -> String {
    format!("{:?} .. {:?}", b.min, b.max)
}

pub fn show_corners(t: &TriangleRecord) -> String {
    format!("{:?} {:?} {:?}", t.v0, t.v1, t.v2)
}
