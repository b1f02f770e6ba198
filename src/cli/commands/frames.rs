//! `bvhc stats --frames`: what the frames of sequences are like.

use crate::build::{BuildError, Progress};
use crate::cache;
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::drawing;
use crate::cli::exit::Exit;
use crate::cli::failure::{Entry, Failure};
use crate::cli::figures;
use crate::cli::names;
use crate::cli::progress::Bar;
use crate::cli::table::{Table, csv_line};
use crate::report::frames::chart::chart;
use crate::report::frames::{FrameReport, FramesError, Measure, SequenceReport};
use crate::size::bytes;
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    files: &'a [Entry<SequenceReport>],
}

pub fn run(
    files: &[PathBuf],
    measure: &Measure,
    as_csv: bool,
    svg: Option<&Path>,
    context: &Context,
) -> Result<Exit, Failure> {
    if measure.fresh && measure.rays == 0 {
        return Err(Failure::new(Exit::Usage, "cannot compare with fresh trees without rays")
            .fact("what rays cost is what is compared, and --rays 0 traces none")
            .help("leave out --rays"));
    }
    svg.map_or(Ok(()), drawing::may_replace)?;
    let (entries, exit) = measured(files, measure, context);
    if context.terminal.json {
        context.terminal.document(&Document { schema: "bvhc.frames.v1", exit_code: exit.code(), files: &entries })?;
    }
    let reports = Entry::all_done(entries);
    if let Some(path) = svg {
        drawing::draw(path, &chart(&reports))?;
    }
    if context.terminal.json {
        return Ok(exit);
    }
    if as_csv {
        context.terminal.print(&csv(&reports))?;
    } else {
        for report in &reports {
            context.terminal.print(&text(report, &names::path(Path::new(&report.path))))?;
        }
    }
    Ok(exit)
}

/// Measure each of the files.
pub fn measured(files: &[PathBuf], measure: &Measure, context: &Context) -> (Vec<Entry<SequenceReport>>, Exit) {
    caches::each(files, context, |path| {
        cache::sound_sequence(path, &caches::options(context), &context.exec).map_err(|e| caches::failure(&e))?;
        let sequence = caches::open_sequence(path, context)?;
        let name = path.to_string_lossy().into_owned();
        let bar = Bar::new(&context.terminal, &names::path(path));
        let frames = sequence.frame_count() as u64;
        bar.phase("measuring frames of", frames);
        let done = |done| bar.set(done, frames);
        let report = SequenceReport::of(name, &sequence, measure, &context.exec, &Ear(&bar), done);
        report.map_err(|error| failure(&error, path))
    })
}

/// A build's ear for signals without its count of triangles: the bar counts frames.
pub struct Ear<'a>(pub &'a Bar);

impl Progress for Ear<'_> {
    fn is_cancelled(&self) -> bool {
        self.0.is_cancelled()
    }
}

pub fn failure(error: &FramesError, path: &Path) -> Failure {
    let unknown = |fact: String| {
        Failure::new(Exit::Usage, format!("cannot build the frames of {} anew", names::path(path)))
            .fact(fact)
            .help("leave out --against-fresh")
    };
    match error {
        FramesError::Cache(error) => caches::failure(error),
        FramesError::Build(error @ (BuildError::UnknownName { .. } | BuildError::Option { .. })) => {
            unknown(format!("META has a recipe of another version: {error}"))
        }
        FramesError::Build(error) => caches::build_failure(error),
        FramesError::NoRecipe => unknown("it has no META, so nobody knows how its trees were built".into()),
    }
}

/// A named figure of a frame, as a person reads it.
type Column = (&'static str, fn(&FrameReport) -> String);

const TEXT: [Column; 9] = [
    ("time", |f| f.time.map_or_else(dash, |time| format!("{time:.4}"))),
    ("triangles", |f| figures::count(f.instanced_triangles)),
    ("instances", |f| figures::count(f.instances)),
    ("trees", |f| figures::count(f.trees)),
    ("built", |f| if f.built == 0 { dash() } else { figures::count(f.built) }),
    ("SAH", |f| format!("{:.2}", f.sah)),
    ("ratio", |f| format!("{:.3}", f.ratio)),
    ("segment", |f| f.segment.to_string()),
    ("new", |f| if f.bytes == 0 { dash() } else { bytes(f.bytes).to_string() }),
];

/// Where rays were traced.
const RAYS: [Column; 1] = [("ray cost", |f| f.ray_cost.map_or_else(dash, |cost| format!("{cost:.2}")))];

/// Where they were traced in fresh trees too.
const FRESH: [Column; 2] = [
    ("fresh", |f| f.fresh_ray_cost.map_or_else(dash, |cost| format!("{cost:.2}"))),
    ("against fresh", |f| f.ray_ratio.map_or_else(dash, |ratio| format!("{ratio:.3}"))),
];

fn text(report: &SequenceReport, name: &str) -> String {
    let has = |cell: fn(&FrameReport) -> Option<f64>| report.frames.iter().any(|f| cell(f).is_some());
    let mut columns = TEXT.to_vec();
    if has(|f| f.ray_cost) {
        columns.extend(RAYS);
    }
    if has(|f| f.ray_ratio) {
        columns.extend(FRESH);
    }
    let mut table = Table::default();
    table.row("frame", columns.iter().map(|(label, _)| (*label).to_string()));
    for frame in &report.frames {
        let held = if frame.held { " (held)" } else { "" };
        table.row(format!("{}{held}", frame.number), columns.iter().map(|(_, cell)| cell(frame)));
    }
    let counted = figures::counted;
    let (frames, all) = (report.frames.len() as u64, bytes(report.file_len));
    let over = |name: &str, value: fn(&FrameReport) -> Option<f64>| {
        let values = report.frames.iter().filter_map(value);
        let (count, sum, most) =
            values.fold((0, 0.0, 0.0f64), |(n, sum, most), value| (n + 1, sum + value, most.max(value)));
        let mean = sum / f64::from(count.max(1));
        if count == 0 { String::new() } else { format!("; {name} {mean:.3} on average, {most:.3} at most") }
    };
    format!(
        "{}{name}: {}, {}, {}; {all}, {} a frame{}{}\n",
        table.render(),
        counted(frames, "frame", "frames"),
        counted(report.topologies, "topology", "topologies"),
        counted(report.poses, "pose", "poses"),
        bytes(report.file_len / frames.max(1)),
        over("ratio", |f| Some(f.ratio)),
        over("against fresh", |f| f.ray_ratio),
    )
}

/// A figure as a machine reads it.
const CSV: [Column; 13] = [
    ("time", |f| f.time.map_or_else(String::new, |time| time.to_string())),
    ("held", |f| f.held.to_string()),
    ("instanced_triangles", |f| f.instanced_triangles.to_string()),
    ("instances", |f| f.instances.to_string()),
    ("trees", |f| f.trees.to_string()),
    ("built", |f| f.built.to_string()),
    ("segment", |f| f.segment.to_string()),
    ("sah", |f| f.sah.to_string()),
    ("ratio", |f| f.ratio.to_string()),
    ("ray_cost", |f| maybe(f.ray_cost)),
    ("fresh_ray_cost", |f| maybe(f.fresh_ray_cost)),
    ("ray_ratio", |f| maybe(f.ray_ratio)),
    ("bytes", |f| f.bytes.to_string()),
];

fn csv(reports: &[SequenceReport]) -> String {
    let heading = csv_line(["file", "frame"].into_iter().chain(CSV.iter().map(|column| column.0)));
    let lines = reports.iter().flat_map(|report| report.frames.iter().map(move |frame| (report, frame)));
    let lines = lines.map(|(report, frame)| {
        let number = frame.number.to_string();
        let cells: Vec<String> = CSV.iter().map(|(_, cell)| cell(frame)).collect();
        let all = [report.path.as_str(), &number].into_iter().chain(cells.iter().map(String::as_str));
        csv_line(all.collect::<Vec<_>>())
    });
    std::iter::once(heading).chain(lines).collect()
}

fn maybe(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

fn dash() -> String {
    "-".to_string()
}
