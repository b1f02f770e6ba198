//! Plain lines go another way than all others; what comes of them is the same.

use super::{TRIANGLE, error, read_as};
use crate::scene::{Degenerate, ReadOptions};

/// The same statements with a space before each line, which makes none of them plain.
fn indented(text: &str) -> String {
    let text = text.replace("\r\n", "\u{1}").replace('\r', "\r ").replace('\n', "\n ").replace('\u{1}', "\r\n ");
    format!(" {text}")
}

/// All that a file's reader says of it.
fn reading(text: &str) -> String {
    let options = ReadOptions { degenerate: Degenerate::Keep, vertices: true, ..ReadOptions::default() };
    match read_as(text, &options) {
        Ok(scene) => format!("{:?} {:?}", scene.meshes, scene.report),
        Err(error) => error.to_string(),
    }
}

/// Texts of a triangle and a dozen statements at random, with odd words in them.
pub(super) fn texts(count: usize) -> Vec<String> {
    let mut state = 1u64;
    let mut next = |n: usize| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize % n
    };
    const NUMBERS: [&str; 27] = [
        "0", "1", "2", "-1.5", ".5", "5.", "1e3", "1E-2", "+2", "0.125", "7", "-0",
        "3.25e+1", // plain, and others:
        "nan", "1.#IND", "1e", "--1", "1.2.3", "abc", "1_0", "inf", "0x10", "1e+", ".", "1e999", "-", "3#x",
    ];
    const CORNERS: [&str; 26] = [
        "1",
        "2",
        "3",
        "4",
        "5",
        "1/2",
        "2//3",
        "3/3/3",
        "4/",
        "2/x",
        "1",
        "2",
        "3", // plain, and others:
        "-1",
        "01",
        "0",
        "1/\\",
        "99",
        "12345678901",
        "18446744073709551617",
        "+1",
        "1/2#",
        "#",
        "x",
        "1-",
        "2/\u{b}",
    ];
    const ENDS: [&str; 12] =
        ["\n", "\n", "\n", "\r\n", "\r", " \n", "\t\r\n", " \\\n", "\\\n", " # c\n", " # c\\\n", "\u{c}\n"];
    const OTHERS: [&str; 14] = [
        "vn 0 0 1", "vt 0 0", "vn", "# c\\", "#", "o a", "g b", "g", "usemtl m", "l 1 2", "s off", "fo 1 2 3", "p 1",
        "",
    ];
    let mut texts = Vec::new();
    for _ in 0..count {
        // Odd words are rare in one half of the files, so that some of these can be read, and frequent in the other.
        let oddity = [40, 3][next(2)];
        let mut pick = |words: &[&'static str], plain: usize| match next(oddity) {
            0 => words[next(words.len())],
            _ => words[next(plain)],
        };
        let mut text = String::from(TRIANGLE);
        for _ in 0..12 {
            let kind = pick(&["v", "f", "v", "f", "other", "V", "fo", "vp"], 5);
            match kind {
                "other" => text += pick(&OTHERS, OTHERS.len()),
                _ => {
                    text += kind;
                    let count: usize = pick(&["3", "4", "5", "6", "2", "1", "0"], 3).parse().unwrap_or(0);
                    for _ in 0..count {
                        text += pick(&[" ", "  ", "\t", "\u{b}", " \\\n", "\u{a0}", ""], 3);
                        text += if kind == "v" { pick(&NUMBERS, 13) } else { pick(&CORNERS, 13) };
                    }
                }
            }
            text += pick(&ENDS, 5);
        }
        texts.push(text);
    }
    texts
}

#[test]
fn plain_lines_are_read_as_all_others() {
    let (mut read, mut refused) = (0, 0);
    for text in texts(4000) {
        let found = reading(&text);
        assert_eq!(found, reading(&indented(&text)), "{text:?}");
        *(if found.starts_with("cannot read") { &mut refused } else { &mut read }) += 1;
    }
    assert!(read > 500 && refused > 500, "{read} read, {refused} refused");
}

#[test]
fn errors_name_their_line_among_many_plain_ones() {
    let many = |n: usize| format!("{TRIANGLE}f 1 2 3\n{}", "v 0 0 0\nvn 0 0 1\nf 1/1 2/2 3/3\n".repeat(n));
    for n in [0, 1, 100, 5000] {
        let at = |line: usize, what: &str| format!("line {}: {what}", 4 + 3 * n + line);
        for (odd, line, what) in [
            ("v 0 zero 0\nf 0 0 0\n", 1, "'zero' is not a number"),
            ("f 1 2 0\nv 0 zero 0\n", 1, "a face uses vertex 0"),
            ("v 0 0 0\nf 1 2 x\nv 0 0\n", 2, "'x' is not a vertex number"),
            ("f 1 2 99999999\nv 0 zero 0\n", 1, "a face uses vertex 99999999"),
        ] {
            let found = error(format!("{}{odd}{}", many(n), many(10)));
            assert!(found.contains(&at(line, what)), "{n}: {found}");
        }
    }
}
