//! A text that is read in ranges says what it says statement by statement.

use super::plain::texts;
use crate::exec::Executor;
use crate::scene::source::Source;
use crate::scene::{Degenerate, ReadOptions};
use std::path::Path;

/// All that a reader says of a text, and what it was charged for: `None` reads statement by statement, else ranges have about so many bytes. And
/// whether it was read in ranges.
fn reading(text: &str, range: Option<usize>, options: &ReadOptions, exec: &Executor) -> (String, bool) {
    let mut progress = |_, _| ();
    let mut source = Source::new(Path::new("test.obj"), None, options, exec, &mut progress);
    let in_ranges = range.is_some_and(|range| {
        let mut unused = |_, _| ();
        let mut source = Source::new(Path::new("test.obj"), None, options, exec, &mut unused);
        super::super::ranges::read(text.as_bytes(), range, &mut source).is_some()
    });
    let said = match super::super::parse_in(text.as_bytes().to_vec(), range, &mut source) {
        Ok(scene) => {
            format!("{:?} {:?} {:?} {}", scene.meshes, scene.report, scene.rounding, source.available())
        }
        Err(error) => error.to_string(),
    };
    (said, in_ranges)
}

/// Hold readings in ranges of several lengths, on one thread and on two, against the one statement by statement. Whether ranges were read.
fn hold(text: &str, exec: &Executor) -> bool {
    let options = ReadOptions { degenerate: Degenerate::Keep, ..ReadOptions::default() };
    let numbered = ReadOptions { vertices: true, faces: true, ..options.clone() };
    let mut in_ranges = false;
    for options in [&options, &numbered] {
        let (expected, _) = reading(text, None, options, &Executor::sequential());
        for range in [0, 40, 1 << 19] {
            let (found, ranges) = reading(text, Some(range), options, exec);
            assert_eq!(found, expected, "ranges of {range} bytes: {text:?}");
            in_ranges |= ranges;
        }
    }
    in_ranges
}

#[test]
fn any_text_is_read_alike_in_ranges_of_any_length() {
    let exec = Executor::new(2).unwrap();
    let in_ranges = texts(1500).iter().filter(|text| hold(text, &exec)).count();
    assert!((100..1400).contains(&in_ranges), "{in_ranges} were read in ranges");
}

#[test]
fn everyday_texts_are_read_in_ranges() {
    let exec = Executor::new(2).unwrap();
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let concave = "v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nv -1 -1 0\n";
    for text in [
        format!(
            "# made by hand\nmtllib a.mtl\no one\n{square}vt 0 0\nvn 0 0 1\ng a\nusemtl m\ns off\nf 1/1/1 2/1/1 3/1/1\nf 1 3 4\n"
        ),
        "v 0 0 0 2\nv 1 0 0 1.000\nv 0 1 0 .5 # half\nv 1 1 0 0.5 0.5 0.5\nv\t1e0 1 1 9\nf 1 2 3 4\nf 2 3 5\n".into(),
        format!("{square}f 1 2 3 4\n{square}f -4 -3 -2 -1\nf -1 -2 -6\n"),
        format!("{concave}f 1 2 3 4 5\nf 1 2 3\nl 1 2\np 3\n\n   f  1  2  3  \n"),
        // Parts share positions, and come back.
        format!("{square}{concave}o a\nf 1 2 3\no b\nf 1 2 3 4\nf 9 8 7\no a\nf 3 2 1\ng\nf 4 3 2\nv 7 7 7\n"),
        // More positions than one face of `tobj` hands out.
        format!("{}f 1 128 129\nf -1 2 65\n", (0..129).map(|i| format!("v {i} {} 0.5\n", i * i)).collect::<String>()),
        format!("\u{feff}{}", square.replace('\n', "\r\n") + "f 1 2 3\r\n"),
    ] {
        assert!(hold(&text, &exec), "{text}");
    }
}

#[test]
fn any_number_of_positions_is_read_in_a_range() {
    let exec = Executor::sequential();
    for count in (3..12).chain(120..135).chain(250..260).chain([383, 384, 2047, 2048, 5001]) {
        let positions: String = (0..count).map(|i| format!("v {i} -{i}.5 0.{i}\n")).collect();
        assert!(hold(&format!("{positions}f 1 2 {count}\n"), &exec), "{count}");
    }
}

#[test]
fn what_depends_on_other_lines_is_read_statement_by_statement() {
    let exec = Executor::sequential();
    let triangle = super::TRIANGLE;
    let many = format!("f{}\n", " 1 2 3".repeat(400));
    for text in [
        format!("{triangle}f 1 2 4\nv 0 0 1\n"),
        format!("{triangle}f 1 2 -4\n"),
        format!("{triangle}f 1 2 3\nf 1 2\n"),
        format!("{triangle}f 1 2 \\\n3\n"),
        format!("{triangle}f 1 2 3\nV 1 2 3\n"),
        format!("{triangle}f 1 2 3\nv 1 2 x\n"),
        format!("{triangle}{many}"),
        triangle.to_owned(),
        String::new(),
    ] {
        assert!(!hold(&text, &exec), "{text}");
    }
}

#[test]
fn a_text_is_charged_for_alike_where_there_is_little_memory() {
    let text = format!("{}f 1 2 3\n", super::TRIANGLE);
    let exec = Executor::sequential();
    let mut failed = 0;
    for max_memory in 0..1500 {
        let options = ReadOptions { max_memory, ..ReadOptions::default() };
        let [by_statement, in_ranges] = [None, Some(8)].map(|range| reading(&text, range, &options, &exec).0);
        assert_eq!(by_statement, in_ranges);
        failed += u64::from(by_statement.contains("the limit is"));
    }
    assert!((1..1500).contains(&failed));
}
