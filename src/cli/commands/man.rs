//! `bvhc man`: the manual pages, made from the same definitions as `--help`.

use crate::cli::Context;
use crate::cli::drawing;
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
    if args.out.as_os_str() == "-" {
        return Err(Failure::new(Exit::Usage, "cannot write manual pages to standard output")
            .fact("they are several files")
            .help("name a folder; one that is called - is ./-"));
    }
    std::fs::create_dir_all(&args.out).map_err(|e| failed(&args.out, &e))?;
    for (name, page) in pages().map_err(|e| failed(&args.out, &e))? {
        let path = args.out.join(name);
        drawing::may_replace(&path)?;
        drawing::put(&path, "the manual page", &page)?;
        if !context.terminal.quiet {
            context.terminal.result(&names::path(&path))?;
        }
    }
    Ok(Exit::Success)
}

/// Every page with its file name, the tool's own first.
pub fn pages() -> std::io::Result<Vec<(String, Vec<u8>)>> {
    // Building the whole definition first hands the global flags down to the commands.
    let mut command = crate::cli::command().disable_help_subcommand(true);
    command.build();
    let subcommands: Vec<clap::Command> = command.get_subcommands().filter(|c| !c.is_hide_set()).cloned().collect();
    std::iter::once(command).chain(subcommands).map(page).collect()
}

fn page(command: clap::Command) -> std::io::Result<(String, Vec<u8>)> {
    let title = command.get_display_name().unwrap_or_else(|| command.get_name()).to_uppercase();
    let man = clap_mangen::Man::new(command).title(title).source(concat!("bvhc ", env!("CARGO_PKG_VERSION")));
    let mut bytes = Vec::new();
    man.render(&mut bytes)?;
    Ok((man.get_filename(), bytes))
}
