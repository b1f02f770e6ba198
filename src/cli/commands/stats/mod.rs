//! `bvhc stats`: what the trees of a file are like.
//!
//! `columns` shows files side by side, `lines` many of them below each other, and `csv` is for machines.

mod columns;
mod csv;
mod lines;

use super::compare;
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::{Entry, Failure};
use crate::cli::figures;
use crate::cli::patterns;
use crate::report::families::FamilyReport;
use crate::report::file::FileReport;
use crate::report::frames::{Measure, SequenceReport};
use crate::report::metrics::{Change, Condition, Measured};
use crate::report::overlap::{EpoMode, EpoReport};
use crate::report::rays::RayReport;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Measure the trees of cache files: SAH, EPO, depth, leaves, duplication, overlap
///
/// The files become columns, or lines with fewer figures where they are more than five. The SAH is over the root's area with C_T = 1.2 and C_I = 1; over several trees it is the mean
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
    /// Rays in each of three sets by which the cost of a ray is counted, from four cameras around the scene or each frame, and in each family of rays; 0 traces none, and a
    /// million is the most [default: 0, with --frames and of sequences 1024, with --compare 4096]
    #[arg(long, value_name = "N", value_parser = figures::parse_rays)]
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
    #[arg(long, conflicts_with = "csv")]
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

/// More files stand below each other: side by side they would be wider than terminals are.
const MOST_COLUMNS: usize = 5;

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    files: &'a [Entry<FileReport>],
}

pub fn run(args: &StatsArgs, context: &Context) -> Result<Exit, Failure> {
    let files = patterns::expand(&args.files, patterns::CACHES, "measure", &context.terminal)?;
    if args.compare && files.len() != 2 {
        return Err(Failure::new(
            Exit::Usage,
            format!("cannot compare {}", figures::counted(files.len() as u64, "file", "files")),
        )
        .fact("what changed is told from one file to another")
        .help("bvhc stats --compare BEFORE AFTER"));
    }
    let sequences = files.iter().filter(|path| caches::is_sequence(path, context)).count();
    if args.compare && sequences > 0 {
        return compare_sequences(args, &files, sequences, context);
    }
    if args.frames || sequences == files.len() {
        // A sequence alone needs no --frames, which refuses these.
        let unread = [("--epo", args.epo.is_some()), ("--depths", args.depths)];
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
        let rays = (count > 0).then(|| RayReport::of_view(&view, count, &context.exec));
        let families = match count {
            // What changed is told of the three sets.
            0 => Vec::new(),
            _ if args.compare => Vec::new(),
            count => FamilyReport::of_view(&view, count, &context.exec),
        };
        let report = FileReport { epo, rays, families, ..FileReport::of_view(name, opened.header().file_len, &view) };
        let report = report.with_notes(opened.meta().map_or(&[], |meta| &meta.notes));
        let report = match opened.compact() {
            Some(trees) => report.with_compact(&trees),
            None => report,
        };
        Ok(match opened.turned() {
            Some(turned) => report.with_turned(&turned),
            None => report,
        })
    });
    if args.compare {
        // With one file nothing is compared, so that its failure is that of the whole.
        return match failed {
            None => compared(&Entry::all_done(entries), |r| r.instanced_triangles, &paths, args, context),
            Some(exit) => Ok(exit),
        };
    }
    if context.terminal.json {
        context.terminal.document(&Document { schema: "bvhc.stats.v1", exit_code: exit.code(), files: &entries })?;
        return Ok(exit);
    }
    let reports = Entry::all_done(entries);
    if args.csv {
        context.terminal.print(&csv::text(&reports))?;
    } else if reports.len() > MOST_COLUMNS && !args.depths {
        context.terminal.print(&lines::text(&reports, &paths))?;
        context.terminal.note("of more files than stand side by side, some figures each; --csv and --json have all");
    } else if !reports.is_empty() {
        context.terminal.print(&columns::text(&reports, &paths, args.depths, context.terminal.verbose))?;
    }
    Ok(exit)
}

/// What changed from one sequence to another, in figures over all frames.
fn compare_sequences(args: &StatsArgs, files: &[PathBuf], count: usize, context: &Context) -> Result<Exit, Failure> {
    if count < files.len() {
        return Err(Failure::new(Exit::Usage, "cannot compare a sequence with a still file")
            .fact("figures of a sequence are over all its frames")
            .help("take a frame out first: bvhc convert FILE -o OUT --frame N"));
    }
    if args.epo.is_some() {
        return Err(Failure::new(Exit::Usage, "cannot measure a sequence with --epo")
            .fact("of sequences the end-point overlap is not measured")
            .help("leave out --epo, or take frames out first: bvhc convert FILE -o OUT --frame N"));
    }
    let measure = Measure { rays: args.rays.unwrap_or(1024) as usize, fresh: false };
    let (entries, exit) = super::frames::measured(files, &measure, context);
    if exit != Exit::Success {
        return Ok(exit);
    }
    compared(&Entry::all_done(entries), SequenceReport::triangles, files, args, context)
}

fn compared<R: Measured>(
    reports: &[R],
    triangles: impl Fn(&R) -> u64,
    paths: &[PathBuf],
    args: &StatsArgs,
    context: &Context,
) -> Result<Exit, Failure> {
    let [before, after] = reports else { return Ok(Exit::Success) };
    let triangles = [before, after].map(triangles);
    compare::run(&Change::all(before, after), triangles, paths, &args.fail_if, context)
}

/// Two digits behind the point, one standard deviation where it shows there, and whether it was sampled.
fn epo(report: &EpoReport) -> String {
    let error = if report.standard_error >= 0.005 { format!(" ±{:.2}", report.standard_error) } else { String::new() };
    let sampled = if report.points > 0 { " sampled" } else { "" };
    format!("{:.2}{error}{sampled}", report.value)
}

fn dash() -> String {
    "-".to_string()
}
