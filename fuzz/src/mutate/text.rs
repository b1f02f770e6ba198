//! OBJ text: lines, words and numbers.

use super::{Bytes, Dice};

/// What stands in for a number.
const NUMBERS: [&str; 22] = [
    "0",
    "1",
    "-1",
    "2",
    "3",
    "-2",
    "255",
    "65535",
    "2147483647",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "-9223372036854775808",
    "99999999999999999999",
    "1e999",
    "-1e-999",
    "nan",
    "inf",
    "0.5",
    "1e38",
    "1e-45",
    "",
];

/// Lines to put in.
const LINES: [&str; 20] = [
    "v 0 0 0",
    "v 1 0 0",
    "v 0 1 0 0.5",
    "v 0 0 1 1 0 0",
    "f 1 2 3",
    "f 1 2 3 4",
    "f -1 -2 -3",
    "f 1/1/1 2/2/2 3/3/3",
    "f 1//1 2//1 3//1",
    "f 1 2 3 4 5 6 7",
    "g a b",
    "o c",
    "usemtl m",
    "mtllib m.mtl",
    "s off",
    "l 1 2 3",
    "p 1",
    "vt 0 0",
    "f 1 2 \\",
    "vn 0 0 1",
];

pub fn change(text: &mut Vec<u8>, dice: &mut Dice, raw: &mut Bytes) {
    match dice.below(10) {
        0 | 1 => raw.change(text),
        2 | 3 => of_lines(text, dice),
        4 => of_separators(text, dice),
        5 => polygon(text, dice),
        _ => of_numbers(text, dice),
    }
    text.truncate(raw.room);
}

/// Replace the next number by an edge case, or by a near one.
fn of_numbers(text: &mut Vec<u8>, dice: &mut Dice) {
    let is_number = |b: &u8| b.is_ascii_digit() || matches!(b, b'-' | b'.' | b'e');
    let from = dice.below(text.len());
    let Some(start) = text[from..].iter().position(is_number).map(|at| at + from) else { return };
    let length = text[start..].iter().take_while(|b| is_number(b)).count();
    let new = match dice.below(3) {
        0 => NUMBERS[dice.below(NUMBERS.len())].to_owned(),
        1 => (dice.below(24) as i64 - 8).to_string(),
        _ => format!("{}", f32::from_bits(dice.roll() as u32)),
    };
    text.splice(start..start + length, new.bytes());
}

/// Lines put in, dropped, doubled and moved.
fn of_lines(text: &mut Vec<u8>, dice: &mut Dice) {
    let mut lines: Vec<&[u8]> = text.split(|b| *b == b'\n').collect();
    let (i, j) = (dice.below(lines.len()), dice.below(lines.len()));
    match dice.below(5) {
        0 => drop(lines.remove(i)),
        1 => lines.insert(i, lines[j]),
        2 => lines.swap(i, j),
        _ => lines.insert(i, LINES[dice.below(LINES.len())].as_bytes()),
    }
    *text = lines.join(&b'\n');
}

/// One separator becomes another.
fn of_separators(text: &mut [u8], dice: &mut Dice) {
    let is_separator = |b: &u8| matches!(b, b' ' | b'\t' | b'\n' | b'\r' | b'/' | b'\\' | b'#');
    let from = dice.below(text.len());
    if let Some(at) = text[from..].iter().position(is_separator) {
        text[from + at] = dice.of(b" \t\n\r/\\#\x0b\x1a\x00");
    }
}

/// A face of many corners, on a coarse grid where edges touch and cross.
fn polygon(text: &mut Vec<u8>, dice: &mut Dice) {
    let corners = 4 + dice.below(20);
    let grid = 1 + dice.below(6);
    let mut lines = String::from("\n");
    for _ in 0..corners {
        let (x, y, z) = (dice.below(grid), dice.below(grid), if dice.one_in(8) { 1 } else { 0 });
        lines.push_str(&format!("v {x} {y} {z}\n"));
    }
    lines.push('f');
    (1..=corners).for_each(|k| lines.push_str(&format!(" -{k}")));
    lines.push('\n');
    text.extend(lines.bytes());
}
