//! Several frames of a sequence, taken out or drawn at once.

use crate::Place;
use crate::sequences::waves;

#[test]
fn each_frame_of_a_list_becomes_a_still_file() {
    let place = Place::new();
    waves(&place, 1..6);
    place.ok("build in/wave.%03d.obj -o wave.bvhc");
    let json = place.ok("convert wave.bvhc -o out/ --frame 1,3-4 --json").json();
    let files = json["files"].as_array().unwrap();
    let told = |key: &str| files.iter().map(|file| file[key].clone()).collect::<Vec<_>>();
    assert_eq!(told("frame"), [1, 3, 4]);
    assert_eq!(told("output"), ["out/wave.0001.bvhc", "out/wave.0003.bvhc", "out/wave.0004.bvhc"]);
    place.ok("convert wave.bvhc -o f%02d.bvhc --frame all");
    place.ok("convert wave.bvhc -o three.bvhc --frame 3");
    for name in ["out/wave.0003.bvhc", "f03.bvhc"] {
        assert!(place.read(name) == place.read("three.bvhc"), "{name}");
    }
    place.ok("check f03.bvhc --source in/wave.003.obj");
    assert!((1..6).all(|n| place.path(&format!("f0{n}.bvhc")).exists()));

    // One number needs no number in the name.
    place.ok("convert wave.bvhc -o one/ --frame 2");
    assert!(place.path("one/wave.bvhc").exists());
    for (args, told) in [
        ("convert wave.bvhc -o x.bvhc --frame 1-2", "2 frames need a folder to go to"),
        ("convert wave.bvhc -o x.bvhc --frame all", "5 frames need a folder to go to"),
        ("convert wave.bvhc -o out2/ --frame 4-7", "not in the file: frame 6-7; it has 1-5"),
        ("convert wave.bvhc -o x%02d.bvhc", "choose frames of a sequence with --frame"),
        ("convert three.bvhc -o x/ --frame all", "it is a still file"),
        ("view wave.bvhc -o x.png --frame 1-2", "2 frames need a folder to go to"),
        ("view wave.bvhc wave.bvhc --compare -o x.png --frame 1-2", "--compare takes one moment of two files"),
    ] {
        let said = place.run(args);
        assert!(said.code == 2 && said.err.contains(told) && said.err.contains("help: "), "{args}: {}", said.err);
    }
    assert!(!place.path("out2").exists() && !place.path("x").exists());
}

#[test]
fn frames_are_drawn_from_one_place() {
    let place = Place::new();
    waves(&place, 1..4);
    place.ok("build in/wave.%03d.obj -o wave.bvhc");
    let json = place.ok("view wave.bvhc -o w.%02d.png --frame all --size 64x40 --json").json();
    let views = json["views"].as_array().unwrap();
    assert_eq!(views.len(), 3);
    let camera = &views[0]["picture"]["camera"];
    for (view, number) in views.iter().zip(1..) {
        assert_eq!(view["output"], format!("w.{number:02}.png"));
        assert_eq!(view["picture"]["files"][0]["frame"], number);
        assert_eq!(&view["picture"]["camera"], camera);
    }
    place.ok("view wave.bvhc -o pictures/ --frame 2-3 --size 64x40");
    assert!(place.read("pictures/wave.0003.png") != place.read("pictures/wave.0002.png"));
    let text = place.ok("view wave.bvhc --tree --depth 1 --frame 1,3").out;
    assert!(text.contains("wave.bvhc, frame 1:\n") && text.contains("wave.bvhc, frame 3:\n"), "{text}");

    // A page holds the frames that are named.
    let some = place.ok("view wave.bvhc --html some.html --frame 1-2").out;
    assert!(some.contains("2 frames"), "{some}");
}
