//! Patterns of files that the shell left alone: quoted, or on a system whose shell knows none.

use super::exit::Exit;
use super::failure::Failure;
use super::names;
use super::numbered;
use super::terminal::Terminal;
use glob::MatchOptions;
use std::cmp::Ordering;
use std::path::{Path, PathBuf};

/// The files of a folder that a command takes, by their extensions.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    extensions: &'static [&'static str],
    what: &'static str,
}

pub const CACHES: Kind = Kind { extensions: &["bvhc"], what: "cache file (*.bvhc)" };
pub const MODELS: Kind = Kind { extensions: &["obj", "gltf", "glb"], what: "model (*.obj, *.gltf, *.glb)" };

/// The files that these arguments name, in their order: patterns are replaced by the files that they match, and folders by those in them.
pub fn expand(paths: &[PathBuf], kind: Kind, action: &str, terminal: &Terminal) -> Result<Vec<PathBuf>, Failure> {
    let files: Vec<Vec<PathBuf>> =
        paths.iter().map(|path| matches(path, kind, action, terminal)).collect::<Result<_, _>>()?;
    Ok(files.concat())
}

/// The one file that an argument names: itself, or the only one that it matches as a pattern or has as a folder.
pub fn one(path: &Path, kind: Kind, action: &str, terminal: &Terminal) -> Result<PathBuf, Failure> {
    let files = matches(path, kind, action, terminal)?;
    match &files[..] {
        [file] => Ok(file.clone()),
        [first, second, ..] => Err(Failure::new(Exit::Usage, format!("cannot {action} {}", names::path(path)))
            .fact(format!(
                "one file is needed, and {} match: {}, {}{}",
                files.len(),
                names::path(first),
                names::path(second),
                if files.len() > 2 { ", …" } else { "" }
            ))
            .help("name one of them")),
        [] => Err(Failure::new(Exit::Internal, format!("cannot {action} {}", names::path(path)))),
    }
}

/// The files of this kind in a folder, not in folders below it, in natural order. As for a shell's patterns, names that begin with a point are hidden. What has
/// such a name and cannot be read, such as a link to nothing, is among them: else a run that checks a folder would pass over it.
fn inside(folder: &Path, kind: Kind, action: &str) -> Result<Vec<PathBuf>, Failure> {
    let refuse = |fact: String| Failure::new(Exit::Io, format!("cannot {action} {}", names::path(folder))).fact(fact);
    let is_wanted = |path: &PathBuf| {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        let is_hidden = path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        !is_hidden && kind.extensions.iter().any(|wanted| wanted.eq_ignore_ascii_case(extension)) && !path.is_dir()
    };
    let entries = folder.read_dir().map_err(|error| refuse(error.to_string()))?;
    let paths: Vec<PathBuf> = entries
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()
        .map_err(|error| refuse(error.to_string()))?;
    let files: Vec<PathBuf> = paths.into_iter().filter(is_wanted).collect();
    if files.is_empty() {
        let pattern = folder.join("**").join(format!("*.{}", kind.extensions[0]));
        return Err(refuse(format!("it is a folder, and no {} is in it", kind.what)).help(format!(
            "folders below it are searched by a pattern: '{}'",
            names::path(&pattern).trim_matches('\'')
        )));
    }
    Ok(in_order(files))
}

fn in_order(mut files: Vec<PathBuf>) -> Vec<PathBuf> {
    files.sort_by(|a, b| natural(a.as_os_str().as_encoded_bytes(), b.as_os_str().as_encoded_bytes()));
    files
}

/// The files that a pattern matches or that are in a folder, in natural order; anything else that exists or is no pattern stands for itself. `action` is what
/// would be done with them, for errors.
pub fn matches(path: &Path, kind: Kind, action: &str, terminal: &Terminal) -> Result<Vec<PathBuf>, Failure> {
    if path.is_dir() {
        return inside(path, kind, action);
    }
    let names_a_folder = path.as_os_str().as_encoded_bytes().ends_with(b"/");
    if names_a_folder && path.symlink_metadata().is_err() {
        return Err(Failure::new(Exit::Io, format!("cannot {action} {}", names::path(path)))
            .fact("there is no such folder")
            .help("paths start from the working directory"));
    }
    if let Some(files) = numbered::files(path, action, terminal) {
        return files;
    }
    let pattern = path.to_str().filter(|text| text.contains(['*', '?', '[']));
    let Some(pattern) = pattern.filter(|_| path.symlink_metadata().is_err()) else { return Ok(vec![path.to_owned()]) };
    let refuse = |exit, fact: String| Failure::new(exit, format!("cannot {action} {}", names::path(path))).fact(fact);
    let as_shells_do = MatchOptions { require_literal_leading_dot: true, ..MatchOptions::new() };
    let found = glob::glob_with(pattern, as_shells_do).map_err(|e| {
        refuse(Exit::Usage, format!("no such file exists, and as a pattern it is wrong: {}", e.msg))
            .help("a pattern is made of *, ?, [a-z] and ** for any folders")
    })?;
    let found: Vec<PathBuf> = found.collect::<Result<_, _>>().map_err(|error| {
        refuse(Exit::Io, format!("{} cannot be searched: {}", names::path(error.path()), error.error()))
    })?;
    let files: Vec<PathBuf> = found.into_iter().filter(|path| !path.is_dir()).collect();
    if files.is_empty() {
        let folder = path.parent().filter(|folder| folder.is_dir()).unwrap_or(Path::new("."));
        return Err(refuse(Exit::Io, "no file matches the pattern".into())
            .help(format!("see what is there: ls {}", names::path(folder))));
    }
    Ok(in_order(files))
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

#[cfg(test)]
mod tests {
    use super::super::terminal::ColorChoice;
    use super::*;

    fn silent() -> Terminal {
        Terminal::new(ColorChoice::Never, true, 0, false)
    }

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
        assert_eq!(matches(&at("a[1].obj"), MODELS, "build", &silent()).unwrap(), [at("a[1].obj")]);
        assert_eq!(matches(&at("missing/"), MODELS, "build", &silent()).unwrap_err().exit, Exit::Io);
        assert_eq!(matches(&at("missing.obj"), MODELS, "build", &silent()).unwrap(), [at("missing.obj")]);
        assert_eq!(matches(&at("b*.obj"), MODELS, "build", &silent()).unwrap(), [at("b9.obj"), at("b10.obj")]);
        assert_eq!(one(&at("b1*.obj"), MODELS, "read", &silent()).unwrap(), at("b10.obj"));
        let two = one(&at("b*.obj"), MODELS, "read", &silent()).unwrap_err();
        assert!(two.exit == Exit::Usage && two.facts[0].starts_with("one file is needed, and 2 match:"), "{two:?}");
        assert_eq!(matches(&at("c*.obj"), MODELS, "build", &silent()).unwrap_err().exit, Exit::Io);
    }

    #[test]
    fn a_folder_stands_for_the_files_in_it_that_are_meant() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["b10.obj", "b9.GLB", "a.gltf", "a.bin", "c.bvhc", ".a.obj", "._b9.GLB"] {
            std::fs::write(at(name), "").unwrap();
        }
        std::fs::create_dir(at("d.obj")).unwrap();
        assert_eq!(
            matches(folder.path(), MODELS, "build", &silent()).unwrap(),
            [at("a.gltf"), at("b9.GLB"), at("b10.obj")]
        );
        assert_eq!(matches(folder.path(), CACHES, "check", &silent()).unwrap(), [at("c.bvhc")]);
        let none = matches(&at("d.obj"), CACHES, "check", &silent()).unwrap_err();
        assert!(none.exit == Exit::Io && none.facts[0].contains("no cache file"), "{none:?}");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_to_nothing_is_not_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("a.bvhc"), "").unwrap();
        std::fs::write(at(".c.bvhc"), "").unwrap();
        std::os::unix::fs::symlink(at("gone"), at("b.bvhc")).unwrap();
        for named in [folder.path().to_owned(), at("*.bvhc"), at("**/*.bvhc")] {
            let found = matches(&named, CACHES, "check", &silent()).unwrap();
            assert_eq!(found, [at("a.bvhc"), at("b.bvhc")], "{named:?}");
        }
    }
}
