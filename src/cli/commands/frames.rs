//! `bvhc stats --frames`: what the frames of sequences are like.

use crate::cache;
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::cli::names;
use crate::cli::table::{Table, csv_line};
use crate::report::frames::{FrameReport, SequenceReport};
use crate::size::bytes;
use serde::Serialize;
use std::path::PathBuf;

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    files: &'a [SequenceReport],
}

pub fn run(files: &[PathBuf], as_csv: bool, context: &Context) -> Result<Exit, Failure> {
    let (reports, exit) = caches::each(files, context, |path| {
        cache::sound_sequence(path, &caches::options(context), &context.exec).map_err(|e| caches::failure(&e))?;
        let sequence = caches::open_sequence(path, context)?;
        let name = path.to_string_lossy().into_owned();
        SequenceReport::of(name, &sequence, &context.exec).map_err(|e| caches::failure(&e))
    });
    if context.terminal.json {
        context.terminal.document(&Document { schema: "bvhc.frames.v1", exit_code: exit.code(), files: &reports })?;
    } else if as_csv {
        context.terminal.print(&csv(&reports))?;
    } else {
        for (report, path) in reports.iter().zip(files) {
            context.terminal.print(&text(report, &names::path(path)))?;
        }
    }
    Ok(exit)
}

/// A named figure of a frame, as a person reads it.
type Column = (&'static str, fn(&FrameReport) -> String);

const TEXT: [Column; 8] = [
    ("time", |f| f.time.map_or_else(dash, |time| format!("{time:.4}"))),
    ("triangles", |f| figures::count(f.triangles)),
    ("instances", |f| figures::count(f.instances)),
    ("trees", |f| figures::count(f.trees)),
    ("built", |f| if f.built == 0 { dash() } else { figures::count(f.built) }),
    ("SAH", |f| format!("{:.2}", f.sah)),
    ("ratio", |f| format!("{:.3}", f.ratio)),
    ("new", |f| if f.bytes == 0 { dash() } else { bytes(f.bytes).to_string() }),
];

fn text(report: &SequenceReport, name: &str) -> String {
    let mut table = Table::default();
    table.row("frame", TEXT.iter().map(|(label, _)| (*label).to_string()));
    for frame in &report.frames {
        let held = if frame.held { " (held)" } else { "" };
        table.row(format!("{}{held}", frame.number), TEXT.iter().map(|(_, cell)| cell(frame)));
    }
    let counted = figures::counted;
    let (frames, all) = (report.frames.len() as u64, bytes(report.file_len));
    let ratios = report.frames.iter().map(|frame| frame.ratio);
    let (sum, most) = ratios.fold((0.0, 0.0f64), |(sum, most), ratio| (sum + ratio, most.max(ratio)));
    let mean = sum / frames.max(1) as f64;
    format!(
        "{}{name}: {}, {}, {}; {all}, {} a frame; ratio {mean:.3} on average, {most:.3} at most\n",
        table.render(),
        counted(frames, "frame", "frames"),
        counted(report.topologies, "topology", "topologies"),
        counted(report.poses, "pose", "poses"),
        bytes(report.file_len / frames.max(1)),
    )
}

/// A figure as a machine reads it.
const CSV: [Column; 9] = [
    ("time", |f| f.time.map_or_else(String::new, |time| time.to_string())),
    ("held", |f| f.held.to_string()),
    ("triangles", |f| f.triangles.to_string()),
    ("instances", |f| f.instances.to_string()),
    ("trees", |f| f.trees.to_string()),
    ("built", |f| f.built.to_string()),
    ("sah", |f| f.sah.to_string()),
    ("ratio", |f| f.ratio.to_string()),
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

fn dash() -> String {
    "-".to_string()
}
