//! glTF extensions that are ignored on demand, and what a still build says it leaves out.

use crate::{Place, gltf};

/// A triangle, in a model that is changed as text.
fn model(place: &Place, name: &str, from: &str, to: &str) {
    let (json, bin) = gltf("tri");
    let changed = json.replacen(from, to, 1);
    assert_ne!(changed, json);
    place.write("tri.bin", bin);
    place.write(name, changed);
}

const REQUIRES_RTC: &str = r#""extensionsRequired":["CESIUM_RTC"],"scene":0"#;

#[test]
fn a_required_extension_is_ignored_only_on_demand_and_the_file_remembers_it() {
    let place = Place::new();
    model(&place, "rtc.gltf", r#""scene":0"#, REQUIRES_RTC);
    let refused = place.run("build rtc.gltf -o a.bvhc");
    assert!(refused.code == 5 && refused.err.contains("--ignore-extension CESIUM_RTC"), "{}", refused.err);
    assert_eq!(place.run("build rtc.gltf -o a.bvhc --ignore-extension KHR_node_visibility").code, 5);
    assert_eq!(place.run("build rtc.gltf -o a.bvhc --ignore-extension CESIUM_RTC,b").code, 2);

    let build = "build rtc.gltf -o a.bvhc --ignore-extension CESIUM_RTC";
    let built = place.ok(build);
    assert!(
        built.err.contains("the glTF extension CESIUM_RTC, which may move or change triangles, is ignored"),
        "{}",
        built.err
    );
    assert!(place.ok(build).out.contains("up to date"));
    let twice = format!("{build} --ignore-extension A_b --ignore-extension CESIUM_RTC -n");
    assert!(place.ok(&twice).out.contains("would build"));
    place.ok("check a.bvhc --source rtc.gltf");
    place.ok("verify a.bvhc --source rtc.gltf --device cpu --rays 1000");
}

#[test]
fn checking_against_a_model_can_ignore_an_extension_that_the_build_did_not_meet() {
    let place = Place::new();
    model(&place, "rtc.gltf", r#""scene":0"#, REQUIRES_RTC);
    model(&place, "plain.gltf", r#""scene":0"#, r#""scene": 0"#);
    place.ok("build plain.gltf -o a.bvhc");
    let verify = "verify a.bvhc --source rtc.gltf --device cpu --rays 1000";
    assert_eq!(place.run(verify).code, 5);
    place.ok(&format!("{verify} --ignore-extension CESIUM_RTC"));
    assert_eq!(place.run("check a.bvhc --source rtc.gltf").code, 5);
    // The two models differ in their bytes, which is all that is found.
    let checked = place.run("check a.bvhc --source rtc.gltf --ignore-extension CESIUM_RTC");
    assert!(checked.code == 1 && checked.out.contains("E0606") && !checked.out.contains("E0603"), "{}", checked.out);
    assert_eq!(place.run("check a.bvhc --ignore-extension CESIUM_RTC").code, 2, "it needs --source");
}

#[test]
fn what_a_still_build_leaves_out_is_said() {
    let place = Place::new();
    for (from, to, says) in [
        (r#""scene":0"#, r#""animations":[{},{}],"scene":0"#, "left out 2 animations (everything stands at rest)"),
        (
            r#"{"mesh":0}"#,
            r#"{"mesh":0,"translation":[1e39,0,0]}"#,
            "left out 1 instance beyond the range of f32 (1.0e39; the limit is 3.4e38)",
        ),
        (r#"{"mesh":0}"#, r#"{"mesh":0,"scale":[0,0,0]}"#, "left out 1 instance scaled to nothing"),
        (r#"{"mesh":0}"#, r#"{"mesh":0,"weights":[1]}"#, "left out 1 morph weight without a target"),
        (
            r#"{"mesh":0}"#,
            r#"{"mesh":0,"extensions":{"KHR_node_visibility":{"visible":false}}}"#,
            "left out 1 hidden node",
        ),
        (
            r#"{"mesh":0}]"#,
            r#"{"mesh":0,"skin":0}],"skins":[{"joints":[0]}]"#,
            "1 node with a skin but without joints or weights: placed without the skin",
        ),
        (
            r#""attributes":"#,
            r#""material":5,"attributes":"#,
            "1 primitive with a material that is not there: left without one",
        ),
    ] {
        model(&place, "m.gltf", from, to);
        let built = place.run("build m.gltf -o m.bvhc --force --json");
        assert!(built.err.contains(says), "{says}: {}", built.err);
    }
    // A decal is no instance that vanishes.
    model(&place, "m.gltf", r#"{"mesh":0}"#, r#"{"mesh":0,"scale":[1,1,0]}"#);
    let built = place.ok("build m.gltf -o m.bvhc --force");
    assert!(built.err.is_empty() && built.out.contains("1 tri "), "{}{}", built.out, built.err);
    place.ok("check m.bvhc --source m.gltf");
    place.ok("verify m.bvhc --source m.gltf --device cpu --rays 1000");
}

#[test]
fn an_extension_that_is_only_used_and_ignored_is_told() {
    let place = Place::new();
    let (model, bin) = gltf("t");
    let hidden = model
        .replace(
            r#""nodes":[{"mesh":0}]"#,
            r#""nodes":[{"mesh":0},{"mesh":0,"extensions":{"KHR_node_visibility":{"visible":false}}}]"#,
        )
        .replace(r#"{"nodes":[0]}"#, r#"{"nodes":[0,1]}"#)
        .replace(r#""scene":0"#, r#""extensionsUsed":["KHR_node_visibility"],"scene":0"#);
    place.write("m.gltf", hidden);
    place.write("t.bin", bin);
    let said = place.ok("build m.gltf -o a.bvhc");
    assert!(said.out.contains("1 tri ") && said.err.contains("1 hidden node"), "{}{}", said.out, said.err);
    let said = place.ok("build m.gltf -o b.bvhc --ignore-extension KHR_node_visibility");
    assert!(
        said.err.contains("the glTF extension KHR_node_visibility") && said.err.contains("is ignored"),
        "{}",
        said.err
    );
    let strict = "build m.gltf -o c.bvhc --warnings-as-errors --ignore-extension KHR_node_visibility";
    assert_eq!(place.run(strict).code, 4);
}
