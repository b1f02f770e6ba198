//! The command line: one file a command, and what they share.
//!
//! | file | holds |
//! |---|---|
//! | `args` | what can be typed |
//! | `commands/` | one command a file |
//! | `exit` | the exit codes, the only table of them |
//! | `failure` | errors as the user reads them, text and JSON |
//! | `settings` | the global flags, or what the environment says in their place |
//! | `usage` | what clap says only in part of a wrong command line |
//! | `terminal` | the two streams, colour, quiet and verbose |
//! | `names`, `figures` | foreign names and numbers as text |
//! | `reading`, `source` | flags that say how a model is read, to build it or to compare a file with it |
//! | `progress`, `interrupt` | the bar, and what a signal does |
//! | `patterns`, `numbered` | patterns of files that the shell left alone, and of numbered files |
//! | `outputs`, `identity` | where outputs may be written, and whether two paths lead to one file |
//! | `depfile` | dependencies for Ninja and Make |
//! | `drawing` | charts and pictures as files |
//!
//! Results go to stdout; progress, warnings and errors go to stderr.

mod advice;
mod args;
mod caches;
pub mod commands;
mod depfile;
mod drawing;
pub mod exit;
mod failure;
mod figures;
mod frame_list;
mod heap;
mod identity;
mod interrupt;
mod names;
mod numbered;
mod outputs;
mod paragraph;
mod patterns;
mod progress;
mod reading;
mod settings;
mod source;
mod table;
mod terminal;
mod usage;

use crate::exec::{Executor, ThreadsError};
use args::{Cli, Command};
use clap::{CommandFactory, FromArgMatches};
use commands::build::options::listing;
use exit::Exit;
use failure::Failure;
use settings::Settings;
use std::ffi::OsString;
use std::sync::{Mutex, PoisonError};
use terminal::Terminal;

/// What every command is given: where it talks to, and the global flags.
pub struct Context {
    terminal: Terminal,
    global: Settings,
    /// The threads of `--jobs`, for everything that the command does.
    exec: Executor,
}

impl Context {
    /// For one of several pieces of work that are done side by side: its own thread alone, a share of the memory, and no bar.
    fn share(&self, of: usize) -> Context {
        let max_memory = self.global.max_memory / of.max(1) as u64;
        Context {
            terminal: self.terminal.still(),
            global: Settings { max_memory, ..self.global.clone() },
            exec: Executor::sequential(),
        }
    }
}

/// The clap definition with generated texts filled in.
pub fn command() -> clap::Command {
    Cli::command()
}

/// Parse, run, report: everything between the operating system's arguments and its exit status.
pub fn run(args: Vec<OsString>) -> Exit {
    let json = args.iter().any(|a| a == "--json");
    let parsed =
        command().try_get_matches_from(&args).and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, matches)));
    let (cli, matches) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => return report_usage(&error, json),
    };
    if let Err(failure) = usage::without_partner(&matches) {
        Terminal::new(cli.global.color.unwrap_or(terminal::ColorChoice::Auto), false, 0, json).error(&failure);
        return failure.exit;
    }
    let variable = |name: &str| std::env::var_os(name).map(|value| value.to_string_lossy().into_owned());
    let global = match Settings::new(&cli.global, variable) {
        Ok(global) => global,
        Err(failure) => {
            Terminal::new(cli.global.color.unwrap_or(terminal::ColorChoice::Auto), false, 0, json).error(&failure);
            return failure.exit;
        }
    };
    let terminal = Terminal::new(global.color, global.quiet, global.verbose, global.json);
    note_panics();
    let outcome = guarded(|| {
        heap::keep_little();
        interrupt::install(terminal)?;
        let exec = Executor::new(global.jobs).map_err(|e| threads_failure(&e))?;
        let context = Context { terminal, global, exec };
        // Inside, so that no operation has to wait for the way in.
        context.exec.run(|| dispatch(&cli.command, &context))
    });
    outcome.unwrap_or_else(|failure| {
        terminal.error(&failure);
        failure.exit
    })
}

fn threads_failure(error: &ThreadsError) -> Failure {
    Failure::new(Exit::Io, format!("cannot start {} threads", error.jobs))
        .fact(error.reason.clone())
        .help("ask for fewer with --jobs")
}

fn dispatch(command: &Command, context: &Context) -> Result<Exit, Failure> {
    if let (true, Some(what)) = (context.terminal.json, command.without_document()) {
        return Err(Failure::new(Exit::Usage, "cannot write a JSON document").fact(what).help("leave out --json"));
    }
    match command {
        Command::Build(args) => commands::build::run(args, context),
        Command::Info(args) => commands::info::run(args, context),
        Command::Stats(args) => commands::stats::run(args, context),
        Command::Check(args) => commands::check::run(args, context),
        Command::Verify(args) => commands::verify::run(args, context),
        Command::View(args) => commands::view::run(args, context),
        Command::Chart(args) => commands::chart::run(args, context),
        Command::Convert(args) => commands::convert::run(args, context),
        Command::Explain(args) => commands::explain::run(args, context),
        Command::Completions(args) => commands::completions::run(args, context),
        Command::Man(args) => commands::man::run(args, context),
        Command::Reference(args) => commands::reference::run(args, context),
    }
}

/// Help and version go to stdout and are fine; anything else that clap has to say is a usage error.
fn report_usage(error: &clap::Error, json: bool) -> Exit {
    let terminal = Terminal::new(terminal::ColorChoice::Auto, false, 0, json);
    if listing::is_asked_for(error) {
        return match terminal.print(&listing::text()) {
            Ok(()) => Exit::Success,
            Err(failure) => {
                terminal.error(&failure);
                failure.exit
            }
        };
    }
    if let Some(failure) = listing::instead_of(error).or_else(|| usage::instead_of(error)) {
        terminal.error(&failure);
        return Exit::Usage;
    }
    if json && error.use_stderr() {
        let text = error.render().to_string();
        let mut lines = text.lines().filter(|l| !l.trim().is_empty());
        let action = lines.next().unwrap_or_default().trim_start_matches("error: ");
        let failure = lines.fold(Failure::new(Exit::Usage, action), |f, line| f.fact(line.trim()));
        Terminal::new(terminal::ColorChoice::Never, false, 0, true).error(&failure);
        return Exit::Usage;
    }
    // A closed pipe is the only way in which this fails, and then there is nobody to tell.
    let _ = error.print();
    if error.use_stderr() { Exit::Usage } else { Exit::Success }
}

/// Where the last panic was, for the report; the default hook would print it in its own form.
static PANIC_PLACE: Mutex<Option<String>> = Mutex::new(None);

fn note_panics() {
    std::panic::set_hook(Box::new(|info| {
        let place = info.location().map(|l| format!("{}:{}", l.file(), l.line()));
        *PANIC_PLACE.lock().unwrap_or_else(PoisonError::into_inner) = place;
        if std::env::var_os("RUST_BACKTRACE").is_some_and(|v| v != "0") {
            eprintln!("{}", std::backtrace::Backtrace::force_capture());
        }
    }));
}

/// Run a command; a panic, which is always a bug, becomes a failure that asks for a report.
fn guarded(run: impl FnOnce() -> Result<Exit, Failure>) -> Result<Exit, Failure> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).unwrap_or_else(|payload| {
        let text = payload.downcast_ref::<&str>().map(|s| (*s).to_string());
        let text = text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default();
        let place = PANIC_PLACE.lock().unwrap_or_else(PoisonError::into_inner).take();
        Err(Failure::new(Exit::Internal, "this is a bug in bvhc")
            .fact(format!(
                "version {}, {}: {text}",
                env!("CARGO_PKG_VERSION"),
                place.as_deref().unwrap_or("unknown place")
            ))
            .help("please report it with this message, the command line and, if you can share it, the input"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_ends_in_the_internal_code_and_asks_for_a_report() {
        let failure = guarded(|| panic!("box {} is empty", 7)).unwrap_err();
        assert_eq!(failure.exit, Exit::Internal);
        let text = failure.to_text(str::to_string);
        assert!(text.contains("box 7 is empty") && text.contains("please report"), "{text}");
    }

    #[test]
    fn the_definition_is_sound() {
        command().debug_assert();
    }
}
