//! `bvhc man`: the manual pages, made from the same definitions as `--help`.

use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::names;
use clap::Args;
use std::path::{Path, PathBuf};

/// Write the manual pages, one for the tool and one a command
#[derive(Debug, Args)]
pub struct ManArgs {
    /// Folder to write to; it is made if need be
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
}

pub fn run(args: &ManArgs, context: &Context) -> Result<Exit, Failure> {
    let failed = |path: &Path, e: &std::io::Error| {
        Failure::new(Exit::Io, format!("cannot write {}", names::path(path))).fact(e.to_string())
    };
    std::fs::create_dir_all(&args.out).map_err(|e| failed(&args.out, &e))?;
    for (name, page) in pages().map_err(|e| failed(&args.out, &e))? {
        let path = args.out.join(name);
        std::fs::write(&path, page).map_err(|e| failed(&path, &e))?;
        context.terminal.result(&names::path(&path))?;
    }
    Ok(Exit::Success)
}

/// Every page with its file name, the tool's own first.
pub fn pages() -> std::io::Result<Vec<(String, Vec<u8>)>> {
    let command = crate::cli::command().disable_help_subcommand(true);
    let subcommands: Vec<clap::Command> = command.get_subcommands().filter(|c| !c.is_hide_set()).cloned().collect();
    let mut pages = vec![page("bvhc".to_string(), command)?];
    for sub in subcommands {
        let name = format!("bvhc-{}", sub.get_name());
        // Pages are looked up by the hyphenated name while the synopsis shows what is typed.
        let spaced = format!("bvhc {}", sub.get_name());
        pages.push(page(name, sub.bin_name(spaced).version(env!("CARGO_PKG_VERSION")))?);
    }
    Ok(pages)
}

fn page(name: String, command: clap::Command) -> std::io::Result<(String, Vec<u8>)> {
    let mut bytes = Vec::new();
    let upper = name.to_uppercase();
    clap_mangen::Man::new(command.name(name.clone())).title(upper).section("1").date("").render(&mut bytes)?;
    Ok((format!("{name}.1"), bytes))
}
