//! `bvhc check`: the verdict on a file, with every finding.

mod frames;

use crate::cache::check::{Finding, Level, Limits, Report, Source, check_bytes};
use crate::cache::{FileBytes, Head, SectionKind, View, rules, tree_flags};
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::{Entry, Failure};
use crate::cli::figures;
use crate::cli::names;
use crate::cli::patterns;
use crate::cli::source::{self, SourceReading, Stated};
use crate::cli::terminal::Paint;
use crate::compile;
use crate::scene::Scene;
use crate::verify::placed;
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Prove that cache files are intact and well formed
///
/// Collects every finding, each with a number that `bvhc explain` explains. Exit code 0: valid; 1: not.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  bvhc check rock.bvhc\n  bvhc check rock.bvhc --source rock.glb\n  bvhc check heli.bvhc --source 'heli.%04d.obj'\n  bvhc check *.bvhc --level hash --json"
)]
pub struct CheckArgs {
    /// Cache files, folders of them, or quoted patterns such as 'caches/**/*.bvhc'
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// How deep to look; each level includes those before it [default: tree, or source with --source]
    #[arg(long, value_enum)]
    level: Option<LevelName>,
    /// The model that the file should hold; of a sequence the glTF model with its clip, or a quoted pattern such as 'heli.%04d.obj'
    #[arg(long, value_name = "MODEL")]
    source: Option<PathBuf>,
    #[command(flatten)]
    reading: SourceReading,
    /// Take warnings for errors
    #[arg(long)]
    warnings_as_errors: bool,
    /// Findings to show for each rule; all are counted
    #[arg(long, value_name = "N", default_value_t = 20)]
    max_issues: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LevelName {
    /// Header, section table, sizes, file id
    Quick,
    /// And the hash of every section
    Hash,
    /// And every record: tree shape, boxes, triangles, instances
    Tree,
    /// And every triangle against the model (needs --source)
    Source,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    files: &'a [Entry<Verdict>],
}

#[derive(Serialize)]
struct Verdict {
    path: String,
    /// No error, and with --warnings-as-errors no warning either.
    valid: bool,
    /// Of a kind that this version cannot read, rather than broken.
    unsupported: bool,
    /// The only trouble is `--max-memory`: nothing is known against the file.
    over_limit: bool,
    errors: u64,
    warnings: u64,
    findings: Vec<Finding>,
    /// Findings that were counted but not kept.
    truncated: u64,
    not_checked: Vec<String>,
}

pub fn run(args: &CheckArgs, context: &Context) -> Result<Exit, Failure> {
    args.reading.suits(args.source.as_ref())?;
    let level = level(args)?;
    let (mut verdicts, mut exits) = (Vec::new(), Vec::new());
    for path in &patterns::expand(&args.files, patterns::CACHES, "check", &context.terminal)? {
        match check(path, level, args, context) {
            Ok(report) => {
                let (verdict, exit) = judge(path, report, args);
                if !context.terminal.json && !context.terminal.quiet {
                    context.terminal.print(&text(&verdict, path, level, context))?;
                }
                verdicts.push(Entry::Done(verdict));
                exits.push(exit);
            }
            Err(failure) => {
                context.terminal.error(&failure);
                exits.push(failure.exit);
                verdicts.push(Entry::failed(path, None, &failure));
            }
        }
    }
    let exit = Exit::combine_verdicts(&exits);
    if context.terminal.json {
        context.terminal.document(&Document { schema: "bvhc.check.v1", exit_code: exit.code(), files: &verdicts })?;
    }
    Ok(exit)
}

fn level(args: &CheckArgs) -> Result<Level, Failure> {
    match (args.level, &args.source) {
        (Some(level), Some(_)) if level != LevelName::Source => {
            Err(Failure::new(Exit::Usage, "cannot check against the source at a lower level")
                .fact("--source names a model, and only --level source reads it")
                .help("leave out --level, or --source"))
        }
        (None, None) | (Some(LevelName::Tree), _) => Ok(Level::Tree),
        (None, Some(_)) | (Some(LevelName::Source), Some(_)) => Ok(Level::Source),
        (Some(LevelName::Quick), _) => Ok(Level::Quick),
        (Some(LevelName::Hash), _) => Ok(Level::Hash),
        (Some(LevelName::Source), None) => Err(Failure::new(Exit::Usage, "cannot check against the source")
            .fact("--level source compares with a model, and none is named")
            .help("name the model: --source MODEL")),
    }
}

fn check(path: &Path, level: Level, args: &CheckArgs, context: &Context) -> Result<Report, Failure> {
    let bytes = FileBytes::open(path, &caches::options(context)).map_err(|e| caches::failure(&e))?;
    let bytes = bytes.as_slice();
    let limits = Limits { max_issues: args.max_issues, max_memory: context.global.max_memory };
    let Some(model) = args.source.as_ref().filter(|_| level == Level::Source) else {
        return Ok(check_bytes(bytes, level, None, &limits, &context.exec));
    };

    // What is no cache file needs no model to be told so.
    let Ok(head) = Head::read(path, &caches::options(context)) else {
        return Ok(check_bytes(bytes, level, None, &limits, &context.exec));
    };
    if head.header.has(tree_flags::SEQUENCE) {
        return frames::check(path, bytes, model, args, &limits, context);
    }
    let model = &patterns::one(model, patterns::MODELS, "compare with", &context.terminal)?;
    let two_levels = head.header.has(tree_flags::TWO_LEVEL);
    let has_vertices = head.sections.iter().any(|section| section.kind == SectionKind::VERT);
    let stated = Stated { meta: head.meta.as_ref(), two_levels, has_vertices };
    let mut first = None;
    for (read, build) in args.reading.ways(path, stated, context)? {
        let scene = source::read(model, &read, &build, context)?;
        let (inputs, left_out, in_f64) = (scene.inputs.clone(), scene.report.clone(), scene.clone());
        let laid = compile::lay_out(scene, &build, &context.exec).map_err(|e| caches::build_failure(&e))?;
        let source = Source {
            meshes: &laid.meshes,
            instances: laid.instances.as_deref(),
            inputs: &inputs,
            report: Some(&left_out),
        };
        let report = check_bytes(bytes, level, Some(&source), &limits, &context.exec);
        if report.is_valid() {
            let cache = caches::open(path, context)?;
            warn_of_rounding(path, &cache.view(), &in_f64, context);
            return Ok(report);
        }
        first.get_or_insert(report);
    }
    first.ok_or_else(|| Failure::new(Exit::Internal, "no way to read the model was tried"))
}

/// A file is held against its model as rounding to f32 makes it. Where that bends the model, `verify`, which knows it in f64, calls the file wrong.
/// Whether it does.
fn warn_of_rounding(path: &Path, view: &View<'_>, model: &Scene, context: &Context) -> bool {
    let placed = placed(view, model, &context.exec);
    if placed.is_right() {
        return false;
    }
    context.terminal.warn(&format!(
        "{} holds the model as rounding to f32 has bent it, by up to {:.3e}: bvhc verify --source calls its hits wrong",
        names::path(path),
        placed.loss.farthest.max(placed.read.farthest)
    ));
    true
}

fn judge(path: &Path, report: Report, args: &CheckArgs) -> (Verdict, Exit) {
    let valid = if args.warnings_as_errors { report.is_clean() } else { report.is_valid() };
    let over_limit = report.errors() > 0 && report.errors() == report.count(&rules::E0127);
    let exit = match (valid, report.is_unsupported()) {
        (true, _) => Exit::Success,
        (false, true) => Exit::Unsupported,
        (false, false) if over_limit => Exit::Limit,
        (false, false) => Exit::Negative,
    };
    let verdict = Verdict {
        path: path.to_string_lossy().into_owned(),
        valid,
        unsupported: report.is_unsupported(),
        over_limit,
        errors: report.errors(),
        warnings: report.warnings(),
        truncated: report.truncated(),
        not_checked: report.not_checked,
        findings: report.findings,
    };
    (verdict, exit)
}

fn text(verdict: &Verdict, path: &Path, level: Level, context: &Context) -> String {
    let terminal = &context.terminal;
    let name = names::path(path);
    let word = match (verdict.valid, verdict.unsupported) {
        (true, _) => terminal.paint(Paint::Green, "valid"),
        (false, true) => terminal.paint(Paint::Yellow, "unsupported"),
        (false, false) if verdict.over_limit => terminal.paint(Paint::Yellow, "not judged"),
        (false, false) => terminal.paint(Paint::Red, "invalid"),
    };
    let level = match level {
        Level::Quick => "container only",
        Level::Hash => "container and hashes",
        Level::Tree => "container, hashes and every record",
        _ => "container, hashes, every record and the source",
    };
    let counted = |n: u64, what: &str| format!("{} {what}{}", figures::count(n), if n == 1 { "" } else { "s" });
    let counts: Vec<String> = [(verdict.errors, "error"), (verdict.warnings, "warning")]
        .into_iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, what)| counted(n, what))
        .collect();
    let summary = if counts.is_empty() { level.to_string() } else { counts.join(", ") };
    let mut text = format!("{name}: {word} ({summary})\n");
    for finding in &verdict.findings {
        text.push_str(&format!("{}\n", names::escape(&finding.to_string())));
    }
    if verdict.truncated > 0 {
        let count = figures::count(verdict.truncated);
        text.push_str(&format!("… and {count} more of the same; --max-issues shows them\n"));
    }
    for what in &verdict.not_checked {
        text.push_str(&format!("not checked: {}\n", names::escape(what)));
    }
    if let Some(first) = verdict.findings.first() {
        text.push_str(&format!("more: bvhc explain {}\n", first.rule.id));
        let remedy = match (verdict.valid, verdict.over_limit) {
            (true, _) => return text,
            (false, false) if first.rule.id == "E0102" => caches::MAKE_ONE.to_string(),
            (false, false) if verdict.findings.iter().all(|f| f.rule.id.starts_with("E06")) => format!(
                "the file is sound by itself, so it was built from another model or from this one before it changed: bvhc build MODEL -o {name}"
            ),
            (false, true) => "if you trust the file: --max-memory 32G".to_string(),
            (false, false) => format!("rebuild: bvhc build MODEL -o {name} --force"),
        };
        text.push_str(&format!("help: {remedy}\n"));
    }
    text
}
