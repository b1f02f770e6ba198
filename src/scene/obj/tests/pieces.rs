//! A file that is read in pieces says what its text says, and has its hash.

use super::super::pieces::{self, Other};
use super::plain::texts;
use crate::exec::Executor;
use crate::scene::source::Source;
use crate::scene::{Degenerate, ReadOptions, Scene, SceneError};
use std::path::Path;

fn said(scene: Result<Scene, SceneError>) -> String {
    match scene {
        Ok(scene) => format!("{:?} {:?} {:?}", scene.meshes, scene.report, scene.rounding),
        Err(error) => error.to_string(),
    }
}

/// Hold a file in pieces of 1,024 bytes, on one thread and on two, against its text as a whole. Whether it was read in pieces.
fn hold(text: &[u8], folder: &Path) -> bool {
    let path = folder.join("test.obj");
    std::fs::write(&path, text).unwrap();
    let options = ReadOptions { degenerate: Degenerate::Keep, vertices: true, ..ReadOptions::default() };
    let mut found = Vec::new();
    for exec in [Executor::sequential(), Executor::new(2).unwrap()] {
        let (mut unused, mut progress) = (|_, _| (), |_, _| ());
        let mut source = Source::new(&path, None, &options, &exec, &mut progress);
        let read = pieces::read(1024, &mut source);
        found.push(read.is_ok());
        let Ok(read) = read else { continue };
        assert_eq!((read.len, read.blake3), (text.len() as u64, *blake3::hash(text).as_bytes()));
        let mut whole = Source::new(&path, None, &options, &exec, &mut unused);
        let expected = said(super::super::parse_in(text.to_vec(), None, &mut whole));
        assert_eq!(
            said(super::super::scene_of(read.text, &mut source)),
            expected,
            "{:?}",
            String::from_utf8_lossy(text)
        );
    }
    assert_eq!(found[0], found[1], "threads make no difference");
    found[0]
}

fn square(lines: &str) -> String {
    format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n{lines}")
}

#[test]
fn any_file_is_read_in_pieces_as_a_whole() {
    let folder = tempfile::tempdir().unwrap();
    let everyday: Vec<String> = texts(400)
        .into_iter()
        .filter(|text| {
            let exec = Executor::sequential();
            let (options, mut progress) = (ReadOptions::default(), |_, _| ());
            let mut source = Source::new(Path::new("test.obj"), None, &options, &exec, &mut progress);
            super::super::ranges::read(text.as_bytes(), 1 << 19, &mut source).is_some()
        })
        .collect();
    assert!(everyday.len() > 50, "{}", everyday.len());
    let mut in_pieces = 0;
    for first in 0..everyday.len() {
        // Lines end at every place of a piece in turn.
        let text: String = (0..30).map(|i| format!("{}\n", everyday[(first + i) % everyday.len()])).collect();
        in_pieces += u32::from(hold(text.as_bytes(), folder.path()));
    }
    assert!(in_pieces > 20, "{in_pieces}");
}

#[test]
fn lines_between_two_pieces_are_whole() {
    let folder = tempfile::tempdir().unwrap();
    for shift in 0..40 {
        for end in ["\n", "\r\n"] {
            let faces = "g a\nf 1 2 3\nf 1/1 3/2/1 4//7\nf -4 -3 -2\nvn 0 0 1\n".repeat(60);
            let text = square(&format!("# {}\n{faces}", "x".repeat(shift))).replace('\n', end);
            assert!(hold(text.as_bytes(), folder.path()), "{shift}");
        }
    }
    // A line that is longer than a piece has no end in it; the last line needs none.
    assert!(!hold(square(&format!("# {}\nf 1 2 3\n", "x".repeat(5000))).as_bytes(), folder.path()));
    assert!(hold(format!("\u{feff}{}f 1 2 3", square(&"f 1 2 3\n".repeat(200))).as_bytes(), folder.path()));
    assert!(hold(square(&format!("{}f 1 2 3\r", "f 1 2 3\rf 1 3 4\r\n".repeat(200))).as_bytes(), folder.path()));
}

#[test]
fn files_of_any_number_of_pieces_have_their_hash() {
    let folder = tempfile::tempdir().unwrap();
    for length in (1025..12_000).step_by(511).chain([2048, 3072, 4096, 8192, 1 << 16]) {
        let mut text = square("f 1 2 3\n");
        while text.len() + 8 <= length {
            text += "f 1 2 3\n";
        }
        text += &"\n".repeat(length - text.len());
        assert!(hold(text.as_bytes(), folder.path()), "{length}");
    }
}

#[test]
fn what_needs_the_whole_text_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let many = "f 1 2 3\n".repeat(300);
    for text in [
        square("f 1 2 3\n"),
        square(&format!("{many}f 1 2 \\\n3\n")),
        square(&format!("{many}f 1 2 9\n")),
        square(&format!("{many}nonsense\n")),
        square(&format!("{many}\0\0\0\n")),
        "\u{feff}# nothing\n".repeat(100),
    ] {
        assert!(!hold(text.as_bytes(), folder.path()), "{text:?}");
    }
    let (exec, options, mut progress) = (Executor::sequential(), ReadOptions::default(), |_, _| ());
    let path = folder.path().join("absent.obj");
    assert!(pieces::read(1024, &mut Source::new(&path, None, &options, &exec, &mut progress)).is_err());
}

#[test]
fn a_text_that_needs_another_reader_is_told_from_a_file_that_does() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("test.obj");
    let options = ReadOptions::default();
    let many = "f 1 2 3\n".repeat(300);
    for (text, other) in [
        (square("f 1 2 3\n"), Other::File),
        (square(&format!("{many}\0")), Other::File),
        (square(&format!("{many}f 1 2 \\\n3\n")), Other::Text),
        (square(&format!("f 1 2 9\n{many}")), Other::Text),
    ] {
        std::fs::write(&path, &text).unwrap();
        for exec in [Executor::sequential(), Executor::new(2).unwrap()] {
            let mut progress = |_, _| ();
            let mut source = Source::new(&path, None, &options, &exec, &mut progress);
            assert_eq!(pieces::read(1024, &mut source).err(), Some(other), "{text:?}");
        }
    }
}
