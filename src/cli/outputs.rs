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
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let shown = names::path(folder);
    let elsewhere = format!("name another file with {flag}");
    if !folder.is_dir() {
        return Err(match folder.exists() {
            true => refuse(format!("{shown} is not a folder")).help(elsewhere),
            false => refuse(format!("there is no folder {shown}")).help(format!("mkdir -p {shown}")),
        });
    }
    takes_files(folder).map_err(|error| {
        let shown = if shown == "." { "this folder".to_owned() } else { format!("the folder {shown}") };
        refuse(format!("{shown} takes no files: {error}")).help(elsewhere)
    })
}

/// Whether files may be made in a folder, as far as the system says so without one being made.
#[cfg(unix)]
fn takes_files(folder: &Path) -> std::io::Result<()> {
    use rustix::fs::{Access, access};
    access(folder, Access::WRITE_OK | Access::EXEC_OK).map_err(Into::into)
}

#[cfg(not(unix))]
fn takes_files(_: &Path) -> std::io::Result<()> {
    Ok(())
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
