//! What every command prints, whole, so that a reviewer reads a change of it as a user would: `snapshots/NAME.snap`.
//!
//! `INSTA_UPDATE=always cargo test --test cli snapshots` writes them anew.

use crate::animations::model;
use crate::frames::heli;
use crate::{Place, Said, gltf, program, repository, said, strip};

/// The terminal after these commands, each run in `place`: what they print to stdout and stderr, and how they end.
fn transcript(place: &Place, commands: &[&str]) -> String {
    let mut text = String::new();
    for command in commands {
        let said = run(place, command);
        text.push_str(&format!("$ bvhc {command}\n"));
        text.push_str(&said.out);
        for line in said.err.lines() {
            text.push_str(&format!("stderr: {line}\n"));
        }
        text.push_str(&format!("[exit {}]\n\n", said.code));
    }
    let folder = place.root().display().to_string();
    text.replace(&folder, "FOLDER").replace(&program().display().to_string(), "bvhc")
}

/// Run without the machine's OpenCL devices, which are in no snapshot.
fn run(place: &Place, command: &str) -> Said {
    let mut run = place.command();
    run.env("OCL_ICD_VENDORS", "/nonexistent").env("OCL_ICD_FILENAMES", "");
    said(run.args(command.split_whitespace()).output().unwrap())
}

/// Compare with the snapshot, but for what depends on the clock or the machine.
fn keep(name: &str, place: &Place, commands: &[&str]) {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    for (pattern, shown) in [
        (r"\b\d+(\.\d+)? (ms|s)\b", "# s"),
        (r" +\d+\.\d+ M rays/s", "  # M rays/s"),
        // The rays in the table of `--accuracy`, before the two columns of counts.
        (r"(?m) +\d+\.\d+( +\d+\.\d +\d+\.\d)$", "        #$1"),
        // What opening a frame takes, behind the bytes that it added.
        (r"(?m)^(\d+(?: +\d+){4}(?: +\d+\.\d+){2} +\d+) +\d+\.\d$", "$1  # µs"),
        (r#""(\w*(?:_ms|seconds|per_second|peak_memory|device_memory))": [0-9.e-]+"#, r#""$1": #"#),
        (r"peak memory [0-9.]+ (KiB|MiB)( \(\d+ bytes per triangle\))?", "peak memory #"),
        (r"peak memory of all builds together: [0-9.]+ (KiB|MiB)", "peak memory of all builds together: #"),
        (r"\b\d+ threads?\b", "# threads"),
        (r"(\| front \| |\bfront +)[0-9.]+", "$1# ms"),
        (r"(\.html  )[0-9.]+ KiB", "$1# KiB"),
        (&regex_of(env!("CARGO_PKG_VERSION")), "bvhc VERSION"),
    ] {
        settings.add_filter(pattern, shown);
    }
    settings.bind(|| insta::assert_snapshot!(name, transcript(place, commands)));
}

fn regex_of(version: &str) -> String {
    format!(r"\bbvhc {}", version.replace('.', r"\."))
}

/// A folder with a strip of 40 triangles, a glTF of one, and a cache of the strip.
fn furnished() -> Place {
    let place = Place::new();
    place.write("roof.obj", strip(20));
    let (json, bin) = gltf("tile");
    place.write("tile.gltf", json);
    place.write("tile.bin", bin);
    place.ok("build roof.obj -o roof.bvhc");
    place
}

#[test]
fn snapshots_of_help() {
    let commands = [
        "-h",
        "build -h",
        "build --help",
        "build -O help",
        "info -h",
        "stats -h",
        "check -h",
        "verify -h",
        "view -h",
        "chart -h",
        "convert -h",
    ];
    keep("help", &Place::new(), &commands);
    keep("explain", &Place::new(), &["explain E0402", "explain E0425", "explain E9999", "explain E0102 --json"]);
}

#[test]
fn snapshots_of_build() {
    let place = furnished();
    let commands = [
        "build roof.obj -o roof.bvhc",
        "build roof.obj -o roof.bvhc --method binned --dry-run --exit-code",
        "build roof.obj -o roof.bvhc --method binned -v",
        "build roof.obj tile.gltf -o caches/",
        "build tile.gltf -o tile.bvhc --codec zstd --json",
        "build roof.obj -o roof.obj",
        "convert roof.bvhc -o small.bvhc --codec zstd",
    ];
    keep("build", &place, &commands);
}

#[test]
fn snapshots_of_what_a_file_is() {
    let place = furnished();
    keep("info", &place, &["info roof.bvhc", "info roof.bvhc --field content_id", "info roof.bvhc --json"]);
    keep("stats", &place, &["stats roof.bvhc", "stats roof.bvhc --json"]);
}

#[test]
fn snapshots_of_looking() {
    let place = furnished();
    place.ok("build roof.obj -o fine.bvhc --preset draft -O max-leaf=1");
    let commands = [
        "stats roof.bvhc fine.bvhc --rays 64",
        "stats --compare roof.bvhc fine.bvhc --rays 64 --fail-if nodes>0",
        "view roof.bvhc --tree --depth 2",
        "view roof.bvhc -o roof.png --size 40x30",
        "view roof.bvhc --tree --depth 1 --json",
    ];
    keep("looking", &place, &commands);
}

/// With no time but for the quickest recipe, so that nothing else depends on the clock; frames are counted, not timed.
#[test]
fn snapshots_of_charts() {
    let place = furnished();
    for frame in 1..4 {
        place.write(&format!("in/heli.{frame:04}.obj"), strip(8 + frame));
    }
    place.ok("build in/heli.%04d.obj -o heli.bvhc");
    let commands = [
        "chart roof.obj -o roof.html --rays 64 --budget 0s",
        "chart roof.obj -o roof.html --rays 64 --budget 0s --markdown",
        "chart heli.bvhc -o heli.html --rays 64",
        "chart roof.obj --recipe nameless",
        "chart none.obj -o none.html",
        "chart roof.bvhc -o roof.html",
    ];
    keep("chart", &place, &commands);
}

#[test]
fn snapshots_of_verdicts() {
    let place = furnished();
    let mut bytes = place.read("roof.bvhc");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x40;
    place.write("bad.bvhc", &bytes);
    place.write("cut.bvhc", &bytes[..bytes.len() - 100]);
    let commands = [
        "check roof.bvhc",
        "check roof.bvhc --source roof.obj",
        "check roof.bvhc --source tile.gltf",
        "check bad.bvhc",
        "check cut.bvhc",
        "check none.bvhc roof.bvhc",
        "check bad.bvhc --json",
    ];
    keep("check", &place, &commands);
    let commands = [
        "verify roof.bvhc --source roof.obj --device cpu --rays 2k",
        "verify roof.bvhc --source tile.gltf --device cpu --rays 2k",
        "verify roof.bvhc --device cpu --ray 3.2,0.3,-5,0,0,1",
        "verify bad.bvhc --device cpu --rays 2k",
    ];
    keep("verify", &place, &commands);
}

#[test]
fn snapshots_of_frames() {
    let place = heli();
    let commands = [
        "build in/heli.%04d.obj -o out/",
        "build in/heli.%04d.obj -o out/ --missing hold -n",
        "build in/heli.%04d.obj -o f%02d.bvhc --missing skip",
        "build in/heli.####.obj -o f%02d.bvhc --missing skip -v",
        "build in/heli.%04d.obj -o out/ --frames 1-2 --json",
        "build in/heli.%03d.obj -o out/",
        "build in/heli.%04d.obj -o out/ --frames 4-1",
    ];
    keep("frames", &place, &commands);
}

#[test]
fn snapshots_of_animations() {
    let place = Place::new();
    model(&place, "fox", &["Rise", "Fall"]);
    place.write("roof.obj", strip(3));
    let commands = [
        "build fox.gltf -o fox.bvhc",
        "build fox.gltf -o fox.bvhc --clip Rise --time 1.75 -v",
        "build fox.gltf -o fox.bvhc --clip Rise --time 9",
        "build fox.gltf -o fox.bvhc --clip Fall -n",
        "info fox.bvhc",
        "check fox.bvhc --source fox.gltf",
        "build fox.gltf -o fox.bvhc --time 1",
        "build fox.gltf -o fox.bvhc --clip Walk",
        "build fox.gltf -o fox.bvhc --clip box",
        "build fox.gltf -o fox.bvhc --animation Rise",
        "build roof.obj -o roof.bvhc --clip Rise",
        "build roof.obj -o roof.bvhc --presplit 0.3",
    ];
    keep("animations", &place, &commands);
}

#[test]
fn snapshots_of_accuracy() {
    let place = Place::new();
    std::fs::copy(repository().join("samples/pillar.obj"), place.path("pillar.obj")).unwrap();
    place.ok("build pillar.obj -o pillar.bvhc --preset draft");
    let commands = [
        "verify pillar.bvhc --accuracy --rays 1k --source pillar.obj",
        "verify pillar.bvhc --accuracy --rays 1k --json",
        "verify pillar.bvhc --accuracy --any-hit",
    ];
    keep("accuracy", &place, &commands);
}

#[test]
fn snapshots_of_devices() {
    let place = Place::new();
    if !run(&place, "verify --list-devices").err.contains("The OpenCL library was loaded") {
        println!("skipped: there is no OpenCL library");
        return;
    }
    keep("devices", &place, &["verify --list-devices", "verify --list-devices --json"]);
}

#[test]
fn snapshots_of_errors() {
    let place = furnished();
    place.write("beyond.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
    place.write("page.obj", "<!DOCTYPE html>\n<p>not found</p>\n");
    place.write("cut.gltf", "{\"asset\":{\"version\":\"2.0\"},");
    let commands = [
        "build none.obj -o a.bvhc",
        "build beyond.obj -o a.bvhc",
        "build page.obj -o a.bvhc",
        "build cut.gltf -o a.bvhc",
        "build cut.gltf -o a.bvhc --json",
        "build roof.obj -o no/folder/a.bvhc",
        "build roof.obj",
        "build roof.obj -o a.bvhc --method spatial",
        "build roof.obj -o a.bvhc --bins 1",
        "build roof.obj -o a.bvhc -O max-leaves=4",
        "build roof.obj -o a.bvhc --max-memory 1k",
        "info roof.obj",
        "stats none.bvhc",
    ];
    keep("errors", &place, &commands);
}
