//! `bvhc completions`: a completion script for a shell.

use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use clap::Args;
use clap_complete::Shell;

/// Print a completion script for a shell
///
/// For bash: bvhc completions bash > ~/.local/share/bash-completion/completions/bvhc
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

pub fn run(args: &CompletionsArgs, context: &Context) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut crate::cli::command(), "bvhc", &mut script);
    context.terminal.print(&String::from_utf8_lossy(&script))?;
    Ok(Exit::Success)
}
