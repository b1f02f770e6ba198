use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use clap::Args;

/// Not yet
#[derive(Debug, Args)]
pub struct CheckArgs {}

pub fn run(_args: &CheckArgs, _context: &Context) -> Result<Exit, Failure> {
    Err(Failure::new(Exit::Unsupported, "cannot check yet"))
}
