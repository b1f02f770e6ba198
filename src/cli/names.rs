//! File names and other foreign text on a terminal.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Foreign text made safe to print: control, bidirectional and invisible characters are shown as escapes, so that a name
/// can neither move the cursor nor pretend to be another one.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if misleads(c) { out.extend(c.escape_unicode()) } else { out.push(c) }
    }
    out
}

/// A path as the user reads it: escaped, bytes that are not UTF-8 as `\xNN`, quoted only if it holds a space or is empty.
pub fn path(path: &Path) -> String {
    let mut out = String::new();
    for chunk in path.as_os_str().as_encoded_bytes().utf8_chunks() {
        out.push_str(&escape(chunk.valid()));
        for byte in chunk.invalid() {
            out.push_str(&format!("\\x{byte:02x}"));
        }
    }
    if out.is_empty() || out.contains(' ') { format!("'{out}'") } else { out }
}

/// A file's own name, without its folder.
pub fn file(full: &Path) -> String {
    path(Path::new(full.file_name().unwrap_or(full.as_os_str())))
}

/// Names of files as headings of columns: the folders that all share are left out, and long names lose their middle as far as
/// they stay distinct.
pub fn headings(paths: &[&Path]) -> Vec<String> {
    let folders = |p: &Path| p.parent().map(|f| f.components().count()).unwrap_or(0);
    let common = |n: usize| paths.iter().all(|p| p.components().take(n).eq(paths[0].components().take(n)));
    let most = paths.iter().map(|p| folders(p)).min().unwrap_or(0);
    let shared = (0..=most).rev().find(|n| common(*n)).unwrap_or(0);
    let full: Vec<String> = paths.iter().map(|p| path(&p.components().skip(shared).collect::<PathBuf>())).collect();
    let distinct = |names: &[String]| names.iter().collect::<BTreeSet<_>>().len();
    let short = |width: usize| full.iter().map(|name| without_middle(name, width)).collect::<Vec<_>>();
    let mut widths = [18, 24, 32, 48].into_iter().map(short);
    widths.find(|names| distinct(names) == distinct(&full)).unwrap_or(full)
}

fn without_middle(name: &str, width: usize) -> String {
    let length = name.chars().count();
    if length <= width {
        return name.to_string();
    }
    let (head, tail) = (width / 2 - 1, width / 2);
    name.chars().take(head).chain(['…']).chain(name.chars().skip(length - tail)).collect()
}

fn misleads(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{ad}' | '\u{61c}' | '\u{115f}' | '\u{1160}' | '\u{180e}'
            | '\u{200b}'..='\u{200f}'
            | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}'
            | '\u{3164}' | '\u{feff}' | '\u{ffa0}'
            | '\u{fff9}'..='\u{fffb}'
            | '\u{e0000}'..='\u{e007f}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_that_could_mislead_is_shown_as_escapes() {
        assert_eq!(escape("rock\u{1b}[31m.obj"), "rock\\u{1b}[31m.obj");
        assert_eq!(escape("a\u{202e}jbo.b"), "a\\u{202e}jbo.b");
        assert_eq!(escape("a\u{200b}b\nc"), "a\\u{200b}b\\u{a}c");
        assert_eq!(escape("Stühle-椅子.obj"), "Stühle-椅子.obj");
    }

    #[test]
    fn paths_are_quoted_only_when_they_hold_a_space() {
        assert_eq!(path(Path::new("a/b.obj")), "a/b.obj");
        assert_eq!(path(Path::new("a b.obj")), "'a b.obj'");
        assert_eq!(path(Path::new("")), "''");
    }

    #[test]
    fn headings_are_short_and_distinct() {
        let of = |paths: &[&str]| headings(&paths.iter().map(Path::new).collect::<Vec<_>>());
        assert_eq!(of(&["out/caches/a.bvhc"]), ["a.bvhc"]);
        assert_eq!(of(&["out/x/a.bvhc", "out/y/a.bvhc", "out/y/b.bvhc"]), ["x/a.bvhc", "y/a.bvhc", "y/b.bvhc"]);
        assert_eq!(of(&["/a/b.bvhc", "c.bvhc"]), ["/a/b.bvhc", "c.bvhc"]);
        let long = of(&["animation_of_a_horse.0001.bvhc", "animation_of_a_horse.0002.bvhc"]);
        assert_eq!(long, ["animatio….0001.bvhc", "animatio….0002.bvhc"].map(|s| s.replace("….", "…")));
        let equal = "one_name_that_is_rather_long.bvhc";
        assert_eq!(of(&[equal, equal]).len(), 2);
        let middle = of(&["prefix_one_A_and_more_text.bvhc", "prefix_one_B_and_more_text.bvhc"]);
        assert_ne!(middle[0], middle[1]);
        assert_eq!(of(&[]), [""; 0]);
    }

    #[cfg(unix)]
    #[test]
    fn bytes_outside_utf8_are_shown_as_hex() {
        use std::os::unix::ffi::OsStrExt;
        assert_eq!(path(Path::new(std::ffi::OsStr::from_bytes(b"a\xff.obj"))), "a\\xff.obj");
    }
}
