//! The table of options for people: what `-O help` prints, and what is said to who types an option that has no flag as one.

use crate::build::{BuildOptions, Kind, OPTIONS, OptionInfo, PRESETS, Preset, Spelling, nearest, option};
use crate::cli::advice;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, Error};

/// Marks the error that ends a parse where the list was asked for. Help ends a parse as an error, too.
const ASKED: &str = "-O help";

pub fn asked_for() -> Error {
    let mut error = Error::new(ErrorKind::DisplayHelp);
    error.insert(ContextKind::InvalidValue, ContextValue::String(ASKED.to_string()));
    error
}

/// Whether the parse ended because the list was asked for.
pub fn is_asked_for(error: &Error) -> bool {
    error.kind() == ErrorKind::DisplayHelp
        && matches!(error.get(ContextKind::InvalidValue), Some(ContextValue::String(text)) if text == ASKED)
}

/// Every option with its values, defaults and readers, as wide as the terminal. Clap lays it out as it lays out a list of commands.
pub fn text() -> String {
    let rows = OPTIONS.iter().map(|row| Command::new(format!("{}={}", row.name, row.placeholder)).about(about(row)));
    let list = Command::new("options")
        .disable_help_subcommand(true)
        .max_term_width(110)
        .help_template("Options of trees, each set with -O NAME=VALUE or by its flag:\n{subcommands}\n")
        .subcommands(rows);
    list.clone().render_help().to_string()
}

fn about(row: &OptionInfo) -> String {
    let flag = match row.spelling {
        Spelling::Flag => format!("flag --{}; ", row.name),
        Spelling::Setting => String::new(),
    };
    format!(
        "{} [{flag}values: {}; default: {}; read by: {}]",
        row.help,
        row.kind.range(),
        defaults(row),
        row.readers_in_words()
    )
}

/// The value in the default preset, and those in others that have another and a method that reads it.
pub fn defaults(row: &OptionInfo) -> String {
    let usual = row.default_in(Preset::Auto);
    let reads = |preset| row.is_read_by(BuildOptions::preset(preset).method);
    let others = PRESETS.iter().filter(|p| reads(p.preset) && row.default_in(p.preset) != usual);
    std::iter::once(usual.clone())
        .chain(others.map(|p| format!("{} in {}", row.default_in(p.preset), p.name)))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Flags that have another name now, with that and their values.
const RENAMED: [(&str, &str, &str); 1] = [("--animation", "--clip", "NAME|NUMBER")];

/// What to type instead of a flag that there is not, if it was renamed, or meant for an option without one.
pub fn instead_of(error: &Error) -> Option<Failure> {
    let context = |kind| error.get(kind).map(ToString::to_string).unwrap_or_default();
    if error.kind() != ErrorKind::UnknownArgument || !context(ContextKind::Usage).contains("bvhc build") {
        return None;
    }
    let typed = context(ContextKind::InvalidArg);
    if let Some((_, now, value)) = RENAMED.iter().find(|(flag, ..)| *flag == typed) {
        let failure = Failure::new(Exit::Usage, format!("cannot read {typed}"));
        return Some(failure.fact(format!("it is called {now} now")).help(format!("write {now} {value}")));
    }
    let word = typed.strip_prefix("--")?;
    let (word, switched) = word.strip_prefix("no-").map_or((word, "true"), |word| (word, "false"));

    // Clap knows the flags alone; what it suggests may be farther from the word than an option without one.
    let suggested = context(ContextKind::SuggestedArg);
    let without_flag = OPTIONS.iter().filter(|row| row.spelling == Spelling::Setting);
    let choices: Vec<&str> = without_flag.map(|row| row.name).chain([suggested.trim_start_matches('-')]).collect();
    let row = nearest(word, &choices).and_then(option).filter(|row| row.spelling == Spelling::Setting)?;
    let value = if matches!(row.kind, Kind::Switch) { switched } else { row.placeholder };
    let fact = format!("{} is an option without a flag of its own", row.name);
    Some(
        Failure::new(Exit::Usage, format!("cannot read {typed}"))
            .fact(if word == row.name { fact } else { format!("there is no such flag; {fact}") })
            .help(format!("write {}; bvhc build -O help lists all options", advice::typed(row, value))),
    )
}
