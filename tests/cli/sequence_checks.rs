//! Sequences beside what they were built from, and beside each other.

use crate::animations::model;
use crate::sequences::waves;
use crate::{Place, gltf};

#[test]
fn every_frame_is_compared_with_its_model() {
    let place = Place::new();
    waves(&place, 1..5);
    place.ok("build in/wave.%03d.obj -o wave.bvhc --vertices");
    let said = place.ok("check wave.bvhc --source in/wave.%03d.obj");
    assert_eq!(said.out, "wave.bvhc: valid (container, hashes, every record and the source)\n");
    // Frames are put on the grid that the file was built on, which is told once.
    place.ok("build in/wave.%03d.obj -o grid.bvhc --vertex-bits 12 --codec compact");
    let said = place.ok("check grid.bvhc --source in/wave.%03d.obj");
    assert_eq!(said.err.matches("is compared on the grid").count(), 1, "{}", said.err);

    let other = std::fs::read_to_string(place.path("in/wave.003.obj")).unwrap().replacen("v 0 ", "v 0.5 ", 1);
    place.write("in/wave.003.obj", other);
    let said = place.run("check wave.bvhc --source in/wave.%03d.obj");
    assert!(said.code == 1 && said.out.contains("in frame 3 ") && said.out.contains("E0603"), "{}", said.out);
    assert!(said.out.contains("not checked: The frames behind frame 3 against their models"), "{}", said.out);
    std::fs::remove_file(place.path("in/wave.003.obj")).unwrap();
    assert_eq!(place.run("check wave.bvhc --source in/wave.%03d.obj").code, 3);

    for (source, told) in [
        ("in/wave.001.obj", "name them by a pattern, in quotes"),
        ("in/wave.obj", "its frames are files, and that names one of them at most"),
    ] {
        let said = place.run(&format!("check wave.bvhc --source {source}"));
        assert!(said.code == 2 && said.err.contains(told), "{} {}", said.code, said.err);
    }
}

#[test]
fn frames_beyond_those_that_trees_are_chosen_by_have_their_own_models() {
    let place = Place::new();
    waves(&place, 1..37);
    place.ok("build in/wave.%03d.obj -o wave.bvhc");
    place.ok("check wave.bvhc --source in/wave.%03d.obj");
    let info = place.ok("info wave.bvhc --json").json();
    let listed: Vec<&str> =
        info["files"][0]["meta"]["inputs"].as_array().unwrap().iter().map(|i| i["name"].as_str().unwrap()).collect();
    let expected: Vec<String> = (1..37).map(|frame| format!("wave.{frame:03}.obj")).collect();
    assert_eq!(listed, expected, "in the order of the frames");
    for frame in [1, 3, 36] {
        place.ok(&format!("convert wave.bvhc -o still.bvhc --frame {frame}"));
        place.ok(&format!("check still.bvhc --source in/wave.{frame:03}.obj"));
    }
    // One frame changes: the others are taken from the file, whose list says which they are.
    let other = std::fs::read_to_string(place.path("in/wave.003.obj")).unwrap().replacen("v 0 ", "v 0.5 ", 1);
    place.write("in/wave.003.obj", other);
    place.ok("build in/wave.%03d.obj -o wave.bvhc");
    place.ok("check wave.bvhc --source in/wave.%03d.obj");
    let said = place.run("verify wave.bvhc --source in/wave.%03d.obj --device cpu");
    assert!(said.code == 2 && said.err.contains("against its own triangles"), "{}", said.err);
}

#[test]
fn frames_that_share_a_buffer_are_compared_with_their_models() {
    let place = Place::new();
    let (json, bin) = gltf("tri");
    place.write("in/tri.bin", &bin);
    for (frame, x) in [(1, 0.0), (2, 1.0), (3, 2.0)] {
        let moved = json.replace(r#"{"mesh":0}"#, &format!(r#"{{"mesh":0,"translation":[{x},0,0]}}"#));
        // The third has a buffer of its own.
        let moved = if frame == 3 { moved.replace("tri.bin", "own.bin") } else { moved };
        place.write(&format!("in/tri.{frame}.gltf"), moved);
    }
    place.write("in/own.bin", &bin);
    place.ok("build in/tri.%d.gltf -o tri.bvhc");
    place.ok("check tri.bvhc --source in/tri.%d.gltf");
    for frame in [1, 3] {
        place.ok(&format!("convert tri.bvhc -o still.bvhc --frame {frame}"));
        place.ok(&format!("check still.bvhc --source in/tri.{frame}.gltf"));
    }
}

#[test]
fn quads_that_are_cut_as_in_the_first_frame_agree_with_their_models() {
    let place = Place::new();
    // The other diagonal suits the second frame.
    for (frame, lift) in [(1, [0.0, 0.3, 0.0, 0.3]), (2, [0.3, 0.0, 0.3, 0.0])] {
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)];
        let vertices = corners.iter().zip(lift).map(|((x, z), y)| format!("v {x} {y} {z}\n"));
        place.write(&format!("q{frame}.obj"), vertices.collect::<String>() + "f 1 2 3 4\n");
    }
    place.ok("build q%d.obj -o q.bvhc");
    place.ok("check q.bvhc --source q%d.obj");
}

#[test]
fn every_moment_of_a_clip_is_compared_with_its_model() {
    let place = Place::new();
    model(&place, "fox", &["Rise", "Fall"]);
    place.ok("build fox.gltf -o fox.bvhc --clip Rise --fps 10");
    place.ok("check fox.bvhc --source fox.gltf");
    let said = place.run("check fox.bvhc --source in/fox.%03d.obj");
    assert!(said.code == 2 && said.err.contains("moments of one model"), "{}", said.err);
}

#[test]
fn sequences_are_compared_by_figures_over_all_frames() {
    let place = Place::new();
    waves(&place, 1..6);
    place.ok("build in/wave.%03d.obj -o one.bvhc --trees 1");
    place.ok("build in/wave.%03d.obj -o first.bvhc --trees first --refit always -O max-leaf=1");
    let said = place.ok("stats --compare one.bvhc one.bvhc");
    let rows: Vec<&str> = said.out.lines().skip(1).filter_map(|line| line.split_whitespace().next()).collect();
    let all = [
        "frames",
        "instanced-triangles",
        "topologies",
        "poses",
        "segments",
        "sah",
        "sah-worst",
        "ratio",
        "ratio-worst",
    ];
    assert_eq!(rows, [&all[..], &["file-bytes", "ray-cost", "ray-cost-worst"]].concat());
    assert_eq!(said.out.matches(" =").count(), rows.len(), "{}", said.out);

    let json = place.ok("stats --compare one.bvhc first.bvhc --json --rays 0").json();
    let change = |name: &str| json["changes"].as_array().unwrap().iter().find(|c| c["metric"] == name).cloned();
    assert!(change("sah").unwrap()["change"].as_f64().unwrap() != 0.0 && change("ray-cost").is_none());
    assert_eq!(place.run("stats --compare one.bvhc first.bvhc --fail-if sah>+0%").code, 8);
    place.ok("stats --compare one.bvhc first.bvhc --fail-if frames>5 --fail-if ratio-worst>1.5");

    place.ok("convert one.bvhc -o still.bvhc --frame 1");
    for (args, told) in [
        ("one.bvhc still.bvhc", "cannot compare a sequence with a still file"),
        ("one.bvhc first.bvhc --epo exact", "cannot measure a sequence with --epo"),
        ("one.bvhc first.bvhc --fail-if depth>40", "depth was not measured"),
        ("still.bvhc still.bvhc --fail-if frames>4", "frames was not measured"),
    ] {
        let said = place.run(&format!("stats --compare {args}"));
        assert!(said.code == 2 && said.err.contains(told), "{args}: {} {}", said.code, said.err);
    }
}

#[test]
fn what_would_be_built_is_told_frame_by_frame() {
    let place = Place::new();
    waves(&place, 1..6);
    let said = place.ok("build in/wave.%03d.obj -o wave.bvhc -n --frames 1-5x2");
    assert_eq!(said.out, "wave.bvhc  would build: missing (3 frames, 1,3,5)\n");
    let said = place.ok("build in/wave.%03d.obj -o wave.bvhc -n -v --frames 4-6 --missing hold");
    assert_eq!(said.out, "wave.bvhc  would build: missing (3 frames, 4-6, held 6)\n");
    assert!(said.err.contains("frame 5: in/wave.005.obj\n"), "{}", said.err);
    assert!(said.err.contains("frame 6: in/wave.005.obj, held\n"), "{}", said.err);
    model(&place, "fox", &["Rise", "Fall"]);
    let said = place.ok("build fox.gltf -o fox.bvhc --clip Rise --fps 4 -n");
    assert!(said.out.contains("(5 frames, 1 to 2 s)"), "{}", said.out);

    // Frames that the shell has listed are told how to become one file.
    let said = place.run("build in/wave.001.obj in/wave.002.obj -o wave.bvhc");
    assert!(said.code == 2 && said.err.contains("bvhc build 'in/wave.%03d.obj' -o wave.bvhc"), "{}", said.err);
}
