//! Flags that say nothing about what is charted: they are refused, since a run that leaves them aside is not the one that was asked for.

use super::ChartArgs;
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::names;

/// Of the flags alone, before anything is read. What clap refuses by itself is in `cli::usage`: it lets a flag pass that needs `--stability` where a model
/// stands in its place.
pub fn flags(args: &ChartArgs) -> Result<(), Failure> {
    if args.stability.is_none() && args.sizes.is_some() {
        return Err(Failure::new(Exit::Usage, "cannot take --sizes without --stability")
            .fact("it is the size of scenes that are made, and a model has its own")
            .help(
                "leave out --sizes, or judge the scenes that builders fail on: bvhc chart --stability --sizes 700,2100",
            ));
    }
    Ok(())
}

/// Of what is charted, once patterns are files: the frames of sequences have trees already.
pub fn inputs(args: &ChartArgs, context: &Context) -> Result<(), Failure> {
    let given = [
        (!args.recipes.is_empty(), "--recipe"),
        (!args.peers.is_empty(), "--peer"),
        (args.rounds.is_some(), "--rounds"),
        (args.accuracy_rays.is_some(), "--accuracy-rays"),
    ];
    let given = given.iter().find_map(|(is_given, flag)| is_given.then_some(*flag)).or(args.reading.first_given());
    let Some(flag) = given else { return Ok(()) };
    // Beside a model, it is about the model.
    let Some(first) = args.models.first() else { return Ok(()) };
    if !args.models.iter().all(|path| caches::is_sequence(path, context)) {
        return Ok(());
    }
    Err(Failure::new(Exit::Usage, format!("cannot chart {} with {flag}", names::path(first)))
        .fact("its frames have trees already, and nothing is read, built or judged anew")
        .help(format!("leave out {flag}, or name the models that the sequence was built from")))
}
