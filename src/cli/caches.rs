//! Cache files as inputs of a command, and the library's errors as failures.

use super::Context;
use super::exit::Exit;
use super::failure::Failure;
use super::figures;
use super::names;
use crate::build::{self, BuildError, BuildOptions, Levels, Named};
use crate::cache::{Cache, CacheError, ErrorKind, Head, Limited, Meta, OpenOptions, Validation};
use crate::scene::{self, Degenerate, ReadOptions, Scene, SceneError};
use std::path::{Path, PathBuf};

/// Open a file for walking its trees: the bytes are those that were written.
pub fn open(path: &Path, context: &Context) -> Result<Cache, Failure> {
    Cache::open_on(path, &options(context), &context.exec).map_err(|e| failure(&e))
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

/// Do the same for every file: failures are reported at once and do not stop the others; the exit code is the common one.
pub fn each<T>(
    paths: &[PathBuf],
    context: &Context,
    mut work: impl FnMut(&Path) -> Result<T, Failure>,
) -> (Vec<T>, Exit) {
    let (mut results, mut exits) = (Vec::new(), Vec::new());
    for path in paths {
        match work(path) {
            Ok(result) => {
                results.push(result);
                exits.push(Exit::Success);
            }
            Err(failure) => {
                context.terminal.error(&failure);
                exits.push(failure.exit);
            }
        }
    }
    (results, Exit::combine(exits))
}

pub fn failure(error: &CacheError) -> Failure {
    let exit = match error.kind() {
        ErrorKind::Io => Exit::Io,
        ErrorKind::Invalid => Exit::Negative,
        ErrorKind::Unsupported => Exit::Unsupported,
        ErrorKind::Limit => Exit::Limit,
        _ => Exit::Internal,
    };
    let failure = Failure::new(exit, error.to_string());
    match error {
        CacheError::Io { source, .. } => {
            let failure = failure.fact(source.to_string());
            if source.kind() == std::io::ErrorKind::NotFound { failure.help(MAKE_ONE) } else { failure }
        }
        // Building "again" would write over what is most likely the model.
        CacheError::Invalid { rule: "E0102", .. } => failure.help(MAKE_ONE),
        CacheError::Invalid { rule, .. } => {
            failure.help(format!("bvhc explain {rule} · build it again: bvhc build MODEL -o FILE --force"))
        }
        CacheError::Unsupported { .. } => {
            failure.help("use the bvhc that wrote it or a newer one, or rebuild with: bvhc build MODEL -o FILE --force")
        }
        CacheError::Limit { limit: Limited::Memory, .. } => {
            failure.help("if you trust the file, raise the limit: --max-memory 32G")
        }
        CacheError::Limit { .. } => failure.help("split the scene into several models, or shorten its names"),
        _ => failure.help("this is a fault of the program that called the writer; please report it"),
    }
}

/// The options in META that decide which triangles a file holds; defaults where it does not say.
pub fn recorded(meta: Option<&Meta>) -> (ReadOptions, BuildOptions) {
    let value =
        |name: &str| meta.and_then(|m| m.options.iter().find(|(n, _)| n == name)).map(|(_, value)| value.as_str());
    let degenerate = value("degenerate").and_then(|v| Degenerate::parse(v).ok()).unwrap_or_default();
    let scene = value("scene").and_then(|v| v.parse().ok());
    let levels = value("levels").and_then(|v| Levels::parse(v).ok()).unwrap_or(Levels::Auto);
    let read = ReadOptions { degenerate, scene, ..ReadOptions::default() };
    (read, BuildOptions { levels, ..BuildOptions::default() })
}

/// For a file that is no cache, or not there.
pub const MAKE_ONE: &str = "cache files are made from models with: bvhc build MODEL -o FILE.bvhc";

pub fn scene_failure(error: &SceneError) -> Failure {
    let exit = match error.kind() {
        scene::ErrorKind::Io => Exit::Io,
        scene::ErrorKind::BadModel => Exit::Model,
        scene::ErrorKind::Unsupported => Exit::Unsupported,
        scene::ErrorKind::Limit => Exit::Limit,
    };
    Failure::from_message(exit, &error.to_string())
}

/// Refuse a scene whose instances or duplicates would take more than `--max-memory` when they are laid out.
pub fn fits(model: &Path, scene: &Scene, options: &BuildOptions, context: &Context) -> Result<(), Failure> {
    let (needed, limit) = (build::bytes_to_reserve(scene, options), context.global.max_memory);
    if needed <= limit {
        return Ok(());
    }
    Err(Failure::new(Exit::Limit, format!("cannot lay out {}", names::path(model)))
        .fact(format!(
            "{} triangles need {}",
            figures::count(build::primitives_to_build(scene, options)),
            figures::bytes(needed)
        ))
        .fact(format!("the limit is {}", figures::bytes(limit)))
        .help(
            "raise it with --max-memory, keep instances apart with --levels two, or lower --split-budget or --presplit",
        ))
}

pub fn build_failure(error: &BuildError) -> Failure {
    let exit = match error {
        BuildError::Cancelled => return Failure::interrupted(),
        BuildError::TooLarge { .. } => Exit::Limit,
        BuildError::Option { .. } | BuildError::UnknownName { .. } => Exit::Usage,
        BuildError::OutOfRange { .. } => Exit::Model,
        BuildError::MeshIndex { .. } => Exit::Internal,
    };
    Failure::from_message(exit, &error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_helps_is_said_for_every_class_of_cache_error() {
        let (name, rule, detail) = ("a.bvhc".to_string(), "E0103", "it has format version 2.0".to_string());
        let io = |kind| CacheError::Io { action: "open", path: "a.bvhc".into(), source: std::io::Error::from(kind) };
        let told = |error: CacheError| failure(&error).to_text(str::to_string);

        let invalid = |rule| CacheError::Invalid { name: name.clone(), rule, detail: detail.clone() };
        let (no_cache, damaged) = (told(invalid("E0102")), told(invalid("E0201")));
        assert!(no_cache.ends_with(MAKE_ONE) && !no_cache.contains("--force"), "{no_cache}");
        assert!(
            damaged.contains("bvhc explain E0201") && damaged.contains("bvhc build MODEL -o FILE --force"),
            "{damaged}"
        );
        let newer = told(CacheError::Unsupported { name: name.clone(), rule, detail: detail.clone() });
        assert!(newer.contains("version 2.0 (E0103)") && newer.contains("bvhc build MODEL -o FILE --force"), "{newer}");
        let large = told(CacheError::Limit { name: name.clone(), detail: detail.clone(), limit: Limited::Memory });
        assert!(large.contains("--max-memory"), "{large}");
        let many = told(CacheError::Limit { name: name.clone(), detail: detail.clone(), limit: Limited::Format });
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
