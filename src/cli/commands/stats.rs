use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use clap::Args;

/// Not yet
#[derive(Debug, Args)]
pub struct StatsArgs {}

pub fn run(_args: &StatsArgs, _context: &Context) -> Result<Exit, Failure> {
    Err(Failure::new(Exit::Unsupported, "cannot stats yet"))
}
