//! Lines as most exporters write them, each read in one loop over its bytes.
//!
//! What passes here holds nothing that this reader or `tobj` could find wrong, so that many lines can go to `tobj` at once and every error
//! still belongs to the one statement at hand. `None` leaves a line to the reader of statements, which knows all of them.

use super::lines::line_end;
use super::position::{Positions, has_weight};
use std::ops::Range;
use std::slice::Iter;

/// A line `v x y z` of plain decimal numbers.
pub(super) struct Position {
    /// Where the three numbers are, from the space before the first one on.
    pub numbers: Range<usize>,
    /// Whether a weight other than 1 follows them.
    pub weighted: bool,
    /// Length of the line with its end.
    pub length: usize,
}

/// Copy [`read_position`]; what follows the numbers is cut off.
pub(super) fn copy_position(text: &[u8], out: &mut Vec<u8>) -> Option<Position> {
    let position = read_position(text)?;
    out.push(b'v');
    out.extend_from_slice(&text[position.numbers.clone()]);
    out.push(b'\n');
    Some(position)
}

pub(super) fn read_position(text: &[u8]) -> Option<Position> {
    let mut bytes = text.get(1..)?.iter();
    let mut byte = *bytes.next()?;
    for _ in 0..3 {
        let first = skip_spaces(&mut bytes, byte)?;
        byte = skip_number(&mut bytes, first)?;
    }
    let end = text.len() - bytes.len() - 1;
    let length = match byte {
        b'\n' => end + 1,
        b'\r' if bytes.next() == Some(&b'\n') => end + 2,
        b' ' | b'\t' => end + passed_over(&text[end..])?,
        _ => return None,
    };
    let rest = &text[end..length];
    let weighted = matches!(byte, b' ' | b'\t') && has_weight(&rest[..line_end(rest).0]);
    Some(Position { numbers: 1..end, weighted, length })
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
    let mut bytes = text.get(1..)?.iter();
    let at = |bytes: &Iter<u8>| text.len() - bytes.len() - 1; // of the byte that was taken last
    let (mut copied, mut corners, mut byte) = (0, 0, *bytes.next()?);
    loop {
        while matches!(byte, b' ' | b'\t') {
            byte = *bytes.next()?;
        }
        match byte {
            b'\n' => break,
            b'\r' if bytes.next() == Some(&b'\n') => break,
            b'1'..=b'9' => {}
            _ => return None,
        }
        let (first, mut vertex) = (bytes.len(), 0u64);
        while byte.is_ascii_digit() {
            vertex = vertex.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
            byte = *bytes.next()?;
        }
        // Longer numbers may not have fitted.
        if first - bytes.len() > 10 || !take(vertex) {
            return None;
        }
        corners += 1;
        if byte == b'/' {
            copy(&text[copied..at(&bytes)]);
            while !matches!(byte, b' ' | b'\t' | b'\n' | b'\r') {
                // A backslash may go on in the next line, and old spaces end words as well.
                if matches!(byte, b'\\' | b'\x0b' | b'\x0c') {
                    return None;
                }
                byte = *bytes.next()?;
            }
            copied = at(&bytes);
        }
    }
    if corners < 3 {
        return None;
    }
    copy(&text[copied..=at(&bytes)]);
    Some((at(&bytes) + 1, corners))
}

/// The length of a line with its end, if its statement ends there and is not read any further.
pub(super) fn passed_over(text: &[u8]) -> Option<usize> {
    let (end, next) = line_end(text);
    let goes_on = text[..end].trim_ascii_end().last() == Some(&b'\\');
    (!goes_on).then_some(next)
}

/// The first byte behind spaces, of which `first` must be one.
fn skip_spaces(bytes: &mut Iter<u8>, first: u8) -> Option<u8> {
    let mut byte = matches!(first, b' ' | b'\t').then_some(first)?;
    while matches!(byte, b' ' | b'\t') {
        byte = *bytes.next()?;
    }
    Some(byte)
}

/// The first byte behind a decimal number that begins with `byte`, as [`f64`]'s own reader has it.
fn skip_number(bytes: &mut Iter<u8>, mut byte: u8) -> Option<u8> {
    let mut next = || bytes.next().copied();
    if matches!(byte, b'-' | b'+') {
        byte = next()?;
    }
    let mut digits = 0u64;
    while byte.is_ascii_digit() {
        digits += 1;
        byte = next()?;
    }
    if byte == b'.' {
        byte = next()?;
        while byte.is_ascii_digit() {
            digits += 1;
            byte = next()?;
        }
    }
    if digits == 0 {
        return None;
    }
    if matches!(byte, b'e' | b'E') {
        byte = next()?;
        if matches!(byte, b'-' | b'+') {
            byte = next()?;
        }
        if !byte.is_ascii_digit() {
            return None;
        }
        while byte.is_ascii_digit() {
            byte = next()?;
        }
    }
    Some(byte)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is copied of a text's first line, and how much of the text that takes.
    fn position(text: &str) -> Option<(String, usize)> {
        let mut out = Vec::new();
        let position = copy_position(text.as_bytes(), &mut out)?;
        Some((String::from_utf8(out).unwrap(), position.length))
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
            let copied = line.replace("\r\n", "\n");
            assert_eq!(position(&format!("{line}f 1 2 3\n")), Some((copied, line.len())), "{line}");
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
