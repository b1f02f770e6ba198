//! Files without META: how their model was read is not known, so nothing is held against it that another way of reading explains.

use crate::common::vectors;
use crate::{Place, animations, strip};
use serde_json::{Value, json};

/// Two triangles of which one has no area.
const FLAT: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n";

/// A file of `a.obj` or `a.gltf`, built with these flags, whose META is left out.
fn without_meta(place: &Place, model: &str, flags: &str) {
    place.ok(&format!("build {model} -o whole.bvhc {flags}"));
    place.ok("convert whole.bvhc -o a.bvhc --drop-meta");
}

#[test]
fn triangles_without_area_may_be_there_or_not() {
    let place = Place::new();
    place.write("a.obj", FLAT);
    for policy in ["keep", "drop"] {
        without_meta(&place, "a.obj", &format!("--degenerate {policy}"));
        for command in ["check a.bvhc --source a.obj", "verify a.bvhc --source a.obj --device cpu --rays 500"] {
            let said = place.ok(command);
            assert!(said.err.contains("no META") && said.err.contains("--degenerate"), "{}", said.err);
            assert!(!place.ok(&format!("{command} --degenerate {policy}")).err.contains("no META"));
            let other = if policy == "keep" { "drop" } else { "keep" };
            assert_eq!(place.run(&format!("{command} --degenerate {other}")).code, 1, "{policy}: {command}");
        }
        // Another triangle is found all the same.
        place.write("b.obj", FLAT.replace("v 0 1 0", "v 0 1.5 0"));
        assert_eq!(place.run("check a.bvhc --source b.obj").code, 1);
    }
}

/// The file itself says that it has numbers of vertices.
#[test]
fn vertices_are_compared_though_no_meta_speaks_of_them() {
    use bvhc::cache::SectionKind;
    let place = Place::new();
    place.write("a.obj", strip(4));
    without_meta(&place, "a.obj", "--vertices");
    place.ok("check a.bvhc --source a.obj");
    let mut bytes = place.read("a.bvhc");
    for number in vectors::bytes::stored(&mut bytes, SectionKind::VERT).chunks_exact_mut(4) {
        let moved = u32::from_le_bytes(number.try_into().unwrap()) + 100;
        number.copy_from_slice(&moved.to_le_bytes());
    }
    place.write("a.bvhc", vectors::bytes::refix(bytes));
    place.ok("check a.bvhc");
    let said = place.run("check a.bvhc --source a.obj");
    assert!(said.code == 1 && said.out.contains("E0607"), "{}", said.out);
}

/// Which element of a node an instance is follows from how many were left out.
#[test]
fn counts_of_instances_that_were_left_out_are_those_of_the_model() {
    use bvhc::cache::{Head, OpenOptions, SectionKind};
    let place = Place::new();
    let (json, bin) = crate::gltf("tile");
    let mut document: Value = serde_json::from_str(&json).unwrap();
    document["nodes"] =
        json!([{ "mesh": 0, "scale": [0, 0, 0] }, { "mesh": 0 }, { "mesh": 0, "translation": [3, 0, 0] }]);
    document["scenes"] = json!([{ "nodes": [0, 1, 2] }]);
    place.write("tile.gltf", document.to_string());
    place.write("tile.bin", bin);
    place.ok("build tile.gltf -o a.bvhc");
    place.ok("check a.bvhc --source tile.gltf");
    let mut bytes = place.read("a.bvhc");
    let meta = vectors::bytes::stored(&mut bytes, SectionKind::META);
    let name = b"singular_instances";
    let at = meta.windows(name.len()).position(|w| w == name).unwrap() + name.len();
    assert_eq!(meta[at], 1);
    meta[at] = 0;
    place.write("a.bvhc", vectors::bytes::refix(bytes));
    let head = Head::read(&place.path("a.bvhc"), &OpenOptions::default()).unwrap();
    assert!(head.meta.unwrap().read_counts.contains(&("singular_instances".into(), 0)));
    place.ok("check a.bvhc");
    let said = place.run("check a.bvhc --source tile.gltf");
    assert!(said.code == 1 && said.out.contains("E0606"), "{}", said.out);
}

/// A triangle that `Rise` lifts, twice in scene 1 and once in scene 0.
fn risen(place: &Place) {
    animations::model(place, "a", &["Rise"]);
    let mut document: Value = serde_json::from_slice(&place.read("a.gltf")).unwrap();
    document["nodes"].as_array_mut().unwrap().push(json!({ "mesh": 0, "translation": [3, 0, 0] }));
    document["scenes"] = json!([{ "nodes": [0] }, { "nodes": [0, 1] }]);
    place.write("a.gltf", document.to_string());
}

#[test]
fn scenes_poses_and_levels_are_told_by_flags() {
    let place = Place::new();
    risen(&place);
    for flags in ["--time 1.5", "--scene 1", "--clip 0", "--scene 1 --levels one", "--scene 1 --levels two"] {
        without_meta(&place, "a.gltf", flags);
        place.ok(&format!("check a.bvhc --source a.gltf {flags}"));
        place.ok(&format!("verify a.bvhc --source a.gltf --device cpu --rays 500 {flags}"));
        // With META the flags may repeat what it says, and no more.
        place.ok(&format!("check whole.bvhc --source a.gltf {flags}"));
        let said = place.run("check whole.bvhc --source a.gltf --degenerate keep");
        assert!(said.code == 2 && said.err.contains("degenerate=drop"), "{}", said.err);
    }
    // How many levels there are shows in the file.
    for levels in ["one", "two"] {
        without_meta(&place, "a.gltf", &format!("--scene 1 --levels {levels}"));
        place.ok("check a.bvhc --source a.gltf --scene 1");
    }
    // How it stands at a time is not what it is at rest.
    without_meta(&place, "a.gltf", "--time 1.5");
    assert_eq!(place.run("check a.bvhc --source a.gltf").code, 1);
    for (flag, value) in [("--time", "1.25"), ("--scene", "0"), ("--clip", "0"), ("--levels", "two")] {
        let said = place.run(&format!("check whole.bvhc --source a.gltf {flag} {value}"));
        assert!(said.code == 2 && said.err.contains(&format!("leave out {flag}")), "{flag}: {}", said.err);
    }
}

#[test]
fn flags_about_a_model_need_one() {
    let place = Place::new();
    place.write("a.obj", strip(3));
    place.ok("build a.obj -o a.bvhc");
    for flag in [
        "--degenerate keep",
        "--scene 0",
        "--clip 0",
        "--time 1",
        "--allow-outside",
        "--ignore-extension X",
        "--levels one",
    ] {
        for command in ["check", "verify"] {
            let said = place.run(&format!("{command} a.bvhc {flag}"));
            assert!(said.code == 2 && said.err.contains("--source MODEL"), "{flag}: {}", said.err);
        }
    }
}

/// Arguments that change places, and a cache in the place of a model.
#[test]
fn what_is_no_cache_and_what_is_no_model_is_told_so() {
    let place = Place::new();
    place.write("a.obj", strip(4));
    place.ok("build a.obj -o a.bvhc");
    let said = place.run("check a.obj --source a.bvhc");
    assert!(said.code == 1 && said.out.contains("E0102") && !said.err.contains("META"), "{}{}", said.out, said.err);
    for command in ["build a.bvhc -o b.bvhc", "check a.bvhc --source a.bvhc"] {
        let said = place.run(command);
        assert!(
            said.code != 0 && said.err.contains("cache file") && said.err.contains("bvhc info"),
            "{command}: {}",
            said.err
        );
    }
}
