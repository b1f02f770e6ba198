//! `bvhc stats --compare`: what changed from one file to another, with a verdict for CI.

use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::cli::names;
use crate::cli::table::Table;
use crate::report::metrics::{Change, Condition, NoCondition, Side, Verdict, metric_names};
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    exit_code: u8,
    before: &'a str,
    after: &'a str,
    changes: &'a [Change],
    verdicts: &'a [Verdict],
}

/// The reading of `--fail-if`.
pub fn parse_condition(text: &str) -> Result<Condition, String> {
    Condition::parse(text).map_err(|error| match error {
        NoCondition::Form => format!(
            "`{}` is no condition; write a figure, one of > >= < <=, and a number, such as 'ray-cost > +2%' or 'depth > 40'",
            names::escape(text)
        ),
        NoCondition::Sign => format!(
            "`{}` has a share without a sign; shares are of the change: +10% for a tenth more, -10% for a tenth less",
            names::escape(text)
        ),
        NoCondition::Metric => {
            format!("`{}` is about no known figure; there are {}", names::escape(text), metric_names().join(", "))
        }
    })
}

/// Print the changes, and fail where a condition holds. `triangles` are those that rays can hit.
pub fn run(
    changes: &[Change],
    triangles: [u64; 2],
    paths: &[PathBuf],
    conditions: &[Condition],
    context: &Context,
) -> Result<Exit, Failure> {
    let [before, after] = paths else { return Ok(Exit::Success) };
    if triangles[0] != triangles[1] {
        let [a, b] = triangles.map(figures::count);
        context.terminal.warn(&format!(
            "rays can hit {a} and {b} triangles: figures of different models say nothing of their trees"
        ));
    }
    let mut verdicts = Vec::new();
    for condition in conditions {
        let Some(verdict) = condition.judge(changes) else {
            return Err(Failure::new(Exit::Usage, format!("cannot judge `{}`", condition.text))
                .fact(format!("{} was not measured", condition.metric))
                .help("figures of rays need --rays N above 0, EPO needs another --epo than off, and sequences have other figures than still files"));
        };
        verdicts.push(verdict);
    }
    let exit = if verdicts.iter().any(|verdict| verdict.holds) { Exit::Worse } else { Exit::Success };
    if context.terminal.json {
        context.terminal.document(&Document {
            schema: "bvhc.stats-compare.v1",
            exit_code: exit.code(),
            before: &before.to_string_lossy(),
            after: &after.to_string_lossy(),
            changes,
            verdicts: &verdicts,
        })?;
    } else {
        context.terminal.print(&text(changes, &verdicts, paths))?;
    }
    Ok(exit)
}

fn text(changes: &[Change], verdicts: &[Verdict], paths: &[PathBuf]) -> String {
    let mut table = Table::default();
    let files = names::headings(&paths.iter().map(PathBuf::as_path).collect::<Vec<&Path>>());
    table.row("", files.into_iter().chain(["change".to_string()]));
    for change in changes {
        let cell = match change.relative {
            Some(0.0) => "=".to_string(),
            Some(relative) => format!("{:+.2} %", 100.0 * relative),
            None => format!("{:+}", round(change.change)),
        };
        table.row(change.metric, [number(change.before), number(change.after), cell]);
    }
    let mut text = table.render();
    for verdict in verdicts {
        let told = if verdict.holds { "FAILED" } else { "passed" };
        text.push_str(&format!("\n{}: {told} ({})", names::escape(&verdict.condition), found(verdict)));
    }
    if !verdicts.is_empty() {
        text.push('\n');
    }
    text
}

/// What was held against a condition's number.
fn found(verdict: &Verdict) -> String {
    match (verdict.of, verdict.value) {
        (_, None) => format!("{} was 0 before, and is not now", verdict.metric),
        (Side::Relative, Some(value)) => format!("it changed by {:+.2} %", 100.0 * value),
        (Side::Change, Some(value)) => format!("it changed by {:+}", round(value)),
        (Side::After, Some(value)) => format!("it is {}", number(value)),
    }
}

fn number(value: f64) -> String {
    if value == value.trunc() && value.abs() < 1e15 { figures::count(value as u64) } else { round(value).to_string() }
}

/// Four digits behind the point.
fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}
