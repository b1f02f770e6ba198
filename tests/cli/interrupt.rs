//! Signals: 130, and nothing half done.
#![cfg(unix)]

use crate::{Place, strip};
use std::process::{Child, Command, Stdio};
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
fn an_interruption_is_told_once_as_any_error_is() {
    let place = Place::new();
    place.write("big.obj", strip(400_000));
    for json in [false, true] {
        let mut command = place.command();
        command.args(["build", "big.obj", "-o", "out.bvhc"]).args(json.then_some("--json"));
        let child = command.stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(200));
        signal(&child, "INT");
        let told = child.wait_with_output().unwrap();
        let err = String::from_utf8(told.stderr).unwrap();
        assert_eq!(told.status.code(), Some(130), "{err}");
        assert_eq!(err.matches("interrupted").count(), if json { 2 } else { 1 }, "{err}");
        if json {
            let line: serde_json::Value = serde_json::from_str(err.trim()).unwrap();
            assert_eq!((line["exit_code"].as_u64(), line["exit_name"].as_str()), (Some(130), Some("interrupted")));
        }
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
