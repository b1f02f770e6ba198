//! Cache files as inputs of a command, and the library's errors as failures.

use super::exit::Exit;
use super::failure::{Entry, Failure};
use super::figures;
use super::names;
use super::{Context, advice};
use crate::build::{BuildError, BuildOptions, Remedy};
use crate::cache::check;
use crate::cache::tree_flags;
use crate::cache::{
    Cache, CacheError, ErrorKind, Frame, Head, Image, Limited, OpenOptions, Sequence, Validation, rules,
};
use crate::compile;
use crate::scene::{self, Scene, SceneError};
use crate::size::beyond;
use std::path::{Path, PathBuf};

/// Open a file for walking its trees: the bytes are those that were written.
pub fn open(path: &Path, context: &Context) -> Result<Cache, Failure> {
    Cache::open_on(path, &options(context), &context.exec).map_err(|e| failure(&e))
}

/// Open a file for measuring its trees: every record is checked first, so that nothing is measured that a rule forbids.
pub fn open_checked(path: &Path, context: &Context) -> Result<Cache, Failure> {
    let options = OpenOptions { validation: Validation::Tree, ..options(context) };
    Cache::open_on(path, &options, &context.exec).map_err(|e| failure(&e))
}

/// Whether a file has many frames. One that cannot be read has none.
pub fn is_sequence(path: &Path, context: &Context) -> bool {
    Head::read(path, &options(context)).is_ok_and(|head| head.header.has(tree_flags::SEQUENCE))
}

/// Open a sequence, whose frames are then handed out as this run wants files to be opened.
pub fn open_sequence(path: &Path, context: &Context) -> Result<Sequence, Failure> {
    Sequence::open_on(path, &options(context), &context.exec).map_err(|e| failure(&e))
}

/// The frame of a sequence that has this number, every record of it checked.
pub fn frame<'s>(sequence: &'s Sequence, path: &Path, number: i32, context: &Context) -> Result<Frame<'s>, Failure> {
    let frames = sequence.frames();
    let Some(index) = sequence.numbered(number) else {
        let count = figures::counted(frames.len() as u64, "frame", "frames");
        let ends = frames
            .first()
            .zip(frames.last())
            .map_or_else(String::new, |(a, b)| format!(", {} to {}", a.number, b.number));
        return Err(Failure::new(Exit::Usage, format!("cannot open frame {number} of {}", names::path(path)))
            .fact(format!("there are {count}{ends}")));
    };
    let opened = sequence.frame_on(index, &context.exec).map_err(|e| failure(&e))?;
    let report = check::check_records(
        &opened.view(),
        opened.tree_flags(),
        check::RecordsOf::Frame,
        &check::Limits::default(),
        &context.exec,
    );
    match report.findings.first().filter(|_| !report.is_valid()) {
        None => Ok(opened),
        Some(finding) => {
            Err(Failure::new(Exit::Negative, format!("cannot use frame {number} of {}", names::path(path)))
                .fact(finding.to_string())
                .help("see all that is wrong with it: bvhc check FILE"))
        }
    }
}

/// Read a file's header, table and META.
pub fn head(path: &Path, context: &Context) -> Result<Head, Failure> {
    Head::read(path, &options(context)).map_err(|e| failure(&e))
}

/// How the global flags want files to be opened, hashes included.
pub fn options(context: &Context) -> OpenOptions {
    let (mmap, max_memory) = (!context.global.no_mmap, context.global.max_memory);
    OpenOptions { validation: Validation::Hash, mmap, max_memory }
}

/// A sequence that stays open while its frames are taken one after the other.
pub struct KeptOpen<'c> {
    context: &'c Context,
    last: Option<(PathBuf, Sequence)>,
}

impl<'c> KeptOpen<'c> {
    pub fn new(context: &'c Context) -> KeptOpen<'c> {
        KeptOpen { context, last: None }
    }

    /// The sequence of this file, opened unless it was the last one.
    pub fn sequence(&mut self, path: &Path) -> Result<&Sequence, Failure> {
        let kept = self.last.take().filter(|(last, _)| last == path);
        let opened = match kept {
            Some((_, sequence)) => sequence,
            None => open_sequence(path, self.context)?,
        };
        Ok(&self.last.insert((path.to_owned(), opened)).1)
    }
}

/// Do the same for every file: failures are reported at once and do not stop the others; the exit code is the common one.
pub fn each<T>(
    paths: &[PathBuf],
    context: &Context,
    mut work: impl FnMut(&Path) -> Result<T, Failure>,
) -> (Vec<Entry<T>>, Exit) {
    each_of(paths.iter().map(|path| (path.as_path(), None)), context, |(path, _)| work(path))
}

/// [`each`], of files or of frames of them.
pub fn each_of<'p, T>(
    things: impl Iterator<Item = (&'p Path, Option<i32>)>,
    context: &Context,
    mut work: impl FnMut((&'p Path, Option<i32>)) -> Result<T, Failure>,
) -> (Vec<Entry<T>>, Exit) {
    let (mut entries, mut exits) = (Vec::new(), Vec::new());
    for (path, frame) in things {
        match work((path, frame)) {
            Ok(result) => {
                entries.push(Entry::Done(result));
                exits.push(Exit::Success);
            }
            Err(failure) => {
                context.terminal.error(&failure);
                exits.push(failure.exit);
                entries.push(Entry::failed(path, frame, &failure));
                if failure.exit == Exit::Interrupted {
                    return (entries, Exit::Interrupted);
                }
            }
        }
    }
    (entries, Exit::combine(exits))
}

pub fn failure(error: &CacheError) -> Failure {
    let exit = match error.kind() {
        ErrorKind::Io => Exit::Io,
        ErrorKind::Invalid => Exit::Negative,
        ErrorKind::Unsupported => Exit::Unsupported,
        ErrorKind::Limit => Exit::Limit,
        ErrorKind::Frames => Exit::Usage,
        _ => Exit::Internal,
    };
    let failure = Failure::new(exit, error.to_string());
    match error {
        CacheError::Io { source, .. } => {
            let failure = failure.fact(source.to_string());
            if source.kind() == std::io::ErrorKind::NotFound { failure.help(MAKE_ONE) } else { failure }
        }
        // Building "again" would write over what is most likely the model.
        CacheError::Invalid { breach, .. } if breach.rule == &rules::E0102 => failure.help(MAKE_ONE),
        CacheError::Invalid { breach, .. } => {
            let rule = breach.rule.id;
            failure
                .fact(format!("more about it: bvhc explain {rule}"))
                .help("build it again: bvhc build MODEL -o FILE --force")
        }
        CacheError::Unsupported { .. } | CacheError::NotCopied { .. } => {
            failure.help("use the bvhc that wrote it or a newer one, or rebuild with: bvhc build MODEL -o FILE --force")
        }
        CacheError::Limit { limit: Limited::Memory { .. }, .. } => {
            failure.help("if you trust the file, raise the limit: --max-memory 32G")
        }
        CacheError::Limit { limit: Limited::Machine { .. }, .. } => failure.help(MORE_MEMORY),
        CacheError::Sequence { name, .. } => failure.help(format!(
            "take a frame out of it as a still file: bvhc convert {} -o STILL --frame N",
            names::escape(name)
        )),
        CacheError::Still { .. } => failure.help("leave out --frame or --frames"),
        CacheError::NoFrame { .. } => failure.help("see which there are: bvhc info FILE"),
        CacheError::Limit { .. } => failure.help("split the scene into several models, or shorten its names"),
        _ => failure.help("this is a fault of the program that called the writer; please report it"),
    }
}

/// For a file that is no cache, or not there.
pub const MAKE_ONE: &str = "cache files are made from models with: bvhc build MODEL -o FILE.bvhc";

/// For what the machine has not got the memory to look into.
pub const MORE_MEMORY: &str = "end other programs, or use a machine with more memory";

pub fn scene_failure(error: &SceneError) -> Failure {
    let exit = match error.kind() {
        scene::ErrorKind::Io => Exit::Io,
        scene::ErrorKind::BadModel => Exit::Model,
        scene::ErrorKind::Unsupported => Exit::Unsupported,
        scene::ErrorKind::Limit => Exit::Limit,
    };
    let failure = advice::told(Failure::new(exit, error.action()).facts(error.facts()), error);
    match advice::for_scene(error) {
        Some(help) => failure.help(help),
        None => failure,
    }
}

/// Refuse a scene whose instances or duplicates would take more than `--max-memory` when they are laid out.
pub fn fits(model: &Path, scene: &Scene, options: &BuildOptions, context: &Context) -> Result<(), Failure> {
    let (needed, limit) = (compile::bytes_to_reserve(scene, options), context.global.max_memory);
    if needed <= limit {
        return Ok(());
    }
    let triangles = figures::count(compile::primitives_to_build(scene, options));
    let [needed, limit] = beyond(needed, limit);
    Err(Failure::new(Exit::Limit, format!("cannot lay out {}", names::path(model)))
        .fact(format!("{triangles} triangles need {needed}"))
        .fact(format!("the limit is {limit}"))
        .help("raise it with --max-memory"))
}

/// The same for turning subtrees of a tree that is built.
pub fn fits_turned(output: &Path, image: &Image, context: &Context) -> Result<(), Failure> {
    let (needed, limit) = (compile::bytes_to_orient(image), context.global.max_memory);
    if needed <= limit {
        return Ok(());
    }
    let references = figures::count(image.triangles.len() as u64);
    let [needed, limit] = beyond(needed, limit);
    Err(Failure::new(Exit::Limit, format!("cannot turn subtrees of {}", names::path(output)))
        .fact(format!("{references} references need {needed}"))
        .fact(format!("the limit is {limit}"))
        .help("raise it with --max-memory, or leave out --orient"))
}

pub fn build_failure(error: &BuildError) -> Failure {
    let exit = match error {
        BuildError::Cancelled => return Failure::interrupted(),
        BuildError::TooLarge { .. } => Exit::Limit,
        BuildError::Option { .. } | BuildError::NotRead { .. } | BuildError::UnknownName { .. } => Exit::Usage,
        BuildError::OutOfRange { .. } | BuildError::Collapsed { .. } => Exit::Model,
        BuildError::Threads(_) => Exit::Io,
        _ => Exit::Internal,
    };
    let failure = Failure::new(exit, error.to_string());
    match error {
        BuildError::TooLarge { remedy, .. } => failure.help(match remedy {
            Remedy::Bonsai => "build it with --method bonsai",
            Remedy::TwoLevels => "keep meshes and instances apart with --levels two",
            Remedy::TwoLevelsOrFewerDuplicates => "keep instances apart with --levels two",
            Remedy::SplitScene => "split the scene into several models",
        }),
        BuildError::Option { default: Some(value), .. } => failure.help(format!("take {value}, the default")),
        BuildError::Option { .. } => failure.help("set it once"),
        BuildError::NotRead { option, .. } => {
            failure.help(format!("choose a method that reads it, or leave {option} out"))
        }
        BuildError::UnknownName { nearest: Some(name), .. } => failure.help(format!("did you mean {name}?")),
        BuildError::UnknownName { .. } => failure.help("take one of those"),
        BuildError::OutOfRange { .. } => failure.help("scale the scene down"),
        BuildError::Collapsed { .. } => {
            failure.help("keep them as they are with --levels auto, or leave them out with --degenerate drop")
        }
        BuildError::Threads(_) => failure.help("ask for fewer with --jobs"),
        _ => failure,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::check::{Finding, Place};

    #[test]
    fn what_helps_is_said_for_every_class_of_cache_error() {
        let (name, detail) = ("a.bvhc".to_string(), "the vertices of tree 3".to_string());
        let io = |kind| CacheError::Io { action: "open", path: "a.bvhc".into(), source: std::io::Error::from(kind) };
        let told = |error: CacheError| failure(&error).to_text(str::to_string);

        let breach = |rule| Box::new(Finding::new(rule, Place::file(), "1".into(), "2.0".into()));
        let invalid = |rule| CacheError::Invalid { name: name.clone(), breach: breach(rule) };
        let (no_cache, damaged) = (told(invalid(&rules::E0102)), told(invalid(&rules::E0201)));
        assert!(no_cache.ends_with(MAKE_ONE) && !no_cache.contains("--force"), "{no_cache}");
        assert!(
            damaged.contains("bvhc explain E0201") && damaged.contains("bvhc build MODEL -o FILE --force"),
            "{damaged}"
        );
        let newer = told(CacheError::Unsupported { name: name.clone(), breach: breach(&rules::E0103) });
        assert!(newer.contains("version 2.0 (E0103)") && newer.contains("bvhc build MODEL -o FILE --force"), "{newer}");
        let large = told(CacheError::Limit { name: name.clone(), limit: Limited::Memory { needed: 9, limit: 8 } });
        assert!(large.contains("--max-memory"), "{large}");
        let short =
            told(CacheError::Limit { name: name.clone(), limit: Limited::Machine { left_out: detail.clone() } });
        assert!(short.contains("more memory") && !short.contains("--max-memory"), "{short}");
        let many =
            told(CacheError::Limit { name: name.clone(), limit: Limited::Format { what: "META", found: 9, most: 8 } });
        assert!(many.contains("split the scene"), "{many}");
        let fault = failure(&CacheError::Unwritable { name, detail });
        assert!(fault.exit == Exit::Internal && fault.help.is_some_and(|h| h.contains("report it")));

        // What the operating system said stands there once.
        let missing = told(io(std::io::ErrorKind::NotFound));
        assert!(missing.ends_with(MAKE_ONE) && missing.matches("entity not found").count() == 1, "{missing}");
        let denied = told(io(std::io::ErrorKind::PermissionDenied));
        assert!(denied.matches("permission denied").count() == 1 && !denied.contains("help:"), "{denied}");
    }
}
