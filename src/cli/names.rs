//! File names and other foreign text on a terminal.

use std::path::Path;

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

    #[cfg(unix)]
    #[test]
    fn bytes_outside_utf8_are_shown_as_hex() {
        use std::os::unix::ffi::OsStrExt;
        assert_eq!(path(Path::new(std::ffi::OsStr::from_bytes(b"a\xff.obj"))), "a\\xff.obj");
    }
}
