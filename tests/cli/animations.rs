//! Models posed at a moment of an animation.

use crate::{Place, gltf, strip};

/// A triangle that two animations move: `Rise` along z by 1 in the second from 1 s to 2 s, and `Fall`, which has one key. The animations' names may be
/// given.
pub fn model(place: &Place, name: &str, animations: &[&str]) {
    let (json, mut bin) = gltf("tri");
    let first = bin.len();
    let floats = [1.0f32, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    bin.extend(floats.iter().flat_map(|v| v.to_le_bytes()));
    let mut document: serde_json::Value = serde_json::from_str(&json).unwrap();
    document["buffers"][0]["byteLength"] = bin.len().into();
    document["buffers"][0]["uri"] = format!("{name}.bin").into();
    let mut push = |list: &str, item: serde_json::Value| {
        let list = document[list].as_array_mut().unwrap();
        list.push(item);
        list.len() - 1
    };
    let view = |offset: usize, length: usize| serde_json::json!({ "buffer": 0, "byteOffset": first + offset, "byteLength": length });
    let (times, values) = (push("bufferViews", view(0, 8)), push("bufferViews", view(8, 24)));
    let accessor = |view: usize, kind: &str, count: usize| serde_json::json!({ "bufferView": view, "componentType": 5126, "type": kind, "count": count });
    let (times_2, values_2) =
        (push("accessors", accessor(times, "SCALAR", 2)), push("accessors", accessor(values, "VEC3", 2)));
    let (times_1, values_1) =
        (push("accessors", accessor(times, "SCALAR", 1)), push("accessors", accessor(values, "VEC3", 1)));
    let sampled = [(times_2, values_2), (times_1, values_1)];
    let animation = |(name, (input, output)): (&&str, &(usize, usize))| {
        serde_json::json!({
            "name": name,
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
            "samplers": [{ "input": input, "output": output }],
        })
    };
    document["animations"] = animations.iter().zip(sampled.iter().cycle()).map(animation).collect();
    place.write(&format!("{name}.bin"), bin);
    place.write(&format!("{name}.gltf"), document.to_string());
}

/// The top of a file's box.
fn height(place: &Place, file: &str) -> f64 {
    place.ok(&format!("info {file} --json")).json()["files"][0]["scene_bounds"]["max"][2].as_f64().unwrap()
}

#[test]
fn a_model_is_posed_at_a_moment_and_the_file_knows_which() {
    let place = Place::new();
    model(&place, "two", &["Rise", "Fall"]);
    let built = place.ok("build two.gltf -o a.bvhc --clip Rise --time 1.75 -v");
    assert!(
        built.err.contains("two.gltf: animation 0 'Rise' at 1.75 s (2 keys from 1 to 2 s, 1 a second)"),
        "{}",
        built.err
    );
    assert!(!built.err.contains("warning"), "{}", built.err);
    assert_eq!(height(&place, "a.bvhc"), 0.75);
    assert!(place.ok("build two.gltf -o a.bvhc --clip Rise --time 1.75").out.contains("up to date"));
    for (again, why) in [
        ("--clip Rise --time 1.5", "time 1.75 → 1.5"),
        ("--clip Rise", "time 1.75 → first"),
        ("--clip Fall --time 1.75", "animation Rise → Fall"),
        ("--clip 0 --time 1.75", "animation_number unset → 0"),
        ("", "animation Rise → unset"),
    ] {
        let said = place.ok(&format!("build two.gltf -o a.bvhc -n {again}"));
        assert!(said.out.contains(why), "{again}: {}", said.out);
    }
    // The same pose is made again to compare with it.
    place.ok("check a.bvhc --source two.gltf");
    place.ok("verify a.bvhc --source two.gltf --device cpu --rays 1000");
    place.ok("build two.gltf -o rest.bvhc");
    assert_eq!(height(&place, "rest.bvhc"), 0.0);
    place.ok("check rest.bvhc --source two.gltf");
    // A file of another pose is told from it.
    let (posed, rest) =
        (place.ok("info a.bvhc --field content_id").out, place.ok("info rest.bvhc --field content_id").out);
    assert_ne!(posed, rest);
}

#[test]
fn a_model_may_be_left_at_rest_on_purpose() {
    let place = Place::new();
    model(&place, "two", &["Rise", "Fall"]);
    let build = "build two.gltf -o a.bvhc";
    let told = place.ok(build);
    assert!(
        told.err.contains("warning: ") && told.err.contains("2 animations (everything stands at rest)"),
        "{}",
        told.err
    );
    let before = place.read("a.bvhc");
    let refused = place.run(&format!("{build} --warnings-as-errors"));
    assert!(refused.code == 4 && refused.err.contains("at rest: --at-rest"), "{}", refused.err);
    for more in ["", " -f", " -f --warnings-as-errors", " --warnings-as-errors", " -n --warnings-as-errors"] {
        let quiet = place.ok(&format!("{build} --at-rest{more}"));
        assert_eq!(quiet.err, "", "{more}");
        assert!(place.read("a.bvhc") == before, "{more}: it is how the model is read anyway");
    }
    for flag in ["--clip Rise", "--time 1", "--fps 24", "--play 0..1"] {
        let refused = place.run(&format!("{build} --at-rest {flag}"));
        assert!(refused.code == 2 && refused.err.contains("at rest"), "{flag}: {}", refused.err);
    }
}

#[test]
fn without_a_time_it_is_the_first_key_and_without_an_animation_the_only_one() {
    let place = Place::new();
    model(&place, "one", &["Rise"]);
    for (args, z) in [("--time 1.5", 0.5), ("--clip 0", 0.0), ("--clip Rise --time 2", 1.0), ("--time -3", 0.0)] {
        place.ok(&format!("build one.gltf -o a.bvhc {args}"));
        assert_eq!(height(&place, "a.bvhc"), z, "{args}");
        place.ok("check a.bvhc --source one.gltf");
    }
    // A name that begins with digits is a name.
    model(&place, "digits", &["0 up", "7"]);
    let posed = place.run("build digits.gltf -o a.bvhc --clip 7");
    assert!(posed.code == 4 && posed.err.contains("animation 1 '7'"), "{}", posed.err);
    place.ok("build digits.gltf -o a.bvhc --clip 1");
}

#[test]
fn a_time_outside_of_the_animation_holds_its_end_and_is_told() {
    let place = Place::new();
    model(&place, "one", &["Rise"]);
    let late = place.ok("build one.gltf -o a.bvhc --time 9");
    let says = "one.gltf: animation 0 'Rise' holds its last value at 9 s (2 keys from 1 to 2 s, 1 a second)";
    assert!(late.err.contains(says), "{}", late.err);
    assert_eq!(height(&place, "a.bvhc"), 1.0);
    let early = place.ok("build one.gltf -o a.bvhc --time 0");
    assert!(early.err.contains("holds its first value at 0 s"), "{}", early.err);
    assert!(place.ok("build one.gltf -o a.bvhc --time 1.5").err.is_empty());
}

#[test]
fn what_cannot_be_posed_is_refused_with_the_animations_that_there_are() {
    let place = Place::new();
    model(&place, "two", &["Rise", "Fall"]);
    model(&place, "same", &["Rise", "Rise"]);
    place.write("a.obj", strip(3));
    let (json, bin) = gltf("tri");
    place.write("tri.gltf", json);
    place.write("tri.bin", bin);
    for (args, code, says) in [
        ("two.gltf --time 1.5", 4, "it has 2 animations, and which is meant is not said"),
        ("two.gltf --time 1.5", 4, "animation 1 'Fall': 1 key at 1 s"),
        ("two.gltf --clip Walk", 4, "it has no animation named 'Walk'"),
        ("two.gltf --clip 2", 4, "animation 0 'Rise': 2 keys from 1 to 2 s, 1 a second"),
        ("two.gltf --clip 2", 4, "letter by letter: --clip NUMBER"),
        ("same.gltf --clip Rise", 4, "2 animations named 'Rise'"),
        ("tri.gltf --time 0", 4, "it has no animations"),
        ("tri.gltf --clip 0", 4, "leave out --clip, --time"),
        ("two.gltf --animation Rise", 2, "write --clip NAME|NUMBER"),
        // How spatial splits cut was chosen by this flag once.
        ("two.gltf --clip box", 4, "-O clip=box"),
        ("tri.gltf --clip exact", 4, "-O clip=exact"),
        ("a.obj --clip box", 2, "-O clip=box"),
        ("a.obj --presplit 0.3", 2, "write -O presplit=SHARE"),
        ("two.gltf --clip Rise --time nan", 2, "finite"),
        ("two.gltf --clip Rise --time inf", 2, "finite"),
        ("two.gltf --clip Rise --time soon", 2, "such as 0.5"),
        ("two.gltf --clip 99999999999 --time 0", 2, "so many animations"),
        ("a.obj --clip Rise", 2, "it is an OBJ model, which has no animations"),
        ("a.obj --time 0", 2, "leave out --time"),
    ] {
        let said = place.run(&format!("build {args} -o x.bvhc"));
        assert_eq!(said.code, code, "{args}: {}", said.err);
        assert!(said.err.contains(says), "{args}: {}\nwant {says}", said.err);
    }
    assert!(!place.names().contains(&"x.bvhc".to_string()));
    // A file of a pose is compared with no model that has none.
    place.ok("build two.gltf -o a.bvhc --clip Rise --time 1.5");
    let other = place.run("verify a.bvhc --source a.obj --device cpu --rays 1000");
    assert!(other.code == 4 && other.err.contains("it has no animations"), "{}", other.err);
}

#[test]
fn json_says_the_moment_and_what_is_told_of_it() {
    let place = Place::new();
    model(&place, "two", &["Rise", "Fall"]);
    let built = |args: &str| place.ok(&format!("build two.gltf -o a.bvhc --json {args}")).json()["files"][0].clone();
    let dry = built("--clip Rise --time 9 -n");
    assert_eq!((dry["status"].as_str(), dry["model"]["triangles"].as_u64()), (Some("would-build"), Some(1)));
    let done = built("--clip Rise --time 9");
    assert!(dry.get("built").is_none() && done.get("model").is_none());
    for one in [&dry["model"], &done["built"]] {
        let posed = &one["posed"];
        assert_eq!(posed["animation"]["number"], 0);
        assert_eq!(posed["animation"]["name"], "Rise");
        assert_eq!(posed["animation"]["keys"]["last"], 2.0);
        assert_eq!(posed["time"], 9.0);
        let remarks = one["remarks"].as_array().unwrap();
        assert!(remarks.len() == 1 && remarks[0].as_str().unwrap().contains("holds its last value"), "{remarks:?}");
    }
    let meta = place.ok("info a.bvhc --json").json()["files"][0]["meta"].clone();
    assert_eq!(meta["moment"]["animation"], "Rise");
    assert_eq!(meta["moment"]["time"], 9.0);
    assert!(meta["moment"]["animation_number"].is_null());
    assert!(meta["notes"][0].as_str().unwrap().contains("animation 0 'Rise' holds its last value at 9 s"), "{meta}");

    assert!(built("--clip 1")["built"]["posed"]["time"] == 1.0);
    let meta = place.ok("info a.bvhc --json").json()["files"][0]["meta"].clone();
    assert!(meta["moment"]["animation_number"] == 1 && meta["moment"]["time"].is_null(), "{meta}");
    let rest = built("");
    assert!(rest["built"]["posed"].is_null());
    assert_eq!(rest["built"]["remarks"], serde_json::json!(["left out 2 animations (everything stands at rest)"]));
    let meta = place.ok("info a.bvhc --json").json()["files"][0]["meta"].clone();
    assert!(
        meta.get("moment").is_none()
            && meta["notes"].as_array().unwrap().iter().all(|n| !n.to_string().contains("Rise"))
    );
}
