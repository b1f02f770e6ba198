//! Lines as most exporters write them, each read in one loop over its bytes.
//!
//! What passes here holds nothing that this reader or `tobj` could find wrong, so that many lines can go to `tobj` at once and every error
//! still belongs to the one statement at hand. `None` leaves a line to the reader of statements, which knows all of them.

use super::lines::line_end;
use super::position::Positions;

/// Copy `v x y z` of plain decimal numbers; what follows them is cut off. The length of the line with its end.
pub(super) fn copy_position(text: &[u8], out: &mut Vec<u8>) -> Option<usize> {
    let mut at = 1;
    for _ in 0..3 {
        at = skip_number(text, skip_spaces(text, at)?)?;
    }
    match text.get(at..)? {
        [b'\n', ..] => at += 1,
        [b'\r', b'\n', ..] => at += 2,
        rest @ [b' ' | b'\t', ..] => {
            let length = passed_over(rest)?;
            out.extend_from_slice(&text[..at]);
            out.push(b'\n');
            return Some(at + length);
        }
        _ => return None,
    }
    out.extend_from_slice(&text[..at]);
    Some(at)
}

/// Copy `f a b c …`, of which all positions are there, without the numbers behind slashes. The length of the line with its end, and the
/// number of corners.
pub(super) fn copy_face(text: &[u8], positions: &mut Positions, out: &mut Vec<u8>) -> Option<(usize, u64)> {
    let before = out.len();
    let copied = go_over_face(text, |vertex| positions.mark(vertex), |text| out.extend_from_slice(text));
    if copied.is_none() {
        out.truncate(before);
    }
    copied
}

/// Hand the vertices of `f a b c …` to `take`, which refuses one by `false`. The length of the line with its end, and the number of corners.
pub(super) fn read_face(text: &[u8], take: impl FnMut(u64) -> bool) -> Option<(usize, u64)> {
    go_over_face(text, take, |_| ())
}

/// `copy` gets the text without the numbers behind slashes, piece by piece.
fn go_over_face(text: &[u8], mut take: impl FnMut(u64) -> bool, mut copy: impl FnMut(&[u8])) -> Option<(usize, u64)> {
    let (mut at, mut copied, mut corners) = (1, 0, 0);
    loop {
        match text.get(at)? {
            b' ' | b'\t' => {
                at += 1;
                continue;
            }
            b'\n' => break,
            b'\r' if text.get(at + 1) == Some(&b'\n') => {
                at += 1;
                break;
            }
            b'1'..=b'9' => {}
            _ => return None,
        }
        let (first, mut vertex) = (at, 0u64);
        while let Some(digit @ b'0'..=b'9') = text.get(at) {
            vertex = vertex.wrapping_mul(10).wrapping_add(u64::from(digit - b'0'));
            at += 1;
        }
        // Longer numbers may not have fitted.
        if at - first > 10 || !take(vertex) {
            return None;
        }
        corners += 1;
        if text.get(at) == Some(&b'/') {
            copy(&text[copied..at]);
            while !matches!(text.get(at)?, b' ' | b'\t' | b'\n' | b'\r') {
                // A backslash may go on in the next line, and old spaces end words as well.
                if matches!(text[at], b'\\' | b'\x0b' | b'\x0c') {
                    return None;
                }
                at += 1;
            }
            copied = at;
        }
    }
    if corners < 3 {
        return None;
    }
    copy(&text[copied..=at]);
    Some((at + 1, corners))
}

/// The length of a line with its end, if its statement ends there and is not read any further.
pub(super) fn passed_over(text: &[u8]) -> Option<usize> {
    let (end, next) = line_end(text);
    let goes_on = text[..end].trim_ascii_end().last() == Some(&b'\\');
    (!goes_on).then_some(next)
}

/// Where the spaces end that must stand here.
fn skip_spaces(text: &[u8], at: usize) -> Option<usize> {
    let spaces = text.get(at..)?.iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
    (spaces > 0).then_some(at + spaces)
}

/// Where the decimal number that must stand here ends, as [`f64`]'s own reader has it.
fn skip_number(text: &[u8], mut at: usize) -> Option<usize> {
    let skip_digits = |from: usize| {
        let mut at = from;
        while matches!(text.get(at), Some(b'0'..=b'9')) {
            at += 1;
        }
        at
    };
    if matches!(text.get(at)?, b'-' | b'+') {
        at += 1;
    }
    let whole = skip_digits(at);
    let mut digits = whole - at;
    at = whole;
    if text.get(at) == Some(&b'.') {
        let end = skip_digits(at + 1);
        digits += end - (at + 1);
        at = end;
    }
    if digits == 0 {
        return None;
    }
    if matches!(text.get(at), Some(b'e' | b'E')) {
        at += 1;
        if matches!(text.get(at)?, b'-' | b'+') {
            at += 1;
        }
        let end = skip_digits(at);
        if end == at {
            return None;
        }
        at = end;
    }
    Some(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is copied of a text's first line, and how much of the text that takes.
    fn position(text: &str) -> Option<(String, usize)> {
        let mut out = Vec::new();
        let length = copy_position(text.as_bytes(), &mut out)?;
        Some((String::from_utf8(out).unwrap(), length))
    }

    fn face(text: &str) -> Option<(String, usize, u64)> {
        let mut positions = Positions::default();
        (0..12).for_each(|_| assert!(positions.add()));
        let mut out = b"before\n".to_vec();
        let copied = copy_face(text.as_bytes(), &mut positions, &mut out);
        let text = String::from_utf8(out).unwrap();
        let text = text.strip_prefix("before\n").unwrap();
        assert!(copied.is_some() || text.is_empty(), "{text}");
        copied.map(|(length, corners)| (text.into(), length, corners))
    }

    #[test]
    fn positions_are_copied_up_to_their_third_number() {
        for line in ["v 1 2 3\n", "v\t-1.5 \t.5e-3  +7.\r\n", "v 1e5 0.25E+10 00\n"] {
            assert_eq!(position(&format!("{line}f 1 2 3\n")), Some((line.into(), line.len())), "{line}");
        }
        for tail in [" \n", " 0.5 nan x\n", "\t# a comment\r\n", " 1 1 1\r"] {
            let line = format!("v 1 2 3{tail}");
            assert_eq!(position(&format!("{line}v")), Some(("v 1 2 3\n".into(), line.len())), "{line}");
        }
        for other in [
            "v 1 2\n",
            "v 1 2 3",
            "v 1 2 3\rv",
            "v1 2 3\n",
            "v 1 2 nan\n",
            "v 1 2 -\n",
            "v 1 2 .\n",
            "v 1 2 3e\n",
            "v 1 2 3e+\n",
            "v 1 2 3#\n",
            "v 1 2 3\\\n4",
            "v 1 2 3 \\ \n4",
            "v 1 2 \\\n3\n",
            "v 1,5 2 3\n",
            "v 1 2 ٣\n",
            "v",
        ] {
            assert_eq!(position(other), None, "{other}");
        }
    }

    #[test]
    fn faces_are_copied_without_what_is_behind_slashes() {
        for line in ["f 1 2 3\n", "f\t12 11 \t10  9\r\n"] {
            let corners = line.split_ascii_whitespace().count() as u64 - 1;
            assert_eq!(face(&format!("{line}f")), Some((line.into(), line.len(), corners)), "{line}");
        }
        for (line, want) in [
            ("f 1/2/3 4//5 6/\n", "f 1 4 6\n"),
            ("f 1 2/2 3 12/x#,\r\n", "f 1 2 3 12\r\n"),
            ("f 1/1 2/2 3/3 \n", "f 1 2 3 \n"),
        ] {
            let corners = want.split_ascii_whitespace().count() as u64 - 1;
            assert_eq!(face(line), Some((want.into(), line.len(), corners)), "{line}");
        }
        for other in [
            "f 1 2\n",
            "f 1 2 3",
            "f 1 2 3\rf",
            "f 1 2 13\n",
            "f 0 1 2\n",
            "f 01 2 3\n",
            "f -1 2 3\n",
            "f 1 2 18446744073709551617\n",
            "f 1 2 3 # a\n",
            "f 1 2 3#\n",
            "f 1 2 3 \\\n4\n",
            "f 1/2\\\n 3 4\n",
            "f 1/2\x0b3 3 4\n",
            "f 1 2 3.\n",
            "f",
        ] {
            assert_eq!(face(other), None, "{other}");
        }
    }

    #[test]
    fn lines_that_go_on_are_not_passed_over() {
        assert_eq!(passed_over(b"vn 0 0 1\r\nv"), Some(10));
        assert_eq!(passed_over(b"vn 0 0 1"), Some(8));
        assert_eq!(passed_over(b"vn 0 0 \\ \n1\n"), None);
    }
}
