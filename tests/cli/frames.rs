//! Patterns of frames, as inputs and as outputs.

use crate::{Place, strip};

/// Frames 1, 2 and 4 of a strip that grows: 2, 4 and 8 triangles.
pub fn heli() -> Place {
    let place = Place::new();
    for frame in [1, 2, 4] {
        place.write(&format!("in/heli.{frame:04}.obj"), strip(frame));
    }
    place
}

/// The file that each line is about, and the triangles in it.
fn built(out: &str) -> Vec<(String, u32)> {
    let words = |line: &str| line.split_whitespace().take(2).map(str::to_string).collect::<Vec<_>>();
    out.lines().map(words).map(|w| (w[0].clone(), w[1].parse().unwrap())).collect()
}

#[test]
fn a_pattern_names_every_frame_and_its_output() {
    let place = heli();
    let expected = |names: [&str; 3]| names.into_iter().map(str::to_string).zip([2, 4, 8]).collect::<Vec<_>>();
    let pattern = "build in/heli.%04d.obj --missing skip";
    let said = place.ok(&format!("{pattern} -o out/"));
    assert_eq!(built(&said.out), expected(["out/heli.0001.bvhc", "out/heli.0002.bvhc", "out/heli.0004.bvhc"]));
    assert!(said.err.contains("warning: in/heli.%04d.obj: frame 3 is missing (left out)"), "{}", said.err);

    let said = place.ok(&format!("{pattern} -o f%02d.bvhc"));
    assert_eq!(built(&said.out), expected(["f01.bvhc", "f02.bvhc", "f04.bvhc"]));
    for other in ["in/heli.####.obj", "in/heli.@@@@.obj", "in/heli.1,2,4#.obj"] {
        let said = place.ok(&format!("build {other} --missing skip -o f%02d.bvhc"));
        assert!(said.out.lines().count() == 3 && said.out.lines().all(|l| l.contains("up to date")), "{}", said.out);
    }
    place.ok("check f01.bvhc --source in/heli.0001.obj");
}

#[test]
fn a_held_frame_is_the_one_before_under_its_own_name() {
    let place = heli();
    let plan = place.ok("build in/heli.%04d.obj --missing hold -o out/ -n");
    let lines: Vec<&str> = plan.out.lines().collect();
    assert_eq!(lines[2], "out/heli.0003.bvhc  would build from in/heli.0002.obj: missing");
    assert_eq!(lines.len(), 4);
    let said = place.ok("build in/heli.%04d.obj --missing hold -o out/ --json");
    let document: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    let results = document["files"].as_array().unwrap();
    let of = |key: &str| results.iter().map(|r| r[key].clone()).collect::<Vec<_>>();
    assert_eq!(of("frame"), [1, 2, 3, 4]);
    assert_eq!(results[2]["input"], "in/heli.0002.obj");
    assert_eq!(results[2]["output"], "out/heli.0003.bvhc");
    let same = |name: &str| std::fs::read(place.path(name)).unwrap();
    assert!(same("out/heli.0002.bvhc") == same("out/heli.0003.bvhc"));
}

#[test]
fn frames_are_chosen_by_number() {
    let place = heli();
    let said = place.ok("build in/heli.%04d.obj -o out/ --frames 2-4x2");
    assert_eq!(built(&said.out).len(), 2);
    place.write("in/neg-0002.obj", strip(5));
    place.write("in/neg0000.obj", strip(6));
    let said = place.ok("build in/neg%04d.obj -o out/ --frames -2,0");
    assert_eq!(built(&said.out), [("out/neg-0002.bvhc".to_string(), 10), ("out/neg0000.bvhc".to_string(), 12)]);
}

#[test]
fn what_is_not_there_or_cannot_be_meant_is_told() {
    let place = heli();
    for (args, code, told) in [
        ("in/heli.%04d.obj -o out/", 3, "frame 3 is missing; there are 3 frames, 1 to 4"),
        ("in/heli.%04d.obj -o out/", 3, "help: leave such frames out with --missing skip"),
        ("in/heli.%03d.obj -o out/", 3, "help: bvhc build 'in/heli.%04d.obj'"),
        ("in/heli.%04d.obj in/heli.%04d.obj -o one.bvhc --frames 1-2", 2, "4 inputs need a folder"),
        ("in/heli.%04d.obj in/heli.%04d.obj -o one.bvhc --frames 1-2", 2, "or give each frame a name by a pattern"),
        ("in/heli.%04d.obj -o f1-2#.bvhc --frames 1-2", 2, "outputs have the numbers of their inputs"),
        ("in/heli.%04d.%d.obj -o out/", 2, "it has 2 places for a frame number"),
        ("in/heli.%4d.obj -o out/", 2, "which pads numbers by spaces"),
        ("in/heli.%4d.obj -o out/", 2, "help: write it so: 'in/heli.%04d.obj'"),
        ("in.%04d/heli.obj -o out/", 2, "in the name of a folder"),
        ("in/heli.%04d.obj -o out.%4d.bvhc --missing skip", 2, "as a pattern of outputs"),
        ("in/heli.%04d.obj -o out/ --frames 7-9 --missing skip", 3, "help: choose among those by --frames"),
        ("in/heli.0001.obj -o a.bvhc --frames 1-2", 2, "no input is a pattern of frames"),
        ("in/heli.%04d.obj -o out/ --frames 4-1", 2, "ends before it begins"),
        ("in/heli.%04d.obj -o a.bvhc --literal", 3, "in/heli.%04d.obj"),
    ] {
        let said = place.run(&format!("build {args}"));
        assert!(said.code == code && said.err.contains(told), "{args}: {} {}", said.code, said.err);
    }
    assert!(!place.path("out").exists() && !place.path("one.bvhc").exists());
    place.write("in/50%04d.obj", strip(1));
    place.ok("build in/50%04d.obj -o 50%04d.bvhc");
    assert!(place.path("50%04d.bvhc").exists(), "what exists is no pattern, and then the output is none");
}
