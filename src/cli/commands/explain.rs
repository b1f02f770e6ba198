//! `bvhc explain`: what a finding of `check` means.

use crate::build::nearest;
use crate::cache::rules;
use crate::cli::Context;
use crate::cli::advice;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::names;
use clap::Args;
use serde::Serialize;

/// Explain a finding of `bvhc check`: what it means, how it happens, what to do
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  bvhc explain E0402\n  bvhc explain --list")]
pub struct ExplainArgs {
    /// Number or name of a rule, such as E0402 or node-child-order
    #[arg(required_unless_present = "list", value_name = "ID")]
    ids: Vec<String>,
    /// List every rule
    #[arg(long, conflicts_with = "ids")]
    list: bool,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    rules: Vec<RuleObject<'a>>,
}

#[derive(Serialize)]
struct RuleObject<'a> {
    id: &'a str,
    name: &'a str,
    severity: rules::Severity,
    headline: &'a str,
    meaning: &'a str,
    cause: &'a str,
    remedy: &'static str,
    specification: String,
    vector: String,
}

pub fn run(args: &ExplainArgs, context: &Context) -> Result<Exit, Failure> {
    let asked = args.ids.iter().map(|id| rules::find(id).ok_or_else(|| unknown(id)));
    let chosen: Vec<&rules::Rule> = if args.list { rules::all().collect() } else { asked.collect::<Result<_, _>>()? };

    if context.terminal.json {
        let document = Document { schema: "bvhc.explain.v1", rules: chosen.into_iter().map(object).collect() };
        context.terminal.document(&document)?;
    } else if args.list {
        let line = |r: &&rules::Rule| format!("{}  {:<26} {}\n", r.id, r.name, r.headline);
        context.terminal.print(&chosen.iter().map(line).collect::<String>())?;
    } else {
        let texts: Vec<String> = chosen.into_iter().map(text).collect();
        context.terminal.print(&texts.join("\n"))?;
    }
    Ok(Exit::Success)
}

fn text(rule: &rules::Rule) -> String {
    let severity = match rule.severity() {
        rules::Severity::Error => "error",
        rules::Severity::Warning => "warning",
    };
    format!(
        "{} {} ({severity})\n{}.\n\nwhat it means\n  {}\nhow it happens\n  {}\nwhat to do\n  {}\n\nspecification  format-spec/SPEC.md#{}\nexample file   {}\n",
        rule.id,
        rule.name,
        rule.headline,
        rule.meaning,
        rule.cause,
        advice::for_rule(rule.remedy),
        rule.spec,
        rule.vector()
    )
}

fn object(rule: &rules::Rule) -> RuleObject<'_> {
    RuleObject {
        id: rule.id,
        name: rule.name,
        severity: rule.severity(),
        headline: rule.headline,
        meaning: rule.meaning,
        cause: rule.cause,
        remedy: advice::for_rule(rule.remedy),
        specification: format!("format-spec/SPEC.md#{}", rule.spec),
        vector: rule.vector(),
    }
}

fn unknown(id: &str) -> Failure {
    let failure = Failure::new(Exit::Usage, format!("cannot explain {}", names::escape(id)))
        .fact("no rule has this number or name");
    // Letters that pass for digits.
    let number = id.to_ascii_uppercase().replace('O', "0").replace(['I', 'L'], "1");
    if let Some(rule) = rules::find(&number) {
        return failure.help(format!("did you mean {}? bvhc explain --list shows all of them", rule.id));
    }
    // Of numbers the neighbour is as near as what was meant.
    let choices: Vec<&str> = rules::all().map(|rule| rule.name).collect();
    failure.help(match nearest(&id.to_ascii_lowercase(), &choices) {
        Some(name) => format!("did you mean {name}? bvhc explain --list shows all of them"),
        None => "bvhc explain --list shows all of them".to_owned(),
    })
}
