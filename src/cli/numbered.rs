//! Patterns of numbered files: what every command makes of a name such as `heli.%04d.obj` or `heli.####.bvhc`.

use super::exit::Exit;
use super::failure::Failure;
use super::figures;
use super::names;
use super::terminal::Terminal;
use crate::scene::frames::{Folder, NoPattern, Pattern, ranges};
use std::path::{Path, PathBuf};

/// The pattern that a path is; `None` for a plain name, and for one that exists. `action` is what would be done with the files, for errors.
pub fn pattern(path: &Path, action: &str) -> Option<Result<Pattern, Failure>> {
    if path.symlink_metadata().is_ok() {
        return None;
    }
    Some(Pattern::parse(path)?.map_err(|why| {
        Failure::new(Exit::Usage, format!("cannot {action} {}", names::path(path)))
            .fact(format!("no such file exists, and as a pattern of frames {why}"))
            .help(way_out(&why))
    }))
}

/// What to do about a name that is not quite a pattern.
pub fn way_out(why: &NoPattern) -> String {
    match why {
        NoPattern::NotUtf8 => "rename the files, or name them one by one".into(),
        NoPattern::Places(_) => "write the other numbers out, or take the name as it is with --literal".into(),
        NoPattern::List(_) => "write the list as 1001-1100, or give it to --frames".into(),
        NoPattern::Spaces { fixed, .. } => format!("write it so: '{}'", fixed.display()),
        NoPattern::InFolder => "build folder by folder, or take the path as it is with --literal".into(),
        _ => "write %04d for numbers of four digits".into(),
    }
}

/// What the pattern's folder has of it: one file at least, and no number twice.
pub fn folder(path: &Path, pattern: &Pattern, action: &str) -> Result<Folder, Failure> {
    let shown = names::path(path);
    let refuse = |exit, fact: String| Failure::new(exit, format!("cannot {action} {shown}")).fact(fact);
    let folder = Folder::read(pattern)
        .map_err(|e| refuse(Exit::Io, format!("cannot list {}: {e}", names::path(pattern.folder()))))
        .map_err(|refused| refused.help("check the name of the folder; paths start from the working directory"))?;
    if let Some((number, [a, b])) = &folder.twice {
        let fact = format!("frame {number} is there twice: {} and {}", names::escape(a), names::escape(b));
        return Err(refuse(Exit::Usage, fact).help("move one of them to another folder"));
    }
    if !folder.files.is_empty() {
        return Ok(folder);
    }
    Err(match folder.padded.values().next() {
        None => match &folder.beyond {
            Some(name) => refuse(Exit::Io, format!("the number of {} is beyond {}", names::escape(name), i32::MAX))
                .help("give frames smaller numbers"),
            None => refuse(Exit::Io, "no such file exists, and as a pattern of frames it matches none".into())
                .help(format!("see what is there: ls {}", names::path(pattern.folder()))),
        },
        Some((name, width)) => {
            let of = figures::counted(folder.padded.len() as u64, "file has", "files have");
            refuse(Exit::Io, format!("{of} its numbers with another padding, such as {}", names::escape(name))).help(
                match action {
                    "build" => format!("bvhc build '{}'", pattern.with_width(*width)),
                    _ => format!("name them so: '{}'", pattern.with_width(*width)),
                },
            )
        }
    })
}

/// What might not be meant by a pattern, as warnings: files that it leaves out.
pub fn left_out(path: &Path, folder: &Folder) -> Vec<String> {
    let shown = names::path(path);
    let padded = folder.padded.values().next().map(|(name, _)| {
        let count = figures::counted(folder.padded.len() as u64, "file", "files");
        format!("{shown}: {count} with another padding left out, such as {}", names::escape(name))
    });
    let beyond = folder
        .beyond
        .as_ref()
        .map(|name| format!("{shown}: a frame number beyond {} left out: {}", i32::MAX, names::escape(name)));
    padded.into_iter().chain(beyond).collect()
}

/// The files of a pattern in the order of their numbers; `None` for a plain name, and for one that exists. A list of numbers in the name chooses among them,
/// and all of these must be there.
pub fn files(path: &Path, action: &str, terminal: &Terminal) -> Option<Result<Vec<PathBuf>, Failure>> {
    Some(pattern(path, action)?.and_then(|pattern| {
        let there = folder(path, &pattern, action)?;
        left_out(path, &there).iter().for_each(|warning| terminal.warn(warning));
        let Some(wanted) = &pattern.numbers else {
            return Ok(there.files.values().map(|name| pattern.file(name)).collect());
        };
        let absent: Vec<i32> = wanted.list().iter().copied().filter(|n| !there.files.contains_key(n)).collect();
        if !absent.is_empty() {
            let some = if absent.len() == 1 { "a frame" } else { "frames" };
            return Err(Failure::new(Exit::Io, format!("cannot {action} {}", names::path(path)))
                .fact(format!(
                    "its list names {some} without a file: {}; there are {}",
                    ranges(&absent),
                    ranges(&there.files.keys().copied().collect::<Vec<_>>())
                ))
                .help("leave out the list, which takes those that are there"));
        }
        Ok(wanted.list().iter().map(|number| pattern.file(&there.files[number])).collect())
    }))
}

#[cfg(test)]
mod tests {
    use super::super::terminal::ColorChoice;
    use super::*;

    fn files(path: &Path) -> Option<Result<Vec<PathBuf>, Failure>> {
        super::files(path, "check", &Terminal::new(ColorChoice::Never, true, 0, false))
    }

    #[test]
    fn a_pattern_is_the_files_that_are_there_in_the_order_of_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["a.0009.bvhc", "a.0010.bvhc", "a.0012.bvhc", "a.7.bvhc", "b.####.bvhc"] {
            std::fs::write(at(name), "").unwrap();
        }
        let all = ["a.0009.bvhc", "a.0010.bvhc", "a.0012.bvhc"].map(at);
        for name in ["a.####.bvhc", "a.%04d.bvhc"] {
            assert_eq!(files(&at(name)).unwrap().unwrap(), all);
        }
        assert_eq!(files(&at("a.9-10####.bvhc")).unwrap().unwrap(), all[..2]);
        assert!(files(&at("a.7.bvhc")).is_none() && files(&at("b.####.bvhc")).is_none());

        let missing = files(&at("a.9-12####.bvhc")).unwrap().unwrap_err();
        assert_eq!(
            (missing.exit, missing.facts[0].as_str()),
            (Exit::Io, "its list names a frame without a file: 11; there are 9-10, 12")
        );
        let padded = files(&at("a.%03d.bvhc")).unwrap().unwrap_err();
        assert!(padded.facts[0].contains("another padding"), "{padded:?}");
        let none = files(&at("c.####.bvhc")).unwrap().unwrap_err();
        assert!(none.exit == Exit::Io && none.facts[0].contains("matches none"), "{none:?}");
    }
}
