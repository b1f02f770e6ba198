//! `bvhc verify --accuracy`: how right and how fast other arithmetics would be on the same trees.

use super::VerifyArgs;
use super::file::{Held, scene_for};
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::drawing;
use crate::cli::exit::Exit;
use crate::cli::failure::{Entry, Failure};
use crate::cli::figures;
use crate::cli::names;
use crate::cli::patterns;
use crate::cli::progress::Bar;
use crate::cli::table::Table;
use crate::report::accuracy::chart;
use crate::verify::Subject;
use crate::verify::accuracy::{AccuracyError, Errors, Measure, Report, Row, measure};
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    seed: u64,
    files: &'a [Entry<Measured>],
    /// With several files: errors added up, speeds and visits as geometric means.
    #[serde(skip_serializing_if = "Option::is_none")]
    all: Option<&'a Report>,
}

#[derive(Serialize)]
struct Measured {
    path: String,
    #[serde(flatten)]
    report: Report,
}

/// Exit 1 if our own arithmetic is wrong anywhere; the others may be.
pub fn run(args: &VerifyArgs, context: &Context) -> Result<Exit, Failure> {
    let full = Measure::default();
    let rays = args.rays.unwrap_or(full.rays);
    let how = Measure { rays, timed: full.timed.min(rays), seed: args.seed, ..full };
    let named = patterns::expand(&args.files, patterns::CACHES, "verify", &context.terminal)?;
    let (files, exit) = caches::each(&named, context, |path| {
        let report = one(path, args, &how, context)?;
        let measured = Measured { path: path.to_string_lossy().into_owned(), report };
        if !context.terminal.json {
            context.terminal.print(&text(&names::path(path), &measured.report))?;
        }
        Ok(measured)
    });
    let reports: Vec<Report> = files.iter().filter_map(Entry::done).map(|f| f.report.clone()).collect();
    let all = Report::of_all(&reports).filter(|_| reports.len() > 1);
    let subject = match &named[..] {
        [one] => names::path(one),
        several => format!("{} files", several.len()),
    };
    let ours_is_right = reports.iter().all(|r| r.ours().fair.wrong() + r.ours().hard.wrong() == 0);
    let exit = if exit == Exit::Success && !ours_is_right { Exit::Negative } else { exit };
    if context.terminal.json {
        let document = Document {
            schema: "bvhc.accuracy.v1",
            exit_code: exit.code(),
            seed: args.seed,
            files: &files,
            all: all.as_ref(),
        };
        context.terminal.document(&document)?;
    } else if let Some(all) = &all {
        context.terminal.print(&text(&format!("{} files together", reports.len()), all))?;
    }
    if let (Some(path), Some(report)) = (&args.svg, all.as_ref().or(reports.first())) {
        drawing::draw(path, &chart(&subject, report))?;
    }
    Ok(exit)
}

fn one(path: &Path, args: &VerifyArgs, how: &Measure, context: &Context) -> Result<Report, Failure> {
    let bar = Bar::new(&context.terminal, &names::path(path));
    bar.spin("opening");
    let cache = caches::open_checked(path, context)?;
    let Held { scene, .. } = scene_for(&cache, path, args, context)?;
    let subject = Subject::new(cache.view(), &scene, &context.exec);
    bar.phase("measuring", how.steps(scene.instanced_triangles()));
    let measured = measure(&subject.view, &subject.oracle, &subject.sampler, how, &context.exec, &bar);
    measured.map_err(|error| match error {
        AccuracyError::Malformed(malformed) => {
            let failure = Failure::new(Exit::Negative, malformed.to_string());
            let failure = failure.fact(format!("the file is {}", names::path(path)));
            failure.help(format!("bvhc check {}", names::path(path)))
        }
        AccuracyError::Cancelled => Failure::interrupted(),
    })
}

fn text(name: &str, report: &Report) -> String {
    let mut table = Table::default();
    let words = |words: &[&str]| words.iter().map(|w| (*w).to_string()).collect::<Vec<_>>();
    table.row("", words(&["fair", "", "", "hard", "", "", "ulps", "", "", "nodes", "tests"]));
    let heads =
        ["missed", "farther", "false", "missed", "farther", "false", "median", "max", "Mrays/s", "a ray", "a ray"];
    table.row("triangles, boxes", words(&heads));
    for row in &report.rows {
        let label = format!("{}, {}", row.arithmetic.triangles.name(), row.arithmetic.boxes.name());
        table.row(label, cells(row));
    }
    let count = |n: u64| figures::count(n);
    format!(
        "{name}: {} triangles; {} fair and {} hard rays judged; {} fair rays timed {} times on one thread\n\n{}\n",
        count(report.instanced_triangles),
        count(report.fair_rays),
        count(report.hard_rays),
        count(report.timed_rays),
        report.rounds,
        table.render()
    )
}

fn cells(row: &Row) -> Vec<String> {
    let errors = |e: &Errors| [e.missed, e.farther, e.false_hits].map(figures::count);
    let ulps = |v: f64| if v >= 1e5 { format!("{v:.1e}") } else { format!("{v:.2}") };
    let mut cells: Vec<String> = errors(&row.fair).into_iter().chain(errors(&row.hard)).collect();
    cells.extend([
        ulps(row.distance.median()),
        ulps(row.distance.max()),
        format!("{:.2}", row.mrays_per_second),
        format!("{:.1}", row.inner_nodes_per_ray),
        format!("{:.1}", row.triangles_per_ray),
    ]);
    cells
}
