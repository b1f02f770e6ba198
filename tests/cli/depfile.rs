//! `--depfile`, judged by the programs that read it.

use crate::{Place, gltf, program, strip};
use std::process::Command;

/// Whether a tool can be run here; says so where it cannot.
fn has(tool: &str) -> bool {
    let found = Command::new(tool).arg("--version").output().is_ok_and(|o| o.status.success());
    if !found {
        println!("skipped: {tool} is not installed");
    }
    found
}

/// What a tool says when it is run in the folder.
fn run(place: &Place, tool: &str, args: &[&str]) -> String {
    let out = Command::new(tool).args(args).current_dir(place.root()).output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{tool}: {text}");
    text
}

/// A glTF model and its buffer, in a folder whose name has all that needs an escape.
fn awkward_model(place: &Place) -> &'static str {
    let (model, bin) = gltf("my%20mesh%231");
    place.write("the: models$#1/t x.gltf", model);
    place.write("the: models$#1/my mesh#1.bin", bin);
    "the: models$#1/t x.gltf"
}

#[test]
fn nothing_is_built_whose_depfile_has_no_place() {
    let place = Place::new();
    place.write("a.obj", strip(3));
    place.write("dep/x", "");
    let name = if cfg!(unix) { "new\nline.obj" } else { "a.obj" };
    place.write(name, strip(3));
    for (depfile, code) in [("gone/a.d", 3), ("dep", 3), ("a.obj/a.d", 3)] {
        let said = place.run(&format!("build a.obj -o a.bvhc --depfile {depfile}"));
        assert!(said.code == code && said.err.contains("help:"), "{depfile}: {}", said.err);
        assert!(!place.path("a.bvhc").exists(), "{depfile}");
    }
    if cfg!(unix) {
        let said = place.command().args(["build", name, "-o", "b.bvhc", "--depfile", "b.d"]).output().unwrap();
        assert_eq!(said.status.code(), Some(2));
        assert!(!place.path("b.bvhc").exists() && !place.path("b.d").exists());
    }
    place.ok("build a.obj -o a.bvhc --depfile a.d --dry-run");
    assert!(!place.path("a.d").exists());
    // A folder that the build makes is no obstacle.
    place.ok("build a.obj -o made/ --depfile made/a.d");
    assert!(place.path("made/a.d").exists());
}

#[test]
fn it_names_target_and_inputs_as_given_also_when_up_to_date() {
    let place = Place::new();
    let (model, bin) = gltf("t");
    place.write("m/t.gltf", model);
    place.write("m/t.bin", bin);
    let rule = "out.bvhc: \\\n  m/t.gltf \\\n  m/t.bin\n";
    for _ in 0..2 {
        place.ok("build m/t.gltf -o out.bvhc --depfile out.d");
        assert_eq!(String::from_utf8(place.read("out.d")).unwrap(), rule);
        std::fs::remove_file(place.path("out.d")).unwrap();
    }
    place.ok("build m/t.gltf -o out.bvhc --depfile out.d --depfile-target other --depfile-phony");
    let text = String::from_utf8(place.read("out.d")).unwrap();
    assert!(text.starts_with("other: ") && text.ends_with("\nm/t.gltf:\n\nm/t.bin:\n"), "{text}");
    place.ok("build m/t.gltf -o out.bvhc --depfile no.d --dry-run");
    assert!(!place.path("no.d").exists());
}

#[test]
fn several_outputs_have_no_single_depfile() {
    let place = Place::new();
    place.write("a.obj", strip(3));
    place.write("b.obj", strip(4));
    assert_eq!(place.run("build a.obj b.obj -o out/ --depfile d").code, 2);
    assert_eq!(place.run("build a.obj -o a.bvhc --depfile-phony").code, 2, "means nothing alone");
    assert_eq!(place.run("build a.obj -o a.bvhc --depfile no/such/d").code, 3);
}

#[test]
fn ninja_rebuilds_when_a_buffer_changes_and_only_then() {
    if !has("ninja") {
        return;
    }
    let place = Place::new();
    let model = awkward_model(&place);
    let escaped = model.replace('$', "$$").replace(' ', "$ ").replace(':', "$:");
    // Ninja quotes $in and $out for the shell itself.
    let rules = format!(
        "rule bvh\n  command = {} build $in -o $out --depfile $out.d\n  depfile = $out.d\n  deps = gcc\n  restat = 1\n\nbuild out.bvhc: bvh {escaped}\n",
        program().display()
    );
    place.write("build.ninja", rules);
    assert!(run(&place, "ninja", &[]).contains("out.bvhc  1 tri "));
    assert!(run(&place, "ninja", &[]).contains("no work to do"));

    // Ninja keeps what the depfile said in its own log; the buffer, which build.ninja does not name, must be there.
    assert!(run(&place, "ninja", &["-t", "deps"]).contains("my mesh#1.bin"));
    std::thread::sleep(std::time::Duration::from_millis(20));
    let mut bin = place.read("the: models$#1/my mesh#1.bin");
    bin[12] ^= 1;
    place.write("the: models$#1/my mesh#1.bin", bin);
    assert!(run(&place, "ninja", &[]).contains("out.bvhc  1 tri "));
    assert!(run(&place, "ninja", &[]).contains("no work to do"));
}

#[test]
fn make_rebuilds_when_a_buffer_changes_and_goes_on_without_it() {
    if !has("make") {
        return;
    }
    let place = Place::new();
    let model = awkward_model(&place);
    let rules = format!(
        "out.bvhc:\n\t'{}' build '{}' -o $@ --depfile $@.d --depfile-phony --touch\n-include out.bvhc.d\n",
        program().display(),
        model.replace('$', "$$")
    );
    place.write("Makefile", rules);
    assert!(run(&place, "make", &[]).contains("out.bvhc  1 tri "));
    assert!(run(&place, "make", &[]).contains("up to date"), "make itself says so");

    // A newer time stamp alone makes Make call us; --touch then satisfies it.
    std::thread::sleep(std::time::Duration::from_millis(20));
    let bin = place.path("the: models$#1/my mesh#1.bin");
    let touch = || std::fs::File::options().append(true).open(&bin).unwrap().set_modified(std::time::SystemTime::now());
    touch().unwrap();
    assert!(run(&place, "make", &[]).contains("up to date (key"), "bvhc says so");
    assert!(run(&place, "make", &[]).contains("'out.bvhc' is up to date"));

    // Without the phony rules Make would refuse to go on when an input is gone; with them it asks us, and we say what is wrong.
    std::fs::remove_file(&bin).unwrap();
    let out = Command::new("make").current_dir(place.root()).output().unwrap();
    assert!(String::from_utf8_lossy(&out.stderr).contains("cannot build out.bvhc"), "{out:?}");
}
