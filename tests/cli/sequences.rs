//! Sequences: many frames in one file.

use crate::animations::model;
use crate::frames::heli;
use crate::{Place, strip};

/// Frames of a sheet that bends: the same triangles, other places.
pub fn waves(place: &Place, frames: std::ops::Range<u32>) {
    for frame in frames {
        let mut obj = String::new();
        for i in 0..100u32 {
            let (x, z) = (i % 10, i / 10);
            let y = (f64::from(x) * 0.5 + f64::from(frame) * 0.1).sin();
            obj += &format!("v {x} {y:.6} {z}\n");
        }
        for c in (0..90).filter(|c| c % 10 != 9) {
            obj += &format!("f {} {} {} {}\n", c + 1, c + 2, c + 12, c + 11);
        }
        place.write(&format!("in/wave.{frame:03}.obj"), obj);
    }
}

#[test]
fn the_frames_of_a_pattern_become_one_file() {
    let place = Place::new();
    waves(&place, 1..6);
    let said = place.ok("build in/wave.%03d.obj -o wave.bvhc --trees first");
    assert!(
        said.out
            .starts_with("wave.bvhc  5 frames of up to 162 tris, 1 topology: 1 tree built, 4 refitted, 0 as before; "),
        "{}",
        said.out
    );
    place.ok("check wave.bvhc");
    assert!(place.ok("build in/wave.%03d.obj -o wave.bvhc --trees first").out.contains("up to date"));

    // Another choice of frames, another way and another model are other files.
    for (args, why) in [
        ("--frames 1-4", "option sequence files 1-5 → files 1-4"),
        ("--refit never", "option refit auto → never"),
        ("--rebuild-ratio 1.5", "option rebuild_ratio 1.2 → 1.5"),
        ("--trees 2", "option trees first → 2"),
    ] {
        let said = place.ok(&format!(
            "build in/wave.%03d.obj -o wave.bvhc -n {}",
            if args.contains("--trees") || args.contains("never") {
                args.to_string()
            } else {
                format!("{args} --trees first")
            }
        ));
        assert!(said.out.contains(why), "{args}: {}", said.out);
    }
    place.write("in/wave.003.obj", std::fs::read(place.path("in/wave.002.obj")).unwrap());
    let said = place.ok("build in/wave.%03d.obj -o wave.bvhc --trees first -v");
    assert!(
        said.err.contains("wave.003.obj changed") && said.out.contains("0 refitted, 1 as before, 3 unchanged"),
        "{}{}",
        said.out,
        said.err
    );

    let json = place.ok("build in/wave.%03d.obj -o wave.bvhc --trees first --force --json").json();
    assert_eq!(json["files"][0]["built"]["duplication"], 0.0, "parts of triangles cannot follow");
    assert!(json["files"][0]["built"]["sah"].is_null(), "each frame has its own");
    let frames = json["files"][0]["built"]["sequence"]["frames"].as_array().unwrap();
    assert_eq!(frames.iter().map(|f| f["number"].as_i64().unwrap()).collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
    assert!(frames[1]["worst_ratio"].as_f64().unwrap() > 0.9);
    let inputs = place.ok("build in/wave.%03d.obj -o wave.bvhc --trees first --depfile wave.d");
    assert!(inputs.out.contains("up to date"));
    let rule = std::fs::read_to_string(place.path("wave.d")).unwrap();
    assert!((1..6).all(|i| rule.contains(&format!("in/wave.00{i}.obj"))), "{rule}");
}

#[test]
fn trees_begin_anew_after_so_many_poses() {
    let place = Place::new();
    waves(&place, 1..11);
    let args = "build in/wave.%03d.obj -o wave.bvhc --codec compact";
    let said = place.ok(&format!("{args} --keyframe-every 4 --refit always"));
    assert!(said.out.contains("3 trees built, 7 refitted, 0 as before"), "{}", said.out);
    place.ok("check wave.bvhc");
    let frames = place.ok("stats wave.bvhc --frames --json --rays 0").json()["files"][0]["frames"].clone();
    let segments: Vec<i64> = frames.as_array().unwrap().iter().map(|f| f["segment"].as_i64().unwrap()).collect();
    assert!(segments.windows(2).map(|pair| pair[1] - pair[0]).eq([0, 0, 0, 1, 0, 0, 0, 1, 0]), "{segments:?}");
    let stale = place.ok(&format!("{args} -n --refit always --trees first"));
    assert!(stale.out.contains("option keyframe_every 4 → unset"), "{}", stale.out);
    assert_eq!(place.run(&format!("{args} --keyframe-every 4 --trees 2")).code, 2);
    assert_eq!(place.run("build in/wave.001.obj -o still.bvhc --keyframe-every 4").code, 2);
}

#[test]
fn a_frame_that_is_taken_out_is_what_a_still_build_makes() {
    let place = Place::new();
    waves(&place, 1..4);
    place.ok("build in/wave.%03d.obj -o wave.bvhc --vertices");
    let said = place.ok("convert wave.bvhc -o two.bvhc --frame 2");
    assert!(said.out.starts_with("two.bvhc  frame 2: "), "{}", said.out);
    place.ok("check two.bvhc");
    place.ok("verify two.bvhc --device cpu --rays 2000");
    place.ok("check two.bvhc --source in/wave.002.obj");
    assert_eq!(place.run("check two.bvhc --source in/wave.001.obj").code, 1);
    place.ok("build in/wave.002.obj -o still.bvhc --levels two --vertices");
    let hits = |file: &str| place.ok(&format!("stats {file} --json")).json()["files"][0]["instanced_triangles"].clone();
    assert_eq!(hits("two.bvhc"), hits("still.bvhc"));
    for (args, code, told) in [
        ("convert wave.bvhc -o x.bvhc --frame 9", 2, "there are 3 frames, 1 to 3"),
        ("verify wave.bvhc --frame 9 --device cpu", 2, "not in the file: frame 9; it has 1-3"),
        ("convert still.bvhc -o x.bvhc --frame 1", 2, "it is a still file"),
        ("stats wave.bvhc two.bvhc", 10, "it is a sequence of 3 frames"),
    ] {
        let said = place.run(args);
        assert!(said.code == code && said.err.contains(told), "{args}: {} {}", said.code, said.err);
    }
}

#[test]
fn frames_that_are_missing_are_held_or_left_out_and_counts_may_change() {
    let place = heli();
    assert_eq!(place.run("build in/heli.%04d.obj -o heli.bvhc").code, 3);
    let held = place.ok("build in/heli.%04d.obj -o heli.bvhc --missing hold");
    assert!(
        held.out.contains("4 frames of up to 8 tris, 3 topologies: 3 trees built, 0 refitted, 1 as before"),
        "{}",
        held.out
    );
    let skipped = place.ok("build in/heli.%04d.obj -o heli.bvhc --missing skip");
    assert!(skipped.out.contains("3 frames of up to 8 tris, 3 topologies: 3 trees built"), "{}", skipped.out);
    place.ok("check heli.bvhc");
    place.ok("convert heli.bvhc -o four.bvhc --frame 4");
    assert_eq!(place.run("convert heli.bvhc -o three.bvhc --frame 3").code, 2);

    // Frames without a triangle are told; a sequence of nothing else is refused.
    place.write("in/heli.0003.obj", "v 0 0 0\n");
    let said = place.ok("build in/heli.%04d.obj -o heli.bvhc");
    assert!(said.err.contains("heli.bvhc, frame 3: there is no triangle in 1 frame"), "{}", said.err);
    place.ok("check heli.bvhc");
    let nothing = place.run("build in/heli.%04d.obj -o none.bvhc --frames 3");
    assert!(nothing.code == 4 && !place.path("none.bvhc").exists(), "{} {}", nothing.code, nothing.err);
}

#[test]
fn a_clip_is_played() {
    let place = Place::new();
    model(&place, "two", &["Rise", "Fall"]);
    let said = place.ok("build two.gltf -o rise.bvhc --clip Rise --fps 4 -v");
    assert!(
        said.out.contains("5 frames of up to 1 tri, 1 topology: 1 tree built, 0 refitted, 4 as before"),
        "{}",
        said.out
    );
    assert!(said.err.contains("two.gltf: animation 0 'Rise': 5 frames from 1 s on, 4 a second"), "{}", said.err);
    place.ok("check rise.bvhc");
    assert!(place.ok("build two.gltf -o rise.bvhc --clip Rise --fps 4").out.contains("up to date"));
    let auto = place.ok("build two.gltf -o rise.bvhc --clip Rise --fps auto -v");
    assert!(auto.out.contains("2 frames") && auto.err.contains("as its keys have"), "{}{}", auto.out, auto.err);
    let part = place.ok("build two.gltf -o rise.bvhc --clip Rise --fps 4 --play 1.5..2");
    assert!(part.out.contains("3 frames"), "{}", part.out);

    // The height of the last frame is that of the pose at its time.
    place.ok("convert rise.bvhc -o last.bvhc --frame 2");
    place.ok("build two.gltf -o still.bvhc --clip Rise --time 2 --levels two");
    let top = |file: &str| place.ok(&format!("info {file} --json")).json()["files"][0]["scene_bounds"]["max"].clone();
    assert_eq!(top("last.bvhc"), top("still.bvhc"));

    // A frame that is taken out is compared with the model at its moment.
    place.ok("check last.bvhc --source two.gltf");
    place.ok("verify last.bvhc --source two.gltf --device cpu --rays 1000");
    place.ok("check rise.bvhc --source two.gltf");

    place.write("a.obj", strip(1));
    for (args, code, told) in [
        ("two.gltf --clip Rise --fps 4 --levels one", 2, "each frame has a top level"),
        ("two.gltf --clip Walk --fps 4 -n", 4, "it has no animation named 'Walk'"),
        ("a.obj --fps 4 -n", 2, "which has no animations"),
        ("two.gltf --fps 4", 4, "it has 2 animations"),
        ("two.gltf --clip Rise --fps 4 --time 1", 2, "leave out --time"),
        ("two.gltf --clip Rise --fps 0", 2, "above 0"),
        ("two.gltf --clip Rise --play 2..1", 2, "the earlier one first"),
        ("two.gltf --clip Rise --fps 1000000", 2, "more than 16000 frames"),
        ("a.obj --fps 4", 2, "which has no animations"),
        ("in%d.obj --fps 4", 3, ""),
    ] {
        let said = place.run(&format!("build {args} -o x.bvhc"));
        assert!(said.code == code && said.err.contains(told), "{args}: {} {}", said.code, said.err);
    }
    assert!(!place.path("x.bvhc").exists());
    let named = place.run("build two.gltf --clip Rise --fps 4 -o rise.%04d.bvhc");
    assert!(named.code == 2 && named.err.contains("a clip becomes one file"), "{}", named.err);
}

#[test]
fn every_frame_is_verified_and_measured() {
    let place = Place::new();
    waves(&place, 1..5);
    place.ok("build in/wave.%03d.obj -o wave.bvhc --trees 1");
    let all = place.ok("verify wave.bvhc --device cpu --rays 2000").out;
    assert_eq!(all.matches(": right").count(), 4, "{all}");
    let sum = all.lines().last().unwrap();
    assert!(sum.starts_with("wave.bvhc: 4 of 4 frames right; ") && sum.ends_with(", 0 mismatches"), "{sum}");
    assert!(all.contains("wave.bvhc frame 4: right"), "{all}");
    let some = place.ok("verify wave.bvhc --device cpu --rays 2000 --frame 2,4 --json --junit v.xml").json();
    let frames = some["files"].as_array().unwrap();
    assert_eq!(frames.iter().map(|f| f["frame"].clone()).collect::<Vec<_>>(), [2, 4]);
    let junit = std::fs::read_to_string(place.path("v.xml")).unwrap();
    assert!(junit.contains("wave.bvhc frame 2") && junit.contains("wave.bvhc frame 4"), "{junit}");
    let none = place.run("verify wave.bvhc --device cpu --frame 9");
    assert!(none.code == 2 && none.err.contains("not in the file: frame 9; it has 1-4"), "{} {}", none.code, none.err);

    let told = place.ok("stats wave.bvhc --frames").out;
    assert!(told.lines().count() == 6 && told.contains("wave.bvhc: 4 frames, 1 topology, 4 poses; "), "{told}");
    let json = place.ok("stats wave.bvhc --frames --json").json();
    let frames = &json["files"][0]["frames"];
    let ratios: Vec<f64> = frames.as_array().unwrap().iter().map(|f| f["ratio"].as_f64().unwrap()).collect();
    assert!(ratios.contains(&1.0) && ratios.iter().all(|ratio| *ratio >= 1.0) && ratios != [1.0; 4], "{ratios:?}");
    assert_eq!(place.ok("stats wave.bvhc --frames --csv").out.lines().count(), 5);

    // Packed and unpacked it is the same file.
    place.ok("convert wave.bvhc -o small.bvhc --codec zstd:9");
    place.ok("check small.bvhc");
    place.ok("verify small.bvhc --device cpu --rays 2000 --frame 3");
    assert!(place.read("small.bvhc").len() < place.read("wave.bvhc").len() * 3 / 4);
    place.ok("convert small.bvhc -o back.bvhc");
    assert!(place.read("back.bvhc") == place.read("wave.bvhc"));

    // A damaged frame is told.
    let mut bytes = std::fs::read(place.path("wave.bvhc")).unwrap();
    let sections = place.ok("info wave.bvhc --json").json();
    let entries = sections["files"][0]["sections"].as_array().unwrap().clone();
    let node = entries.iter().filter(|e| e["type"] == "NODE").nth(2).unwrap();
    let offset = node["offset"].as_u64().unwrap() as usize;
    bytes[offset + 40 * 32] ^= 1;
    place.write("bad.bvhc", bytes);
    let bad = place.run("verify bad.bvhc --device cpu --rays 2000");
    assert!(bad.code == 1 && !bad.out.contains("right") && bad.err.contains("E0201"), "{}{}", bad.out, bad.err);
    assert!(place.run("convert bad.bvhc -o x.bvhc").err.contains("E0201"));
    assert!(place.run("check bad.bvhc").out.contains("NODE 2 @"));
}

#[test]
fn what_rays_cost_in_each_frame_is_told_beside_trees_that_are_built_for_it() {
    let place = Place::new();
    waves(&place, 1..7);
    let frames = |args: &str| {
        let json = place.ok(&format!("stats wave.bvhc --frames --json {args}")).json();
        json["files"][0]["frames"].as_array().unwrap().clone()
    };
    let all = |frames: &[serde_json::Value], name: &str| frames.iter().map(|f| f[name].clone()).collect::<Vec<_>>();

    // Trees that were built for their frames are built again as they are.
    for recipe in ["", "--preset balanced", "--method sweep --reinsert 3"] {
        place.ok(&format!("build in/wave.%03d.obj -o wave.bvhc --refit never --force {recipe}"));
        let built = frames("--against-fresh");
        assert_eq!(all(&built, "ray_ratio"), [1.0; 6], "{recipe}");
        assert_eq!(all(&built, "segment"), [0, 1, 2, 3, 4, 5], "each frame has a tree of its own");
    }

    place.ok("build in/wave.%03d.obj -o wave.bvhc --trees first --refit always --force");
    let refitted = frames("--against-fresh");
    assert_eq!(refitted[0]["ray_ratio"], 1.0);
    assert!(refitted[5]["ray_ratio"].as_f64().unwrap() > 1.0, "{refitted:?}");
    assert_eq!(all(&refitted, "segment"), [0; 6]);
    for frame in &refitted {
        let [stored, fresh, ratio] =
            ["ray_cost", "fresh_ray_cost", "ray_ratio"].map(|name| frame[name].as_f64().unwrap());
        assert!(stored > 1.0 && (stored / fresh - ratio).abs() < 1e-12, "{frame}");
    }
    // Fresh trees are built where they are asked for.
    let plain = frames("");
    assert_eq!(all(&plain, "ray_cost"), all(&refitted, "ray_cost"));
    assert!(plain.iter().all(|frame| frame["fresh_ray_cost"].is_null() && frame["ray_ratio"].is_null()));
    assert!(frames("--rays 0").iter().all(|frame| frame["ray_cost"].is_null()));
    assert_eq!(
        place.ok("stats wave.bvhc --frames -j 1 --csv").out,
        place.ok("stats wave.bvhc --frames -j 2 --csv").out
    );

    let told = place.ok("stats wave.bvhc --frames --against-fresh --svg wave.svg").out;
    assert!(told.contains("against fresh") && told.trim_end().ends_with(" at most"), "{told}");
    assert!(place.read("wave.svg").starts_with(b"<!-- bvhc -->\n<svg"));
    let csv = place.ok("stats wave.bvhc --frames --csv --against-fresh").out;
    assert!(csv.starts_with("file,frame,") && csv.contains(",ray_cost,fresh_ray_cost,ray_ratio,bytes"), "{csv}");
    for (args, told) in [
        ("stats wave.bvhc --against-fresh", "--frames"),
        ("stats wave.bvhc --frames --against-fresh --rays 0", "leave out --rays"),
        ("stats wave.bvhc --frames --svg in/wave.001.obj", "cannot replace"),
    ] {
        let said = place.run(args);
        assert!(said.code == 2 && said.err.contains(told), "{args}: {} {}", said.code, said.err);
    }
}

#[test]
fn trees_for_all_frames_cost_less_than_that_of_the_first() {
    let place = Place::new();
    waves(&place, 0..40);
    let mean = |args: &str| {
        let built = place.ok(&format!("build in/wave.%03d.obj -o wave.bvhc --refit always --force {args}"));
        place.ok("check wave.bvhc");
        let json = place.ok("stats wave.bvhc --frames --json").json();
        let frames = json["files"][0]["frames"].as_array().unwrap().clone();
        assert_eq!(frames.len(), 40, "{}", built.out);
        frames.iter().map(|f| f["sah"].as_f64().unwrap()).sum::<f64>() / 40.0
    };
    let (first, one, three) = (mean("--trees first"), mean("--trees 1"), mean("--trees 3"));
    assert!(one < first && three <= one * 1.001, "{first} {one} {three}");
    // The frames that the trees are made of are read together, by as many threads as there are.
    let [alone, together] = [1, 4].map(|jobs| {
        place.ok(&format!("build in/wave.%03d.obj -o by{jobs}.bvhc --jobs {jobs}"));
        std::fs::read(place.path(&format!("by{jobs}.bvhc"))).unwrap()
    });
    assert!(alone == together);
    for wrong in ["0", "9", "many"] {
        assert_eq!(place.run(&format!("build in/wave.%03d.obj -o wave.bvhc --trees {wrong}")).code, 2);
    }
}

#[test]
fn a_compact_file_is_the_same_and_a_grid_is_told() {
    let place = Place::new();
    waves(&place, 1..9);
    let build = "build in/wave.%03d.obj --trees first";
    place.ok(&format!("{build} -o raw.bvhc"));
    place.ok(&format!("{build} -o small.bvhc --codec compact"));
    let info = |file: &str| place.ok(&format!("info {file} --json")).json()["files"][0].clone();
    let (raw, small) = (info("raw.bvhc"), info("small.bvhc"));
    assert_eq!(raw["content_id"], small["content_id"]);
    let codecs = |kind: &str| -> Vec<String> {
        let of_kind = small["sections"].as_array().unwrap().iter().filter(|s| s["type"] == kind);
        of_kind.map(|s| s["codec"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!((codecs("VPOS"), codecs("NODE")), (vec!["delta".to_owned(); 8], vec!["delta".to_owned(); 8]));
    place.ok("check small.bvhc");
    place.ok("verify small.bvhc --device cpu --rays 2000");
    place.ok("convert small.bvhc -o frame.bvhc --frame 5");
    place.ok("check frame.bvhc --source in/wave.005.obj");
    assert!(place.ok(&format!("{build} -o small.bvhc --codec compact")).out.contains("up to date"));
    let said = place.ok(&format!("{build} -o small.bvhc -n"));
    assert!(said.out.contains("codec compact → raw"), "{}", said.out);

    // A grid is part of what was asked for: its files are others, and are compared with the model on it.
    place.ok(&format!("{build} -o grid.bvhc --codec compact --vertex-bits 12"));
    place.ok("convert grid.bvhc -o frame.bvhc --frame 5");
    place.ok("check frame.bvhc --source in/wave.005.obj");
    let still = place.ok("build in/wave.001.obj -o still.bvhc --vertex-bits 12 --json").json();
    let loss = &still["files"][0]["built"]["rounding"]["grid"];
    assert!(loss["farthest"].as_f64().is_some_and(|moved| moved > 0.0 && moved < 9.0 / 2048.0), "{still}");
    let checked = place.ok("check still.bvhc --source in/wave.001.obj");
    assert!(
        checked.err.contains("compared on the grid") && checked.err.contains("% of a triangle's"),
        "{}",
        checked.err
    );
    let coarse = place.ok("build in/wave.001.obj -o still.bvhc --vertex-bits 8 --force");
    assert!(!coarse.err.contains("a grid"), "{}", coarse.err);
    let mut thin = String::from("v 0 0 0\nv 1000 0 0\nv 0 1000 0\nv 3 3 0\nv 3.4 3 0\nv 3 3.4 0\n");
    thin += &"f 1 2 3\nf 4 5 6\n".repeat(9);
    place.write("thin.obj", thin);
    let told = place.ok("build thin.obj -o thin.bvhc --vertex-bits 8");
    assert!(
        told.err.contains("positions on a grid move its corners") && told.err.contains("more --vertex-bits"),
        "{}",
        told.err
    );
    assert!(place.run("build thin.obj -o thin.bvhc --vertex-bits 30").err.contains("a number from 8 to 24"));
}

#[test]
fn flags_that_a_file_does_not_read_are_refused() {
    let place = Place::new();
    waves(&place, 1..3);
    place.ok("build in/wave.%03d.obj -o wave.bvhc");
    for (args, told) in [
        ("build in/wave.001.obj -o still.bvhc --trees 1", "--trees is about the trees of a sequence"),
        ("build in/wave.001.obj -o still.bvhc --refit never -n", "--refit is about the trees of a sequence"),
        ("build in/wave.%03d.obj -o w%03d.bvhc --rebuild-ratio 2", "--rebuild-ratio is about the trees of a sequence"),
        ("build in/wave.%03d.obj -o wave.bvhc --degenerate drop", "--degenerate drop is about still files"),
        ("build in/wave.%03d.obj -o w.bvhc --refit never --trees 2", "--trees has no effect: with --refit never"),
        ("build in/wave.%03d.obj -o w.bvhc --refit always --rebuild-ratio 2", "--rebuild-ratio has no effect"),
        ("stats wave.bvhc --epo exact", "cannot measure a sequence with --epo"),
        ("stats wave.bvhc --depths", "cannot measure a sequence with --depths"),
    ] {
        let said = place.run(args);
        assert!(
            said.code == 2 && said.err.contains(told) && said.err.contains("leave"),
            "{args}: {} {}",
            said.code,
            said.err
        );
    }
    place.ok("build in/wave.%03d.obj -o wave.bvhc --degenerate keep --force");
}
