//! Writers killed at random moments.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use bvhc::cache::{Cache, Codec, Image, OpenOptions, WriteOptions, write_file};
use bvhc::exec::Executor;

use crate::images::{meta, one_triangle};

/// The contents are large, and no trees.
const UNCHECKED: WriteOptions = WriteOptions { codec: Codec::Raw, check: false };

const TARGET: &str = "BVHC_TEST_KILL_TARGET";
const FIRST: &str = "BVHC_TEST_KILL_FIRST";

/// Two contents of 5 MB that cannot be taken for each other.
fn contents() -> [Image; 2] {
    [1, 2].map(|marker| {
        let mut image = one_triangle();
        image.triangles.resize(100_000, image.triangles[0]);
        image.triangles.iter_mut().for_each(|t| t.prim = marker);
        image
    })
}

/// Not a test of its own: the process that the tests below kill. Writes the two contents in turn until it is ended.
#[test]
#[ignore = "run by the kill tests"]
fn writer() {
    let Some(path) = std::env::var_os(TARGET) else { return };
    let contents = contents();
    let first = usize::from(std::env::var_os(FIRST).is_some_and(|first| first == "1"));
    println!("\nready");
    for i in first.. {
        write_file(Path::new(&path), &contents[i % 2], &meta(), &UNCHECKED, &Executor::current()).unwrap();
    }
}

fn kill_writers(times: u64) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.bvhc");
    let contents = contents();
    let ids = contents.each_ref().map(|image| {
        let summary = write_file(&path, image, &meta(), &UNCHECKED, &Executor::current()).unwrap();
        summary.header.content_id
    });

    let (mut seen, mut strays, mut current) = ([0; 2], 0, 1);
    for i in 0..times {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["kill::writer", "--exact", "--ignored", "--nocapture"])
            .env(TARGET, &path)
            .env(FIRST, (1 - current).to_string()) // so that the first write already changes the file
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        assert!(lines.any(|line| line.unwrap() == "ready"));
        // Spread over a few writes, by a fixed sequence that hits every phase.
        std::thread::sleep(Duration::from_micros(i * 7919 % 40_009));
        child.kill().unwrap(); // SIGKILL on Unix
        child.wait().unwrap();

        // The old or the new file, whole; and at most the one stray that the next writer removes.
        let cache = Cache::open_with(&path, &OpenOptions::default()).unwrap();
        let which = ids.iter().position(|id| *id == cache.header().content_id).expect("one of the two contents");
        seen[usize::from(which != current)] += 1;
        current = which;
        let files = std::fs::read_dir(folder.path()).unwrap().count();
        assert!(files <= 2, "{files} files after {i} kills");
        strays += files - 1;
    }
    write_file(&path, &contents[0], &meta(), &UNCHECKED, &Executor::current()).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "the next writer cleans up");
    println!("{times} kills: {seen:?} left the old or the new file, {strays} in the middle of a write");
    assert!(strays > 0, "no kill hit a write: the test shows nothing");
}

#[test]
fn a_killed_writer_leaves_the_old_or_the_new_file() {
    kill_writers(25);
}

#[test]
#[ignore = "long: 200 processes"]
fn long_200_killed_writers_leave_the_old_or_the_new_file() {
    kill_writers(200);
}
