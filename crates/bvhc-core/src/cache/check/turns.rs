//! Turned subtrees: whether each is what lies below a node of the tree, in boxes along its axes that hold what is there.

use super::Limits;
use super::boxes::show;
use crate::cache::report::{Place, Report};
use crate::cache::rules;
use crate::exec::Executor;
use crate::geom::vector::dot;
use crate::layout::{NEST, Node, SectionKind, TurnRecord, View};
use crate::refit::{Held, turned_nodes};

/// How far products of axes may be from those of exact ones.
const RIGHT: f64 = 1.0 / (1u64 << 20) as f64;

/// What a file has of turned subtrees: a section each, or `None` where it is not there.
#[derive(Clone, Copy, Debug, Default)]
pub struct TurnRecords<'a> {
    /// `OROW`.
    pub rows: Option<&'a [TurnRecord]>,
    /// `ONOD`.
    pub nodes: Option<&'a [Node]>,
}

/// Hold turned subtrees against the tree of `view`, in which no rule is broken. A file without them has nothing to be found.
///
/// Linear in the number of records: subtrees lie in one another at most [`NEST`] deep.
pub fn check(view: &View<'_>, records: &TurnRecords<'_>, limits: &Limits, exec: &Executor) -> Report {
    let mut out = Report::new(limits.max_issues);
    let (rows, nodes) = match (records.rows, records.nodes) {
        (Some(rows), Some(nodes)) => (rows, nodes),
        (None, None) => return out,
        (rows, _) => {
            let actual = if rows.is_some() { "OROW" } else { "ONOD" };
            out.add(&rules::E0329, Place::file(), || ("OROW and ONOD".into(), format!("{actual} alone")));
            return out;
        }
    };
    let tree = match view.blases {
        [_] if view.instances.is_empty() => view.blas(0),
        _ => None,
    };
    let Some(tree) = tree else {
        let actual = format!("{} trees and {} instances", view.blases.len(), view.instances.len());
        out.add(&rules::E0329, Place::section(SectionKind::OROW), || ("one tree and no instances".into(), actual));
        return out;
    };
    if !check_rows(tree.nodes, rows, nodes.len(), &mut out) {
        return out;
    }
    for (i, row) in rows.iter().enumerate() {
        if let Some(actual) = crooked(&row.axes) {
            out.add(&rules::E0436, Place::record(SectionKind::OROW, i as u64), || {
                ("three axes of length 1 at right angles".into(), actual)
            });
        }
    }
    if !out.is_valid() {
        return out;
    }
    let fitted = |held| turned_nodes(&tree, rows, held, exec).filter(|fitted| fitted.len() == nodes.len());
    let (Some(least), Some(most)) = (fitted(Held::Part), fitted(Held::Whole)) else {
        // Rows and tree were checked, so this is not reached.
        return out;
    };
    for (i, node) in nodes.iter().enumerate() {
        let (place, least, most) = (Place::record(SectionKind::ONOD, i as u64), &least[i], &most[i]);
        let bounds = node.bounds();
        if (node.first, node.count) != (least.first, least.count) {
            out.add(&rules::E0437, place, || {
                let links = |node: &Node| format!("first {} and count {}", node.first, node.count);
                (links(least), links(node))
            });
        } else if !bounds.contains(&least.bounds()) {
            out.add(&rules::E0438, place, || (show(&least.bounds()), show(&bounds)));
        } else if !most.bounds().contains(&bounds) {
            out.add(&rules::E0439, place, || (show(&most.bounds()), show(&bounds)));
        }
    }
    out
}

/// Whether rows stand in order, each names all that is below one inner node, and their records tile `ONOD`.
fn check_rows(tree: &[Node], rows: &[TurnRecord], nodes: usize, out: &mut Report) -> bool {
    // By pair, behind the last record that is below the pair's parent.
    let mut ends: Vec<u32> = Vec::new();
    if ends.try_reserve_exact(tree.len() / 2).is_err() {
        out.starve(Place::section(SectionKind::OROW), "Turned subtrees");
        return false;
    }
    ends.extend((0..tree.len() as u32 / 2).map(|pair| 2 * pair + 2));
    for (i, node) in tree.iter().enumerate().skip(2).rev().filter(|(_, node)| !node.is_leaf()) {
        if let Some(end) = ends.get(node.first as usize / 2).copied() {
            ends[i / 2] = ends[i / 2].max(end);
        }
    }
    let (mut open, mut next): (Vec<TurnRecord>, usize) = (Vec::new(), 0);
    for (i, row) in rows.iter().enumerate() {
        while open.last().is_some_and(|outer| outer.end <= row.first) {
            open.pop();
        }
        let last = i.checked_sub(1).map_or(1, |before| rows[before].first);
        let end = ends.get(row.first as usize / 2).copied().unwrap_or(0);
        let offset = open
            .last()
            .map_or(next as u64, |outer| u64::from(outer.node_offset) + u64::from(row.first.wrapping_sub(outer.first)));
        let told = if row.first <= last || row.first % 2 != 0 || end == 0 {
            Some((format!("an even pair of children above {last} and below {}", tree.len()), row.first.to_string()))
        } else if row.end != end {
            Some((format!("records up to {end}, behind the last one below the node"), row.end.to_string()))
        } else if open.len() >= NEST {
            Some((format!("at most {NEST} subtrees in one another"), (open.len() + 1).to_string()))
        } else if u64::from(row.node_offset) != offset {
            Some((format!("records from {offset} of ONOD on"), row.node_offset.to_string()))
        } else if row.reserved != [0; 4] {
            Some(("zeros behind node_offset".into(), format!("{:?}", row.reserved)))
        } else {
            None
        };
        if let Some(values) = told {
            out.add(&rules::E0330, Place::record(SectionKind::OROW, i as u64), || values);
            return false;
        }
        if open.is_empty() {
            next += (row.end - row.first) as usize;
        }
        open.push(*row);
    }
    if next != nodes {
        out.add(&rules::E0329, Place::section(SectionKind::ONOD), || {
            (format!("{next} records, one for each node below a turned one"), nodes.to_string())
        });
        return false;
    }
    true
}

/// What is wrong with axes, if anything.
fn crooked(axes: &[[f32; 3]; 3]) -> Option<String> {
    let axes = axes.map(|axis| axis.map(f64::from));
    for (i, j) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
        let product = dot(axes[i], axes[j]);
        let wanted = if i == j { 1.0 } else { 0.0 };
        // Written so that NaN is refused too.
        if !((product - wanted).abs() <= RIGHT) {
            return Some(format!("axis {i} times axis {j} is {product:e}"));
        }
    }
    None
}
