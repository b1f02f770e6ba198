//! glTF at rest: what the shared models, animated situations and cases must give.

mod common;

use bvhc::geom::Aabb;
use bvhc::scene::{self, Degenerate, ErrorKind, ReadOptions, Scene};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn options() -> ReadOptions {
    ReadOptions { degenerate: Degenerate::Keep, ..ReadOptions::default() }
}

fn read(path: &Path) -> Scene {
    scene::read(path, &options()).unwrap_or_else(|e| panic!("{e}"))
}

/// A folder beside that of the models.
fn beside_models(name: &str) -> Option<PathBuf> {
    let folder = common::models_dir()?.parent()?.join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: there is no folder {name} beside the models");
    None
}

/// The positions of an instance in world space.
fn placed(scene: &Scene, instance: usize) -> Vec<[f64; 3]> {
    let instance = &scene.instances[instance];
    let mesh = &scene.meshes[instance.mesh as usize];
    (0..mesh.positions.len()).map(|v| instance.transform.transform_point(mesh.exact_position(v))).collect()
}

/// Situations in which no two loaders need agree, or in which ours says by a warning that it decided otherwise.
const UNDEFINED: [&str; 1] = ["skin_weights_zero"];

#[test]
fn every_animated_situation_rests_as_the_specification_has_it() {
    let Some(folder) = beside_models("sequences") else { return };
    let folder = folder.join("situations");
    let expected = std::fs::read_to_string(folder.join("expected.json")).unwrap();
    let expected: BTreeMap<String, serde_json::Value> = serde_json::from_str(&expected).unwrap();
    let (mut wrong, mut compared) = (Vec::new(), 0);
    for (name, situation) in expected {
        let scene = read(&folder.join(&name).with_extension("gltf"));
        let mut by_node: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (i, instance) in scene.instances.iter().enumerate() {
            by_node.entry(&instance.name).or_default().push(i);
        }
        for (node, instances) in situation["rest"].as_object().unwrap() {
            let ours = by_node.get(node.as_str()).cloned().unwrap_or_default();
            let theirs = instances.as_array().unwrap();
            if ours.len() != theirs.len() {
                wrong.push(format!("{name}: {} instances of {node}, want {}", ours.len(), theirs.len()));
                continue;
            }
            for (instance, primitives) in ours.into_iter().zip(theirs) {
                let want: Vec<[f64; 3]> = primitives
                    .as_array()
                    .unwrap()
                    .iter()
                    .flat_map(|p| serde_json::from_value::<Vec<[f64; 3]>>(p.clone()).unwrap())
                    .collect();
                let got = placed(&scene, instance);
                let is_same = |a: &[f64; 3], b: &[f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6);
                let is_right = got.len() == want.len() && got.iter().zip(&want).all(|(a, b)| is_same(a, b));
                if !is_right && !UNDEFINED.contains(&name.as_str()) {
                    wrong.push(format!("{name}: {node} is at {got:?}, want {want:?}"));
                }
                compared += 1;
            }
        }
    }
    println!("{compared} instances compared");
    assert!(wrong.is_empty() && compared >= 50, "{compared} compared\n{}", wrong.join("\n"));
}

fn world_box(scene: &Scene) -> Aabb {
    let mut bounds = Aabb::EMPTY;
    for i in 0..scene.instances.len() {
        for p in placed(scene, i) {
            bounds = bounds.grow(p.map(|c| c as f32));
        }
    }
    bounds
}

fn assert_close(got: &Aabb, want: [[f32; 3]; 2], slack: f32, name: &str) {
    let pairs = got.min.iter().chain(&got.max).zip(want.iter().flatten());
    for (a, b) in pairs {
        assert!((a - b).abs() <= slack, "{name}: {got:?}, want {want:?}");
    }
}

#[test]
fn skinned_models_stand_where_their_joints_put_them() {
    let Some(models) = common::models_dir() else { return };
    let pigman = read(&models.join("sf_pigman/scene.gltf"));
    assert_close(&world_box(&pigman), [[-10.3, -16.7, -19.5], [10.3, 45.3, 5.5]], 0.05, "sf_pigman");
    assert_eq!((pigman.report.unplayed_animations, pigman.report.unposed_skins), (4, 0));
    let animations = [("anim_fox/Fox.glb", 3), ("anim_cesiumman/CesiumMan.gltf", 1), ("anim_soldier/Soldier.glb", 4)];
    for (name, clips) in animations {
        let report = read(&models.join(name)).report;
        assert_eq!(
            (report.unplayed_animations, report.unposed_skins, report.unweighted_vertices),
            (clips, 0, 0),
            "{name}"
        );
    }
    let names: Vec<String> = pigman.meshes[0].parts.iter().map(|p| p.name.clone()).collect();
    assert!(names.iter().all(|n| !n.is_empty()), "{names:?}");
}

#[test]
fn cases_that_were_read_wrongly_are_read_rightly() {
    let Some(cases) = beside_models("cases") else { return };
    let corners = |file: &str| {
        let scene = read(&cases.join(file));
        let place = |i: usize| placed(&scene, i).iter().map(|p| p.map(|c| c as f32)).collect::<Vec<_>>();
        (0..scene.instances.len()).map(place).collect::<Vec<_>>()
    };
    assert_close(
        &world_box(&read(&cases.join("01-skinned-node-transform/skin.gltf"))),
        [[0.0, 1.0, 0.0], [1.0, 2.0, 0.0]],
        1e-6,
        "skin",
    );
    let decal = corners("09-scale-zero-one-axis/decal.gltf");
    assert_eq!(
        decal,
        [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[3.0, 0.0, 0.0], [4.0, 0.0, 0.0], [3.0, 1.0, 0.0]]]
    );
    let flat = corners("09-scale-zero-one-axis/flattened_matrix.gltf");
    assert_eq!(flat, [[[2.0, 2.0, 2.0], [3.0, 2.0, 2.0], [2.0, 3.0, 2.0]]]);
    let beyond = read(&cases.join("09-scale-zero-one-axis/beyond_f32.gltf")).report;
    assert_eq!((beyond.out_of_range_instances, beyond.largest_magnitude, beyond.singular_instances), (1, 1e39, 0));
    assert_eq!(corners("14-backslash-uri/m.gltf").len(), 1);

    let rtc = cases.join("16-cesium-rtc/rtc.gltf");
    let refused = scene::read(&rtc, &options()).unwrap_err();
    assert!(refused.kind() == ErrorKind::Unsupported && refused.to_string().contains("CESIUM_RTC"), "{refused}");
    let ignoring = ReadOptions { ignore_extensions: vec!["CESIUM_RTC".into()], ..options() };
    let scene = scene::read(&rtc, &ignoring).unwrap();
    assert_eq!((scene.instances.len(), scene.report.ignored_extensions), (1, vec!["CESIUM_RTC".to_string()]));
}
