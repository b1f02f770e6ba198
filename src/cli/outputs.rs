//! Where cache files may be written.

use super::exit::Exit;
use super::failure::Failure;
use super::identity::Identity;
use super::names;
use crate::cache::MAGIC;
use crate::scene::frames::Pattern;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

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

/// Whether a path names a folder for outputs: one that is there, or a name that ends as folders do.
pub fn is_folder(path: &Path) -> bool {
    let last = path.as_os_str().as_encoded_bytes().last();
    path.is_dir() || last.is_some_and(|b| *b == b'/' || *b == b'\\' && cfg!(windows))
}

/// Where an output will be, by its folder's own name: two folders of which one is a link to the other are one place.
pub fn place(output: &Path) -> PathBuf {
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match (folder.canonicalize(), output.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => output.to_owned(),
    }
}

/// What an output is made of: a file, or a frame of it.
#[derive(Clone, Debug)]
pub struct Source {
    pub path: PathBuf,
    pub frame: Option<i32>,
    /// Whether a list of frames was asked for, so that the number belongs into the name.
    pub is_one_of_several: bool,
}

/// Where each output goes: to the one that is named, to the name that a pattern has for its frame, or into a folder under the input's own name with this
/// extension. Refuses what could lose data: two inputs for one output, and an output that is an input. `action` is what is done with the inputs, for errors.
pub fn of_each(sources: &[Source], output: &Path, extension: &str, action: &str) -> Result<Vec<PathBuf>, Failure> {
    let refuse = |fact: String| Failure::new(Exit::Usage, format!("cannot {action}")).fact(fact);
    let into_folder = is_folder(output);
    let shown = names::path(output);
    let pattern = match Pattern::parse(output).filter(|_| !into_folder) {
        None => None,
        Some(Ok(pattern)) if pattern.numbers.is_none() && sources.iter().all(|source| source.frame.is_some()) => {
            Some(pattern)
        }
        Some(_) => {
            return Err(refuse(format!("{shown} has a place for a frame's number, and one file is written"))
                .help("name a file without such a place, or a folder, or choose frames of a sequence with --frame"));
        }
    };
    if sources.len() > 1 && !into_folder && pattern.is_none() {
        let what = if sources.iter().all(|source| source.is_one_of_several) { "frames" } else { "inputs" };
        return Err(refuse(format!("{} {what} need a folder to go to, and {shown} is not one", sources.len()))
            .help(format!("write -o {shown}/ to make it a folder")));
    }
    let name = |source: &Source| -> Option<PathBuf> {
        match (&pattern, source.frame) {
            (Some(pattern), Some(number)) => return Some(pattern.path(number)),
            _ if !into_folder => return Some(output.to_owned()),
            _ => {}
        }
        let mut name = source.path.file_stem()?.to_os_string();
        if let Some(number) = source.frame.filter(|_| source.is_one_of_several) {
            name.push(format!(".{number:04}"));
        }
        name.push(".");
        name.push(extension);
        Some(output.join(name))
    };
    let read: BTreeMap<Identity, &PathBuf> =
        sources.iter().filter_map(|source| Some((Identity::of(&source.path)?, &source.path))).collect();
    let mut owners: BTreeMap<PathBuf, &Path> = BTreeMap::new();
    let mut outputs = Vec::with_capacity(sources.len());
    for source in sources {
        let input = &source.path;
        let output = name(source).ok_or_else(|| refuse(format!("{} names no file", names::path(input))))?;
        if let Some(same) = Identity::of(&output).and_then(|output| read.get(&output)) {
            let fact = match *same == input {
                true => format!("{} and its output {} are one file", names::path(input), names::path(&output)),
                false => format!("{}, which is to be read, would be written over", names::path(same)),
            };
            return Err(refuse(fact).help("name another output with -o"));
        }
        if let Some(other) = owners.insert(place(&output), input) {
            let [a, b, one] = [other, input, &output].map(names::path);
            let fact = if other == input {
                format!("{a} is named twice")
            } else {
                format!("{a} and {b} would both become {one}")
            };
            return Err(refuse(fact).help("name one of them, or do the other into another folder"));
        }
        outputs.push(output);
    }
    Ok(outputs)
}

/// Make the folder of an output, where `-o` names the folder.
pub fn make_folder(output: &Path, named: &Path) -> Result<(), Failure> {
    let Some(folder) = output.parent().filter(|_| output != named) else { return Ok(()) };
    std::fs::create_dir_all(folder)
        .map_err(|e| Failure::new(Exit::Io, format!("cannot create {}", names::path(folder))).fact(e.to_string()))
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
