//! Patterns of files that the shell left alone: quoted, or on a system whose shell knows none.

use super::exit::Exit;
use super::failure::Failure;
use super::names;
use std::cmp::Ordering;
use std::path::{Path, PathBuf};

/// The files that these arguments name, in their order: patterns are replaced by the files that they match.
pub fn expand(paths: &[PathBuf], action: &str) -> Result<Vec<PathBuf>, Failure> {
    let files: Vec<Vec<PathBuf>> = paths.iter().map(|path| matches(path, action)).collect::<Result<_, _>>()?;
    Ok(files.concat())
}

/// The files that a pattern matches, in natural order; anything that exists or is no pattern stands for itself. `action` is what would be done with them,
/// for errors.
pub fn matches(path: &Path, action: &str) -> Result<Vec<PathBuf>, Failure> {
    let pattern = path.to_str().filter(|text| text.contains(['*', '?', '[']));
    let Some(pattern) = pattern.filter(|_| path.symlink_metadata().is_err()) else { return Ok(vec![path.to_owned()]) };
    let refuse = |exit, fact: String| Failure::new(exit, format!("cannot {action} {}", names::path(path))).fact(fact);
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
        assert_eq!(matches(&at("a[1].obj"), "build").unwrap(), [at("a[1].obj")]);
        assert_eq!(matches(&at("missing.obj"), "build").unwrap(), [at("missing.obj")]);
        assert_eq!(matches(&at("b*.obj"), "build").unwrap(), [at("b9.obj"), at("b10.obj")]);
        assert_eq!(matches(&at("c*.obj"), "build").unwrap_err().exit, Exit::Io);
    }
}
