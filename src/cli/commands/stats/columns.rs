//! Files side by side: a column each.

use super::{dash, epo};
use crate::cli::advice;
use crate::cli::figures;
use crate::cli::names;
use crate::cli::paragraph;
use crate::cli::table::Table;
use crate::report::effort::BuildEffort;
use crate::report::families::FamilyReport;
use crate::report::file::{BlasSpread, Extreme, FileReport};
use crate::report::rays::{RayReport, SetReport};
use crate::report::stats::TopReport;
use crate::size::bytes;
use crate::trace::probe::{Family, SETS};
use std::path::PathBuf;

/// A named figure of a file, as a person reads it.
type Row = (&'static str, fn(&FileReport) -> String);

const ROWS: [Row; 14] = [
    ("nodes", |r| figures::count(r.blas.nodes)),
    ("leaves", |r| figures::count(r.blas.leaves)),
    ("triangles", |r| figures::count(r.blas.triangles)),
    ("references", |r| figures::count(r.blas.references)),
    ("duplicated", |r| format!("{:+.1} %", r.blas.duplication * 100.0)),
    ("depth", |r| r.blas.max_depth.to_string()),
    ("SAH", |r| format!("{:.2}", r.blas.sah)),
    ("  nodes' share", |r| format!("{:.1} %", share(r.blas.sah_nodes, r.blas.sah))),
    ("  leaves' share", |r| format!("{:.1} %", share(r.blas.sah_leaves, r.blas.sah))),
    ("EPO", |r| r.epo.as_ref().map_or_else(dash, epo)),
    ("refs per leaf", |r| format!("{:.2}", r.blas.references_per_leaf)),
    ("sibling overlap", |r| format!("{:.2} %", r.blas.mean_sibling_overlap * 100.0)),
    ("bytes per triangle", |r| format!("{:.1}", r.bytes_per_triangle)),
    ("empty space", |r| format!("{:.2} %", r.blas.mean_empty_share * 100.0)),
];

/// One of a two-level file's top level.
type TopRow = (&'static str, fn(&FileReport, &TopReport) -> String);

const TOP_ROWS: [TopRow; 6] = [
    ("instances", |r, _| figures::count(r.instances)),
    ("instanced triangles", |r, _| figures::count(r.instanced_triangles)),
    ("top-level nodes", |_, t| figures::count(t.nodes)),
    ("top-level depth", |_, t| t.max_depth.to_string()),
    ("top-level SAH", |_, t| format!("{:.2}", t.sah)),
    ("top-level overlap", |_, t| format!("{:.2} %", t.mean_sibling_overlap * 100.0)),
];

/// One of how a file's trees differ.
type SpreadRow = (&'static str, fn(&BlasSpread) -> String);

const SPREAD_ROWS: [SpreadRow; 5] = [
    ("trees", |s| figures::count(s.count)),
    ("  largest", |s| extreme(s.largest, |v| format!("{} tris", figures::count(v as u64)))),
    ("  deepest", |s| extreme(s.deepest, |v| format!("{v:.0}"))),
    ("  highest SAH", |s| extreme(s.highest_sah, |v| format!("{v:.2}"))),
    ("  mean SAH", |s| format!("{:.2}", s.mean_sah)),
];

/// One of what a set of rays does.
type RayRow = (&'static str, fn(&SetReport) -> f64);

/// One of what a build took.
type EffortRow = (&'static str, fn(&BuildEffort) -> String);

const EFFORT_ROWS: [EffortRow; 2] = [
    ("build time", |e| format!("{:.3} s ({})", e.seconds, figures::counted(e.threads, "thread", "threads"))),
    ("build memory", |e| e.peak_memory.map_or_else(dash, |peak| bytes(peak).to_string())),
];

const RAY_ROWS: [RayRow; 5] = [
    ("  visits", |s| s.visits),
    ("  tests", |s| s.tests),
    ("  leaves", |s| s.leaves),
    ("  leaf variability", |s| s.leaf_variability),
    ("  cost", |s| s.cost),
];

/// What rays do, a set after another, and what they cost in all sets.
fn ray_rows(table: &mut Table, reports: &[FileReport]) {
    let traced = |r: &FileReport, cell: &dyn Fn(&RayReport) -> String| r.rays.as_ref().map_or_else(dash, cell);
    table.gap();
    table.row("ray cost", reports.iter().map(|r| traced(r, &|rays| format!("{:.2}", rays.cost))));
    for name in SETS {
        let set = |rays: &RayReport, cell: &dyn Fn(&SetReport) -> String| {
            rays.sets.iter().find(|set| set.name == name).map_or_else(dash, cell)
        };
        let of_set = |r: &FileReport, cell: &dyn Fn(&SetReport) -> String| traced(r, &|rays| set(rays, cell));
        table.row(format!("{name} rays"), reports.iter().map(|r| of_set(r, &|s| figures::count(s.rays))));
        for (label, value) in RAY_ROWS {
            table.row(label, reports.iter().map(|r| of_set(r, &|s| format!("{:.2}", value(s)))));
        }
    }
}

/// What a ray of each family costs, with the standard error of that.
fn family_rows(table: &mut Table, reports: &[FileReport]) {
    table.gap();
    table.row("families of rays", reports.iter().map(|_| "cost".to_string()));
    for family in Family::ALL {
        let name = family.name();
        let cell = |f: &FamilyReport| format!("{:.2} ±{:.2}", f.cost, f.standard_error);
        let of = |r: &FileReport| r.families.iter().find(|f| f.name == name).map_or_else(dash, cell);
        if reports.iter().any(|r| r.families.iter().any(|f| f.name == name)) {
            table.row(format!("  {name}"), reports.iter().map(of));
        }
    }
}

fn extreme(e: Extreme, show: impl Fn(f64) -> String) -> String {
    format!("{} (#{})", show(e.value), e.blas)
}

fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole * 100.0 } else { 0.0 }
}

/// All figures, and why the trees are as they are.
pub fn text(reports: &[FileReport], paths: &[PathBuf], depths: bool, verbose: u8) -> String {
    let mut table = Table::default();
    table.row("", names::headings(&paths.iter().map(PathBuf::as_path).collect::<Vec<_>>()));
    for (label, cell) in ROWS {
        table.row(label, reports.iter().map(cell));
    }
    if reports.iter().any(|r| r.compact8_bytes_per_triangle.is_some()) {
        let each = |bytes: Option<f64>| bytes.map_or_else(dash, |bytes| format!("{bytes:.1}"));
        table.row("  binary nodes", reports.iter().map(|r| each(Some(r.node_bytes_per_triangle))));
        table.row("  compact8 nodes", reports.iter().map(|r| each(r.compact8_bytes_per_triangle)));
    }
    if reports.iter().any(|r| r.turned_subtrees.is_some()) {
        let count = |r: &FileReport| r.turned_subtrees.map_or_else(dash, figures::count);
        let each = |r: &FileReport| r.turned_bytes_per_triangle.map_or_else(dash, |bytes| format!("{bytes:.1}"));
        table.row("turned subtrees", reports.iter().map(count));
        table.row("  bytes per triangle", reports.iter().map(each));
    }
    if reports.iter().any(|r| r.blas_spread.is_some()) {
        for (label, cell) in SPREAD_ROWS {
            table.row(label, reports.iter().map(|r| r.blas_spread.as_ref().map_or_else(dash, cell)));
        }
    }
    if reports.iter().any(|r| r.tlas.is_some()) {
        for (label, cell) in TOP_ROWS {
            table.row(label, reports.iter().map(|r| r.tlas.as_ref().map_or_else(dash, |t| cell(r, t))));
        }
    }

    if reports.iter().any(|r| r.effort.is_some()) {
        for (label, cell) in EFFORT_ROWS {
            table.row(label, reports.iter().map(|r| r.effort.as_ref().map_or_else(dash, cell)));
        }
    }
    if reports.iter().any(|r| r.rays.is_some()) {
        ray_rows(&mut table, reports);
    }
    if reports.iter().any(|r| !r.families.is_empty()) {
        family_rows(&mut table, reports);
    }

    // The histograms: leaves by size always, since few sizes occur; nodes by depth on demand.
    table.gap();
    table.row("leaves by size", []);
    let sizes: std::collections::BTreeSet<u32> =
        reports.iter().flat_map(|r| r.blas.leaf_sizes.iter().map(|l| l.0)).collect();
    for size in sizes {
        let of = |r: &FileReport| r.blas.leaf_sizes.iter().find(|l| l.0 == size).map_or(0, |l| l.1);
        table.row(format!("{size:>4}"), reports.iter().map(|r| counted(of(r), r.blas.leaves)));
    }
    if depths {
        table.gap();
        table.row("nodes (leaves, overlap) by depth", []);
        for depth in 0..reports.iter().map(|r| r.blas.nodes_per_depth.len()).max().unwrap_or(0) {
            let at = |histogram: &[u64]| histogram.get(depth).copied().unwrap_or(0);
            let cell = |r: &FileReport| {
                let (nodes, leaves) = (at(&r.blas.nodes_per_depth), at(&r.blas.leaves_per_depth));
                let overlap = 100.0 * r.blas.overlap_per_depth.get(depth).copied().unwrap_or(0.0);
                format!("{} ({}, {overlap:.1} %)", figures::count(nodes), figures::count(leaves))
            };
            table.row(format!("{depth:>4}"), reports.iter().map(cell));
        }
    }
    table.render() + &notes(reports, paths, verbose)
}

/// Why the trees are as they are, where the builder had a choice.
fn notes(reports: &[FileReport], paths: &[PathBuf], verbose: u8) -> String {
    let headings = names::headings(&paths.iter().map(PathBuf::as_path).collect::<Vec<_>>());
    let mut text = String::new();
    for (report, heading) in reports.iter().zip(headings).filter(|(report, _)| !report.notes.is_empty()) {
        text.push_str(&format!("\n{heading}\n"));
        for note in advice::notes(&report.notes, verbose) {
            let told = names::escape(&note);
            text +=
                &if advice::names_a_recipe(&note) { format!("  {told}\n") } else { paragraph::hanging("  ", &told) };
        }
    }
    text
}

fn counted(n: u64, of: u64) -> String {
    if n == 0 { dash() } else { format!("{}  {:>5.1} %", figures::count(n), share(n as f64, of as f64)) }
}
