use std::ops::ControlFlow;

use super::Limits;
use super::boxes::{bits, show};
use crate::cache::container::Sink;
use crate::cache::report::{Place, Report};
use crate::cache::rules;
use crate::geom::Aabb;
use crate::layout::{BlasRecord, GeomRecord, Header, MAX_LEAF, NO_NODE, SectionKind, View, tree_flags};

/// A tree's records, as far as its row in `BLAS` could be followed.
#[derive(Clone, Copy)]
pub struct TreeRanges {
    pub nodes: (usize, usize),
    pub triangles: (usize, usize),
    pub geoms: (u32, u32),
}

/// Follow the rows of `BLAS` through `NODE`, `TRIS` and `GEOM`. A tree whose row cannot be followed is `None`.
pub fn ranges(view: &View<'_>, out: &mut Report) -> Vec<Option<TreeRanges>> {
    let geoms = geom_ranges(view.geoms, view.blases.len(), out);
    _ = check_rows(view.blases, view.nodes.len() as u64, view.triangles.len() as u64, out);
    let mut trees = Vec::with_capacity(view.blases.len()); // as many as there are records in memory
    for (i, blas) in view.blases.iter().enumerate() {
        check_blas(blas, Place::record(SectionKind::BLAS, i as u64), out);
        let nodes = piece(blas.node_offset, blas.node_count, view.nodes.len() as u64);
        let triangles = piece(blas.ref_offset, blas.ref_count, view.triangles.len() as u64);
        trees.push(match (nodes, triangles) {
            (Some(nodes), Some(triangles)) => Some(TreeRanges { nodes, triangles, geoms: geoms[i] }),
            _ => {
                out.skip(format!("Tree {i}: its records are not where BLAS says."));
                None
            }
        });
    }
    trees
}

/// The rows of `BLAS` tile `NODE` and `TRIS`, and no tree has more references than its leaves can hold.
///
/// It needs the sections' lengths alone, so that a file whose counts contradict each other is refused before they are decoded.
pub fn check_rows(blases: &[BlasRecord], nodes: u64, triangles: u64, out: &mut impl Sink) -> ControlFlow<()> {
    let (mut node, mut slot, mut inside) = (0u64, 0u64, true);
    for (i, blas) in blases.iter().enumerate() {
        let place = Place::record(SectionKind::BLAS, i as u64);
        let has_nodes = piece(blas.node_offset, blas.node_count, nodes).is_some();
        let has_triangles = piece(blas.ref_offset, blas.ref_count, triangles).is_some();
        if blas.node_offset != node || !has_nodes {
            out.breach(&rules::E0310, place, || (node.to_string(), span(blas.node_offset, blas.node_count)))?;
        }
        if blas.ref_offset != slot || !has_triangles {
            out.breach(&rules::E0311, place, || (slot.to_string(), span(blas.ref_offset, blas.ref_count)))?;
        }
        inside = has_nodes && has_triangles;
        node = blas.node_offset.saturating_add(blas.node_count.into());
        slot = blas.ref_offset.saturating_add(blas.ref_count.into());

        // A root, an unused record and pairs: half of the records are leaves.
        let most = u64::from(blas.node_count / 2) * u64::from(MAX_LEAF);
        if u64::from(blas.ref_count) > most && blas.node_count > 0 {
            let leaves = blas.node_count / 2;
            out.breach(&rules::E0410, place, || {
                (format!("{MAX_LEAF} items a leaf"), format!("{leaves} leaves share {} items", blas.ref_count))
            })?;
        }
    }

    // The last row ends where the sections end.
    let last = Place::record(SectionKind::BLAS, (blases.len() as u64).saturating_sub(1));
    let ends = |end: u64, at: u64| (format!("(all trees) 0 and end at {end}"), format!("that the last ends at {at}"));
    if node != nodes && inside {
        out.breach(&rules::E0310, last, || ends(nodes, node))?;
    }
    if slot != triangles && inside {
        out.breach(&rules::E0311, last, || ends(triangles, slot))?;
    }
    ControlFlow::Continue(())
}

fn piece(offset: u64, count: u32, len: u64) -> Option<(usize, usize)> {
    let end = offset.checked_add(count.into()).filter(|end| *end <= len)?;
    Some((usize::try_from(offset).ok()?, usize::try_from(end).ok()?))
}

fn span(offset: u64, count: u32) -> String {
    format!("{offset} and {count} records")
}

fn check_blas(blas: &BlasRecord, place: Place, out: &mut Report) {
    let odd = !blas.node_count.is_multiple_of(2);
    if odd || blas.node_count >= 1 << 31 {
        out.add(&rules::E0312, place, || ("even and < 2147483648".into(), blas.node_count.to_string()));
    } else if (blas.node_count == 0) != (blas.ref_count == 0) || blas.ref_count >= 1 << 31 {
        let expected =
            format!("0 exactly if there are no triangles, and < 2147483648 triangles (there are {})", blas.ref_count);
        out.add(&rules::E0312, place, || (expected, blas.node_count.to_string()));
    }
    if blas.flags != tree_flags::REFITTABLE && blas.flags != tree_flags::DUP_REFS {
        out.add(&rules::E0313, place, || ("0x1 (REFITTABLE) or 0x2 (DUP_REFS)".into(), format!("{:#x}", blas.flags)));
    }
}

/// For each tree its rows of `GEOM`, which stand in the order of the trees.
fn geom_ranges(geoms: &[GeomRecord], trees: usize, out: &mut Report) -> Vec<(u32, u32)> {
    let mut ranges = vec![(0u32, 0u32); trees];
    let (mut tree, mut row) = (0usize, 0usize);
    for (i, geom) in geoms.iter().enumerate() {
        let place = Place::record(SectionKind::GEOM, i as u64);
        check_geom(geom, place, out);
        if geom.blas as usize >= trees || (geom.blas as usize) < tree {
            let (low, high) = (tree, trees);
            out.add(&rules::E0314, place, || (format!("in {low} .. {high}"), geom.blas.to_string()));
            continue;
        }
        if geom.blas as usize != tree || i == 0 {
            tree = geom.blas as usize;
            row = i;
        }
        ranges[tree] = (row as u32, i as u32 + 1);
    }
    check_numbers(geoms, &ranges, out);
    ranges
}

/// Rows of parts, before there is a file that they stand in: what can be told of them without the triangles.
pub fn check_parts(geoms: &[GeomRecord], trees: usize, limits: &Limits) -> Report {
    let mut out = Report::new(limits.max_issues);
    geom_ranges(geoms, trees, &mut out);
    out
}

/// In each tree: parts of one mesh have no triangle's number in common and stand one behind the other, and what is said of one part in several rows,
/// each for another node, is the same.
fn check_numbers(geoms: &[GeomRecord], ranges: &[(u32, u32)], out: &mut Report) {
    let mut rows: Vec<u32> = Vec::new(); // of one tree at a time
    for (tree, (low, high)) in ranges.iter().enumerate() {
        let of_tree = |row: &u32| geoms[*row as usize].blas as usize == tree;
        rows.clear();
        rows.extend((*low..*high).filter(of_tree));
        rows.sort_unstable_by_key(|row| {
            let g = &geoms[*row as usize];
            (g.source_mesh, g.source_part, g.baked_node, *row)
        });
        for pair in rows.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|row| &geoms[row as usize]);
            if a.source_mesh != b.source_mesh {
                continue;
            }
            let (place, of) = (Place::record(SectionKind::GEOM, pair[1].into()), |g: &GeomRecord| {
                format!("part {} of mesh {}", g.source_part, g.source_mesh)
            });
            let end = u64::from(a.first_prim) + u64::from(a.prim_count);
            if a.source_part != b.source_part {
                if end > u64::from(b.first_prim) {
                    let expected = format!("start at {end} or behind, where {} ends", of(a));
                    out.add(&rules::E0328, place, || (expected, format!("{} starts at {}", of(b), b.first_prim)));
                }
            } else if (a.first_prim, a.prim_count, a.name_hash) != (b.first_prim, b.prim_count, b.name_hash) {
                let expected = format!("have the numbers and the name that row {} gives it", pair[0]);
                out.add(&rules::E0328, place, || (expected, format!("{} has others", of(b))));
            } else if a.baked_node == NO_NODE {
                let expected = format!("name a node, or stand in row {} alone", pair[0]);
                out.add(&rules::E0328, place, || (expected, format!("{} does not", of(b))));
            }
        }
    }
}

fn check_geom(geom: &GeomRecord, place: Place, out: &mut Report) {
    if geom.reserved != 0 {
        out.add(&rules::E0315, place, || ("0".into(), geom.reserved.to_string()));
    }
    let end = u64::from(geom.first_prim) + u64::from(geom.prim_count);
    if end > u64::from(u32::MAX) {
        out.add(&rules::E0316, place, || (u32::MAX.to_string(), end.to_string()));
    }
}

/// Hold the header's flags and the trees' against each other; needs no file.
pub fn check_flags(view: &View<'_>, flags: u32, out: &mut Report) {
    let any_split = view.blases.iter().any(|b| b.flags & tree_flags::DUP_REFS != 0);
    let known = view.blases.iter().all(|b| b.flags == tree_flags::REFITTABLE || b.flags == tree_flags::DUP_REFS);
    let kind = if any_split { tree_flags::DUP_REFS } else { tree_flags::REFITTABLE };
    let either = tree_flags::DUP_REFS | tree_flags::REFITTABLE;
    if known && flags & either != kind {
        let expected = flags & !either | kind;
        out.add(&rules::E0309, Place::file(), || (format!("{expected:#x}"), format!("{flags:#x}")));
    }
    if flags & tree_flags::TWO_LEVEL == 0 && view.blases.len() > 1 {
        out.add(&rules::E0317, Place::section(SectionKind::BLAS), || ("1".into(), view.blases.len().to_string()));
    }
}

/// Hold the header against the records; the counts that the table bears out were compared with it before.
///
/// `depth` is the deepest leaf of all trees, `None` where some tree could not be followed.
pub fn check_header(view: &View<'_>, header: &Header, depth: Option<u32>, out: &mut Report) {
    let mut compare = |rule, offset, expected: u64, actual: u64| {
        if expected != actual {
            out.add(rule, Place::byte(offset), || (expected.to_string(), actual.to_string()));
        }
    };
    let live = |records: u64| records.saturating_sub(1);
    let nodes = view.blases.iter().map(|b| live(b.node_count.into())).sum::<u64>() + live(view.tlas_nodes.len() as u64);
    compare(&rules::E0301, 176, nodes, header.node_count);
    compare(&rules::E0303, 160, view.blases.iter().map(|b| u64::from(b.prim_count)).sum(), header.prim_count);
    if let Some(depth) = depth {
        compare(&rules::E0306, 196, depth.into(), header.max_depth.into());
    }

    // The scene's box is the root's, and zero where there is no root.
    let two_level = header.has(tree_flags::TWO_LEVEL);
    let root = if two_level { view.tlas_nodes.first() } else { view.nodes.first() };
    let expected = root.map_or(Aabb { min: [0.0; 3], max: [0.0; 3] }, |n| n.bounds());
    if bits(&expected) != bits(&header.scene_bounds()) {
        out.add(&rules::E0307, Place::byte(200), || (show(&expected), show(&header.scene_bounds())));
    }
}
