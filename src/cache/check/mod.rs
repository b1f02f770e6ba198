//! The check: is this file intact, well formed, and the tree of that model?
//!
//! All but the last question is answered by `bvhc_core::cache::check`, which appears here again. This room compares with the model.

mod source;

pub use bvhc_core::cache::check::{
    CompactRecords, Finding, Level, Limits, Place, RecordsOf, Report, TurnRecords, check_compact, check_records,
    check_sides, check_turns, check_vertices,
};
pub use source::Source;

use bvhc_core::cache::check as core;

use super::Image;
use crate::exec::Executor;

/// Check a file's bytes as deeply as `level` says; [`Level::Source`] needs a `source` and is [`Level::Tree`] without.
pub fn check_bytes(
    bytes: &[u8],
    level: Level,
    source: Option<&Source<'_>>,
    limits: &Limits,
    exec: &Executor,
) -> Report {
    let Some(source) = source else { return core::check_bytes(bytes, level, None, limits, exec) };
    core::check_bytes(
        bytes,
        level,
        Some(&|content, out| source::check(content, source, limits.max_issues, out, exec)),
        limits,
        exec,
    )
}

/// Check the content of a file that is not one yet: what a builder or a converter is about to write.
pub fn check_image(image: &Image, limits: &Limits, exec: &Executor) -> Report {
    let view = image.view();
    let mut report = check_records(&view, image.flags, RecordsOf::Still, limits, exec);
    if let Some(compact) = image.compact.as_ref().filter(|_| report.is_valid()) {
        let (rows, nodes, order) = (Some(&compact.rows[..]), Some(&compact.nodes[..]), Some(&compact.order[..]));
        report.append(check_compact(&view, &CompactRecords { rows, nodes, order }, limits, exec));
    }
    if let Some(turns) = image.turns.as_ref().filter(|_| report.is_valid()) {
        let records = TurnRecords { rows: Some(&turns.rows), nodes: Some(&turns.nodes) };
        report.append(check_turns(&view, &records, limits, exec));
    }
    if !image.vertices.is_empty() {
        report.append(check_vertices(&view, &image.vertices, limits, exec));
    }
    if !image.sides.is_empty() {
        check_sides(view.geoms, &image.sides, &mut report);
    }
    report
}
