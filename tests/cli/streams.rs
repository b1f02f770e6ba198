//! What goes to which stream, colour, foreign names, and pipes that close early.

use crate::{Place, said, strip};
use std::io::Read;
use std::process::Stdio;

#[test]
fn results_and_errors_are_apart() {
    let place = Place::new();
    place.write("a.obj", strip(5));
    let said = place.run("build a.obj missing.obj -o out/");
    assert!(said.out.starts_with("out/a.bvhc  ") && said.out.lines().count() == 1);
    assert!(said.err.starts_with("error: "));
    let version = place.ok("--version");
    assert!(version.out.starts_with("bvhc ") && version.err.is_empty());
    let help = place.ok("--help");
    assert!(help.out.contains("Examples:") && help.err.is_empty());
}

#[test]
fn colour_is_off_unless_asked_for() {
    let place = Place::new();
    assert!(!place.run("info missing.bvhc").err.contains('\x1b'), "no terminal, no colour");
    assert!(place.run("info missing.bvhc --color always").err.contains("\x1b["));
    assert!(!place.run("info missing.bvhc --color never").err.contains('\x1b'));
    let no_color = said(place.command().args(["info", "missing.bvhc"]).env("NO_COLOR", "1").output().unwrap());
    assert!(!no_color.err.contains('\x1b'));
}

/// A terminal made by `script`: the only way to see what a person sees.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_gets_colour_unless_no_color_or_a_dumb_one() {
    let on_terminal = |variable: &str, value: &str| {
        let place = Place::new();
        let line = format!("{} info missing.bvhc", crate::program().display());
        let mut command = std::process::Command::new("script");
        command
            .args(["-qec", &line, "/dev/null"])
            .current_dir(place.root())
            .env_remove("NO_COLOR")
            .env("TERM", "xterm");
        command.env(variable, value).stdin(Stdio::null());
        command.output().ok().map(|o| String::from_utf8_lossy(&o.stdout).into_owned())
    };
    let Some(plain) = on_terminal("X", "") else {
        println!("skipped: script is not installed");
        return;
    };
    assert!(plain.contains("\x1b[1;31merror:"), "{plain:?}");
    assert!(on_terminal("NO_COLOR", "").unwrap().contains('\x1b'), "empty means unset");
    assert!(!on_terminal("NO_COLOR", "1").unwrap().contains('\x1b'));
    assert!(!on_terminal("TERM", "dumb").unwrap().contains('\x1b'));
}

#[cfg(unix)]
#[test]
fn names_cannot_steer_the_terminal() {
    let place = Place::new();
    let name = "ro\x1b[31mck\u{202e}\u{200b}.obj";
    place.write(name, strip(5));
    let out = said(place.command().args(["build", name, "-o", "out/"]).output().unwrap());
    assert_eq!(out.code, 0, "{}", out.err);
    assert!(out.out.starts_with("out/ro\\u{1b}[31mck\\u{202e}\\u{200b}.bvhc  "), "{}", out.out);
    let cache = format!("out/{}", name.replace(".obj", ".bvhc"));
    let info = said(place.command().args(["info", &cache]).output().unwrap());
    let failed = said(place.command().args(["build", "none\x1b[2J.obj", "-o", "x.bvhc"]).output().unwrap());
    for text in [&info.out, &failed.err] {
        assert!(text.chars().all(|c| c == '\n' || !c.is_control() && c != '\u{202e}'), "{text:?}");
    }
}

#[test]
fn a_pipe_that_closes_early_is_no_error() {
    let place = Place::new();
    let mut child =
        place.command().args(["explain", "--list"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let mut err = String::new();
    child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert_eq!((child.wait().unwrap().code(), err.as_str()), (Some(0), ""));
}

#[test]
fn who_closes_stdout_changes_neither_the_outputs_nor_the_exit_code() {
    let place = Place::new();
    for name in ["a", "b", "c"] {
        place.write(&format!("{name}.obj"), strip(5));
    }
    let run = |args: &[&str]| {
        let mut command = place.command();
        let mut child = command.args(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let mut err = String::new();
        child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
        (child.wait().unwrap().code(), err)
    };
    let (code, _) = run(&["build", "a.obj", "b.obj", "c.obj", "-o", "out/", "-q"]);
    assert_eq!(code, Some(0));
    assert!(["out/a.bvhc", "out/b.bvhc", "out/c.bvhc"].iter().all(|name| place.path(name).exists()));
    let (code, err) = run(&["build", "a.obj", "none.obj", "b.obj", "-o", "out/", "-f"]);
    assert!(code == Some(10) && err.contains("none.obj"), "{code:?} {err}");
    place.write("out/c.bvhc", "no cache");
    let (code, err) = run(&["check", "out/a.bvhc", "out/b.bvhc", "out/c.bvhc"]);
    assert_eq!(code, place.run("check out/a.bvhc out/b.bvhc out/c.bvhc").code.into(), "{err}");
    assert_ne!(code, Some(0));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_stdout_is_an_io_error() {
    let place = Place::new();
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let out = place.command().args(["explain", "--list"]).stdout(full).output().unwrap();
    assert_eq!(out.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&out.stderr).contains("cannot write to standard output"));
}

#[test]
fn json_errors_are_json() {
    let place = Place::new();
    for args in ["info missing.bvhc --json", "build --json", "nonsense --json"] {
        let said = place.run(args);
        let error: serde_json::Value =
            serde_json::from_str(said.err.trim()).unwrap_or_else(|e| panic!("{args}: {e}: {}", said.err));
        assert_eq!(error["exit_code"].as_i64(), Some(i64::from(said.code)), "{args}");
        assert_eq!(error["reason"], "error");
    }
}
