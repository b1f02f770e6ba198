//! What the arguments of `bvhc build` name: files, patterns that the shell left alone, or standard input.

use super::BuildArgs;
use super::frames::{self, Frame};
use super::plan::{Input, Job};
use super::remarks;
use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::cli::names;
use crate::cli::patterns;
use std::io::{IsTerminal, Read};
use std::path::{Path, PathBuf};

/// What standard input is called in messages and in META.
pub const STDIN: &str = "stdin";

/// The models in order: patterns are replaced by the files that they match, in the order of their numbers, and `-` is read.
pub fn expand(args: &BuildArgs, context: &Context) -> Result<Vec<Input>, Failure> {
    let mut inputs: Vec<Input> = Vec::new();
    let plain = |path: PathBuf| Input { path, bytes: None, frame: None };
    let is_stdin = |path: &Path| path.as_os_str() == "-";
    if args.read.input_format.is_some() && !args.inputs.iter().any(|i| is_stdin(i)) {
        return Err(Failure::new(Exit::Usage, "cannot build").fact(
            "--input-format is about standard input, and no input is -; the format of files is told by their names",
        ));
    }
    for path in &args.inputs {
        if is_stdin(path) {
            if inputs.iter().any(|i| i.bytes.is_some()) {
                return Err(Failure::new(Exit::Usage, "cannot build").fact("standard input can be read only once"));
            }
            let bytes = Some(read_stdin(args, context.global.max_memory)?);
            inputs.push(Input { bytes, ..plain(STDIN.into()) });
        } else if let Some(sequence) = frames::resolve(path, &args.frames) {
            let sequence = sequence?;
            sequence.warnings.iter().for_each(|warning| context.terminal.warn(warning));
            if args.warnings_as_errors && !sequence.unasked.is_empty() {
                return Err(remarks::with_warnings(&names::path(path), &sequence.unasked));
            }
            context.terminal.detail(&sequence.summary);
            let input = |frame: Frame| Input { frame: Some((frame.number, frame.path)), ..plain(frame.model) };
            inputs.extend(sequence.frames.into_iter().map(input));
        } else if args.frames.literal {
            inputs.push(plain(path.clone()));
        } else {
            inputs
                .extend(patterns::matches(path, patterns::MODELS, "build", &context.terminal)?.into_iter().map(plain));
        }
    }
    let asks = match (&args.frames.frames, args.frames.missing) {
        (Some(list), _) => {
            Some(format!("--frames names {}", figures::counted(list.list().len() as u64, "frame", "frames")))
        }
        (None, Some(_)) => Some("--missing is about frames that are not there".to_owned()),
        (None, None) => None,
    };
    if let Some(asks) = asks.filter(|_| inputs.iter().all(|i| i.frame.is_none())) {
        return Err(Failure::new(Exit::Usage, "cannot build")
            .fact(format!("{asks}, and no input is a pattern of frames"))
            .help("put the place of the number into the name, for example 'heli.%04d.obj' or 'heli.####.obj'"));
    }
    Ok(inputs)
}

fn read_stdin(args: &BuildArgs, limit: u64) -> Result<Vec<u8>, Failure> {
    let refuse = |exit, fact: String| Failure::new(exit, "cannot read standard input").fact(fact);
    let stdin = std::io::stdin();
    if stdin.is_terminal() {
        return Err(refuse(Exit::Usage, "it is a terminal, and a model is expected there".into())
            .help("pipe one in: bvhc build - -o OUT < MODEL"));
    }
    if let Some(flag) = args.depfile.asked_by() {
        return Err(refuse(
            Exit::Usage,
            format!("{flag} names the files that an output depends on, and there is none"),
        )
        .help(format!("leave out {flag}")));
    }
    let mut bytes = Vec::new();
    stdin.lock().take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(|e| refuse(Exit::Io, e.to_string()))?;
    if bytes.len() as u64 > limit {
        return Err(refuse(Exit::Limit, format!("it is longer than --max-memory allows ({limit} bytes)"))
            .help("raise --max-memory"));
    }
    Ok(bytes)
}

/// A model must be there, and it is read more than once, which a pipe or a folder does not allow.
pub fn readable(job: &Job) -> Result<(), Failure> {
    if job.bytes.is_some() {
        return Ok(());
    }
    let refuse = |fact: &str| Failure::new(Exit::Io, format!("cannot read {}", names::path(&job.input))).fact(fact);
    match job.input.metadata() {
        Ok(m) if m.is_dir() => {
            let pattern = names::path(&job.input.join("*.obj"));
            Err(refuse("it is a folder")
                .help(format!("name the models in it, for example '{}'", pattern.trim_matches('\''))))
        }
        Ok(m) if !m.is_file() => Err(refuse("it is not a regular file, and a model is read more than once")
            .help("pipe it in, with - as the input, or write the model to a file first")),
        Ok(_) => Ok(()),
        Err(error) => {
            let refused = refuse(&error.to_string());
            // A relative path that leads nowhere was mostly typed in another folder than it was meant for.
            match std::env::current_dir() {
                Ok(folder) if error.kind() == std::io::ErrorKind::NotFound && job.input.is_relative() => {
                    Err(refused.help(format!("paths start from {}", names::path(&folder))))
                }
                _ => Err(refused),
            }
        }
    }
}

/// Refuse to write over a file that a model is read from.
pub fn is_an_input(output: &Path, input: &Path) -> Failure {
    Failure::new(Exit::Usage, format!("cannot write {}", names::path(output)))
        .fact(format!("it is {}, a file that the model is read from", names::path(input)))
        .help("name another output with -o")
}
