//! What the arguments of `bvhc build` name: files, patterns that the shell left alone, or standard input.

use super::BuildArgs;
use super::frames::{self, Frame};
use super::plan::{Input, Job};
use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::cli::names;
use std::cmp::Ordering;
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
            context.terminal.detail(&sequence.summary);
            let input = |frame: Frame| Input { frame: Some((frame.number, frame.path)), ..plain(frame.model) };
            inputs.extend(sequence.frames.into_iter().map(input));
        } else if args.frames.literal {
            inputs.push(plain(path.clone()));
        } else {
            inputs.extend(matches(path)?.into_iter().map(plain));
        }
    }
    if let Some(list) = args.frames.frames.as_ref().filter(|_| inputs.iter().all(|i| i.frame.is_none())) {
        let count = figures::counted(list.list().len() as u64, "frame", "frames");
        return Err(Failure::new(Exit::Usage, "cannot build")
            .fact(format!("--frames names {count}, and no input is a pattern of frames"))
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
    if args.depfile.path.is_some() {
        return Err(refuse(
            Exit::Usage,
            "--depfile names the files that an output depends on, and there is none".into(),
        )
        .help("build from a file, or leave out --depfile"));
    }
    let mut bytes = Vec::new();
    stdin.lock().take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(|e| refuse(Exit::Io, e.to_string()))?;
    if bytes.len() as u64 > limit {
        return Err(refuse(Exit::Limit, format!("it is longer than --max-memory allows ({limit} bytes)"))
            .help("raise --max-memory"));
    }
    Ok(bytes)
}

/// The files that a pattern matches; anything that exists or is no pattern stands for itself.
fn matches(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    let pattern = path.to_str().filter(|text| text.contains(['*', '?', '[']));
    let Some(pattern) = pattern.filter(|_| path.symlink_metadata().is_err()) else { return Ok(vec![path.to_owned()]) };
    let refuse = |exit, fact: String| Failure::new(exit, format!("cannot build {}", names::path(path))).fact(fact);
    let found = glob::glob(pattern).map_err(|e| {
        refuse(Exit::Usage, format!("no such file exists, and as a pattern it is wrong: {}", e.msg))
            .help("a pattern is made of *, ?, [a-z] and ** for any folders")
    })?;
    let mut files: Vec<PathBuf> = found.filter_map(Result::ok).filter(|p| p.is_file()).collect();
    if files.is_empty() {
        let folder = path.parent().filter(|folder| folder.is_dir()).unwrap_or(Path::new("."));
        return Err(refuse(Exit::Io, "no file matches the pattern".into())
            .help(format!("see what is there: ls {}", names::path(folder))));
    }
    files.sort_by(|a, b| natural(a.as_os_str().as_encoded_bytes(), b.as_os_str().as_encoded_bytes()));
    Ok(files)
}

/// Order in which `frame.9` comes before `frame.10`: runs of digits compare as numbers, all else byte by byte.
fn natural(a: &[u8], b: &[u8]) -> Ordering {
    let digits = |text: &[u8]| text.iter().take_while(|c| c.is_ascii_digit()).count();
    let (mut x, mut y) = (a, b);
    while let (Some(first), Some(second)) = (x.first(), y.first()) {
        let (n, m) = (digits(x), digits(y));
        if n > 0 && m > 0 {
            let significant = |run: &[u8]| run.iter().skip_while(|c| **c == b'0').copied().collect::<Vec<u8>>();
            let (v, w) = (significant(&x[..n]), significant(&y[..m]));
            let order = v.len().cmp(&w.len()).then_with(|| v.cmp(&w));
            if order.is_ne() {
                return order;
            }
            (x, y) = (&x[n..], &y[m..]);
        } else if first != second {
            return first.cmp(second);
        } else {
            (x, y) = (&x[1..], &y[1..]);
        }
    }
    x.len().cmp(&y.len()).then_with(|| a.cmp(b))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count() {
        let mut names = ["f.10.obj", "f.9.obj", "f.009.obj", "f.1.obj", "e.11.obj", "f.obj"];
        names.sort_by(|a, b| natural(a.as_bytes(), b.as_bytes()));
        assert_eq!(names, ["e.11.obj", "f.1.obj", "f.009.obj", "f.9.obj", "f.10.obj", "f.obj"]);
    }

    #[test]
    fn what_exists_or_is_no_pattern_stands_for_itself() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["a[1].obj", "b10.obj", "b9.obj"] {
            std::fs::write(at(name), "").unwrap();
        }
        assert_eq!(matches(&at("a[1].obj")).unwrap(), [at("a[1].obj")]);
        assert_eq!(matches(&at("missing.obj")).unwrap(), [at("missing.obj")]);
        assert_eq!(matches(&at("b*.obj")).unwrap(), [at("b9.obj"), at("b10.obj")]);
        assert_eq!(matches(&at("c*.obj")).unwrap_err().exit, Exit::Io);
    }
}
