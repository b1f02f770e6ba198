//! Where cache files may be written.

use super::exit::Exit;
use super::failure::Failure;
use super::names;
use crate::cache::MAGIC;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Say before a long build what its end would say: that there is no place for the file.
pub fn writable(path: &Path) -> Result<(), Failure> {
    has_place(path, "-o")
}

/// [`writable`] of a file that this flag names.
pub fn has_place(path: &Path, flag: &str) -> Result<(), Failure> {
    let refuse = |fact: String| Failure::new(Exit::Io, format!("cannot write {}", names::path(path))).fact(fact);
    if path.is_dir() {
        return Err(refuse("it is a folder".into()).help(format!("name a file with {flag}")));
    }
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            if folder.exists() {
                return Err(refuse(format!("{} is not a folder", names::path(folder)))
                    .help(format!("name another file with {flag}")));
            }
            let folder = names::path(folder);
            Err(refuse(format!("there is no folder {folder}")).help(format!("mkdir -p {folder}")))
        }
        _ => Ok(()),
    }
}

/// Refuse to write over what is most likely somebody's only copy: a file with something in it that is no cache.
pub fn may_replace(path: &Path) -> Result<(), Failure> {
    let is_cache = |start: &[u8]| start.is_empty() || start.starts_with(&MAGIC);
    let start = |path: &Path| -> std::io::Result<Vec<u8>> {
        let mut start = Vec::new();
        File::open(path)?.take(MAGIC.len() as u64).read_to_end(&mut start)?;
        Ok(start)
    };
    // Devices are written to, not replaced.
    if !path.metadata().is_ok_and(|m| m.is_file() && m.len() > 0) {
        return Ok(());
    }
    let action = format!("cannot replace {}", names::path(path));
    match start(path) {
        Ok(start) if is_cache(&start) => Ok(()),
        Ok(_) => Err(Failure::new(Exit::Usage, action)
            .fact("it is not a .bvhc file, and only those are written over")
            .help("name another output with -o, or write over it with --force")),
        Err(error) => Err(Failure::new(Exit::Io, action)
            .fact(format!("whether it is a .bvhc file cannot be seen: {error}"))
            .help("name another output with -o, or write over it with --force")),
    }
}

/// Refuse a pipe as an output: a reader would wait for it for ever, and a file that is renamed into its place ends it. And `-`, which means
/// standard output elsewhere.
pub fn is_no_pipe(path: &Path) -> Result<(), Failure> {
    if path.as_os_str() == "-" {
        return Err(Failure::new(Exit::Usage, "cannot write a cache file to standard output")
            .fact("it is written beside its place and then renamed, so that nobody sees a part of it")
            .help("name a file with -o; one that is called - is ./-"));
    }
    #[cfg(unix)]
    let is_pipe = {
        use std::os::unix::fs::FileTypeExt;
        path.metadata().is_ok_and(|m| m.file_type().is_fifo() || m.file_type().is_socket())
    };
    #[cfg(not(unix))]
    let is_pipe = false;
    if !is_pipe {
        return Ok(());
    }
    Err(Failure::new(Exit::Io, format!("cannot write {}", names::path(path)))
        .fact("it is a pipe, and a cache file is written beside its place and then renamed")
        .help("name a file with -o"))
}
