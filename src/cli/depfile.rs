//! Makefile-syntax dependency files that both Ninja and Make read.
//!
//! One rule, one target (older Ninja refuses several), the target exactly as given because Ninja compares strings.

use super::exit::Exit;
use super::failure::Failure;
use super::names;
use super::outputs;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The whole file: `target: inputs…`, and with `phony` one empty rule per input, so that Make does not stop when an input
/// has been removed.
pub fn render(target: &Path, inputs: &[PathBuf], phony: bool) -> Result<Vec<u8>, Failure> {
    let mut out = escape(target)?;
    out.push(b':');
    let mut seen = std::collections::BTreeSet::new();
    let inputs: Vec<&PathBuf> = inputs.iter().filter(|path| seen.insert(*path)).collect();
    for input in &inputs {
        out.extend_from_slice(b" \\\n  ");
        out.extend(escape(input)?);
    }
    out.push(b'\n');
    if phony {
        for input in &inputs {
            out.push(b'\n');
            out.extend(escape(input)?);
            out.extend_from_slice(b":\n");
        }
    }
    Ok(out)
}

/// Say before a build that there is no place for its depfile: else the output would be there and nothing would know what it depends on. `made` is a folder that
/// the build makes.
pub fn writable(path: &Path, made: Option<&Path>) -> Result<(), Failure> {
    if path.as_os_str() == "-" {
        return Err(Failure::new(Exit::Usage, "cannot write a depfile to standard output")
            .fact("it is written into a file, which build tools read")
            .help("name a file with --depfile; one that is called - is ./-"));
    }
    if made.is_some_and(|made| path.parent() == Some(made)) && !path.is_dir() {
        return Ok(());
    }
    outputs::has_place(path, "--depfile")?;
    match path.metadata() {
        Ok(metadata) if metadata.is_file() && metadata.permissions().readonly() => {
            Err(Failure::new(Exit::Io, format!("cannot write {}", names::path(path)))
                .fact("it is read-only")
                .help("name another file with --depfile, or make this one writable"))
        }
        _ => Ok(()),
    }
}

/// Refuse to write over a file that is no depfile as [`render`] makes it.
pub fn may_replace(path: &Path) -> Result<(), Failure> {
    let Ok(metadata) = path.metadata() else { return Ok(()) };
    let mut start = Vec::new();
    let mut read = || File::open(path)?.take(64 << 10).read_to_end(&mut start);
    if !metadata.is_file() || metadata.len() == 0 || (read().is_ok() && is_rule(&start)) {
        return Ok(());
    }
    Err(Failure::new(Exit::Usage, format!("cannot replace {}", names::path(path)))
        .fact("it is not a depfile of bvhc, and only those are written over")
        .help("name another with --depfile, or write over it with --force"))
}

/// One rule whose inputs stand in lines of their own, two spaces before each, and rules without inputs. A Makefile has recipes, or inputs beside the target.
fn is_rule(text: &[u8]) -> bool {
    let mut lines = text.split(|b| *b == b'\n').map(|line| line.strip_suffix(b"\r").unwrap_or(line));
    let first = lines.next().unwrap_or_default();
    let is_target = |line: &[u8]| line.ends_with(b":") && !line.starts_with(b"#") && !line.contains(&0);
    let begins = is_target(first.strip_suffix(b" \\").unwrap_or(first));
    // The last line may be cut where reading ended.
    let rest: Vec<&[u8]> = lines.collect();
    let whole = rest.split_last().map_or(&rest[..], |(_, whole)| whole);
    begins && whole.iter().all(|line| line.is_empty() || line.starts_with(b"  ") || is_target(line))
}

/// Escape one name: a backslash before a space or `#`, with the backslashes that precede it doubled; `$` as `$$`; a backslash
/// before a colon, but for the drive letters of Windows. A `%` stays: in a target, Make wants a backslash before it and Ninja
/// none, and only `--depfile-target` knows which of them reads. Names with line breaks cannot be written in this syntax at all.
fn escape(path: &Path) -> Result<Vec<u8>, Failure> {
    let name = path.as_os_str().as_encoded_bytes();
    if name.iter().any(|b| matches!(b, b'\n' | b'\r' | 0)) {
        return Err(Failure::new(Exit::Usage, "cannot write a depfile")
            .fact(format!("{} contains a line break, which the syntax of depfiles cannot express", names::path(path)))
            .help("rename the file, or build without --depfile"));
    }

    // Walk the bytes with the length of the run of backslashes that ends here: only before a space, a tab or `#` does Make
    // read backslashes as escapes, so only there they are doubled.
    let mut out = Vec::with_capacity(name.len() + 8);
    let mut backslashes = 0;
    for &b in name {
        match b {
            b' ' | b'\t' | b'#' => {
                out.extend(std::iter::repeat_n(b'\\', backslashes + 1));
                out.push(b);
            }
            b':' if !cfg!(windows) => out.extend_from_slice(b"\\:"),
            b'$' => out.extend_from_slice(b"$$"),
            _ => out.push(b),
        }
        backslashes = if b == b'\\' { backslashes + 1 } else { 0 };
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rendered(target: &str, inputs: &[&str], phony: bool) -> String {
        let inputs: Vec<PathBuf> = inputs.iter().map(PathBuf::from).collect();
        String::from_utf8(render(Path::new(target), &inputs, phony).unwrap()).unwrap()
    }

    #[test]
    fn one_rule_with_every_input_once() {
        assert_eq!(
            rendered("out/a.bvhc", &["a.gltf", "a.bin", "a.gltf"], false),
            "out/a.bvhc: \\\n  a.gltf \\\n  a.bin\n"
        );
    }

    #[test]
    fn phony_rules_follow() {
        assert_eq!(rendered("a.bvhc", &["a.obj"], true), "a.bvhc: \\\n  a.obj\n\na.obj:\n");
    }

    #[test]
    fn special_characters_are_escaped() {
        assert_eq!(rendered("o", &["my rock#1 $x.obj"], false), "o: \\\n  my\\ rock\\#1\\ $$x.obj\n");
        assert_eq!(rendered("o", &["a\\ b"], false), "o: \\\n  a\\\\\\ b\n");
        assert_eq!(rendered("o", &["a\\b"], false), "o: \\\n  a\\b\n");
        #[cfg(not(windows))]
        assert_eq!(rendered("o", &["a:b%"], false), "o: \\\n  a\\:b%\n");
    }

    #[test]
    fn only_depfiles_are_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let said = |text: &[u8]| {
            let path = folder.path().join("d");
            std::fs::write(&path, text).unwrap();
            may_replace(&path).is_ok()
        };
        assert!(said(b"") && said(&render(Path::new("a b"), &["c".into()], true).unwrap()));
        assert!(said(&render(Path::new("a"), &[], false).unwrap()) && may_replace(&folder.path().join("none")).is_ok());
        for model in [
            "v 0 0 0\n",
            "# made by: hand\nv 0 0 0\n",
            "{\"asset\": {}}",
            "glTF\0: ",
            "a.o: a.c b.h\n",
            "all:\n\tcc a.c\n",
            "all: \\\n  a.o\n\tcc a.c\n",
        ] {
            assert!(!said(model.as_bytes()), "{model}");
        }
    }

    #[test]
    fn line_breaks_are_refused() {
        assert!(render(Path::new("a\nb"), &[], false).is_err());
    }
}
