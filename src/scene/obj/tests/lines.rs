//! Lines, and what is no OBJ at all.

use super::{TRIANGLE, corners, error, read, read_as};
use crate::scene::{Format, ReadOptions, Resemblance, SceneError, read_bytes};

#[test]
fn line_ends_continuations_and_odd_spaces() {
    let want = corners(&read(format!("{TRIANGLE}f 1 2 3\n")));
    let crlf = format!("{TRIANGLE}f 1 2 3\n").replace('\n', "\r\n");
    let cr_only = crlf.replace("\r\n", "\r");
    let tabs = "\u{feff}  v\t0  0 0 \n\n v 1 0 0\nv 0 1 0\t\n\tf  1\t2 3  # the end";
    let joined = "v 0 \\\n0 0\nv 1 0 0\nv 0 1 0\nf 1 \\\r\n2 \\\n 3\\";
    let comments = "# C:\\folder\\\nv 0 0 0 # first\nv 1 0 0\nv 0 1 0\ng a\\\nf 1 2 3";
    let latin1 = b"o caf\xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\n# \xff\nf 1 2 3".as_slice();
    for text in [crlf.as_bytes(), cr_only.as_bytes(), tabs.as_bytes(), joined.as_bytes(), comments.as_bytes(), latin1] {
        assert_eq!(corners(&read(text)), want, "{}", String::from_utf8_lossy(text));
    }
}

#[test]
fn nul_bytes_are_read_over_at_the_end_and_nowhere_else() {
    let want = corners(&read(format!("{TRIANGLE}f 1 2 3\n")));
    for comment in [0, 5000] {
        for end in ["\0", "\n\0\0\0\0", "\0\0\n\0\r\n", "\n\x1a", "\n\x1a\0\0"] {
            let text = format!("#{}\n{TRIANGLE}f 1 2 3{end}", "-".repeat(comment));
            assert_eq!(corners(&read(&text)), want, "{text:?}");
        }
        for inside in ["v 0 0 0\0\n", "# a\0b\n", "\0\n"] {
            let text = format!("#{}\n{inside}{TRIANGLE}f 1 2 3\n", "-".repeat(comment));
            assert!(error(&text).contains("line 2: it has a NUL byte"), "{}", error(&text));
        }
    }
    let lines = error("# one\rv 0 0 0\r\n\nv 0 \0 0\nf 1 2 3\n");
    assert!(lines.contains("line 4: it has a NUL byte"), "each kind of line end counts once: {lines}");
    assert!(read("\0\0\0").meshes.is_empty());
}

#[test]
fn a_text_without_any_statement_is_no_obj() {
    let is_refused = |text: &str, begins: &str, like: Resemblance| match read_as(text, &ReadOptions::default()) {
        Err(SceneError::NotObj { found, resembles, .. }) => {
            assert!(found.contains(begins) && resembles == like, "{found} {resembles:?}")
        }
        other => panic!("{other:?}"),
    };
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:0123\nsize 2380763\n";
    is_refused(pointer, "version", Resemblance::LfsPointer);
    is_refused("\n <!DOCTYPE html><html><body>Not Found</body></html>\n", "<!DOCTYPE", Resemblance::WebPage);
    is_refused("# shouting\nV 0 0 0\nV 1 0 0\nV 0 1 0\nF 1 2 3\n", "V 0 0 0", Resemblance::Capitals);
    is_refused("{\"asset\":{\"version\":\"2.0\"}}", "{", Resemblance::Json);
    is_refused("solid cube\nfacet normal 0 0 1\nendsolid\n", "'solid cube'", Resemblance::Nothing);
    is_refused("Access denied \\\n to this file", "'Access denied", Resemblance::Nothing);
    // One statement is enough, wherever it stands and whatever else there is.
    assert_eq!(read(format!("exported by hand\n{TRIANGLE}f 1 2 3\n")).meshes.len(), 1);
    assert!(read("\\\nv 0 0 0\n").meshes.is_empty());
}

#[test]
fn statements_that_are_not_known_are_counted_and_the_first_is_named() {
    let text =
        format!("{TRIANGLE}f 1 2 3\n<<<<<<< ours\nF 1 2 3\n=======\ncall part.obj\n>>>>>>> theirs\nf 3 2 \\\n1\n");
    let report = read(&text).report;
    let first = report.first_unknown_statement.unwrap();
    assert_eq!((report.unknown_statements, first.line, first.word.as_str()), (5, 5, "<<<<<<<"));
    // A statement of several lines is one, with the number of its first line; a long word is shortened.
    let report = read(format!("{TRIANGLE}f 1 2 3\n\nX{} \\\n 2\nF\n", "x".repeat(500))).report;
    let first = report.first_unknown_statement.unwrap();
    assert_eq!((report.unknown_statements, first.line), (2, 6));
    assert!(first.word.starts_with("Xxx") && first.word.len() < 200, "{}", first.word);

    // What the format knows and triangles do not need says nothing, nor does a comment.
    let silent = "vp 0 0\ns off\nmtllib a.mtl\nusemtl b\ncstype bezier\ndeg 3\nparm u 0 1\nend\nlod 1\nshadow_obj a\n#F\n # F\n\nt crease 1\n";
    let report = read(format!("{TRIANGLE}{silent}f 1 2 3\nbzp 1 2 3\ncdc 1 2 3 1\ncurv 0 1 1 2\n")).report;
    assert_eq!((report.unknown_statements, report.first_unknown_statement, report.skipped_primitives), (0, None, 3));
}

#[test]
fn text_of_two_bytes_a_character_is_told_as_such() {
    let text = format!("{TRIANGLE}f 1 2 3\n");
    let wide = |mark: &str, bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
        format!("{mark}{text}").encode_utf16().flat_map(bytes).collect()
    };
    for mark in ["\u{feff}", ""] {
        for bytes in [wide(mark, u16::to_le_bytes), wide(mark, u16::to_be_bytes)] {
            for format in [Some(Format::Obj), Some(Format::Gltf), None] {
                match read_bytes(bytes.clone(), "a", format, None, &ReadOptions::default()) {
                    Err(error @ SceneError::InPlaceOfData { resembles: Resemblance::Utf16, .. }) => {
                        assert!(error.to_string().contains("text in UTF-16"), "{error}")
                    }
                    other => panic!("{format:?}: {other:?}"),
                }
            }
        }
    }
    assert!(error("v\0\0\0 \0\0\x000\0\0\0").contains("NUL"), "UTF-32 and other binary data");
}
