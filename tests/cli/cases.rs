//! Every input of the folder of cases, and neighbours of its kinds, through the program: what is right stands in one table a kind.
//!
//! The folder is `BVHC_CASES`, else `../shared/cases`. Without it only the neighbours are tried, which are made here.

mod forged;
mod overwritten;

use crate::common::{cases_dir, models_dir};
use crate::{Place, gltf};
use serde_json::{Value, json};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// What a build of a model must come to.
enum Right {
    /// Triangles, parts, and the box to so many units; the words that must be said, and none where there are none.
    Built(u64, u64, [[f64; 3]; 2], f64, &'static [&'static str]),
    /// An exit code and words.
    Refused(i32, &'static [&'static str]),
}
use Right::{Built, Refused};

const UNIT: [[f64; 3]; 2] = [[0.0; 3], [1.0, 1.0, 0.0]];
const RAISED: [[f64; 3]; 2] = [[0.0, 1.0, 0.0], [1.0, 2.0, 0.0]];
const CUBE: [[f64; 3]; 2] = [[0.0; 3], [1.0; 3]];
/// Where the far patch lies, to the spacing of 32-bit floats there.
const FAR: [[f64; 3]; 2] = [[500_123.25, 102.48, -4_649_776.75], [500_125.25, 102.52, -4_649_774.75]];

fn bounds(info: &Value) -> [[f64; 3]; 2] {
    let side = |name: &str| serde_json::from_value(info["scene_bounds"][name].clone()).unwrap();
    [side("min"), side("max")]
}

/// Build a model and hold it against what is right. A build that succeeds leaves a file that is valid and answers rays as the model does.
fn hold(place: &Place, model: &str, flags: &str, right: &Right) {
    let _ = std::fs::remove_file(place.path("out.bvhc"));
    let said = place.run(&format!("build {model} -o out.bvhc {flags}"));
    let all = format!("{model}: exit code {}\n{}{}", said.code, said.out, said.err);
    match right {
        Refused(code, words) => {
            assert!(said.code == *code && !place.path("out.bvhc").exists(), "{all}");
            words.iter().for_each(|word| assert!(said.err.contains(word), "'{word}' is not said of {all}"));
        }
        Built(triangles, parts, right, slack, words) => {
            assert_eq!(said.code, 0, "{all}");
            assert_eq!(said.err.is_empty(), words.is_empty(), "{all}");
            words.iter().for_each(|word| assert!(said.err.contains(word), "'{word}' is not said of {all}"));
            let info = place.ok("info out.bvhc --json").json()["files"][0].clone();
            let geoms = info["sections"].as_array().unwrap().iter().find(|s| s["type"] == "GEOM").unwrap();
            // So it was called by programs that tests/cases_before.sh runs.
            let count = info.get("triangles").unwrap_or(&info["prim_count"]);
            assert_eq!((count.as_u64(), geoms["elem_count"].as_u64()), (Some(*triangles), Some(*parts)), "{all}");
            let got = bounds(&info);
            let near = got.iter().flatten().zip(right.iter().flatten()).all(|(a, b)| (a - b).abs() <= *slack);
            assert!(near, "{model}: {got:?}, want {right:?}");
            place.ok(&format!("check out.bvhc --source {model} {flags}"));
            place.ok(&format!("verify out.bvhc --source {model} {flags} --device cpu --rays 2k"));
        }
    }
}

/// Each file of the folder, what it is built with, and what is right.
#[rustfmt::skip]
const CASES: [(&str, &str, Right); 20] = [
    ("01-skinned-node-transform/skin.gltf", "", Built(1, 1, RAISED, 1e-6, &[])),
    ("03-far-placed-mesh-baked/patch.gltf", "", Built(800, 1, [[0.0, -0.02, 0.0], [2.0, 0.02, 2.0]], 1e-3, &[])),
    ("03-far-placed-mesh-baked/patch_far.gltf", "", Built(800, 1, FAR, 0.5, &[])),
    ("03-far-placed-mesh-baked/patch_far_twice.gltf", "", Built(800, 1, [FAR[0], [500_132.25, FAR[1][1], FAR[1][2]]], 0.5, &[])),
    ("05-obj-utm-coordinates/patch_far.obj", "", Built(760, 1, FAR, 1.0, &["left out 40 triangles", "rounded before", "0.500 apart", "closer to the origin"])),
    ("06-lfs-pointer-obj/rock.obj", "", Refused(4, &["git lfs pull"])),
    ("06-lfs-pointer-obj/page.obj", "", Refused(4, &["web page"])),
    ("06-lfs-pointer-obj/upper.obj", "", Refused(4, &["small letters"])),
    ("07-objects-sharing-group-name/two_objects.obj", "", Built(2, 2, CUBE, 0.0, &[])),
    ("07-objects-sharing-group-name/same_object_name.obj", "", Built(2, 2, CUBE, 0.0, &[])),
    ("07-objects-sharing-group-name/slash.obj", "", Built(2, 2, CUBE, 0.0, &[])),
    ("09-scale-zero-one-axis/decal.gltf", "", Built(2, 2, [[0.0; 3], [4.0, 1.0, 0.0]], 0.0, &[])),
    ("09-scale-zero-one-axis/flattened_matrix.gltf", "", Built(1, 1, [[2.0, 2.0, 2.0], [3.0, 3.0, 2.0]], 0.0, &[])),
    ("09-scale-zero-one-axis/beyond_f32.gltf", "", Refused(4, &["beyond the range of f32", "1.0e39"])),
    ("10-nul-at-end-obj/nul.obj", "", Built(1, 1, UNIT, 0.0, &[])),
    ("10-nul-at-end-obj/nul_long.obj", "", Built(1, 1, UNIT, 0.0, &[])),
    ("14-backslash-uri/m.gltf", "", Built(1, 1, UNIT, 0.0, &[])),
    ("16-cesium-rtc/rtc.gltf", "", Refused(5, &["CESIUM_RTC"])),
    ("16-cesium-rtc/rtc.gltf", "--ignore-extension CESIUM_RTC", Built(1, 1, UNIT, 0.0, &["CESIUM_RTC"])),
    ("21-damaged-cache-up-to-date/tri.obj", "", Built(1, 1, UNIT, 0.0, &[])),
];

/// Hold each case and print what came of it; fail in the end. So one run tells of every case whether it is right, of another program as well
/// (`tests/cases_before.sh`).
fn judge<T>(cases: &[T], name: impl Fn(&T) -> String, hold: impl Fn(&T)) {
    let mut wrong = Vec::new();
    for case in cases {
        let is_right = catch_unwind(AssertUnwindSafe(|| hold(case))).is_ok();
        println!("{}: {}", if is_right { "right" } else { "wrong" }, name(case).trim_end());
        wrong.extend((!is_right).then(|| name(case)));
    }
    assert!(wrong.is_empty(), "{} of {} are wrong: {wrong:?}", wrong.len(), cases.len());
}

/// Files of a folder and the folders in it.
fn files_below(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    entries.flat_map(|p| if p.is_dir() { files_below(&p) } else { vec![p] }).collect()
}

#[test]
fn every_model_of_the_folder_is_read_rightly() {
    let Some(cases) = cases_dir() else { return };
    let place = Place::new();
    for file in files_below(&cases) {
        let name = file.strip_prefix(&cases).unwrap().to_str().unwrap().to_owned();
        let is_model = name.ends_with(".obj") || name.ends_with(".gltf");
        assert!(!is_model || CASES.iter().any(|c| c.0 == name), "{name} is not in the table");
        place.write(&name, std::fs::read(&file).unwrap());
    }
    let name = |(model, flags, _): &(&str, &str, Right)| format!("{model} {flags}");
    judge(&CASES, name, |(model, flags, right)| {
        hold(&place, model, flags, right);
        if *model == "03-far-placed-mesh-baked/patch_far.gltf" {
            // In world space, 32 bits lose its shape, of which its box says little.
            let info = place.ok("info out.bvhc --json").json();
            assert_eq!(info["files"][0]["instances"], 1, "it has an origin of its own");
        }
    });
}

#[test]
fn a_real_skinned_model_stands_where_its_joints_put_it() {
    let Some(models) = models_dir() else { return };
    let (place, model) = (Place::new(), models.join("sf_pigman/scene.gltf"));
    place.ok(&format!("build {} -o out.bvhc --preset draft", model.display()));
    let got = bounds(&place.ok("info out.bvhc --json").json()["files"][0]);
    let want = [[-10.3, -16.7, -19.5], [10.3, 45.3, 5.5]];
    let near = got.iter().flatten().zip(want.iter().flatten()).all(|(a, b)| (a - b).abs() < 0.06);
    assert!(near, "{got:?}");
}

/// A triangle in a glTF with its buffer beside it, changed as a document.
fn document(place: &Place, name: &str, edit: impl FnOnce(&mut Value)) {
    let (text, bin) = gltf("tri");
    place.write("tri.bin", bin);
    let mut document: Value = serde_json::from_str(&text).unwrap();
    edit(&mut document);
    place.write(name, document.to_string());
}

/// A triangle that one joint raises by 1, and the node of its mesh.
fn skinned(place: &Place, name: &str, node: Value) {
    let corners: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let weights = [1.0f32, 0.0, 0.0, 0.0].repeat(3);
    let mut bin: Vec<u8> = corners.iter().chain(&weights).flat_map(|v| v.to_le_bytes()).collect();
    bin.extend([0; 12]);
    place.write("skin.bin", bin);
    document(place, name, |d| {
        d["buffers"] = json!([{"uri": "skin.bin", "byteLength": 96}]);
        let view = |offset, length| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
        d["bufferViews"] = json!([view(0, 36), view(36, 48), view(84, 12)]);
        let accessor =
            |view, kind, component| json!({"bufferView": view, "componentType": component, "count": 3, "type": kind});
        d["accessors"] = json!([accessor(0, "VEC3", 5126), accessor(1, "VEC4", 5126), accessor(2, "VEC4", 5121)]);
        d["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0, "WEIGHTS_0": 1, "JOINTS_0": 2});
        d["skins"] = json!([{"joints": [1]}]);
        d["nodes"] = json!([node, {"translation": [0, 1, 0]}]);
        d["nodes"][0]["mesh"] = json!(0);
        d["nodes"][0]["skin"] = json!(0);
        d["scenes"][0]["nodes"] = json!([0, 1]);
    });
}

#[test]
fn the_place_of_a_skinned_node_is_nothing_whatever_it_is() {
    let place = Place::new();
    for node in [
        json!({}),
        json!({"translation": [5, 5, 5], "rotation": [0, 0, 1, 0]}),
        json!({"translation": [1e39, 0, 0]}),
        json!({"scale": [0, 0, 0]}),
        json!({"scale": [1, 1, 0]}),
        json!({"matrix": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]}),
    ] {
        skinned(&place, "skin.gltf", node);
        hold(&place, "skin.gltf", "", &Built(1, 1, RAISED, 1e-6, &[]));
    }
}

/// A wavy patch of 441 vertices, the first of them of this number in the file.
fn patch(at: [f64; 3], first: u32) -> String {
    let mut text = String::new();
    for (i, j) in (0..=20).flat_map(|i| (0..=20).map(move |j| (f64::from(i), f64::from(j)))) {
        let height = at[1] + 0.02 * (i * 0.7).sin() * (j * 0.9).cos();
        text += &format!("v {:.4} {height:.4} {:.4}\n", at[0] + 0.1 * i, at[2] + 0.1 * j);
    }
    for (i, j) in (0..20).flat_map(|i| (0..20).map(move |j| (i, j))) {
        let a = first + i * 21 + j;
        text += &format!("f {a} {} {}\nf {a} {} {}\n", a + 1, a + 22, a + 22, a + 21);
    }
    text
}

#[test]
fn far_off_along_any_axis_the_shape_is_kept_or_the_loss_is_told() {
    let place = Place::new();
    let at = |min: [f64; 3]| [[min[0], min[1] - 0.02, min[2]], [min[0] + 2.0, min[1] + 0.02, min[2] + 2.0]];
    for far in [[500_123.26, 102.5, -4_649_776.77], [0.0, 6_378_137.0, 0.0], [0.0, 0.0, -2e8], [5e8, 0.0, 4e9]] {
        place.write("far.obj", patch(far, 1));
        let slack = far.iter().map(|c| c.abs()).fold(0.0, f64::max) * 2e-7;
        hold(&place, "far.obj", "", &Built(800, 1, at(far), slack, &[]));
    }
    // Two that no one origin is near to.
    place.write("two.obj", patch([5e5, 0.0, -4e6], 1) + &patch([-5e5, 0.0, 4e6], 442));
    let said = place.ok("build two.obj -o two.bvhc");
    assert!(said.err.contains("it loses its shape: ") && said.err.contains("split it into files"), "{}", said.err);
}

#[test]
fn what_stands_in_the_place_of_a_file_is_no_model() {
    let place = Place::new();
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:0123\nsize 2380763\n";
    let page = "\n<!DOCTYPE html><html><body>Not Found</body></html>\n";
    for name in ["a.obj", "a.gltf", "a.glb"] {
        place.write(name, pointer);
        hold(&place, name, "", &Refused(4, &["git lfs pull"]));
        place.write(name, page);
        hold(&place, name, "", &Refused(4, &["web page"]));
    }
    place.write("a.obj", "ply\nformat ascii 1.0\nelement vertex 3\nend_header\n0 0 0\n");
    hold(&place, "a.obj", "", &Refused(4, &["no statement of an OBJ"]));
    place.write("a.glb", "");
    hold(&place, "a.glb", "", &Refused(4, &[]));
    // A buffer is a file, too.
    document(&place, "b.gltf", |_| ());
    hold(&place, "b.gltf", "", &Built(1, 1, UNIT, 0.0, &[]));
    place.write("tri.bin", pointer);
    hold(&place, "b.gltf", "", &Refused(4, &["buffer 0, ", "tri.bin, is a Git LFS pointer", "git lfs pull"]));
    place.write("tri.bin", page);
    hold(&place, "b.gltf", "", &Refused(4, &["tri.bin, is a web page"]));
}

#[test]
fn a_part_is_a_run_of_one_object_group_and_material() {
    let place = Place::new();
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\n";
    for (faces, parts) in [
        ("g a\nf 1 2 3\nusemtl m\nf 4 5 6\n", 2),
        ("o A\nusemtl m\nf 1 2 3\no B\nf 4 5 6\n", 2),
        ("o A\ng x\nf 1 2 3\no B\ng x\nf 4 5 6\n", 2),
        ("o A\nf 1 2 3\no A\nf 4 5 6\n", 2),
        ("g x\no A\nf 1 2 3\no B\nf 4 5 6\n", 2),
        ("g a/b\nusemtl c\nf 1 2 3\ng a\nusemtl b/c\nf 4 5 6\n", 2),
        ("g a b\nf 1 2 3\ng b a\nf 4 5 6\n", 2),
        ("o a\ng b\nf 1 2 3\no a b\ng\nf 4 5 6\n", 2),
        ("usemtl m\nf 1 2 3\nusemtl m\nf 4 5 6\n", 1),
        ("f 1 2 3\nf 4 5 6\n", 1),
    ] {
        place.write("a.obj", format!("{vertices}{faces}"));
        hold(&place, "a.obj", "", &Built(2, parts, CUBE, 0.0, &[]));
    }
}

#[test]
fn a_node_that_is_flat_shows_and_one_of_no_size_does_not() {
    let place = Place::new();
    let is = |node: Value, right: Right| {
        document(&place, "a.gltf", |d| {
            d["nodes"] = json!([node, {"mesh": 0}]);
            // A child of the first node has the mesh where that has none.
            d["scenes"][0]["nodes"] = json!([0]);
        });
        hold(&place, "a.gltf", "", &right);
    };
    is(json!({"mesh": 0, "scale": [1, 1, -0.0]}), Built(1, 1, UNIT, 0.0, &[]));
    is(json!({"mesh": 0, "scale": [-1, 1, 0]}), Built(1, 1, [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 0.0, &[]));
    is(json!({"mesh": 0, "scale": [1e-30, 1e-30, 1e-30]}), Built(1, 1, [[0.0; 3]; 2], 1e-29, &[]));
    is(json!({"scale": [1, 1, 0], "rotation": [0, 0, 0, 1], "children": [1]}), Built(1, 1, UNIT, 0.0, &[]));
    is(json!({"mesh": 0, "scale": [0, 1, 1]}), Refused(4, &["left out 1 triangle without area"]));
    is(json!({"mesh": 0, "scale": [0, 0, 0]}), Refused(4, &["left out 1 instance scaled to nothing"]));
    is(json!({"mesh": 0, "scale": [1e300, 1, 1]}), Refused(4, &["beyond the range of f32", "1.0e300"]));
}

#[test]
fn padding_behind_the_end_of_a_text_is_read_over_in_every_format() {
    let place = Place::new();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3";
    for padding in ["\0", "\n\0\0\0\n", "\r\n\u{1a}", "\0\0\r\n"] {
        place.write("a.obj", format!("{triangle}{padding}"));
        hold(&place, "a.obj", "", &Built(1, 1, UNIT, 0.0, &[]));
        document(&place, "a.gltf", |_| ());
        let text = String::from_utf8(place.read("a.gltf")).unwrap();
        place.write("a.gltf", format!("{text}{padding}"));
        hold(&place, "a.gltf", "", &Built(1, 1, UNIT, 0.0, &[]));
    }
    place.write("a.obj", format!("{triangle}\n{}", "\0".repeat(10_000)));
    hold(&place, "a.obj", "", &Built(1, 1, UNIT, 0.0, &[]));
    place.write("a.obj", format!("{triangle}\n\0f 1 2 3\n"));
    hold(&place, "a.obj", "", &Refused(4, &["line 5", "NUL"]));
}

#[test]
fn references_that_exporters_write_are_found() {
    let place = Place::new();
    let (_, bin) = gltf("tri");
    place.write("data/tri.bin", &bin);
    place.write("data/a b/tri.bin", &bin);
    for (uri, right) in [
        ("data\\\\tri.bin", Built(1, 1, UNIT, 0.0, &[])),
        (".\\data\\tri.bin", Built(1, 1, UNIT, 0.0, &[])),
        ("data%5Ctri.bin", Built(1, 1, UNIT, 0.0, &[])),
        ("data\\a%20b\\tri.bin", Built(1, 1, UNIT, 0.0, &[])),
        ("data/a b/tri.bin", Built(1, 1, UNIT, 0.0, &[])),
        ("data\\other.bin", Refused(3, &["cannot be opened"])),
        ("C:\\data\\tri.bin", Refused(4, &["an absolute path"])),
        ("..\\data\\tri.bin", Refused(4, &["leaves the model's folder"])),
    ] {
        document(&place, "a.gltf", |d| d["buffers"][0]["uri"] = json!(uri));
        hold(&place, "a.gltf", "", &right);
    }
}

#[test]
fn an_extension_that_moves_triangles_is_refused_where_required_and_else_told() {
    let place = Place::new();
    let rtc = |d: &mut Value, lists: &[&str]| {
        d["extensions"] = json!({"CESIUM_RTC": {"center": [6_378_137.0, 100.0, 0.0]}});
        lists.iter().for_each(|list| d[*list] = json!(["CESIUM_RTC"]));
    };
    document(&place, "a.gltf", |d| rtc(d, &["extensionsUsed", "extensionsRequired"]));
    hold(&place, "a.gltf", "", &Refused(5, &["CESIUM_RTC", "--ignore-extension"]));
    document(&place, "a.gltf", |d| rtc(d, &["extensionsRequired"]));
    hold(&place, "a.gltf", "", &Refused(5, &["CESIUM_RTC"]));
    document(&place, "a.gltf", |d| rtc(d, &["extensionsUsed"]));
    hold(&place, "a.gltf", "", &Built(1, 1, UNIT, 0.0, &["CESIUM_RTC", "is ignored"]));
    document(&place, "a.gltf", |d| rtc(d, &[]));
    hold(&place, "a.gltf", "", &Built(1, 1, UNIT, 0.0, &["CESIUM_RTC", "is ignored"]));
    document(&place, "a.gltf", |d| {
        d["extensionsRequired"] = json!(["KHR_draco_mesh_compression", "KHR_materials_unlit"])
    });
    hold(&place, "a.gltf", "", &Built(1, 1, UNIT, 0.0, &[]));
}
