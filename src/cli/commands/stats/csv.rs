//! Files as comma-separated values.

use crate::cli::table::csv_line;
use crate::report::file::FileReport;
use crate::report::overlap::EpoReport;
use crate::report::rays::RayReport;
use crate::trace::probe::Family;

/// A figure as a machine reads it; the shortest text that gives the same number back.
type Column = (&'static str, fn(&FileReport) -> String);

const COLUMNS: [Column; 33] = [
    ("file_len", |r| r.file_len.to_string()),
    ("levels", |r| r.levels.to_string()),
    ("trees", |r| r.blas.trees.to_string()),
    ("nodes", |r| r.blas.nodes.to_string()),
    ("leaves", |r| r.blas.leaves.to_string()),
    ("triangles", |r| r.blas.triangles.to_string()),
    ("references", |r| r.blas.references.to_string()),
    ("duplication", |r| r.blas.duplication.to_string()),
    ("max_depth", |r| r.blas.max_depth.to_string()),
    ("sah", |r| r.blas.sah.to_string()),
    ("sah_nodes", |r| r.blas.sah_nodes.to_string()),
    ("sah_leaves", |r| r.blas.sah_leaves.to_string()),
    ("epo", |r| epo_column(r, |e| e.value.to_string())),
    ("epo_standard_error", |r| epo_column(r, |e| e.standard_error.to_string())),
    ("epo_points", |r| epo_column(r, |e| e.points.to_string())),
    ("references_per_leaf", |r| r.blas.references_per_leaf.to_string()),
    ("mean_sibling_overlap", |r| r.blas.mean_sibling_overlap.to_string()),
    ("overlap_per_root_area", |r| r.blas.overlap_per_root_area.to_string()),
    ("bytes_per_triangle", |r| r.bytes_per_triangle.to_string()),
    ("mean_empty_share", |r| r.blas.mean_empty_share.to_string()),
    ("ray_cost", |r| ray_column(r, |rays| rays.cost)),
    ("visits", |r| ray_column(r, |rays| rays.mean(|s| s.visits))),
    ("tests", |r| ray_column(r, |rays| rays.mean(|s| s.tests))),
    ("leaf_visits", |r| ray_column(r, |rays| rays.mean(|s| s.leaves))),
    ("leaf_variability", |r| ray_column(r, |rays| rays.mean(|s| s.leaf_variability))),
    ("instances", |r| r.instances.to_string()),
    ("instanced_triangles", |r| r.instanced_triangles.to_string()),
    ("tlas_nodes", |r| r.tlas.as_ref().map_or_else(String::new, |t| t.nodes.to_string())),
    ("tlas_sah", |r| r.tlas.as_ref().map_or_else(String::new, |t| t.sah.to_string())),
    ("node_bytes_per_triangle", |r| r.node_bytes_per_triangle.to_string()),
    ("compact8_bytes_per_triangle", |r| {
        r.compact8_bytes_per_triangle.map_or_else(String::new, |bytes| bytes.to_string())
    }),
    ("turned_subtrees", |r| r.turned_subtrees.map_or_else(String::new, |count| count.to_string())),
    ("turned_bytes_per_triangle", |r| r.turned_bytes_per_triangle.map_or_else(String::new, |bytes| bytes.to_string())),
];

fn epo_column(report: &FileReport, cell: fn(&EpoReport) -> String) -> String {
    report.epo.as_ref().map_or_else(String::new, cell)
}

fn ray_column(report: &FileReport, cell: fn(&RayReport) -> f64) -> String {
    report.rays.as_ref().map_or_else(String::new, |rays| cell(rays).to_string())
}

/// A heading, and a line each.
pub fn text(reports: &[FileReport]) -> String {
    let families = Family::ALL.map(|family| (family.name(), format!("{}_cost", family.name())));
    let names = COLUMNS.iter().map(|c| c.0).chain(families.iter().map(|f| f.1.as_str()));
    let heading = csv_line(std::iter::once("file").chain(names));
    let lines = reports.iter().map(|r| {
        let cost = |name| r.families.iter().find(|f| f.name == name).map_or_else(String::new, |f| f.cost.to_string());
        let families = families.iter().map(|(name, _)| cost(*name));
        let cells: Vec<String> = COLUMNS.iter().map(|(_, cell)| cell(r)).chain(families).collect();
        csv_line(std::iter::once(r.path.as_str()).chain(cells.iter().map(String::as_str)))
    });
    std::iter::once(heading).chain(lines).collect()
}
