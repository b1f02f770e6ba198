//! Compact trees: whether each is its binary tree, collapsed, in boxes that hold what those hold.

use super::Limits;
use super::boxes::show;
use crate::cache::report::{Place, Report};
use crate::cache::rules;
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::layout::{BlasView, CompactNode, SectionKind, View, WideRow};

/// What a file has of compact trees: a section each, or `None` where it is not there.
#[derive(Clone, Copy, Debug, Default)]
pub struct CompactRecords<'a> {
    /// `CROW`.
    pub rows: Option<&'a [WideRow]>,
    /// `CNOD`.
    pub nodes: Option<&'a [CompactNode]>,
    /// `CREF`.
    pub order: Option<&'a [u32]>,
}

/// Hold compact trees against the binary ones of `view`, in which no rule is broken. A file without them has nothing to be found.
///
/// Linear in the number of records: no node is entered twice, and nothing is followed before it is known where it leads.
pub fn check(view: &View<'_>, records: &CompactRecords<'_>, limits: &Limits, exec: &Executor) -> Report {
    let mut out = Report::new(limits.max_issues);
    let CompactRecords { rows, nodes, order } = *records;
    if rows.is_none() && nodes.is_none() && order.is_none() {
        return out;
    }
    let (Some(rows), Some(nodes), Some(order)) = (rows, nodes, order) else {
        let is_there = [("CROW", rows.is_some()), ("CNOD", nodes.is_some()), ("CREF", order.is_some())];
        let there = is_there.into_iter().filter_map(|(name, is_there)| is_there.then_some(name));
        let actual = there.collect::<Vec<_>>().join(" and ");
        out.add(&rules::E0326, Place::file(), || ("CROW, CNOD and CREF".into(), format!("{actual} alone")));
        return out;
    };
    let wanted = [
        (SectionKind::CROW, rows.len(), view.blases.len(), "one row for each tree"),
        (SectionKind::CREF, order.len(), view.triangles.len(), "one number for each record of TRIS"),
    ];
    for (kind, actual, expected, why) in wanted.into_iter().filter(|(_, actual, expected, _)| actual != expected) {
        let values = (format!("{expected} records, {why}"), actual.to_string());
        out.add(&rules::E0326, Place::section(kind), || values);
    }
    if !out.is_valid() || !check_rows(view, rows, nodes.len() as u64, &mut out) {
        return out;
    }
    let parts = exec.map_range(rows.len(), |number| {
        let mut part = Report::new(limits.max_issues);
        let (row, blas) = (&rows[number], &view.blases[number]);
        let piece = |offset: u64, count: u32| {
            let start = usize::try_from(offset).ok()?;
            Some(start..start.checked_add(count as usize)?)
        };
        let own = piece(row.node_offset, row.node_count).and_then(|range| nodes.get(range));
        let order = piece(blas.ref_offset, blas.ref_count).and_then(|range| order.get(range));
        // Both are there: rows tile their sections.
        if let (Some(nodes), Some(order), Some(binary)) = (own, order, view.blas(number)) {
            let (number, first_ref) = (number as u32, blas.ref_offset);
            Tree { number, row, nodes, order, first_ref, binary }.check(&mut part);
        }
        part
    });
    parts.into_iter().for_each(|part| out.append(part));
    out
}

/// Whether the rows tile `CNOD`, and a tree has nodes exactly where its binary one has.
fn check_rows(view: &View<'_>, rows: &[WideRow], nodes: u64, out: &mut Report) -> bool {
    let mut next = 0u64;
    for (i, (row, blas)) in rows.iter().zip(view.blases).enumerate() {
        let end = row.node_offset.checked_add(row.node_count.into()).filter(|end| *end <= nodes);
        let is_last = i + 1 == rows.len();
        let told = if row.node_offset != next || end.is_none() {
            Some((
                format!("nodes from {next} to at most {nodes}"),
                format!("{} from {}", row.node_count, row.node_offset),
            ))
        } else if (row.node_count == 0) != (blas.node_count == 0) {
            Some((
                format!("no nodes exactly where BLAS states none, which has {}", blas.node_count),
                row.node_count.to_string(),
            ))
        } else if is_last && end != Some(nodes) {
            Some((format!("nodes up to the end of CNOD, which is {nodes}"), format!("{} from {next}", row.node_count)))
        } else {
            None
        };
        if let Some(values) = told {
            out.add(&rules::E0327, Place::record(SectionKind::CROW, i as u64), || values);
            return false;
        }
        next = end.unwrap_or(next);
    }
    if rows.is_empty() && nodes > 0 {
        out.add(&rules::E0327, Place::section(SectionKind::CNOD), || {
            ("no nodes without trees".into(), nodes.to_string())
        });
        return false;
    }
    true
}

/// One compact tree, beside the binary one that it is to be.
struct Tree<'a> {
    number: u32,
    row: &'a WideRow,
    nodes: &'a [CompactNode],
    order: &'a [u32],
    /// Where the order starts in its section.
    first_ref: u64,
    binary: BlasView<'a>,
}

/// A compact node and the binary one that it stands for.
struct Pair {
    node: u32,
    binary: u32,
    /// First reference below them.
    first: u32,
    /// Children that wait beside the node or above it.
    waiting: u32,
}

impl Tree<'_> {
    fn check(&self, out: &mut Report) {
        if !self.check_links(out) {
            return;
        }
        let Some((below, refs)) = self.counts_below() else {
            return out.starve(self.node(0), &format!("Compact tree {}", self.number));
        };
        let waiting = if self.nodes.is_empty() { Some(0) } else { self.compare(&below, &refs, out) };
        if let Some(waiting) = waiting.filter(|waiting| *waiting != self.row.waiting) {
            let place = Place::record(SectionKind::CROW, self.number.into());
            let told = |waiting: u32| format!("that {waiting} children wait at once");
            out.add(&rules::E0327, place, || (told(waiting), told(self.row.waiting)));
        }
    }

    fn node(&self, index: usize) -> Place {
        let tree = Some((self.number, index as u64));
        Place { tree, ..Place::record(SectionKind::CNOD, self.row.node_offset + index as u64) }
    }

    /// Whether the records are a tree in its one order: each child, node or reference, is the next that nobody named.
    fn check_links(&self, out: &mut Report) -> bool {
        let (mut next_node, mut next_ref) = (1u64, 0u64);
        let mut pending: Vec<u32> = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(index) = pending.pop() {
            let node = &self.nodes[index as usize];
            if !self.check_lanes(index as usize, out) {
                return false;
            }
            let named = (u64::from(node.first_node), u64::from(node.first_ref));
            let told = |(node, first): (u64, u64)| format!("node {node} and reference {first}");
            if named != (next_node, next_ref) {
                let expected = told((next_node, next_ref));
                out.add(&rules::E0430, self.node(index as usize), || (expected, told(named)));
                return false;
            }
            let counts = &node.counts[..usize::from(node.children)];
            let end = next_node + counts.iter().filter(|count| **count == 0).count() as u64;
            if end > self.nodes.len() as u64 {
                let expected = format!("a node below {}", self.nodes.len());
                out.add(&rules::E0430, self.node(index as usize), || (expected, format!("node {}", end - 1)));
                return false;
            }
            // Both ends are at most the number of records, which has 32 bits.
            pending.extend((next_node as u32..end as u32).rev());
            next_node = end;
            next_ref += counts.iter().map(|count| u64::from(*count)).sum::<u64>();
        }
        let all = (self.nodes.len() as u64, self.order.len() as u64);
        if !self.nodes.is_empty() && (next_node, next_ref) != all {
            let told = |(nodes, refs): (u64, u64)| format!("{nodes} nodes and {refs} references, all together");
            out.add(&rules::E0430, self.node(0), || (told(all), told((next_node, next_ref))));
            return false;
        }
        true
    }

    /// Two to eight children, but for a tree that is one leaf; and nothing in the lanes behind them.
    fn check_lanes(&self, index: usize, out: &mut Report) -> bool {
        let node = &self.nodes[index];
        let children = usize::from(node.children);
        let is_leaf_alone = self.nodes.len() == 1 && children == 1 && node.counts[0] > 0;
        if !(2..=8).contains(&children) && !is_leaf_alone {
            let expected = "2 to 8 children, or be the one node of a tree and have one leaf".into();
            out.add(&rules::E0429, self.node(index), || (expected, format!("it has {children} children")));
            return false;
        }
        let rows = node.planes.iter().chain([&node.counts]);
        if rows.flat_map(|row| &row[children..]).any(|byte| *byte != 0) {
            let expected = format!("zeros in the lanes from {children} on");
            out.add(&rules::E0429, self.node(index), || (expected, "something else stands there".into()));
            return false;
        }
        true
    }

    /// For each compact node and for each binary one the references below it; `None` where memory is short.
    fn counts_below(&self) -> Option<(Vec<u32>, Vec<u32>)> {
        // Children lie behind their parents, in either tree.
        let mut below = zeros(self.nodes.len())?;
        for (index, node) in self.nodes.iter().enumerate().rev() {
            let mut next = node.first_node as usize;
            let mut sum = 0;
            for count in &node.counts[..usize::from(node.children)] {
                if *count == 0 {
                    sum += below[next];
                    next += 1;
                } else {
                    sum += u32::from(*count);
                }
            }
            below[index] = sum;
        }
        let mut refs = zeros(self.binary.nodes.len())?;
        for (index, node) in self.binary.nodes.iter().enumerate().rev() {
            let first = node.first as usize;
            refs[index] = match index {
                1 => 0,
                _ if node.is_leaf() => node.count,
                _ => refs[first] + refs[first + 1],
            };
        }
        Some((below, refs))
    }

    /// Walk both trees at once. Each child of a compact node stands for the binary node that has the same references: there is one at most, since both
    /// children of a node have some. Returns how many children wait at once; `None` where a child stands for nothing.
    fn compare(&self, below: &[u32], refs: &[u32], out: &mut Report) -> Option<u32> {
        let binary = self.binary.nodes;
        let mut pending = vec![Pair { node: 0, binary: 0, first: 0, waiting: 0 }];
        let (mut cut, mut most) = (Vec::new(), 0);
        let mut stands_for = [Aabb::EMPTY; 8];
        while let Some(Pair { node: index, binary: whole, mut first, waiting }) = pending.pop() {
            let (place, node) = (self.node(index as usize), &self.nodes[index as usize]);
            let children = usize::from(node.children);
            most = most.max(waiting + children as u32);
            let (mut next_node, mut next_ref, start) = (node.first_node, node.first_ref as usize, pending.len());
            cut.clear();
            cut.push(whole);
            let mut holds_all = true;
            for lane in 0..children {
                let count = u32::from(node.counts[lane]);
                let wanted = if count == 0 { below[next_node as usize] } else { count };
                let found = loop {
                    let Some(at) = cut.pop() else { break None };
                    if refs[at as usize] == wanted {
                        break Some(at);
                    }
                    let within = &binary[at as usize];
                    if within.is_leaf() || refs[at as usize] < wanted {
                        break None;
                    }
                    cut.extend([within.first + 1, within.first]);
                };
                let Some(at) = found else {
                    let expected = "a node of the binary tree".into();
                    let end = first + wanted;
                    out.add(&rules::E0431, place, || {
                        (expected, format!("child {lane} has references {first} to {end}"))
                    });
                    return None;
                };
                let (outer, inner) = (node.bounds(lane), binary[at as usize].bounds());
                let holds = |axis: usize| outer.min[axis] <= inner.min[axis] && outer.max[axis] >= inner.max[axis];
                stands_for[lane] = inner;
                if !(0..3).all(holds) {
                    holds_all = false;
                    let actual = format!("that of child {lane} is {}", show(&outer));
                    out.add(&rules::E0432, place, || (show(&inner), actual));
                }
                if count == 0 {
                    let waiting = waiting + children as u32 - 1;
                    pending.push(Pair { node: next_node, binary: at, first, waiting });
                    next_node += 1;
                } else {
                    self.check_order(next_ref, first, count, out);
                    next_ref += count as usize;
                }
                first += wanted;
            }
            if holds_all && let Some((expected, actual)) = node.looser_than_needed(&stands_for[..children]) {
                out.add(&rules::E0435, place, || (expected.clone(), actual.clone()));
            }
            pending[start..].reverse();
        }
        Some(most)
    }

    /// Whether the references of a leaf are the triangles from `first` on, in their order.
    fn check_order(&self, from: usize, first: u32, count: u32, out: &mut Report) {
        for (slot, expected) in (from..).zip(first..first + count) {
            let actual = self.order[slot];
            if actual != expected {
                let tree = Some((self.number, slot as u64));
                let place = Place { tree, ..Place::record(SectionKind::CREF, self.first_ref + slot as u64) };
                out.add(&rules::E0433, place, || (expected.to_string(), actual.to_string()));
            }
        }
    }
}

fn zeros(len: usize) -> Option<Vec<u32>> {
    let mut zeros = Vec::new();
    zeros.try_reserve_exact(len).ok()?;
    zeros.resize(len, 0);
    Some(zeros)
}
