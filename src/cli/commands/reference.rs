//! `bvhc reference` (hidden): the tables of README.md and docs/, made from the code.
//!
//! A block in a Markdown file stands between `<!-- generated: NAME -->` and `<!-- end generated -->`. `--update FILE` writes
//! every block anew; `--check FILE` exits with 1 if one differs.

use super::build::options::{listing, preset_lines};
use crate::build::{METHODS, OPTIONS, Spelling};
use crate::cli::Context;
use crate::cli::exit::{self, Exit};
use crate::cli::failure::Failure;
use crate::cli::names;
use crate::scene::{GLTF_EXTENSIONS, Treatment};
use clap::Args;
use std::path::{Path, PathBuf};

/// Print the generated tables of the documentation, or bring them up to date in a file
#[derive(Debug, Args)]
pub struct ReferenceArgs {
    /// Print only this block
    block: Option<String>,
    /// Write every block in this file anew
    #[arg(long, value_name = "FILE", conflicts_with_all = ["block", "check"])]
    update: Option<PathBuf>,
    /// Exit with 1 if a block in this file is not up to date
    #[arg(long, value_name = "FILE", conflicts_with = "block")]
    check: Option<PathBuf>,
}

const END: &str = "<!-- end generated -->";

pub fn run(args: &ReferenceArgs, context: &Context) -> Result<Exit, Failure> {
    let Some(path) = args.update.as_ref().or(args.check.as_ref()) else {
        for (name, text) in blocks().into_iter().filter(|(name, _)| args.block.as_ref().is_none_or(|b| b == name)) {
            context.terminal.print(&format!("<!-- generated: {name} -->\n{text}{END}\n"))?;
        }
        return Ok(Exit::Success);
    };
    let failed = |verb: &str, e: &std::io::Error| {
        Failure::new(Exit::Io, format!("cannot {verb} {}", names::path(path))).fact(e.to_string())
    };
    let old = std::fs::read_to_string(path).map_err(|e| failed("read", &e))?;
    let new = updated(&old, path)?;
    if args.check.is_some() {
        return Ok(if old == new { Exit::Success } else { Exit::Negative });
    }
    std::fs::write(path, new).map_err(|e| failed("write", &e))?;
    Ok(Exit::Success)
}

/// Every block by name.
pub fn blocks() -> Vec<(&'static str, String)> {
    vec![
        ("commands", commands()),
        ("exit-codes", exit::markdown_table()),
        ("gltf-extensions", gltf_extensions()),
        ("methods", methods()),
        ("options", options()),
        ("presets", presets()),
        ("tree-options", tree_options()),
    ]
}

/// The text with every block replaced by what the code says now.
pub fn updated(text: &str, path: &Path) -> Result<String, Failure> {
    let blocks = blocks();
    let (mut out, mut rest) = (String::new(), text);
    while let Some(start) = rest.find("<!-- generated: ") {
        let tail = &rest[start..];
        let name = tail.trim_start_matches("<!-- generated: ").split(" -->").next().unwrap_or_default();
        let block = blocks.iter().find(|(n, _)| *n == name);
        let (Some((name, new)), Some(end)) = (block, tail.find(END)) else {
            return Err(Failure::new(Exit::Usage, format!("cannot update {}", names::path(path)))
                .fact(format!("the block {} is unknown or has no end", names::escape(name)))
                .help("bvhc reference prints all blocks"));
        };
        out.push_str(&rest[..start]);
        out.push_str(&format!("<!-- generated: {name} -->\n{new}{END}"));
        rest = &tail[end + END.len()..];
    }
    out.push_str(rest);
    Ok(out)
}

fn commands() -> String {
    let mut text = String::from("| command | does |\n|---|---|\n");
    for command in crate::cli::command().get_subcommands().filter(|c| !c.is_hide_set()) {
        let about = command.get_about().map(ToString::to_string).unwrap_or_default();
        text.push_str(&format!("| `bvhc {}` | {about} |\n", command.get_name()));
    }
    text
}

/// What reading does with a glTF extension that a file requires.
fn gltf_extensions() -> String {
    let mut text = String::from("| extension | is | because |\n|---|---|---|\n");
    for row in GLTF_EXTENSIONS {
        let treatment = match row.treatment {
            Treatment::Honoured => "honoured",
            Treatment::Decoded => "refused where used",
            Treatment::Refused => "refused",
            Treatment::Played => "refused where played",
            Treatment::Passed => "passed over",
        };
        text.push_str(&format!("| `{}` | {treatment} | {} |\n", row.name, row.why));
    }
    text
}

/// The flags of `build`, in the order of its help, but for those of the table of options.
fn options() -> String {
    let mut text = String::from("| flag | default | meaning |\n|---|---|---|\n");
    let command = crate::cli::command();
    let Some(build) = command.find_subcommand("build") else { return text };
    let in_table = |name: &str| OPTIONS.iter().any(|row| row.spelling == Spelling::Flag && row.name == name);
    for arg in build.get_arguments().filter(|a| !a.is_hide_set() && !in_table(a.get_id().as_str())) {
        let short = arg.get_short().map(|c| format!("-{c}"));
        let names: Vec<String> = short.into_iter().chain(arg.get_long().map(|long| format!("--{long}"))).collect();
        if names.is_empty() {
            continue;
        }
        let values: Vec<String> = arg.get_possible_values().iter().map(|v| v.get_name().to_string()).collect();
        let takes = arg.get_action().takes_values();
        let value = match arg.get_value_names() {
            _ if !takes => String::new(),
            _ if !values.is_empty() => format!(" {}", values.join("\\|")),
            Some(names) => format!(" {}", names.join(" ").replace('|', "\\|")),
            None => String::new(),
        };
        let default = arg.get_default_values().iter().map(|v| v.to_string_lossy()).collect::<Vec<_>>().join(" ");
        let default = if takes { default } else { String::new() };
        let help = arg.get_help().map(ToString::to_string).unwrap_or_default().replace('|', "\\|");
        text.push_str(&format!("| `{}{value}` | {default} | {help} |\n", names.join("`, `")));
    }
    text
}

/// The table of options.
fn tree_options() -> String {
    let mut text = String::from("| option | values | default | meaning |\n|---|---|---|---|\n");
    for row in OPTIONS {
        let typed = match row.spelling {
            Spelling::Flag => format!("--{}", row.name),
            Spelling::Setting => format!("-O {}=", row.name),
        };
        let (range, defaults) = (row.kind.range(), listing::defaults(row));
        text.push_str(&format!("| `{typed}` | {range} | {defaults} | {}. {} |\n", row.help, row.details));
    }
    text
}

/// The ways to build a tree, and the options that each of them reads.
fn methods() -> String {
    let mut text = String::from("| `--method` | trees | reads |\n|---|---|---|\n");
    for row in METHODS {
        let read = OPTIONS.iter().filter(|option| option.is_read_by(row.method));
        let options: Vec<String> = read.map(|option| format!("`{}`", option.name)).collect();
        text.push_str(&format!("| `{}` | {} | {} |\n", row.name, row.summary, options.join(" ")));
    }
    text
}

fn presets() -> String {
    let mut text = String::from("| preset | stands for |\n|---|---|\n");
    for (name, flags) in preset_lines() {
        text.push_str(&format!("| `{name}` | `{flags}` |\n"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_replaced_and_all_else_stays() {
        let old = format!("a\n<!-- generated: exit-codes -->\nold\n{END}\nb\n");
        let new = updated(&old, Path::new("x")).unwrap();
        assert!(
            new.starts_with("a\n<!-- generated: exit-codes -->\n| code |") && new.ends_with(&format!("{END}\nb\n"))
        );
        assert_eq!(updated(&new, Path::new("x")).unwrap(), new);
        assert!(updated("<!-- generated: nonsense -->", Path::new("x")).is_err());
    }
}
