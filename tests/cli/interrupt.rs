//! Signals: 130, and nothing half done.
#![cfg(unix)]

use crate::{Place, strip};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status().unwrap().success());
}

/// Start a build that takes long, send a signal after `delay`, and give its exit code and how long it then took.
fn interrupted(place: &Place, name: &str, delay: u64) -> (i32, Duration) {
    let mut child = place.command().args(["build", "big.obj", "-o", "out.bvhc", "-q", "-f"]).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(delay));
    let sent = Instant::now();
    signal(&child, name);
    (child.wait().unwrap().code().unwrap(), sent.elapsed())
}

#[test]
fn an_interrupted_build_ends_with_130_and_leaves_nothing() {
    let place = Place::new();
    place.write("big.obj", strip(400_000));
    for (name, delay) in [("INT", 100), ("TERM", 100), ("INT", 600)] {
        let (code, took) = interrupted(&place, name, delay);
        assert_eq!(code, 130, "{name} after {delay} ms");
        // A guard against builds that do not listen, not a speed.
        assert!(took < Duration::from_secs(30), "{took:?}");
        assert_eq!(place.names(), ["big.obj"]);
    }
}

#[test]
fn an_interrupted_build_keeps_the_old_output() {
    let place = Place::new();
    place.write("big.obj", strip(3));
    place.ok("build big.obj -o out.bvhc");
    let before = place.read("out.bvhc");
    place.write("big.obj", strip(400_000));
    assert_eq!(interrupted(&place, "INT", 300).0, 130);
    assert!(place.read("out.bvhc") == before);
    assert_eq!(place.names(), ["big.obj", "out.bvhc"]);
}
