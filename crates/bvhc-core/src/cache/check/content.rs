//! Records: everything behind the container, from a [`View`] alone.

use super::boxes::{self, Items, bits, show};
use super::counts::{self, TreeRanges};
use super::topology::{self, TreePlace};
use super::{Limits, identity, instances};
use crate::cache::report::{Place, Report};
use crate::cache::rules;
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::layout::{BlasRecord, Header, SectionKind, View, tree_flags};
use crate::quality;

/// What records are of, which decides what is asked of them.
#[derive(Clone, Copy, Debug)]
pub enum RecordsOf<'h> {
    /// A still file with this header.
    File(&'h Header),
    /// A still file that is not written yet: what its header will state is not asked.
    Still,
    /// A frame of a sequence. It is asked what the sequence is, and there nothing is said of nodes.
    Frame,
}

/// Check every record.
pub fn check_records(view: &View<'_>, flags: u32, of: RecordsOf<'_>, limits: &Limits, exec: &Executor) -> Report {
    let mut out = Report::new(limits.max_issues);
    counts::check_flags(view, flags, &mut out);
    let trees = counts::ranges(view, &mut out);

    // Look at each tree. Many small trees share the cores, a large one divides its nodes among them.
    let mut depth = Some(0u32);
    let parts = exec.map_range(view.blases.len().min(trees.len()), |i| match &trees[i] {
        Some(ranges) => check_tree(view, i as u32, &view.blases[i], ranges, limits, exec),
        None => (Report::new(limits.max_issues), None),
    });
    for (part, tree_depth) in parts {
        depth = depth.zip(tree_depth).map(|(a, b)| a.max(b));
        out.append(part);
    }

    if flags & tree_flags::TWO_LEVEL != 0 {
        let baked = match of {
            RecordsOf::Frame => Vec::new(),
            RecordsOf::File(_) | RecordsOf::Still => instances::baked_nodes(view.geoms, view.blases.len()),
        };
        let top_depth = check_top(view, &baked, limits, &mut out, exec);
        depth = depth.zip(top_depth).map(|(a, b)| a.max(b));
        instances::check_used(view.instances.iter(), view.blases.len(), SectionKind::BLAS, &mut out);
    }
    if let RecordsOf::File(header) = of {
        counts::check_header(view, header, depth, &mut out);
    }
    out
}

/// Look at the top level; the depth of its tree, if that can be told.
///
/// `baked`: the [`instances::baked_nodes`] of the trees, or nothing where they are not asked.
pub fn check_top(
    view: &View<'_>,
    baked: &[Option<(u32, u32)>],
    limits: &Limits,
    out: &mut Report,
    exec: &Executor,
) -> Option<u32> {
    let at = TreePlace { kind: SectionKind::TNOD, tree: None, start: 0 };
    let (nodes, count) = (view.tlas_nodes, view.instances.len());
    if nodes.len() % 2 != 0 || nodes.is_empty() != (count == 0) {
        let expected = if count == 0 { "0 without instances" } else { "even and not 0 with instances" };
        out.add(&rules::E0312, Place::section(SectionKind::TNOD), || (expected.into(), nodes.len().to_string()));
    }
    let shape = topology::walk(nodes, count as u64, at, out);
    out.append(boxes::check(nodes, None, shape.tiled, at, limits.max_issues, exec));
    instances::check(view, baked, out);
    instances::check_leaves(view, shape.tiled, at, out);
    shape.depth
}

fn check_tree(
    view: &View<'_>,
    tree: u32,
    blas: &BlasRecord,
    ranges: &TreeRanges,
    limits: &Limits,
    exec: &Executor,
) -> (Report, Option<u32>) {
    let nodes = &view.nodes[ranges.nodes.0..ranges.nodes.1];
    let triangles = &view.triangles[ranges.triangles.0..ranges.triangles.1];
    let at = TreePlace { kind: SectionKind::NODE, tree: Some(tree), start: ranges.nodes.0 as u64 };
    let items = Items {
        triangles,
        start: ranges.triangles.0 as u64,
        tree,
        geoms: ranges.geoms,
        prims: view.geoms,
        split: blas.flags & tree_flags::DUP_REFS != 0,
    };
    let mut out = Report::new(limits.max_issues);
    let shape = topology::walk(nodes, triangles.len() as u64, at, &mut out);
    let ((boxes, identity), sah) = exec.join(
        || {
            exec.join(
                || boxes::check(nodes, Some(items), shape.tiled, at, limits.max_issues, exec),
                || identity::check(nodes, items, shape.tiled, blas.prim_count, limits.max_issues, exec),
            )
        },
        || quality::sah(nodes),
    );
    out.append(boxes);
    out.append(identity);

    // Compare what the row states with what the records are.
    let place = Place::record(SectionKind::BLAS, tree.into());
    let root = nodes.first().map_or(Aabb { min: [0.0; 3], max: [0.0; 3] }, |n| n.bounds());
    let stated = Aabb { min: blas.min, max: blas.max };
    if bits(&root) != bits(&stated) {
        out.add(&rules::E0414, place, || (show(&root), show(&stated)));
    }
    if let Some(depth) = shape.depth.filter(|d| *d != blas.max_depth) {
        out.add(&rules::E0407, place, || (depth.to_string(), blas.max_depth.to_string()));
    }
    if sah.to_bits() != blas.sah.to_bits() && shape.depth.is_some() {
        out.add(&rules::E0427, place, || (format!("{sah:?}"), format!("{:?}", blas.sah)));
    }
    (out, shape.depth)
}
