//! Many files below each other: a line each, with the figures that tell them apart.

use super::{dash, epo};
use crate::cli::figures;
use crate::cli::names;
use crate::cli::table::Table;
use crate::report::file::FileReport;
use std::path::{Path, PathBuf};

/// A figure and its name.
type Column = (&'static str, fn(&FileReport) -> String);

const COLUMNS: [Column; 8] = [
    ("triangles", |r| figures::count(r.blas.triangles)),
    ("duplicated", |r| format!("{:+.1} %", r.blas.duplication * 100.0)),
    ("nodes", |r| figures::count(r.blas.nodes)),
    ("depth", |r| r.blas.max_depth.to_string()),
    ("SAH", |r| format!("{:.2}", r.blas.sah)),
    ("EPO", |r| r.epo.as_ref().map_or_else(dash, epo)),
    ("ray cost", |r| r.rays.as_ref().map_or_else(dash, |rays| format!("{:.2}", rays.cost))),
    ("B/triangle", |r| format!("{:.1}", r.bytes_per_triangle)),
];

/// A heading, and a line each. A column of which no file has anything is left out.
pub fn text(reports: &[FileReport], paths: &[PathBuf]) -> String {
    let is_known = |column: &&Column| reports.iter().any(|report| column.1(report) != dash());
    let columns: Vec<&Column> = COLUMNS.iter().filter(is_known).collect();
    let mut table = Table::default();
    table.row("", columns.iter().map(|column| column.0.to_string()));
    let names = names::headings(&paths.iter().map(PathBuf::as_path).collect::<Vec<&Path>>());
    for (report, name) in reports.iter().zip(names) {
        table.row(name, columns.iter().map(|column| column.1(report)));
    }
    table.render()
}
