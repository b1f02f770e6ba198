//! `bvhc stats`: what the trees of a file are like.

use super::compare;
use crate::cli::Context;
use crate::cli::advice;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::{Entry, Failure};
use crate::cli::figures;
use crate::cli::names;
use crate::cli::paragraph;
use crate::cli::patterns;
use crate::cli::table::{Table, csv_line};
use crate::report::file::{BlasSpread, Extreme, FileReport};
use crate::report::frames::Measure;
use crate::report::metrics::Condition;
use crate::report::overlap::{EpoMode, EpoReport};
use crate::report::rays::{RayReport, SetReport};
use crate::report::stats::TreeReport;
use crate::trace::probe::SETS;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Measure the trees of cache files: SAH, EPO, depth, leaves, duplication, overlap
///
/// The files become columns. The SAH is over the root's area with C_T = 1.2 and C_I = 1; over several trees it is the mean
/// weighted by the areas of their roots. EPO, the end-point overlap, is what a ray pays with the same costs for nodes that contain its end but
/// not the triangle there; over several trees it is weighted by the areas of their surfaces. SAH and EPO together tell more than either alone.
#[derive(Debug, Args)]
pub struct StatsArgs {
    /// Cache files, folders of them, or quoted patterns such as 'caches/**/*.bvhc'
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// One line of comma-separated values per file, with a heading; with --frames one per frame
    #[arg(long, conflicts_with = "json")]
    csv: bool,
    /// Of sequences: one row per frame, with what refitting costs and what each frame adds to the file
    #[arg(long, conflicts_with_all = ["epo", "depths"])]
    frames: bool,
    /// Rays in each of three sets by which the cost of a ray is counted, from four cameras around the scene or each frame; 0 traces none, and a million is the
    /// most [default: 0, with --frames 1024, with --compare 4096]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=1_000_000))]
    rays: Option<u32>,
    /// With --frames: build each frame's trees anew by the recipe in the file, and count what the same rays cost there
    #[arg(long, requires = "frames")]
    against_fresh: bool,
    /// With --frames: draw ray cost and bytes from frame to frame
    #[arg(long, value_name = "FILE", requires = "frames")]
    svg: Option<PathBuf>,
    /// How EPO is measured [default: auto]
    #[arg(long, value_name = "HOW", value_enum)]
    epo: Option<Epo>,
    /// Show also the nodes, leaves and overlap at each depth
    #[arg(long)]
    depths: bool,
    /// Of two files: what changed from the first to the second
    #[arg(long, conflicts_with_all = ["csv", "frames", "depths"])]
    compare: bool,
    /// With --compare: exit with 8 where this holds, such as 'ray-cost > +2%', 'sah > +0.5' or 'depth > 40'; may be given again. With a sign it is
    /// about the change, with a sign and % about its share, else about the second file's value
    #[arg(long = "fail-if", value_name = "CONDITION", requires = "compare", value_parser = compare::parse_condition)]
    fail_if: Vec<Condition>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Epo {
    /// `exact` where that takes no more work than a few good trees of that size, `sampled` otherwise
    Auto,
    /// Every triangle clipped with every box that it reaches into: long for bad trees of many triangles
    Exact,
    /// At 262,144 points of the surface, with the standard error beside it
    Sampled,
    /// Not at all
    Off,
}

impl Epo {
    fn mode(self) -> Option<EpoMode> {
        match self {
            Epo::Auto => Some(EpoMode::Auto(1 << 18)),
            Epo::Exact => Some(EpoMode::Exact),
            Epo::Sampled => Some(EpoMode::Points(1 << 18)),
            Epo::Off => None,
        }
    }
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    files: &'a [Entry<FileReport>],
}

pub fn run(args: &StatsArgs, context: &Context) -> Result<Exit, Failure> {
    let files = patterns::expand(&args.files, patterns::CACHES, "measure")?;
    if args.compare && files.len() != 2 {
        return Err(Failure::new(
            Exit::Usage,
            format!("cannot compare {}", figures::counted(files.len() as u64, "file", "files")),
        )
        .fact("what changed is told from one file to another")
        .help("bvhc stats --compare BEFORE AFTER"));
    }
    if args.frames || files.iter().all(|path| caches::is_sequence(path, context)) {
        // A sequence alone needs no --frames, which refuses these.
        let unread = [("--epo", args.epo.is_some()), ("--depths", args.depths), ("--compare", args.compare)];
        if let Some((flag, _)) = unread.into_iter().find(|(_, is_given)| *is_given) {
            return Err(Failure::new(Exit::Usage, format!("cannot measure a sequence with {flag}"))
                .fact("the frames of a sequence are told by a row each")
                .help(format!("leave out {flag}, or take a frame out first: bvhc convert FILE -o OUT --frame N")));
        }
        let measure = Measure { rays: args.rays.unwrap_or(1024) as usize, fresh: args.against_fresh };
        return super::frames::run(&files, &measure, args.csv, args.svg.as_deref(), context);
    }
    let count = args.rays.unwrap_or(if args.compare { 4096 } else { 0 }) as usize;
    let mut paths = Vec::new();
    let mut failed = None;
    let (entries, exit) = caches::each(&files, context, |path| {
        let opened = caches::open_checked(path, context).inspect_err(|failure| failed = Some(failure.exit))?;
        paths.push(path.to_path_buf());
        let (name, view) = (path.to_string_lossy().into_owned(), opened.view());
        let epo = args.epo.unwrap_or(Epo::Auto).mode().map(|mode| EpoReport::of_view(&view, mode, &context.exec));
        let notes = opened.meta().map_or_else(Vec::new, |meta| meta.notes.clone());
        let rays = (count > 0).then(|| RayReport::of_view(&view, count, &context.exec));
        let report = FileReport { epo, rays, notes, ..FileReport::of_view(name, opened.header().file_len, &view) };
        Ok(match opened.compact() {
            Some(trees) => report.with_compact(&trees),
            None => report,
        })
    });
    if args.compare {
        // With one file nothing is compared, so that its failure is that of the whole.
        return match failed {
            None => compare::run(&Entry::all_done(entries), &paths, &args.fail_if, context),
            Some(exit) => Ok(exit),
        };
    }
    if context.terminal.json {
        context.terminal.document(&Document { schema: "bvhc.stats.v1", exit_code: exit.code(), files: &entries })?;
        return Ok(exit);
    }
    let reports = Entry::all_done(entries);
    if args.csv {
        context.terminal.print(&csv(&reports))?;
    } else if !reports.is_empty() {
        context.terminal.print(&text(&reports, &paths, args.depths))?;
    }
    Ok(exit)
}

/// A named figure of a file, as a person reads it.
type Row = (&'static str, fn(&FileReport) -> String);

const ROWS: [Row; 14] = [
    ("nodes", |r| figures::count(r.blas.nodes)),
    ("leaves", |r| figures::count(r.blas.leaves)),
    ("triangles", |r| figures::count(r.blas.prims)),
    ("references", |r| figures::count(r.blas.refs)),
    ("duplicated", |r| format!("{:+.1} %", r.blas.duplication * 100.0)),
    ("depth", |r| r.blas.max_depth.to_string()),
    ("SAH", |r| format!("{:.2}", r.blas.sah)),
    ("  nodes' share", |r| format!("{:.1} %", share(r.blas.sah_nodes, r.blas.sah))),
    ("  leaves' share", |r| format!("{:.1} %", share(r.blas.sah_leaves, r.blas.sah))),
    ("EPO", |r| r.epo.as_ref().map_or_else(dash, epo)),
    ("refs per leaf", |r| format!("{:.2}", r.blas.refs_per_leaf)),
    ("sibling overlap", |r| format!("{:.2} %", r.blas.mean_sibling_overlap * 100.0)),
    ("bytes per triangle", |r| format!("{:.1}", r.bytes_per_triangle)),
    ("empty space", |r| format!("{:.2} %", r.blas.mean_empty_share * 100.0)),
];

/// One of a two-level file's top level.
type TopRow = (&'static str, fn(&FileReport, &TreeReport) -> String);

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

fn extreme(e: Extreme, show: impl Fn(f64) -> String) -> String {
    format!("{} (#{})", show(e.value), e.blas)
}

/// Two digits behind the point, one standard deviation where it shows there, and whether it was sampled.
fn epo(report: &EpoReport) -> String {
    let error = if report.standard_error >= 0.005 { format!(" ±{:.2}", report.standard_error) } else { String::new() };
    let sampled = if report.points > 0 { " sampled" } else { "" };
    format!("{:.2}{error}{sampled}", report.value)
}

fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole * 100.0 } else { 0.0 }
}

fn text(reports: &[FileReport], paths: &[PathBuf], depths: bool) -> String {
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

    if reports.iter().any(|r| r.rays.is_some()) {
        ray_rows(&mut table, reports);
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
    table.render() + &notes(reports, paths)
}

/// Why the trees are as they are, where the builder had a choice.
fn notes(reports: &[FileReport], paths: &[PathBuf]) -> String {
    let headings = names::headings(&paths.iter().map(PathBuf::as_path).collect::<Vec<_>>());
    let mut text = String::new();
    for (report, heading) in reports.iter().zip(headings).filter(|(report, _)| !report.notes.is_empty()) {
        text.push_str(&format!("\n{heading}\n"));
        for note in &report.notes {
            let told = names::escape(&advice::note(note));
            text += &if advice::names_a_recipe(note) { format!("  {told}\n") } else { paragraph::hanging("  ", &told) };
        }
    }
    text
}

fn dash() -> String {
    "-".to_string()
}

fn counted(n: u64, of: u64) -> String {
    if n == 0 { dash() } else { format!("{}  {:>5.1} %", figures::count(n), share(n as f64, of as f64)) }
}

/// A figure as a machine reads it; the shortest text that gives the same number back.
type Column = (&'static str, fn(&FileReport) -> String);

const COLUMNS: [Column; 31] = [
    ("file_len", |r| r.file_len.to_string()),
    ("levels", |r| r.levels.to_string()),
    ("trees", |r| r.blas.trees.to_string()),
    ("nodes", |r| r.blas.nodes.to_string()),
    ("leaves", |r| r.blas.leaves.to_string()),
    ("triangles", |r| r.blas.prims.to_string()),
    ("references", |r| r.blas.refs.to_string()),
    ("duplication", |r| r.blas.duplication.to_string()),
    ("max_depth", |r| r.blas.max_depth.to_string()),
    ("sah", |r| r.blas.sah.to_string()),
    ("sah_nodes", |r| r.blas.sah_nodes.to_string()),
    ("sah_leaves", |r| r.blas.sah_leaves.to_string()),
    ("epo", |r| epo_column(r, |e| e.value.to_string())),
    ("epo_standard_error", |r| epo_column(r, |e| e.standard_error.to_string())),
    ("epo_points", |r| epo_column(r, |e| e.points.to_string())),
    ("refs_per_leaf", |r| r.blas.refs_per_leaf.to_string()),
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
];

fn epo_column(report: &FileReport, cell: fn(&EpoReport) -> String) -> String {
    report.epo.as_ref().map_or_else(String::new, cell)
}

fn ray_column(report: &FileReport, cell: fn(&RayReport) -> f64) -> String {
    report.rays.as_ref().map_or_else(String::new, |rays| cell(rays).to_string())
}

fn csv(reports: &[FileReport]) -> String {
    let heading = csv_line(std::iter::once("file").chain(COLUMNS.iter().map(|c| c.0)));
    let lines = reports.iter().map(|r| {
        let cells: Vec<String> = COLUMNS.iter().map(|(_, cell)| cell(r)).collect();
        csv_line(std::iter::once(r.path.as_str()).chain(cells.iter().map(String::as_str)))
    });
    std::iter::once(heading).chain(lines).collect()
}
